"""Results tables in; data frames, maps and CSV files out.

Each file here turns a table into numbers or numbers into a picture; `commands` holds the command line, `paper` what
concerns the paper alone. From `sweep` come the table's columns (`sweep.schema`), the rule by which ke_ratio falls
(`sweep.plan.fall`, which adaptive sweeps follow too) and what both command lines share. The pictures of the methods
(tradeoff, atlas) and those of the paper run the kernel. matplotlib is imported only when a picture is drawn.
"""

from analysis import start  # before the others, which must not come from the user's folder
from analysis.arrays import to_xarray
from analysis.best import best
from analysis.collapse import collapse
from analysis.level import crossings
from analysis.optimum import optimum
from analysis.paper.findings import findings
from analysis.plane import map_over, plane
from analysis.power_law import power_law, power_laws
from analysis.table import load
from analysis.transition import transition
from kernel.version import __version__
from sweep.errors import InputError

del start

__all__ = [
    "InputError",
    "__version__",
    "best",
    "collapse",
    "crossings",
    "findings",
    "load",
    "map_over",
    "optimum",
    "plane",
    "power_law",
    "power_laws",
    "to_xarray",
    "transition",
]
