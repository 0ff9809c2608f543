"""One simulation: physics in, numbers out. Knows no MPI, no files, no data frames."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kernel.along import Disordered, Graded
    from kernel.columns import KeRatio
    from kernel.histories import HalfSine, Harmonic, Ramp, Samples
    from kernel.ke import ke_ratio, ke_ratios
    from kernel.lattice import Model
    from kernel.laws import Bistable, Hertz, PiecewiseLinear, Polynomial, PowerLaw, Toda
    from kernel.merit import measure
    from kernel.scene import Drive, Impact, Release, Scene
    from kernel.simulation import Simulation, simulate
    from kernel.task import Task
    from kernel.version import __version__

# Loaded when first asked for: who only reads a table or plans a sweep need not wait for numba and compiled code.
_NAMES = {
    "along": "Disordered Graded",
    "histories": "HalfSine Harmonic Ramp Samples",
    "columns": "KeRatio",
    "ke": "ke_ratio ke_ratios",
    "lattice": "Model",
    "laws": "Bistable Hertz PiecewiseLinear Polynomial PowerLaw Toda",
    "merit": "measure",
    "scene": "Drive Impact Release Scene",
    "simulation": "Simulation simulate",
    "task": "Task",
    "version": "__version__",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}
# fmt: off
__all__ = [
    "Bistable", "Disordered", "Drive", "Graded", "HalfSine", "Harmonic", "Hertz", "Impact", "KeRatio", "Model",
    "PiecewiseLinear", "Polynomial", "PowerLaw", "Ramp", "Release", "Samples", "Scene", "Simulation", "Task", "Toda",
    "__version__", "ke_ratio", "ke_ratios", "measure", "simulate",
]
# fmt: on


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kernel' has no attribute {name!r}")
    value = getattr(import_module(f"kernel.{_HOMES[name]}"), name)
    globals()[name] = value  # so that the next look finds it at once
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
