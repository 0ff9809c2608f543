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
    """Where numba keeps the compiled kernel; it need not exist."""
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given) if given else Path(kernel.__file__).parent / "__pycache__"
