"""The search for the lowest beside other samplers: how many tasks of a whole grid, and seconds, to the same quality.

For `python -m tests.beside`, which makes the tables: of a whole grid, as of jobs/paper/quick/fig8.toml, in which the
samplers look up what they ask for, and of the same spec with [search], find = "lowest". In a sample of cells (one N and
zeta_T) each sampler looks for the lowest ke_ratio over the impacts, with a share of the cell's tasks; a task asked for
twice counts once. Chaotic rows are no lowest. Optuna's TPE is tried where it is installed (pip install optuna). Seconds
of one core: those of the rows that were looked at, as the grid's table has them, and the sampler's own; ours with what
it screened and tried in these cells. Make both tables on an idle machine: a row's seconds are those of the clock.
"""

import contextlib
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import differential_evolution

import analysis
from analysis.searched import spec_of
from analysis.table import flagged
from kernel.ke import results_of
from kernel.method import choose
from sweep.plan.search import SCREENED_UNTIL, SCREENING
from sweep.schema import PARAMETERS, RESULTS, SCREENED, is_screened
from sweep.store.table import reading

CELL = ["N", "zeta_T"]
NEAR = 0.02  # of the grid's lowest: what counts as found
SHARES = (0.02, 0.05, 0.1, 0.2, 0.4)  # of a cell's tasks
NOTHING = 1e3  # what a sampler is told of a chaotic or failed row
Cell = np.ndarray  # (masses, speeds): ke_ratio, or NOTHING


class Spent(Exception):  # noqa: N818
    """All tasks that a sampler may ask for are spent."""


class Looked:
    """What one sampler has seen of one cell."""

    def __init__(self, cell: Cell, most: int) -> None:
        self.cell, self.most, self.seen = cell, most, set[tuple[int, int]]()

    def at(self, place: tuple[int, int]) -> float:
        if place not in self.seen and len(self.seen) >= self.most:
            raise Spent
        self.seen.add(place)
        return float(self.cell[place])

    @property
    def lowest(self) -> float:
        return min((float(self.cell[place]) for place in self.seen), default=np.inf)


def at_random(looked: Looked, seed: int) -> None:
    """Tasks drawn without replacement."""
    for task in np.random.default_rng(seed).permutation(looked.cell.size):
        looked.at(tuple(map(int, np.unravel_index(task, looked.cell.shape))))


def evolution(looked: Looked, seed: int) -> None:
    """Scipy's differential evolution, started anew for as long as it may go on."""
    bounds, n = [(0, size - 1) for size in looked.cell.shape], 0
    while True:
        n += 1
        differential_evolution(
            lambda x: looked.at((round(x[0]), round(x[1]))), bounds, integrality=[True, True], popsize=5, polish=False,
            tol=0.0, maxiter=20, rng=seed + 10_000 * n,
        )  # fmt: skip
        if n > 50:  # it asks for what it knows
            return


def tpe(looked: Looked, seed: int) -> None:
    """Optuna's tree-structured Parzen estimator."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed))
    sizes = looked.cell.shape
    study.optimize(
        lambda trial: looked.at((trial.suggest_int("M", 0, sizes[0] - 1), trial.suggest_int("V", 0, sizes[1] - 1))),
        n_trials=4 * looked.most, catch=(),
    )  # fmt: skip


class Found(NamedTuple):
    """What a sampler did in all cells; `seconds`: its own."""

    looks: list[Looked]
    good: float
    seconds: float


def found(sampler: Callable[[Looked, int], None], cells: list[Cell], share: float) -> Found:
    """What it looked at of every cell, and of how many of them it found the lowest, or one NEAR it."""
    looks, start = [], time.thread_time()
    for seed, cell in enumerate(cells):
        looked = Looked(cell, max(1, round(share * cell.size)))
        with contextlib.suppress(Spent):
            sampler(looked, seed)
        looks.append(looked)
    good = [looked.lowest <= (1 + NEAR) * looked.cell.min() for looked in looks]
    return Found(looks, float(np.mean(good)), time.thread_time() - start)


def cells_of(path: Path) -> dict[tuple[float, float], tuple[Cell, Cell, pd.DataFrame]]:
    """Of every cell the numbers over masses and speeds, the seconds of each, and the rows."""
    table = analysis.load(path, done_only=False)
    calm = (table["status"] == "done") & ~flagged(table)
    table["number"] = table["ke_ratio"].where(calm, NOTHING).fillna(NOTHING)
    return {key: (*(_over(rows, name) for name in ("number", "seconds")), rows) for key, rows in table.groupby(CELL)}


def _over(rows: pd.DataFrame, name: str) -> Cell:
    cell: Cell = rows.pivot_table(index="M_over_M0", columns="V_over_V0", values=name, dropna=False).to_numpy()
    return cell


def line(name: str, share: float, good: float, seconds: float) -> str:
    return f"{name:32} {share:6.1%} of the tasks, {seconds:7.2f} s: found in {good:.0%} of the cells"


def ours(search: Path, keys: list[tuple[float, float]], every: dict[tuple[float, float], Cell]) -> str:
    """What our search did in these cells."""
    cells = cells_of(search)
    good = np.mean([cells[key][0].min() <= (1 + NEAR) * every[key].min() for key in keys])
    rows = pd.concat([cells[key][2] for key in keys])
    done = rows["status"] == "done"
    with reading(search) as file:
        tried = rows[is_screened(file[SCREENED][()])[len(file[RESULTS]) + rows.index]]
    start = time.thread_time()
    trying = choose("auto", spec_of(search)["accuracy"]["target"])
    for some, how, until in ((rows, SCREENING, SCREENED_UNTIL), (tried, trying, np.inf)):
        columns = {name: some[name].to_numpy() for name in PARAMETERS}
        results_of(columns, how, certify=False, until=until, shared=how is SCREENING)
    seconds = time.thread_time() - start + rows.loc[done, "seconds"].sum()
    return line(f"ours, {len(tried) / len(rows):.1%} tried, all screened besides", done.mean(), good, seconds)


def tell(path: Path, search: Path, count: int) -> None:
    """Print a line for every sampler and share."""
    grid = cells_of(path)
    every = {key: cell for key, (cell, _, _) in grid.items()}
    keys = [key for key, cell in every.items() if cell.min() < NOTHING]
    chosen = [keys[k] for k in np.random.default_rng(1).permutation(len(keys))[:count]]
    cells = [every[key] for key in chosen]
    print(f"{len(cells)} cells of {cells[0].size} tasks; found: the lowest or one within {NEAR:.0%} of it")
    print(ours(search, chosen, every))
    tasks = sum(cell.size for cell in cells)
    print(line("the whole grid", 1.0, 1.0, sum(float(np.nansum(grid[key][1])) for key in chosen)))
    samplers = {"random search": at_random, "scipy's differential evolution": evolution, "Optuna's TPE": tpe}
    for name, sampler in samplers.items():
        for share in SHARES:
            try:
                looks, good, seconds = found(sampler, cells, share)
            except ImportError:
                print(f"{name}: is not installed")
                break
            seconds += sum(
                float(grid[key][1][place]) for key, one in zip(chosen, looks, strict=True) for place in one.seen
            )
            print(line(name, sum(len(one.seen) for one in looks) / tasks, good, seconds), flush=True)
