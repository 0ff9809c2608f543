"""Random tasks of a fresh seed, and what is true of them: tight Dormand-Prince, for stiff ones CVODE's BDF.

The condition number is measured tightly: from runs whose mass, speed and first velocities are disturbed together, as in
kernel.condition, and from neighbours in damping ratio, mass and speed, each alone and both ways, which the kernel does
not ask: a chaotic task that one disturbance leaves where it is another one moves. Crests that nearly win count.
"""

from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np

from kernel.condition import CREST_GROWTH, DISTURBANCE
from kernel.crests import moved
from kernel.integrate import peak_of
from kernel.ke import PARAMETERS
from kernel.lattice import PAPER_MODEL, Model
from kernel.method import Integrator, choose
from kernel.model import lattice_chain, linear_chain
from kernel.pairs import DAMPING_DISTURBED
from kernel.task import M0, V0
from kernel.watch import PARTS

CHAINS = ("bistable", "linear")
RTOL, DISTURBED_RTOL, ATOL_OVER_RTOL = 1e-11, 1e-10, 1e-3
# N^2 zeta_T, what a step of Dormand-Prince against the dampers costs: above, BDF is the reference.
STIFF = 4000.0
DAMPING_STEP = DAMPING_DISTURBED * DISTURBANCE
AT_ONCE = 16  # tasks of one call


class Truth(NamedTuple):
    """Of n tasks, both chains: what converged runs say."""

    KE: np.ndarray  # (n, 2): largest KE of the middle site over TE
    condition: np.ndarray  # (n, 2)
    shown: np.ndarray  # (n,): largest relative change of ke_ratio that a disturbed run shows, over the disturbance


def draw(count: int, seed: int, longest: int = 500, wide: float = 0.25) -> dict[str, np.ndarray]:
    """Tasks of the paper's domain, one in eight undamped, and a share `wide` of a wider box."""
    rng = np.random.default_rng(seed)
    far = rng.random(count) < wide
    low, high = np.where(far, 2, 5), np.where(far, min(2 * longest, 1000), longest)
    N = np.rint(np.exp(rng.uniform(np.log(low), np.log(high)))).astype(np.int64)
    zeta_T = np.where(rng.random(count) < 0.125, 0.0, 10 ** rng.uniform(-6, 0, count))
    M, V = (10 ** (rng.uniform(-1, 1, count) * np.where(far, 1.4, 1.0)) for _ in range(2))
    return {"N": N, "zeta_T": zeta_T, "M_over_M0": M, "V_over_V0": np.minimum(V, 20.0)}


def stiff(tasks: Mapping[str, np.ndarray]) -> np.ndarray:
    """Which tasks an explicit reference cannot afford, (n,)."""
    return np.asarray(tasks["N"] ** 2 * tasks["zeta_T"] > STIFF)


def crests(
    tasks: Mapping[str, np.ndarray], integrator: Integrator, disturbance: float = 0.0, model: Model = PAPER_MODEL
) -> np.ndarray:
    """Largest KE/TE of both chains in each part of the run, (n, 2, PARTS); nan where a run failed."""
    found = np.full((len(tasks["N"]), 2, PARTS), np.nan)
    for i, (N, zeta_T, M, V) in enumerate(zip(*(tasks[name].tolist() for name in PARAMETERS), strict=True)):
        M, V, lattice = M * M0 * (1.0 + disturbance), V * V0 * (1.0 + disturbance), model.lattice(N)
        for chain, make in enumerate((lattice_chain, linear_chain)):
            peak = peak_of(make(N, zeta_T, M, lattice), V, disturbance, integrator, (), False)
            if peak.run.status == 0:
                found[i, chain] = peak.crests
    return found


def truth(tasks: Mapping[str, np.ndarray], model: Model = PAPER_MODEL) -> Truth:
    """Of tasks that are not stiff, on all cores."""
    parts = [
        {name: values[first : first + AT_ONCE] for name, values in tasks.items()}
        for first in range(0, len(tasks["N"]), AT_ONCE)
    ]
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        found = list(pool.map(truth_here, parts, repeat(model)))
    return Truth(*(np.concatenate([getattr(x, name) for x in found]) for name in Truth._fields))


def truth_here(tasks: Mapping[str, np.ndarray], model: Model = PAPER_MODEL) -> Truth:
    """The same in this process."""
    tight, disturbed = (choose("rk45", rtol=rtol, atol=ATOL_OVER_RTOL * rtol) for rtol in (RTOL, DISTURBED_RTOL))
    here = crests(tasks, tight, model=model)
    runs = [(crests(tasks, disturbed, size, model), size) for size in (DISTURBANCE, 0.1 * DISTURBANCE)]
    runs += [(crests(near, disturbed, model=model), DISTURBANCE) for near in neighbours(tasks)]
    condition = np.max([distance(here, there) / size for there, size in runs], axis=0)
    shown = np.max([np.abs(ratio(there) / ratio(here) - 1.0) / size for there, size in runs], axis=0)
    return Truth(here.max(axis=2), np.maximum(1.0, condition), shown)


def neighbours(tasks: Mapping[str, np.ndarray]) -> Iterator[dict[str, np.ndarray]]:
    """The same tasks with another damping ratio, mass or speed."""
    yield {**tasks, "zeta_T": tasks["zeta_T"] + DAMPING_STEP}
    for name in ("M_over_M0", "V_over_V0"):
        for size in (DISTURBANCE, -DISTURBANCE):
            yield {**tasks, name: tasks[name] * (1.0 + size)}


def ratio(found: np.ndarray) -> np.ndarray:
    """ke_ratio of crests (n, 2, PARTS), (n,)."""
    KE = found.max(axis=2)
    return np.asarray(KE[:, 0] / KE[:, 1])


def distance(a: np.ndarray, b: np.ndarray, margin: float = CREST_GROWTH) -> np.ndarray:
    """kernel.crests.moved of crests (n, 2, PARTS), (n, 2)."""
    return np.array([[moved(x, y, margin) for x, y in zip(*pair, strict=True)] for pair in zip(a, b, strict=True)])


def stiff_ratios(tasks: Mapping[str, np.ndarray], rtol: float = 1e-9) -> np.ndarray:
    """ke_ratio of stiff tasks by CVODE's BDF (scikit-sundae), (n,)."""
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        return np.array(list(pool.map(_stiff_ratio, _rows(tasks), [rtol] * len(tasks["N"]))))


def _rows(tasks: Mapping[str, np.ndarray]) -> Iterator[tuple[int, float, float, float]]:
    yield from zip(*(tasks[name].tolist() for name in PARAMETERS), strict=True)


def _stiff_ratio(row: tuple[int, float, float, float], rtol: float) -> float:
    from kernel.task import Task
    from tests.peers import cvode

    return float(cvode.ke_ratio("BDF", Task(*row), rtol))
