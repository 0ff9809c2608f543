"""Which bits the kernel gives: a number that its authors raise when they change any, and what this machine makes of it.

Rows that were computed elsewhere, or by an older kernel, are those that would be computed here where both agree.
"""

import hashlib
from collections.abc import Iterable
from functools import cache

import numpy as np
from llvmlite import binding

from kernel.ke import results_of
from kernel.method import Integrator, choose

# Raised with every change of any bit of any row, and with nothing else: tests/test_kernel_numerics.py tells when.
NUMERICS = 1

# Few and short tasks, so that a run that asks for them starts no later: both regimes of damping, each method, links
# that snap and links that do not. A change that leaves all of these alone and moves others is for NUMERICS to tell.
SITES, DAMPINGS = (2, 9, 24, 50), (0.0, 1e-4, 5e-3, 0.1)
IMPACTS = ((0.5, 0.3), (2.0, 3.0))


def samples() -> dict[str, np.ndarray]:
    """The tasks of `digest`, one array for each input."""
    every = [(N, zeta_T, M, V) for N in SITES for zeta_T in DAMPINGS for M, V in IMPACTS]
    N, zeta_T, M, V = zip(*every, strict=True)
    return {"N": np.array(N), "zeta_T": np.array(zeta_T), "M_over_M0": np.array(M), "V_over_V0": np.array(V)}


def digest(integrators: Iterable[Integrator]) -> str:
    """Of all bits of the certified rows of `samples`, computed here, each integrator's one after the other."""
    known = hashlib.sha256()
    for integrator in integrators:
        known.update(results_of(samples(), integrator, certify=True).tobytes())
    return known.hexdigest()[:16]


def processor_kind() -> str:
    """The kind of processor for which the kernel is compiled here: LLVM's name of it, and a digest of what it can do.

    A virtual machine may lack instructions that others of the same name have.
    """
    features = str(binding.get_host_cpu_features().flatten())
    return f"{binding.get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


@cache
def numerics() -> str:
    """NUMERICS, the kind of processor, and a digest of rows computed here: where all are the same, so are all bits."""
    return f"{NUMERICS} {processor_kind()} {digest([choose(accuracy=1e-2), choose('rk45', rtol=1e-3)])}"
