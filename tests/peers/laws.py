"""Every spring law by ours and by Boost.odeint's dopri5, in one run.

python -m tests.peers.laws [--laws toda ..] [--tasks A D ..] [--keep]

The tasks and the measure of tests.peers.bench, with the springs of tests.promises. The reference is computed anew: our
rk45 at rtol 1e-11, on the first neighbours of each task on which Boost's at 1e-10 agrees with it; a chaotic one tells
nothing about a solver. Boost is compiled with -ffast-math: of exponentials and powers it then takes several at once.
"""

import argparse
from collections.abc import Iterator

import kernel
from tests import measured
from tests.promises import LAWS

from . import measure, odeint, ours, table
from .common import TASKS, neighbours

FLAGS = (*odeint.FLAGS, "-ffast-math")
RTOL, THEIRS, AGREE = 1e-11, 1e-10, 1e-5
JUDGED = 8  # neighbours of a task
TRIED = 24  # of which so many are looked at: most may be chaotic
BOOST, BEST = "Boost.odeint dopri5", "Boost.odeint dopri5, atol = rtol"


def reference(model, name):
    """{index of the neighbour: ke_ratio} of those that both methods agree on."""
    found = {}
    for index, task in enumerate(neighbours(name, TRIED)):
        exact = kernel.ke_ratio(**vars(task), method="rk45", rtol=RTOL, certify=False, model=model).ke_ratio
        if abs(odeint.ke_ratio(task, THEIRS, THEIRS, model.spring, FLAGS) / exact - 1.0) <= AGREE:
            found[index] = exact
        if len(found) == JUDGED:
            break
    return found


def row_of(name, tasks) -> Iterator[tuple[str, str]]:
    """Of one law: time of each solver over that of ours in a batch, at error 1e-3."""
    model = kernel.Model(spring=LAWS[name])
    exact = {task: found for task in tasks if (found := reference(model, task))}
    solvers = [*ours.solvers(model), *odeint.solvers(model.spring, FLAGS)]
    points = measure.everything(solvers, list(exact), exact)
    yield "law", name
    for solver in ("ours rk45", BOOST, BEST):
        yield solver, table.mean(points, solver, table.BATCHED).strip()
    for task in exact:
        over = table.ratio(points, BEST, task, table.MIDDLE, table.BATCHED)
        yield f"its best on {task}", "-" if over is None else f"{over:.3g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=list(LAWS))
    parser.add_argument("--tasks", nargs="+", choices=TASKS, default=list(table.MEANT))
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    args = parser.parse_args()
    rows = []
    for name in args.laws:
        rows.append(dict(row_of(name, args.tasks)))
        print(", ".join(f"{what}: {figure}" for what, figure in rows[-1].items()), flush=True)
    if args.keep:
        about = "time over ours in a batch at error 1e-3, mean of the tasks in brackets; best: with atol = rtol"
        measured.keep("laws", rows, about)


if __name__ == "__main__":
    main()
