"""The one exception of this package."""


class InputError(ValueError):
    """What the user gave cannot be analysed; the text has one line per problem, which says what and why."""

    @property
    def problems(self) -> tuple[str, ...]:
        """One line each."""
        return tuple(str(self).splitlines())
