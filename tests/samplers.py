"""The search for the lowest beside other samplers: how many tasks of a whole grid each takes to the same quality.

    python -m tests.samplers GRID.h5 [--search SEARCH.h5] [--cells 100] [--shares 0.02 0.05 0.1 0.2 0.4]

GRID.h5: the table of a whole grid, as of jobs/paper/quick/fig8.toml; nothing is computed, samplers look up what they
ask for. SEARCH.h5: the same spec with [search], find = "lowest". In a sample of cells (one N and zeta_T) each sampler
looks for the lowest ke_ratio over the impacts, with a share of the cell's tasks; a task asked for twice counts once.
Chaotic rows are no lowest. Optuna's TPE is tried where it is installed (pip install optuna).
"""

import argparse
import contextlib
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import differential_evolution

import analysis
from analysis.table import flagged

NEAR = 0.02  # of the grid's lowest: what counts as found
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


def found(sampler: Callable[[Looked, int], None], cells: list[Cell], share: float) -> tuple[float, float]:
    """The share of all tasks that it looked at, and of the cells in which it found the lowest, or one NEAR it."""
    looks = []
    for seed, cell in enumerate(cells):
        looked = Looked(cell, max(1, round(share * cell.size)))
        with contextlib.suppress(Spent):
            sampler(looked, seed)
        looks.append(looked)
    good = [looked.lowest <= (1 + NEAR) * looked.cell.min() for looked in looks]
    return sum(len(looked.seen) for looked in looks) / sum(cell.size for cell in cells), float(np.mean(good))


def cells_of(path: Path) -> tuple[dict[tuple[float, float], Cell], dict[tuple[float, float], np.ndarray]]:
    """Of every cell the numbers over masses and speeds, and which tasks were computed."""
    table = analysis.load(path, done_only=False)
    calm = (table["status"] == "done") & ~flagged(table)
    table["number"] = table["ke_ratio"].where(calm, NOTHING).fillna(NOTHING)
    table["computed"] = table["status"] == "done"
    numbers, computed = {}, {}
    for key, rows in table.groupby(["N", "zeta_T"]):
        numbers[key] = rows.pivot_table(index="M_over_M0", columns="V_over_V0", values="number").to_numpy()
        computed[key] = rows["computed"].to_numpy()
    return numbers, computed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grid", type=Path)
    parser.add_argument("--search", type=Path)
    parser.add_argument("--cells", type=int, default=100)
    parser.add_argument("--shares", type=float, nargs="+", default=[0.02, 0.05, 0.1, 0.2, 0.4])
    args = parser.parse_args()
    every, _ = cells_of(args.grid)
    keys = [key for key, cell in every.items() if cell.min() < NOTHING]
    chosen = [keys[k] for k in np.random.default_rng(1).permutation(len(keys))[: args.cells]]
    cells = [every[key] for key in chosen]
    print(f"{len(cells)} cells of {cells[0].size} tasks; found: the lowest or one within {NEAR:.0%} of it")
    if args.search:
        ours, computed = cells_of(args.search)
        good = np.mean([ours[key].min() <= (1 + NEAR) * every[key].min() for key in chosen])
        share = np.concatenate([computed[key] for key in chosen]).mean()
        print(f"{'ours, all screened besides':36} {share:6.1%} of the tasks: found in {good:.0%} of the cells")
    samplers = {"random search": at_random, "scipy's differential evolution": evolution, "Optuna's TPE": tpe}
    for name, sampler in samplers.items():
        for share in args.shares:
            try:
                looked, good = found(sampler, cells, share)
            except ImportError:
                print(f"{name}: is not installed")
                break
            print(f"{name:36} {looked:6.1%} of the tasks: found in {good:.0%} of the cells", flush=True)


if __name__ == "__main__":
    main()
