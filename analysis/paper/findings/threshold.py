"""Finding 2: the threshold in N is sharp and depends on the viscosity."""

import numpy as np
import pandas as pd

from analysis.paper.findings.finding import (
    Finding,
    Numbers,
    both,
    damped,
    most,
    ordered,
    reaches,
    usable,
    waiting_lines,
)
from analysis.paper.numbers import COARSE_N, FINE_N, HIGH_DAMPING, LOW_DAMPING, MIN_POINTS, ORDERED_SHARE
from analysis.table import IMPACT
from analysis.transition import LINE, transition
from sweep.errors import InputError

CLAIM = "the threshold in N is sharp, and depends on the viscosity"
OCTAVE = 2.0  # the paper's N reach over 6.6 octaves: a power law would fall by 15 % of its whole fall in one
SHARP_SHARE = 0.5  # of the whole fall of log ke_ratio, within one octave about N_transition
DAMPED = f"0 < zeta_T <= {HIGH_DAMPING:g}"
KNOWN = f"known to a factor of {OCTAVE:g} in N"
RULE = (
    f"of the transitions at {DAMPED} that are {KNOWN}, most have at least {SHARP_SHARE:.0%} of the whole fall of log "
    f"ke_ratio within a factor of {OCTAVE:g} in N, N_transition in its middle; at most impacts with {MIN_POINTS} of "
    "these or more N_transition is higher at the lowest zeta_T than at the highest, and of all pairs at least "
    f"{ORDERED_SHARE:.0%} have the higher one at the lower zeta_T"
)


def sharp_threshold(df: pd.DataFrame) -> Finding:
    """Whether ke_ratio "abruptly shifts from high to low" (figure 6) at an N that rises as zeta_T falls (section 3).

    Transitions and their intervals are those of `analysis.transition`. One counts if it has a damping, up to
    HIGH_DAMPING, and the two N about it are at most an OCTAVE apart; an impact if it has at least MIN_POINTS such
    transitions. Without any transition the finding fails where the frame reaches from COARSE_N to FINE_N at a low
    damping, in MIN_POINTS or more N, and is open elsewhere. InputError as in `usable`.
    """
    rows, counts = usable(df)
    if lacking := waiting_lines(df, HIGH_DAMPING):
        return Finding(2, CLAIM, None, counts, lacking)
    found = _transitions(damped(df, HIGH_DAMPING))
    if found.empty:
        low = damped(rows, LOW_DAMPING[1])
        seen = reaches(low) and low["N"].nunique() >= MIN_POINTS
        unseen = (
            f", and no 0 < zeta_T <= {LOW_DAMPING[1]:g} is seen from N <= {COARSE_N} to N >= {FINE_N} in at least "
            f"{MIN_POINTS} N"
        )
        return Finding(2, CLAIM, False if seen else None, counts, f"no line has a transition{'' if seen else unseen}")
    lines = dict(iter(rows.groupby(LINE)))
    shares = [_fall(lines[tuple(key)], N) for *key, N in found[[*LINE, "N_transition"]].to_numpy()]
    falls = [share for share in shares if share is not None]
    close = found[[share is not None for share in shares]]
    depends = [_depends(one) for _, one in close.groupby(IMPACT) if len(one) >= MIN_POINTS]
    numbers: Numbers = {
        f"transitions at {DAMPED}": len(found),
        KNOWN: len(falls),
        "sharp": f"{sum(fall >= SHARP_SHARE for fall in falls)} of {len(falls)}",
        "impacts at which it depends on zeta_T": f"{sum(depends)} of {len(depends)}",
        "N_transition": f"{found['N_transition'].min():.0f} to {found['N_transition'].max():.0f}",
    }
    if falls:
        numbers["share of the fall within an octave, median"] = float(np.median(falls))
    holds = both(most([fall >= SHARP_SHARE for fall in falls]), most(depends))
    lacks = [
        *([] if falls else [f"no transition is {KNOWN}"]),
        *([] if depends else [f"no impact has {MIN_POINTS} transitions"]),
    ]
    return Finding(2, CLAIM, holds, numbers | counts, "; ".join(lacks) if holds is None else RULE)


def _transitions(df: pd.DataFrame) -> pd.DataFrame:
    """The lines that have a transition."""
    try:
        found = transition(df)
    except InputError:  # no line with enough N
        return pd.DataFrame()
    return found[found["N_transition"].notna()]


def _fall(line: pd.DataFrame, at: float) -> float | None:
    """The share of the whole fall of log ke_ratio within one octave about `at`; None where the N are too far apart."""
    curve = line.sort_values("N").drop_duplicates("N")
    N, ratio = curve["N"].to_numpy(float), np.log(curve["ke_ratio"].to_numpy(float))
    if N[at <= N][0] > OCTAVE * N[at >= N][-1]:
        return None
    before, after = np.interp(np.log(at) + np.array([-0.5, 0.5]) * np.log(OCTAVE), np.log(N), ratio)
    return float((before - after) / (ratio[at >= N].max() - ratio[at <= N].min()))


def _depends(one: pd.DataFrame) -> bool:
    by_damping = one.sort_values("zeta_T")
    apart = by_damping["N_low"].iloc[0] > by_damping["N_high"].iloc[-1]
    rising = ordered(-by_damping["zeta_T"].to_numpy(), by_damping["N_transition"].to_numpy())
    return bool(apart and rising >= ORDERED_SHARE)
