"""How fast this machine is beside the one of the cost model's fit: measured, and remembered beside the compiled kernel.

What is remembered are the seconds of a batch, not their ratio to what is predicted for it: that changes with every fit.
"""

import contextlib
import json
import math
import os
import time
import uuid
import zlib
from typing import Any

import numpy as np

from kernel.method import choose
from kernel.version import source_hash
from sweep.machine import cache_folder, processor_name
from sweep.plan.cost import predict_work

FILE = "speed.json"  # an entry for each kind of processor: several may share a folder
BATCH = {
    "N": [20, 50, 100, 150] * 3,
    "zeta_T": [1e-4] * 4 + [1e-3] * 4 + [0.3] * 4,
    "M_over_M0": [1.0] * 12,
    "V_over_V0": [1.0] * 12,
}
REPEATS = 8


def seconds_per_work() -> float:
    """Seconds of this machine for one unit of predicted work: by what is remembered, measured where nothing is."""
    seconds = _remembered()
    return measure() if seconds is None else _per_work(seconds)


def measure() -> float:
    """The same, measured now on this core and remembered (compiles the kernel if need be)."""
    from kernel.ke import results_of  # and with it numba, which a remembered speed does not need

    columns, integrator, best = _columns(), choose(), math.inf
    results_of({name: values[:1] for name, values in columns.items()}, integrator, certify=True)  # may compile
    for _ in range(REPEATS):
        start = time.thread_time()  # of this core, whoever else wants it
        results_of(columns, integrator, certify=False)
        best = min(best, time.thread_time() - start)
    _remember(best)
    return _per_work(best)


def _columns() -> dict[str, Any]:
    return {name: np.array(values) for name, values in BATCH.items()}


def _per_work(seconds: float) -> float:
    return float(seconds / predict_work(_columns(), choose(), certify=False).sum())


def _identity() -> str:
    """What the seconds depend on beside the processor: kernel, batch, whether it is compiled at all."""
    return f"{source_hash()} {zlib.crc32(repr(BATCH).encode()):08x}{os.environ.get('NUMBA_DISABLE_JIT', '')}"


def _entries() -> dict[str, Any]:
    """What is remembered of all processors; nothing where the file is missing, damaged or not to be read."""
    try:
        told = json.loads((cache_folder() / FILE).read_text())
    except (OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _remembered() -> float | None:
    entry = _entries().get(processor_name())
    if not isinstance(entry, dict) or entry.get("of") != _identity():
        return None
    seconds = entry.get("seconds")
    return seconds if isinstance(seconds, float) and 0.0 < seconds < math.inf else None


def _remember(seconds: float) -> None:
    """Without a word where the folder cannot be written: then every start measures."""
    folder = cache_folder()
    told = json.dumps(_entries() | {processor_name(): {"of": _identity(), "seconds": seconds}}, indent=1)
    partial = folder / f".{FILE}.{uuid.uuid4().hex}"  # complete or not there: others may read meanwhile
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            partial.write_text(told)
            partial.replace(folder / FILE)
        finally:
            partial.unlink(missing_ok=True)
