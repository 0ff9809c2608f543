"""Numbers of a bistable cubic that might tell what its chain does, and which laws are the same at another strain.

With the compression m = -e the spring pushes with m - c2 m^2 + c3 m^3 and holds m^2/2 - c2 m^3/3 + c3 m^4/4, in the
units of kernel.model. Strain and speed in units of 1/c2 leave c2^2/c3 alone in the equations of the chain (where its
contact is stiff): a law with q c2 and q^2 c3 does at the speed V/q what (c2, c3) does at V.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from kernel.task import V0

Array = NDArray[np.float64]
C2, C3 = "spring.c2", "spring.c3"
LAW = [C2, C3]
SHAPE = "c2^2/c3"
# What a chain's law can be by its shape: where the push of its springs stops to fall anywhere, to reach zero, and to
# have a second stable state that lies higher than the first.
MONOTONE, BISTABLE, LEVEL_WELLS = 3.0, 4.0, 4.5
STRAIN_MAX = 1.0  # of the second stable state: beyond it a link would be shorter than nothing
FAMILIES = (
    "softens and stiffens again",
    "its force falls, no second state",
    "bistable, second state higher",
    "bistable, second state lower",
)
SAME_SHAPE = 1e-6  # relative: grids are rounded to 12 digits


# Numbers of the law, by which something might be predicted.
CANDIDATES = {
    SHAPE: "shape of the law, c2^2/c3",
    "barrier": "height of the barrier, in k_T L^2/N",
    "depth": "depth of the second well below the barrier, in k_T L^2/N",
    "depth/barrier": "that depth over the barrier's height",
    "snap strain": "strain of the second stable state",
    "push": "largest push before the snap, in k_T L",
}
# What an impact at speed V can be compared with; without an impact they are the same as one above, or a power of it.
OF_IMPACT = {
    "V/snap strain": "impact speed over the sound's, by the strain of the second stable state",
    "V^2/barrier": "impact speed squared, by the height of the barrier",
    "V^2/depth": "impact speed squared, by the depth of the second well below the barrier",
}


def with_numbers(laws: pd.DataFrame) -> pd.DataFrame:
    """The rows with all CANDIDATES, and with a V_over_V0 those OF_IMPACT; nan where a law has no barrier."""
    c2, c3 = laws[C2].to_numpy(float), laws[C3].to_numpy(float)
    shape = c2**2 / c3
    two = np.where(shape > BISTABLE, 1.0, np.nan)
    with np.errstate(invalid="ignore"):
        root = np.sqrt(c2**2 - BISTABLE * c3) * two
        turn = (c2 - np.sqrt(c2**2 - MONOTONE * c3)) / (3 * c3)
    top, second = (c2 - root) / (2 * c3), (c2 + root) / (2 * c3)
    barrier = _energy(top, c2, c3)
    numbers = {
        SHAPE: shape,
        "barrier": barrier,
        "depth": barrier - _energy(second, c2, c3),
        "depth/barrier": 1 - _energy(second, c2, c3) / barrier,
        "snap strain": second,
        "push": (turn - c2 * turn**2 + c3 * turn**3) * two,
    }
    found = laws.assign(**numbers)
    if "V_over_V0" not in laws:
        return found
    V = laws["V_over_V0"] * V0
    speeds = {"V/snap strain": V / second, "V^2/barrier": V**2 / barrier, "V^2/depth": V**2 / found["depth"]}
    return found.assign(**speeds)


def possible(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of `with_numbers` whose links can snap: a second stable state at STRAIN_MAX or more is none."""
    return rows[~(rows["snap strain"] >= STRAIN_MAX)]


def family(shape: float) -> str:
    """What a law of this shape is."""
    if shape <= MONOTONE * (1 + SAME_SHAPE):
        return FAMILIES[0]
    if shape <= BISTABLE * (1 + SAME_SHAPE):
        return FAMILIES[1]
    return FAMILIES[2] if shape <= LEVEL_WELLS else FAMILIES[3]


def _energy(m: Array, c2: Array, c3: Array) -> Array:
    return m**2 / 2 - c2 * m**3 / 3 + c3 * m**4 / 4


def scaled_pairs(rows: pd.DataFrame, others: list[str], values: list[str]) -> pd.DataFrame:
    """Pairs of rows that should be alike: of one shape, with V c2 the same, and the same `others`.

    One row per pair of neighbours in c2, with each of the `values` as NAME and NAME_other.
    """
    key = rows.assign(_shape=_rounded(rows[C2] ** 2 / rows[C3]), _strain=_rounded(rows["V_over_V0"] * rows[C2]))
    key = key.sort_values(C2)
    by = ["_shape", "_strain", *others]
    later = key.groupby(by)[values].shift(-1).add_suffix("_other")
    return key[[*LAW, "V_over_V0", *others, *values]].join(later).dropna(subset=[f"{name}_other" for name in values])


def _rounded(values: "pd.Series[float]") -> "pd.Series[float]":
    """For grouping: values that differ by rounding alone become one."""
    return np.round(np.log(values) / (10 * SAME_SHAPE)) * (10 * SAME_SHAPE)  # type: ignore[return-value]
