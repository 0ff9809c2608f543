"""Made-up tables for every open question, whose answers are known."""

from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from analysis.outlook.laws import C2, C3
from analysis.outlook.merits import MERITS
from analysis.outlook.questions.lattice import LATTICES
from analysis.outlook.thresholds import MIDDLE_ZETA_T
from analysis.paper.recipe import Source
from kernel.task import M0, V0

from .drawn import FOUR

NS = np.unique(np.geomspace(5, 700, 36).astype(int))
ZETAS = np.geomspace(4e-5, 4e-3, 6)
LAWS = [(4.0 * 1.2**k, 4.0 * 1.2**j) for k, j in product(range(3), range(3))]


def rows(grid, names=FOUR, **columns):
    """Finished, checked rows of a grid."""
    df = pd.DataFrame(list(product(*grid)), columns=list(names))
    rest = {"error": 1e-4, "chaotic": False, "checked": True, "status": "done"}
    return df.assign(**(rest | columns)).astype({"chaotic": "boolean"})


def falling(N, at):
    """A ke_ratio that falls from 2.5 to 0.01, the most steeply at an N."""
    return 0.01 + 2.5 / (1 + 251**0.5 * (N / at) ** 12)


def with_threshold(b=0.5, laws=LAWS, speeds=(2.0, 4.0)):
    """Laws whose N_transition is A zeta_T^-b; A is 50 at MIDDLE_ZETA_T for c2 V = 10, and goes as its root."""
    table = rows((NS, ZETAS, [2.0], speeds, laws), (*FOUR, "law"))
    table[C2], table[C3] = (table["law"].str[k] for k in (0, 1))
    at = 50 * (table["zeta_T"] / MIDDLE_ZETA_T) ** -b * np.sqrt(table[C2] * table["V_over_V0"] / 10)
    return table.drop(columns="law").assign(ke_ratio=falling(table["N"], at))


def with_optimum(s=0.8, laws=LAWS):
    """A table whose lowest ke_ratio goes as (Pi_IV c2)^-s: all impacts of one momentum, the lightest the best."""
    grid = (([80, 320], np.geomspace(4e-5, 0.1, 9), [0.1, 1.0], [10.0], laws), (*FOUR, "law"))
    table = rows(*grid)
    table[C2], table[C3] = (table["law"].str[k] for k in (0, 1))
    number = 0.1 * M0 * table["V_over_V0"] * V0 / (2 * table["zeta_T"]) * table[C2]
    return table.drop(columns="law").assign(ke_ratio=0.1 * number**-s * (1 + table["M_over_M0"]) * 100 / table["N"])


def with_merits(**columns):
    table = rows((NS[NS < 330][::3], [0, 4e-5, 1e-4, 4e-4, 1e-3, 4e-3], [0.1, 1.0, 10.0], [0.1, 1.0, 10.0]))
    zeta_T = table["zeta_T"].clip(lower=1e-9)
    after = 0.01 * (zeta_T / 1e-5) ** 0.4
    ratio = after + (2.5 - after) / (1 + (table["N"] / (0.76 * zeta_T**-0.5)) ** 12)
    table = table.assign(ke_ratio=ratio)
    for merit in MERITS[1:]:
        table[merit.column] = 1 / ratio if merit.more_is_better else ratio
        table[f"{merit.name}_error"] = 1e-4
    return table.assign(**{name: make(table) for name, make in columns.items()})


def with_disorder(loss, **columns):
    """Two optima, 20 draws of each kind at 10 %, all of which lose as much."""
    names = (*FOUR, "mass.spread", "stiffness.spread", "mass.seed")
    optima_ = [(55, 4e-4, 0.1, 4.0), (138, 4e-3, 0.2, 10.0)]
    spreads = [(0.0, 0.0, 0), *((*one, seed) for one in ((0.1, 0.0), (0.0, 0.1), (0.1, 0.1)) for seed in range(1, 21))]
    table = pd.DataFrame([(*at, *spread) for at in optima_ for spread in spreads], columns=list(names))
    uniform = (table["mass.spread"] == 0) & (table["stiffness.spread"] == 0)
    ratio = np.where(uniform, 0.01, 0.01 * np.asarray(loss))
    rest = {"ke_ratio": ratio, "ke_bistable": 0.1 * ratio, "error": 1e-4, "chaotic": False, "checked": True}
    return table.assign(**(rest | {"status": "done"} | columns)).astype({"chaotic": "boolean"})


def small_source(folder=Path("nowhere")):
    chains = with_threshold(laws=[(5.0, 6.0)], speeds=[2.0]).drop(columns=[C2, C3])
    tables = dict.fromkeys(LATTICES, chains)
    more = [*LAWS, (5.2, 5.8), (4.6, 4.6)]  # six of them bistable, as many as a number needs that is to predict
    tables |= {"threshold": with_threshold(laws=more), "optimum": with_optimum(), "merit": with_merits()}
    return Source(folder, _tables=tables | {"disorder": with_disorder(1.5)})
