"""One simulation: physics in, numbers out. Knows no MPI, no files, no data frames."""

from kernel.ke import KeRatio, ke_ratio
from kernel.task import Task

__all__ = ["KeRatio", "Task", "ke_ratio"]
