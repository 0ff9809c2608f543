"""The search for a map with other constants: how many tasks it would take to what quality, played on whole grids.

python -m tests.map_constants GRID.h5 [GRID.h5 ..] [--error 0.1] [--constant OFF 1.2 1.5 1.8] [--unscreened]

GRID.h5: tables of whole grids, as of jobs/paper/fig4.toml and fig5.toml, or of the grids that --planes writes. A map is
over the two axes that have most values. Every task is screened here. Told of each table: the share of its tasks that
the search computes, the share of its calm places (not chaotic) that are then computed or inferred within the error, and
how far the last of a hundred is off.

python -m tests.map_constants --planes FOLDER [--seed S]     writes specs of other maps than the paper's, to be run by
`sweep run`: those on which the constants were chosen, or with a seed eight at random
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

import analysis
from analysis.table import flagged
from kernel.ke import results_of
from sweep.plan import refine, spline
from sweep.plan.refine import Planes, Refine
from sweep.plan.search import SCREENING
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, PARAMETERS, blank

CONSTANTS: dict[str, Sequence[float]] = {
    "OFF": (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5),
    "THROUGH": (8, 12, 20, 24, 30),
    "AROUND": (2, 3, 4, 6),
    "FIRST_STEP": (6, 8, 10, 12),
    "ROUGH": (0.005, 0.01, 0.02, 0.04),
    "ROUND": (0.01, 0.02, 0.03, 0.05),
}
IMPACTS = [(3, 0.7, 50), (0.3, 6, 50), (1, 1, 40), (0.5, 2, 40), (5, 3, 40)]  # M_over_M0, V_over_V0, values of an axis
SPEC = """name = "another map"
[grid]
N         = {{ log = [10, 200], points = {2} }}
zeta_T    = {{ log = [1e-5, 1], points = {2} }}
M_over_M0 = {0}
V_over_V0 = {1}
"""


IMPACTS_ALL = "M_over_M0 = { log = [0.1, 10], points = 50 }\nV_over_V0 = { log = [0.1, 10], points = 50 }\n"


def random_specs(seed: int) -> dict[str, str]:
    """Four maps over N and zeta_T at random impacts, and four over the impact at random N and zeta_T."""
    rng, head = np.random.default_rng(seed), 'name = "another map"\n[grid]\n'
    specs = {f"chains{k}": SPEC.format(*10 ** rng.uniform(-1, 1, 2), 50) for k in range(4)}
    for k in range(4):
        N, zeta_T = int(np.exp(rng.uniform(np.log(8), np.log(300)))), 10 ** rng.uniform(-5, -1)
        specs[f"impacts{k}"] = f"{head}N = {N}\nzeta_T = {zeta_T}\n{IMPACTS_ALL}"
    return specs


class Grid(NamedTuple):
    """A table of all tasks: what every task gives, nan where it is worth nothing."""

    name: str
    tasks: Tasks
    over: list[str]
    ratio: np.ndarray
    seen: np.ndarray | None  # what screening gives; None where nothing is screened


def grid_of(path: Path, screen: bool) -> Grid:
    rows = analysis.load(path, done_only=False)
    tasks = Tasks({name: np.unique(rows[name]).tolist() for name in PARAMETERS})
    over = sorted(PARAMETERS, key=lambda name: -len(tasks.axes[name]))[:2]
    known = np.where((rows["status"] == "done") & ~flagged(rows), rows["ke_ratio"], np.nan)
    ratio = np.empty(len(tasks))
    ratio[tasks.find({name: rows[name].to_numpy() for name in PARAMETERS})] = known
    seen = (
        results_of(tasks.columns(np.arange(len(tasks))), SCREENING, False, shared=True)["ke_ratio"] if screen else None
    )
    return Grid(path.stem, tasks, over, ratio, seen)


def played(grid: Grid, error: float) -> tuple[float, float, float]:
    """The share of tasks that a search computes, of calm places that are then good, and how far the last 1 % is off."""
    n, screen = len(grid.tasks), grid.seen is not None
    search, rows = Refine(grid.tasks, grid.over, "ke_ratio", error, refine.ROUND, screen), blank(n)
    rows["status"], rows["ke_ratio"], rows["chaotic"] = DONE, np.nan_to_num(grid.ratio), np.isnan(grid.ratio)
    asked, seen = np.zeros(n, np.bool_), np.ones(n) if grid.seen is None else grid.seen
    while len(orders := search.ask()):
        ids, screened = orders[orders < n], orders[orders >= n]
        asked[ids] = True
        search.tell_seen(screened, seen[screened - n])
        search.tell(ids, rows[ids])
    numbers = np.where(asked, grid.ratio, np.nan)
    off = np.where(
        asked, 0.0, np.abs(Planes(grid.tasks, grid.over).inferred(numbers, seen, asked) - np.log(grid.ratio))
    )
    off = off[np.isfinite(grid.ratio)]
    return float(asked.mean()), float((off <= error).mean()), float(np.nanquantile(off, 0.99))


def show(name: str, grids: Sequence[Grid], error: float) -> None:
    told = [played(grid, error) for grid in grids]
    means = (("mean", np.mean(told, axis=0)), *zip((grid.name for grid in grids), told, strict=True))
    shares = "  ".join(f"{name} {asked:5.1%} {good:5.1%} {off:.2f}" for name, (asked, good, off) in means)
    print(f"{name:18}  {shares}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("grids", type=Path, nargs="*")
    parser.add_argument("--error", type=float, default=0.1)
    parser.add_argument("--constant", nargs="+", metavar=("NAME", "VALUE"), help="this one alone")
    parser.add_argument("--planes", type=Path, metavar="FOLDER")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--unscreened", action="store_true", help="as with screen = false")
    args = parser.parse_args()
    if args.planes:
        known = {f"map{number}": SPEC.format(*impact) for number, impact in enumerate(IMPACTS)}
        for name, text in (known if args.seed is None else random_specs(args.seed)).items():
            (args.planes / f"{name}.toml").write_text(text)
        return
    constants = {args.constant[0]: [*map(float, args.constant[1:])]} if args.constant else CONSTANTS
    grids = [grid_of(path, not args.unscreened) for path in args.grids]
    show("as it is", grids, args.error)
    for name, values in constants.items():
        home = refine if name == "ROUND" else spline
        before = getattr(home, name)
        for value in values:
            setattr(home, name, type(before)(value))
            show(f"{name} = {value:g}", grids, args.error)
        setattr(home, name, before)


if __name__ == "__main__":
    main()
