"""One simulation: physics in, numbers out. Knows no MPI, no files, no data frames."""

from kernel.ke import KeRatio, ke_ratio, ke_ratios
from kernel.scene import Drive, Impact, Scene
from kernel.simulate import Simulation, simulate
from kernel.task import Task
from kernel.version import __version__

__all__ = [
    "Drive",
    "Impact",
    "KeRatio",
    "Scene",
    "Simulation",
    "Task",
    "__version__",
    "ke_ratio",
    "ke_ratios",
    "simulate",
]
