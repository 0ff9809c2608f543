"""Which version is installed; said once for all three packages."""

from importlib.metadata import version

__version__ = version("bistable-sweep")
