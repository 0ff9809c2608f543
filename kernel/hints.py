"""What somebody who mistyped a word may have meant."""

from collections.abc import Iterable

SHOWN_MAX = 100  # characters of a value that a message shows
NAMES_MAX = 12  # names that a message lists: a chain's list has one for each site
# Of difflib's ratio, 1 for equal words. From 0.65 to 0.75 a name with one slip is found in 99 % (0.8: 95 %), and few
# words that are no slip are taken for one (0.6: every second): tests/test_sweep_grammar.py.
LIKENESS_MIN = 0.7
REST_MIN = 0.5  # the same of what follows the dot, where what stands before it is the same: c3 is near c5, not b


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
    near = _nearest(word, choices)
    return f" (did you mean {near!r}?)" if near else ""


def taken_for(missing: str, there: Iterable[str]) -> str:
    """The one of the names that are there by which the missing one may be meant, as the end of a message."""
    near = _nearest(missing, there)
    return f" (did you mean it by {near!r}?)" if near else ""


def meant_or_known(word: str, choices: Iterable[str]) -> str:
    """`did_you_mean`; where nothing looks like it, what there is to choose from."""
    names = list(choices)
    more = ", .." if len(names) > NAMES_MAX else ""
    return did_you_mean(word, names) or f" (there are {', '.join(names[:NAMES_MAX])}{more})"


def _nearest(word: str, choices: Iterable[str]) -> str:
    """The choice that looks most like a word; "" where none does."""
    import difflib  # only for who mistyped: every rank loads this file

    plain = {choice.lower(): choice for choice in choices if choice}
    part, _, rest = word.lower().rpartition(".")
    near = [name for name in plain if name.endswith(f".{word.lower()}")]  # c2 of spring.c2
    for name in near or difflib.get_close_matches(word.lower(), plain, cutoff=LIKENESS_MIN):
        before, _, after = name.rpartition(".")
        if not part or before != part or difflib.SequenceMatcher(None, rest, after).ratio() >= REST_MIN:
            return plain[name]
    begun = [name for name in plain if name.startswith(f"{word.lower()}_")]  # M of M_over_M0, zeta of zeta_T
    return plain[begun[0]] if len(begun) == 1 else ""


def unknown(what: str, name: object, known: Iterable[str]) -> str:
    """`what: must be one of .., got name`, and what may have been meant."""
    names = list(known)
    return f"{what}: must be one of {', '.join(names)}, got {shown(name)}{did_you_mean(str(name), names)}"


def shown(value: object) -> str:
    """A value in a message: on one line, and not long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN_MAX else f"{text[:SHOWN_MAX]}..."


def exactly(value: float) -> str:
    """A number with all its digits, so that it is the same when it is typed again; a whole number without .0."""
    return repr(float(value)).removesuffix(".0")
