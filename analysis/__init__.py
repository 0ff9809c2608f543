"""Results tables in; data frames, maps and CSV files out.

Knows the table's row (`sweep.schema`) and nothing else of the sweep; the pictures about the methods themselves
(tradeoff, atlas) run the kernel. matplotlib is imported only when a
picture is drawn.
"""

from analysis.best import best
from analysis.errors import InputError
from analysis.plane import map_over, plane
from analysis.table import load

__all__ = ["InputError", "best", "load", "map_over", "plane"]
