"""What this machine calls its processor, and where the compiled kernel is kept on it."""

import os
import platform
from pathlib import Path

import kernel


def processor_name() -> str:
    """The model, as the system names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def cache_folder() -> Path:
    """Where numba keeps the compiled kernel, of an installation that is read-only in the user's own folder.

    It need not exist.
    """
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(given)
    package = Path(kernel.__file__).parent
    beside = package / "__pycache__"
    if os.access(beside if beside.exists() else package, os.W_OK | os.X_OK):
        return beside
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
