"""Results tables in; data frames, maps and CSV files out.

Of the sweep it knows the table (`sweep.schema`, and where a page tells of runs, `sweep.store.table`), what a fall of
ke_ratio is (`sweep.plan.fall`, which adaptive sweeps follow too), and the grammar of command lines. The pictures about
the methods themselves (tradeoff, atlas) run the kernel. matplotlib is imported only when a picture is drawn.
"""

from analysis import start  # first: what follows must not come from the user's folder
from analysis.best import best
from analysis.collapse import collapse
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
    "findings",
    "load",
    "map_over",
    "optimum",
    "plane",
    "power_law",
    "power_laws",
    "transition",
]
