"""One simulation: physics in, numbers out. Knows no MPI, no files, no data frames."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kernel.ke import KeRatio, ke_ratio, ke_ratios
    from kernel.scene import Drive, Impact, Scene
    from kernel.simulation import Simulation, simulate
    from kernel.task import Task
    from kernel.version import __version__

# Loaded when first asked for: who only reads a table or plans a sweep need not wait for numba and compiled code.
_HOMES = {
    "Drive": "scene",
    "Impact": "scene",
    "KeRatio": "ke",
    "Scene": "scene",
    "Simulation": "simulation",
    "Task": "task",
    "__version__": "version",
    "ke_ratio": "ke",
    "ke_ratios": "ke",
    "simulate": "simulation",
}
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


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kernel' has no attribute {name!r}")
    value = getattr(import_module(f"kernel.{_HOMES[name]}"), name)
    globals()[name] = value  # so that the next look finds it at once
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
