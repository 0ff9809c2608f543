"""The one exception of this package."""


class InputError(ValueError):
    """What the user gave cannot be analysed; the text is one line that says what and why."""
