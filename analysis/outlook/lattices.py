"""Question d: have chains that are not bistable a threshold in N?"""

import pandas as pd

from analysis.outlook.draws import share_of
from analysis.transition import transition
from sweep.plan.fall import HIGH, LOW

LATTICES = {  # by the name of their table
    "bistable": "the paper's, bistable",
    "granular": "grains under precompression, Hertz's law",
    "fput": "Fermi, Pasta, Ulam and Tsingou's, stiffening",
    "toda": "Toda's",
    "softening": "softening, straight pieces, no second well",
}
YES = 0.5  # of the lines
RULE = (
    "of `analysis transition`: a line, one impact at one zeta_T, has a transition where ke_ratio begins above "
    f"{HIGH:g} and ends below {LOW:g} at the largest N; a chain has a threshold where at least {YES:.0%} of its lines "
    "have one, none where no line has"
)


def answer(df: pd.DataFrame) -> dict[str, object]:
    """Of one chain: `lines`, `transitions`, the interval of their share (Wilson, 95 %), `others`, and the `verdict`."""
    found = transition(df)
    with_one = int((found["why_not"] == "").sum())
    share, low, high = share_of(with_one, len(found))
    others = found["why_not"][found["why_not"] != ""].value_counts()
    verdict = "yes" if share >= YES else "some lines" if with_one else "no"
    told = {"lines": len(found), "transitions": with_one, "low": low, "high": high, "verdict": verdict}
    without = ", ".join(f"{count} {why}" for why, count in others.items())
    return told | {"chaotic": int(found["chaotic"].sum()), "others": without}
