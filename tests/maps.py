"""The search for a map beside other samplers: how many tasks of a whole plane, and seconds, each takes to what quality.

For `python -m tests.beside`, which makes the tables: of a plane over N and zeta_T, as of jobs/paper/fig4.toml, and of
the same spec with [search], find = "map". Good places: of those of the grid that are not chaotic, whose ke_ratio is
known, or inferred WITHIN its logarithm. python-adaptive's Learner2D is tried where it is installed (pip install
adaptive): it asks for impacts anywhere in the plane, at the nearest whole N; they are computed. Seconds of one core: of
computing what was asked for, and the sampler's own. Others than our search interpolate linearly on triangles.
"""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

import analysis
import kernel
from analysis.quantity import KE
from analysis.sought import inferred
from analysis.table import flagged
from sweep.tell import report

AXES = ["N", "zeta_T"]
SHARES, WITHIN = (0.05, 0.1, 0.15, 0.25, 0.4), 0.1  # of the tasks; of the logarithm
Array = np.ndarray


class Plane(NamedTuple):
    """Every place of a plane: coordinates (places, 2) from 0 to 1, its logarithm, nan where chaotic, and seconds."""

    rows: pd.DataFrame
    place: Array
    logs: Array
    seconds: Array


def plane_of(path: Path) -> Plane:
    rows = analysis.load(path, done_only=False)
    logs = np.log(rows[AXES].to_numpy(float))
    at = (logs - logs.min(axis=0)) / np.ptp(logs, axis=0)
    known = np.where((rows["status"] == "done") & ~flagged(rows), rows["ke_ratio"], np.nan)
    return Plane(rows, at, np.log(known), rows["seconds"].to_numpy(float))


def between(at: Array, logs: Array, asked: Array) -> Array:
    """Interpolated on triangles; beyond them the nearest."""
    calm = np.isfinite(logs)
    found = LinearNDInterpolator(at[calm], logs[calm])(asked)
    return np.where(np.isfinite(found), found, NearestNDInterpolator(at[calm], logs[calm])(asked))


def line(name: str, plane: Plane, asked: int, logs: Array, seconds: float) -> str:
    calm = np.isfinite(plane.logs)
    good = np.mean(np.abs(logs - plane.logs)[calm] <= WITHIN)
    return (
        f"{name:32} {asked:5} tasks, {asked / len(plane.logs):6.1%}, {seconds:6.2f} s: {good:6.1%} of the places good"
    )


def ours(path: Path, plane: Plane) -> str:
    rows = analysis.load(path, done_only=False)
    done = (rows["status"] == "done").to_numpy()
    guessed = inferred(path, rows, KE)
    logs = np.where(done, plane.logs, np.nan)
    if guessed is not None:
        logs[guessed.index] = np.log(guessed["ke_ratio"])
    busy = sum(run["busy"] for run in report.show(path)["runs"])  # with what screening takes
    return line(f"ours, {path.stem}", plane, int(done.sum()), logs, busy)


def of_the_grid(plane: Plane) -> Iterator[str]:
    """Places at random, and coarser grids."""
    n = len(plane.logs)
    for share in SHARES:
        picked = np.random.default_rng(1).permutation(n)[: round(share * n)]
        yield _line_of("random places", plane, picked)
    sides = [np.unique(plane.rows[name], return_inverse=True)[1] for name in AXES]
    for step in (2, 3, 4):
        ends = [(side % step == 0) | (side == side.max()) for side in sides]
        yield _line_of(f"every {step}. place of both axes", plane, np.flatnonzero(ends[0] & ends[1]))


def _line_of(name: str, plane: Plane, picked: Array) -> str:
    start = time.thread_time()
    logs = between(plane.place[picked], plane.logs[picked], plane.place)
    seconds = plane.seconds[picked].sum() + time.thread_time() - start
    return line(name, plane, len(picked), logs, seconds)


def learner(plane: Plane) -> Iterator[str]:
    """python-adaptive's Learner2D."""
    import adaptive

    low, high = (np.log(plane.rows[AXES].agg(end).to_numpy(float)) for end in ("min", "max"))
    fixed = {name: float(plane.rows[name].iloc[0]) for name in ("M_over_M0", "V_over_V0")}
    computed: dict[tuple[int, float], float] = {}

    def log(at: tuple[float, float]) -> float:
        N, zeta_T = np.exp(low + np.array(at) * (high - low))
        key = (round(N), float(zeta_T))
        if key not in computed:
            computed[key] = float(np.log(kernel.ke_ratio(N=key[0], zeta_T=key[1], **fixed).ke_ratio))
        return computed[key]

    asks, start = adaptive.Learner2D(log, bounds=[(0, 1), (0, 1)]), time.thread_time()
    for share in SHARES:
        while len(computed) < share * len(plane.logs):
            for at in asks.ask(1)[0]:
                asks.tell(at, log(at))
        seconds = time.thread_time() - start
        at, logs = (np.array(list(part)) for part in (asks.data.keys(), asks.data.values()))
        yield line("adaptive's Learner2D", plane, len(computed), between(at, logs, plane.place), seconds)


def tell(path: Path, searches: Sequence[Path]) -> None:
    """Print a line for every sampler and share."""
    plane = plane_of(path)
    print(f"a map of {len(plane.logs)} tasks; good: known within {WITHIN:g} of its logarithm")
    print(line("the whole grid", plane, len(plane.logs), plane.logs, plane.seconds.sum()))
    for search in searches:
        print(ours(search, plane))
    for told in of_the_grid(plane):
        print(told)
    try:
        for told in learner(plane):
            print(told, flush=True)
    except ImportError:
        print("adaptive's Learner2D: is not installed")
