"""How wide the best impact is: what is left of its ke_ratio where the impact is not met exactly.

    python -m tests.needle [--task N zeta_T M_over_M0 V_over_V0] [--keep]
    python -m tests.needle --table SEARCH.h5      how many of the lowest rows of a table have a chaotic neighbour

Default: the paper's best of the best (its figure 8). Around the impact lie rings of impacts whose mass and speed are
off by up to a relative distance, as around a candidate of a search with `robust`, but more closely. Of each ring: the
worst and the median ratio, over that of the impact itself, and how many of its impacts are chaotic. Of a chaotic impact
the worst is the upper end of its spread. The width is the distance from which the worst is more than TWICE the impact's
own ratio.

With --table: the lowest row of every cell, as `analysis best` has it, beside three NEIGHBOURS of it.
"""

import argparse
from pathlib import Path

import numpy as np

import analysis
import kernel
from tests.measured import keep

PAPER_BEST = (330, 2.585e-5, 0.1622, 10.0)
DISTANCES = (1e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1)
TWICE = 2.0
SIDES = 8  # impacts from corner to corner of a ring
ACCURACY = 1e-4
NEAR, CHANGED = 1e-6, 0.05  # relative: of mass and speed, of ke_ratio
NEIGHBOURS = ((NEAR, NEAR), (-NEAR, 0.0), (0.0, -NEAR))


def ring(distance: float) -> np.ndarray:
    """Factors (impacts, 2) of mass and speed on a square of this half side."""
    along = np.linspace(-1.0, 1.0, SIDES + 1)
    square = np.array([(x, y) for x in along for y in along if max(abs(x), abs(y)) == 1.0])
    return np.asarray(1.0 + distance * square)


def around(task: tuple[float, ...], distance: float) -> np.ndarray:
    """The rows of a ring."""
    N, zeta_T, M, V = task
    factors = ring(distance)
    columns = {"N": int(N), "zeta_T": zeta_T, "M_over_M0": M * factors[:, 0], "V_over_V0": V * factors[:, 1]}
    return kernel.ke_ratios(columns, ACCURACY)


def tell_neighbours(path: Path) -> None:
    """Print how many of a table's lowest rows have a neighbour that is chaotic, or differs much."""
    lowest = analysis.best(analysis.load(path))
    lowest = lowest[~lowest["chaotic"].astype(bool)]
    chaotic, changed = np.zeros((2, len(lowest)), np.bool_)
    for mass, speed in NEIGHBOURS:
        columns = {name: lowest[name].to_numpy() for name in ("N", "zeta_T")}
        columns |= {"M_over_M0": lowest["M_over_M0"].to_numpy() * (1.0 + mass)}
        columns |= {"V_over_V0": lowest["V_over_V0"].to_numpy() * (1.0 + speed)}
        rows = kernel.ke_ratios(columns, workers=2)
        chaotic |= rows["chaotic"]
        changed |= np.abs(rows["ke_ratio"] / lowest["ke_ratio"].to_numpy() - 1.0) > CHANGED
    print(f"{len(lowest)} lowest rows that are not chaotic; of {chaotic.sum()} a neighbour at {NEAR:g} is,")
    print(f"of {changed.sum()} one differs by more than {CHANGED:.0%}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", type=float, nargs=4, default=PAPER_BEST, metavar=("N", "zeta_T", "M", "V"))
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    parser.add_argument("--table", type=Path)
    args = parser.parse_args()
    if args.table:
        tell_neighbours(args.table)
        return
    here = kernel.ke_ratio(int(args.task[0]), *args.task[1:], ACCURACY)
    print(f"{args.task}: {here.ke_ratio:.4g}, error {here.error:.1g}, chaotic {here.chaotic}")
    width, told = np.inf, []
    for distance in DISTANCES:
        rows = around(tuple(args.task), distance)
        done = rows[rows["status"] == "done"]
        highest = np.where(done["chaotic"], done["spread_high"], done["ke_ratio"])
        worst, middle = float(highest.max()) / here.ke_ratio, float(np.median(done["ke_ratio"])) / here.ke_ratio
        chaotic = f"{rows['chaotic'].sum()} of {len(rows)}"
        print(f"within {distance:7.2%}: worst {worst:7.3f}, median {middle:7.3f} times; chaotic {chaotic}", flush=True)
        told.append({
            "mass and speed off by": f"{distance:.2%}",
            "worst": f"{worst:.3g}",
            "median": f"{middle:.3g}",
            "chaotic": chaotic,
        })  # fmt: skip
        width = min(width, distance if worst > TWICE else np.inf)
    print(f"width: {width:.2%}" if width < np.inf else f"wider than {DISTANCES[-1]:.0%}")
    if args.keep:
        keep(
            "needle",
            told,
            f"N = {args.task[0]:g}, zeta_T = {args.task[1]:g}, M/M0 = {args.task[2]:g}, V/V0 = {args.task[3]:g}",
        )


if __name__ == "__main__":
    main()
