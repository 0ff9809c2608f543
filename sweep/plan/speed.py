"""How fast this machine is, compared with the machine on which the cost model was fitted.

The seconds of a small batch are measured and kept in a file beside the compiled kernel; their ratio to the prediction
is not kept, as it changes with every fit.
"""

import contextlib
import json
import math
import os
import time
import zlib
from typing import Any

import numpy as np

from kernel.method import choose
from kernel.version import source_hash
from sweep.files import replacing
from sweep.log import Compiling
from sweep.machine import cache_folder, processor_name
from sweep.plan.cost import predict_work

FILE = "speed.json"  # an entry for each kind of processor: several may share a folder
BATCH = {
    "N": [20, 50, 100, 150] * 3,
    "zeta_T": [1e-4] * 4 + [1e-3] * 4 + [0.3] * 4,
    "M_over_M0": [1.0] * 12,
    "V_over_V0": [1.0] * 12,
}
REPEATS = 8  # of which the fastest counts: another program may slow down some of them


def seconds_per_work() -> float:
    """Seconds of this machine for one unit of predicted work: from the file, or measured, saying so if it compiles."""
    if (seconds := _remembered()) is not None:
        return _per_work(seconds)
    from kernel.jit import compiling  # and with it numba

    with compiling(Compiling()):
        return measure()


def without_measuring() -> float:
    """The same from the file; where it has none, that of the machine on which the cost model was fitted."""
    seconds = _remembered()
    return 1.0 if seconds is None else _per_work(seconds)


def measure() -> float:
    """The same, measured now on this core and written to the file; compiles the kernel if need be."""
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
    """What the seconds depend on besides the processor: kernel, batch, and whether the kernel is compiled."""
    return f"{source_hash()} {zlib.crc32(repr(BATCH).encode()):08x}{os.environ.get('NUMBA_DISABLE_JIT', '')}"


def _entries() -> dict[str, Any]:
    """The file's entries of all processors; none where the file is missing, damaged or cannot be read."""
    try:
        entries = json.loads((cache_folder() / FILE).read_text())
    except (OSError, ValueError, RecursionError):
        return {}
    return entries if isinstance(entries, dict) else {}


def _remembered() -> float | None:
    entry = _entries().get(processor_name())
    if not isinstance(entry, dict) or entry.get("of") != _identity():
        return None
    seconds = entry.get("seconds")
    return seconds if isinstance(seconds, float) and 0.0 < seconds < math.inf else None


def _remember(seconds: float) -> None:
    """Write the seconds to the file. Where its folder cannot be written, nothing is said and every start measures."""
    folder = cache_folder()
    text = json.dumps(_entries() | {processor_name(): {"of": _identity(), "seconds": seconds}}, indent=1)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / FILE) as partial:  # complete or not there: others may read meanwhile
            partial.write_text(text)
