"""The search for the lowest with other constants: what it would cost and miss, played on numbers that are all known.

python -m tests.search_constants [SPEC | --random SEED ...] [--speeds]    SPEC: a grid; default: that of QUICK

--speeds: other values of kernel.method.SHARED_SPEED_RATIO; with 1.0 no linear chain is shared. Told besides: how far
the energy of a shared linear chain is off in 99 of 100 random tasks, with the paper's contact and a softer one.

Every task is screened, tried and computed once. Cost is told by site evaluations, over those of the whole grid; what a
task costs besides is left out, and makes screening dearer than it looks here.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel import Hertz, Model, method
from kernel.ke import results_of
from kernel.method import choose
from sweep.plan import lowest
from sweep.plan.search import COMPUTE, SCREEN, SCREENED_UNTIL, SCREENING, TRY
from sweep.plan.spec import parse_spec
from sweep.plan.tasks import Tasks
from sweep.schema import blank

from . import truth
from .searches import QUICK, SEARCH, random_grid

UNTIL = (1.3, 1.5, 1.8)  # of sweep.plan.search.SCREENED_UNTIL
CONSTANTS = [(until, beyond, first) for until in UNTIL for beyond in (1.2, 1.5, 2.0) for first in (4, 8, 16)]
RATIOS = (1.0, 2.0, 4.0, 16.0, 1e6)  # of kernel.method.SHARED_SPEED_RATIO
TASKS, SOFTER = 600, (1.0, 1e5)  # for which, and with how much softer contacts, shared linear chains are looked at
KINDS = (COMPUTE, SCREEN, TRY)
Known = Sequence[NDArray[np.void]]  # by KINDS


def everything(tasks: Tasks, accuracy: float, untils: Sequence[float] = UNTIL) -> dict[float, Known]:
    """What computing, screening and trying give for every task, by when screening ends."""
    columns, integrator = tasks.columns(np.arange(len(tasks))), choose("auto", accuracy)
    computed, tried = (results_of(columns, integrator, certify) for certify in (True, False))
    return {until: (computed, screened(columns, until), tried) for until in untils}


def screened(columns: dict[str, NDArray[Any]], until: float) -> NDArray[np.void]:
    """What screening gives for these tasks."""
    return results_of(columns, SCREENING, False, until=until, shared=method.SHARED_SPEED_RATIO > 1.0)


def played(tasks: Tasks, known: Known) -> NDArray[np.bool_]:
    """Which tasks a search computes, screens and tries, (3, tasks)."""
    search, n = lowest.Lowest(tasks, SEARCH["over"], "ke_ratio"), len(tasks)
    rows, asked = blank(n), np.zeros((len(KINDS), n), np.bool_)
    for name in ("ke_ratio", "status", "chaotic", "checked"):
        rows[name] = known[COMPUTE][name]
    seen = np.concatenate([np.where(each["status"] == "done", each["ke_ratio"], np.nan) for each in known])
    while len(orders := search.ask()):
        asked.ravel()[orders] = True
        search.tell_seen(orders[orders >= n], seen[orders[orders >= n]])
        search.tell(orders[orders < n], rows[orders[orders < n]])
    return asked


def judged(tasks: Tasks, known: Known) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of each kind the share of tasks and of the grid's site evaluations, (2, 3); how far cells miss their lowest."""
    asked, cells = played(tasks, known), lowest.blocks(tasks, SEARCH["over"], 1)[:, :, 0]
    work = np.array([each["site_evaluations"] for each in known])
    share = np.array([asked.mean(axis=1), (asked * work).sum(axis=1) / work[COMPUTE].sum()])
    rows = known[COMPUTE]
    calm = np.where((rows["status"] == "done") & ~rows["chaotic"], rows["ke_ratio"], np.inf)
    whole, found = (values[cells].min(axis=1) for values in (calm, np.where(asked[COMPUTE], calm, np.inf)))
    return share, found[np.isfinite(whole)] / whole[np.isfinite(whole)] - 1.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("spec", type=Path, nargs="?", default=QUICK)
    parser.add_argument("--random", type=int, nargs="+", metavar="SEED", help="grids of random values instead")
    parser.add_argument("--speeds", action="store_true", help="vary which tasks share a linear chain")
    args = parser.parse_args()
    texts = [args.spec.read_text()] if args.random is None else [random_grid(seed) for seed in args.random]
    specs = [parse_spec(text, "grid") for text in texts]
    untils = (SCREENED_UNTIL,) if args.speeds else UNTIL
    grids = [(tasks, everything(tasks, spec.accuracy.target, untils)) for spec in specs if (tasks := spec.task_list())]
    names = "computed  tried   work: computed, screened, tried, all   cells  > 2 %  > 10 %  worst"
    if args.speeds:
        print(f"ratio      {names}  linear chain off, with a contact softer {SOFTER} times")
        for method.SHARED_SPEED_RATIO in RATIOS:
            said = told([(tasks, again(tasks, known)) for tasks, known in grids])
            off = " ".join(f"{shared_off(softer):6.1%}" for softer in SOFTER)
            print(f"{method.SHARED_SPEED_RATIO:9g} {said}  {off}", flush=True)
        return
    print(f"until  BEYOND  FIRST_ROUND  {names}")
    for until, lowest.BEYOND, lowest.FIRST_ROUND in CONSTANTS:
        said = told([(tasks, known[until]) for tasks, known in grids])
        print(f"{until:5}  {lowest.BEYOND:6}  {lowest.FIRST_ROUND:11}", said, flush=True)


def again(tasks: Tasks, known: dict[float, Known]) -> Known:
    """The same, screened anew."""
    computed, _, tried = known[SCREENED_UNTIL]
    return computed, screened(tasks.columns(np.arange(len(tasks))), SCREENED_UNTIL), tried


def shared_off(softer: float) -> float:
    """How far ke_linear is off where tasks share it, as a logarithm, in 99 of 100 random tasks."""
    tasks, model = truth.draw(TASKS, 5, 100, 0.0), Model(contact=Hertz(stiffness=Hertz().stiffness / softer))
    own, shared = (
        results_of(tasks, SCREENING, False, model=model, shared=x)["ke_linear"]
        for x in (False, method.SHARED_SPEED_RATIO > 1.0)
    )
    return float(np.nanquantile(np.abs(np.log(shared / own)), 0.99))


def told(grids: Sequence[tuple[Tasks, Known]]) -> str:
    """What searches of these grids would take and miss."""
    shares, above = zip(*(judged(tasks, known) for tasks, known in grids), strict=True)
    share, work = np.mean(shares, axis=0)
    excess = np.concatenate(above)
    spent = " ".join(f"{work[kind]:9.3f}" for kind in KINDS)
    good = f"{len(excess):6}  {(excess > 0.02).sum():5}  {(excess > 0.1).sum():6}  {excess.max():5.1%}"
    return f" {share[COMPUTE]:8.1%}  {share[TRY]:5.1%}  {spent} {work.sum():6.3f}  {good}"


if __name__ == "__main__":
    main()
