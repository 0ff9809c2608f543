"""What a user can mend: reported as one message, exit status 2, nothing written."""


class InputError(Exception):
    """Bad input or environment; `problems` holds one line each."""

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems


class DamagedTableError(InputError):
    """A table whose structure cannot be trusted; its rows may be intact."""

    def __init__(self, path: object, what: str) -> None:
        remedy = "`sweep run --repair` with its spec saves the intact rows and computes the others"
        super().__init__(f"{path}: {what}; {remedy}")
