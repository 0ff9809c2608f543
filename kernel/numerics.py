"""Which bits the kernel gives: a number that its authors raise when they change any, and what this machine makes of it.

Rows that were computed elsewhere, or by an older kernel, are those that would be computed here where both agree.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from llvmlite import binding

from kernel import along
from kernel.ke import results_of
from kernel.lattice import PAPER_MODEL, Model
from kernel.method import Integrator, choose
from kernel.quantities import QUANTITIES
from kernel.task import T_END_OVER_N

# Raised with every change of any bit of any row, and with nothing else: tests/test_kernel_numerics.py tells when.
NUMERICS = 20

# Few and short tasks, so that a run that asks for them starts no later: both regimes of damping, each method, links
# that snap and links that do not. A change that leaves all of these alone and moves others is for NUMERICS to tell.
SITES, DAMPINGS = (2, 9, 24, 50), (0.0, 1e-4, 5e-3, 0.1)
IMPACTS = ((0.5, 0.3), (2.0, 3.0))
LISTED = 24  # sites of a chain that lists its own
STEPS_MAX = 100_000  # of one run, far more than the paper's chain takes: stiff contacts and masses of 1e-3 want more


def samples(sites: int | None = None) -> dict[str, np.ndarray]:
    """The tasks of `digest`, one array for each input; `sites`: of all, where the model says how many."""
    every = [(N, zeta_T, M, V) for N in ([sites] if sites else SITES) for zeta_T in DAMPINGS for M, V in IMPACTS]
    N, zeta_T, M, V = zip(*every, strict=True)
    return {"N": np.array(N), "zeta_T": np.array(zeta_T), "M_over_M0": np.array(M), "V_over_V0": np.array(V)}


def digest(integrators: Iterable[Integrator], model: Model = PAPER_MODEL, quantities: tuple[str, ...] = ()) -> str:
    """A digest of all bits of the certified rows of `samples`, computed here by one integrator after the other."""
    known, model = hashlib.sha256(), _short(model)
    tasks, asked = samples(model.sites), {name: QUANTITIES[name] for name in quantities}
    for integrator in integrators:
        known.update(results_of(tasks, integrator, certify=True, quantities=asked, model=model).tobytes())
    return known.hexdigest()[:16]


def _short(model: Model) -> Model:
    """The model watched as long as the paper's, with the first numbers of its lists: what it compiles is the same."""
    lists: dict[str, Any] = {name: x[:LISTED] for name in along.KINDS if type(x := getattr(model, name)) is tuple}
    return replace(model, t_end=T_END_OVER_N, **lists)


def processor_kind() -> str:
    """The kind of processor for which the kernel is compiled here: LLVM's name of it, and a digest of what it can do.

    A virtual machine may lack instructions that others of the same name have.
    """
    features = str(binding.get_host_cpu_features().flatten())
    return f"{binding.get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:8]}"


@cache
def numerics(model: Model = PAPER_MODEL, quantities: tuple[str, ...] = ()) -> str:
    """NUMERICS, the kind of processor, and a digest of rows computed here: where all are the same, so are all bits.

    Of this model and these quantities: what else the kernel can do need not be compiled, and may have changed.
    """
    integrators = choose(accuracy=1e-2, max_steps=STEPS_MAX), choose("rk45", rtol=1e-3, max_steps=STEPS_MAX)
    return f"{NUMERICS} {processor_kind()} {digest(integrators, model, quantities)}"
