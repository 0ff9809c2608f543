"""Text on a picture, broken into lines."""

import re
from textwrap import wrap

_EQUALS, _PRIVATE = "\0=\0", 0xE000  # stand for " = " and for formulas while lines are broken


def wrapped(text: str, letters: int) -> str:
    """`text` in lines of at most `letters`; a formula, or "x = 1", stays on one line."""
    formulas = re.findall(r"\$[^$]*\$", text.replace(" = ", _EQUALS))
    kept = text.replace(" = ", _EQUALS)
    for k, formula in enumerate(formulas):
        kept = kept.replace(formula, chr(_PRIVATE + k) * _seen(formula), 1)
    lines = "\n".join(wrap(kept, max(letters, 20)))
    for k, formula in enumerate(formulas):
        lines = lines.replace(chr(_PRIVATE + k) * _seen(formula), formula, 1)
    return lines.replace(_EQUALS, " = ")


def _seen(formula: str) -> int:
    """The width of a formula, in letters."""
    plain = re.sub(r"\\mathrm|\\,|[${}_^ ]", "", formula)
    return max(len(re.sub(r"\\[a-zA-Z]+", "x", plain)), 1)
