"""What somebody who mistyped a word may have meant."""

from collections.abc import Iterable

SHOWN_MAX = 100  # characters of a value that a message shows
LIKENESS_MIN = 0.6  # of difflib's ratio, 1 for equal words


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """The choice that looks most like `word`, as the end of a message.

    Parameters
    ----------
    word : what the user wrote; upper and lower case count alike.
    choices : what would have been right; an empty one is left out.

    Returns
    -------
    " (did you mean 'x'?)", or "" where nothing looks like it.
    """
    import difflib  # only for who mistyped: every rank loads this file

    plain = {choice.lower(): choice for choice in choices if choice}
    near = [name for name in plain if name.endswith(f".{word.lower()}")]  # c2 of spring.c2
    near = near or difflib.get_close_matches(word.lower(), plain, n=1, cutoff=LIKENESS_MIN)
    return f" (did you mean {plain[near[0]]!r}?)" if near else ""


def unknown(what: str, name: object, known: Iterable[str]) -> str:
    """`what: must be one of .., got name`, and what may have been meant."""
    names = list(known)
    return f"{what}: must be one of {', '.join(names)}, got {shown(name)}{did_you_mean(str(name), names)}"


def shown(value: object) -> str:
    """A value in a message: on one line, and not long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN_MAX else f"{text[:SHOWN_MAX]}..."
