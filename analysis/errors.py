"""The one error of this package."""

from sweep import errors


class InputError(errors.InputError, ValueError):
    """What the user gave cannot be analysed: the sweep's error, and a ValueError, as the kernel raises one too."""
