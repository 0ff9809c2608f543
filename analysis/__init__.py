"""Results tables in; data frames, maps and CSV files out.

Knows the table's row (`sweep.schema`) and nothing else of the sweep; the pictures about the methods themselves
(tradeoff, atlas) run the kernel. matplotlib is imported only when a
picture is drawn.
"""

from analysis import start  # first: what follows must not come from the user's folder
from analysis.best import best
from analysis.collapse import collapse
from analysis.errors import InputError
from analysis.findings import findings
from analysis.optimum import optimum
from analysis.plane import map_over, plane
from analysis.power_law import power_law, power_laws
from analysis.table import load
from analysis.transition import transition
from kernel.version import __version__

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
