"""Verdicts counted, in a sentence."""

from collections import Counter
from collections.abc import Iterable

PLURAL = {"agrees": "agree", "differs": "differ", "holds": "hold", "does not hold": "do not hold"}


def tally(verdicts: Iterable[str]) -> str:
    """The most frequent first, for example "8 hold, 1 does not hold"."""
    return ", ".join(f"{count} {_verb(verdict, count)}" for verdict, count in Counter(verdicts).most_common())


def _verb(verdict: str, count: int) -> str:
    first = next((word for word in PLURAL if verdict.startswith(word)), None)
    return verdict if count == 1 or first is None else PLURAL[first] + verdict.removeprefix(first)
