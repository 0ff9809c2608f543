"""Many impacts: spec, tasks, scheduler, table, command line; `run` starts a sweep from a script or a notebook."""

from typing import TYPE_CHECKING, Any

from kernel.version import __version__
from sweep.errors import InputError

if TYPE_CHECKING:
    from sweep.caller import Finished, run

__all__ = ["Finished", "InputError", "__version__", "run"]


def __getattr__(name: str) -> Any:
    if name not in ("Finished", "run"):
        raise AttributeError(f"module 'sweep' has no attribute {name!r}")
    from sweep import caller  # with it what only scripts need: the command line and the workers do without

    return getattr(caller, name)
