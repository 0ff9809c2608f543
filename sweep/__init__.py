"""Many impacts: spec, tasks, scheduler, table, command line."""

from kernel.version import __version__

__all__ = ["__version__"]
