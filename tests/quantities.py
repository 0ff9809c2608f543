"""What `q_error` promises of every quantity q, on tasks nobody has seen.

    python -m tests.quantities [--random 1000] [--seed S] [--longest 60] [--target 1e-3] [--law toda] [--keep]
    python -m tests.quantities --sites 3 [...]: by the site that is watched, from the third on

Truth is Dormand-Prince at rtol 1e-11, where one at 1e-9 agrees: what differs by more than a tenth of `q_error` is no
truth. Of the certified rows that are done and not chaotic, per quantity: the share of its ratios within the target,
that `q_error` covers, and half of it would; its median, how many errors are beyond five times it, and the largest error
of either chain's value over the larger of target and `q_error`. Exit status 1 where less than COVERED are covered.
"""

import argparse
import secrets
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.ke import PARAMETERS, rows_of
from kernel.lattice import Model
from kernel.method import choose
from kernel.quantities import QUANTITIES
from tests import measured, truth
from tests.promises import LAWS

COVERED, FAR = 0.97, 5.0
TRUE, NEARLY_TRUE = 1e-11, 1e-9  # rtol
SETTLED = 0.1  # of an estimated error: the references differ by less
CORES = 2

Rows = NDArray[np.void]


def apart(a: Any, b: Any) -> Any:
    """Relative difference; nan where one is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.abs(a / b - 1.0)


def solved(tasks: Mapping[str, np.ndarray], target: float, law: str = "bistable") -> tuple[Rows, Rows, Rows]:
    """The certified rows, and two that are true."""
    model = Model(spring=LAWS[law])
    runs = [(choose(accuracy=target), True), *((choose("rk45", rtol=rtol), False) for rtol in (TRUE, NEARLY_TRUE))]
    fast, true, nearly = (rows_of(tasks, by, certify, model, QUANTITIES, CORES) for by, certify in runs)
    return fast, true, nearly


def judged(name: str, fast: Rows, true: Rows, nearly: Rows) -> tuple[NDArray[np.bool_], Any, Any, Any]:
    """Of quantity `name`: which rows can be judged, their errors, those of each chain's value (n, 2), the estimates."""
    told, ratio = fast[f"{name}_error"], f"{name}_ratio"
    off = apart(fast[ratio], true[ratio])
    each = np.stack([apart(fast[name + chain], true[name + chain]) for chain in ("", "_linear")], axis=1)
    settled = apart(nearly[ratio], true[ratio]) < SETTLED * told
    here = (fast["status"] == "done") & ~fast["chaotic"] & np.isfinite(off) & settled
    return here, off[here], each[here], told[here]


def row(name: str, target: float, found: tuple[Rows, Rows, Rows]) -> tuple[dict[str, str], float]:
    """One line of the table, and what share is covered."""
    here, off, each, told = judged(name, *found)
    if not np.any(here):
        return {}, 1.0
    covered = float(np.mean(off <= told))
    worst = each.max(axis=1) / np.maximum(told, target)
    return {
        "quantity": f"`{name}`",
        "tasks": f"{len(off)}",
        "median error": f"{np.median(off):.1e}",
        "within the target": f"{np.mean(off <= target):.1%}",
        "covered": f"{covered:.1%}",
        "by half of it": f"{np.mean(off <= 0.5 * told):.1%}",
        "median `q_error`": f"{np.median(told):.1e}",
        "beyond 5 times": f"{np.mean(off > FAR * told):.2%}",
        "worst value": f"{np.max(worst):.2g}",
    }, covered


def by_site(first: int, target: float, found: tuple[Rows, Rows, Rows]) -> None:
    """Print the largest error of either chain's value at each site, of what the site itself tells."""
    for name in ("arrival", "acceleration"):
        here, _, each, _ = judged(name, *found)
        site = (found[0]["N"][here] + 1) // 2
        some = [each[site == k].max(axis=1) for k in range(first, first + 11)]
        told = [f"{first + k}: {x.max():.1e} ({np.mean(x > target):.1%})" for k, x in enumerate(some) if len(x)]
        print(f"{name}, largest by site (share beyond the target): {', '.join(told)}")


def main() -> int:
    """Draw, compute, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=secrets.randbits(32))
    parser.add_argument("--longest", type=int, default=60)
    parser.add_argument("--target", type=float, default=1e-3)
    parser.add_argument("--law", choices=LAWS, default="bistable")
    parser.add_argument("--sites", type=int)
    parser.add_argument("--keep", action="store_true")
    args = parser.parse_args()
    tasks = truth.draw(args.random, args.seed, args.longest)
    if args.sites:
        tasks["N"] = 2 * args.sites + tasks["N"] % 20
    found = solved({name: tasks[name] for name in PARAMETERS}, args.target, args.law)
    lines = [(line, covered) for line, covered in (row(name, args.target, found) for name in QUANTITIES) if line]
    for line, _ in lines:
        print("  ".join(f"{name} {value}" for name, value in line.items()), flush=True)
    if args.sites:
        by_site(args.sites, args.target, found)
    if args.keep:
        measured.keep("quantities", [line for line, _ in lines], f"seed {args.seed}")
    poor = [line["quantity"] for line, covered in lines if covered < COVERED]
    print(
        f"seed {args.seed}: "
        + (
            f"covered too rarely: {', '.join(poor)}"
            if poor
            else f"at least {COVERED:.0%} of each quantity's errors are covered"
        )
    )
    return 1 if poor else 0


if __name__ == "__main__":
    raise SystemExit(main())
