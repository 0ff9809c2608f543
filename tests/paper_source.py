"""Small tables for every figure of the paper, and its own scene files."""

from functools import cache
from itertools import product
from pathlib import Path

import pandas as pd

import kernel
from analysis.paper.numbers import Point
from analysis.paper.recipe import Source
from kernel.ke import PARAMETERS

JOBS = Path(__file__).parent.parent / "jobs/paper"
SMALL = Point("small", "nowhere", 20, 4e-3, 1.0, 2.0, 0.5, (0, 0, 0))
ZETAS = [0, 4e-5, 4e-4, 4e-3, 4e-2, 4e-1]
GRIDS = {
    "fig1": ([5, 10, 20], ZETAS, [2], [2]),
    "fig4": ([5, 8, 13, 20, 60], [1e-5, 1e-4, 1e-3, 1e-1, 1], [2], [2]),
    "fig4-mass": ([5, 60], [1e-3, 1e-1], [2 / 2.75], [2]),
    "fig5": ([20, 200], [0, 4e-5, 4e-4], [0.1, 1, 3, 10], [0.1, 1, 10]),
    "fig6": ([5, 20, 80], [4e-4], [0.1, 0.5, 2], [1, 2, 4, 10]),
    "fig6b": ([5, 10, 20, 40, 80, 160], [4e-4, 6e-4, 1e-3, 2e-3, 4e-3], [0.1, 2], [2, 4, 10]),
    "fig8": ([5, 8, 13, 20, 30], [1e-5, 1e-4, 1e-3, 1e-2, 1e-1], [0.1, 1], [1, 10]),
}


def table(name: str) -> pd.DataFrame:
    """What a sweep over the grid would hold."""
    tasks = pd.DataFrame(list(product(*GRIDS[name])), columns=list(PARAMETERS))
    return pd.DataFrame(kernel.ke_ratios(tasks, 1e-2)).drop(columns=["method", "status"])


@cache
def small_source() -> Source:
    """Without files: the tables are held in memory, and each scene is run once."""
    return Source(Path("nowhere"), JOBS, _tables={name: table(name) for name in GRIDS})
