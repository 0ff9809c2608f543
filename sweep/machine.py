"""What this machine calls its processor, and where the compiled kernel is kept on it."""

import hashlib
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


def compiled_for() -> str:
    """The kind of processor for which the kernel is compiled here: on one kind a task has the same bits.

    numba's settings may name another kind than this machine's, for nodes that are to agree.
    """
    from kernel.numerics import processor_kind  # the compiler, which most commands do without

    here, name, features = processor_kind(), os.environ.get("NUMBA_CPU_NAME"), os.environ.get("NUMBA_CPU_FEATURES")
    if name is None and features is None:
        return here
    told = hashlib.sha256((here if features is None else features).encode()).hexdigest()[:8]
    return f"{name or here.rpartition('-')[0]}-{told}"


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
