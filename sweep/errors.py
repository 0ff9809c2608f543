"""What a user can mend: reported as one message, exit status 2, nothing written."""


class InputError(Exception):
    """Bad input or environment; `problems` holds one line each."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems
