"""What another chain costs over the paper's: prints the factors of sweep/plan/chains.py.

    python -m tests.law_costs [--tasks 400] [--laws toda power]

The same random tasks of 5 to 200 sites by every law, at three targets, with and without certification: seconds over
those of the paper's law, and over what `sweep plan` predicts. Then the paper's law as a chain of equal numbers that is
taken for one that is not uniform. What quantities cost prints tests.measure.
"""

import argparse
import time
from collections.abc import Mapping

import numpy as np

from kernel.ke import results_of
from kernel.lattice import Model
from kernel.method import Integrator, choose
from sweep.plan.cost import predict_work
from tests import truth
from tests.promises import LAWS

TARGETS = (1e-2, 1e-3, 1e-4)
LISTED = 30  # sites of the chain that is not uniform


def seconds(
    tasks: Mapping[str, np.ndarray],
    model: Model,
    integrator: Integrator,
    certify: bool,
) -> float:
    """Of all tasks on this core."""
    results_of({name: x[:1] for name, x in tasks.items()}, integrator, certify, model=model)  # compiles
    start = time.thread_time()
    results_of(tasks, integrator, certify, model=model)
    return time.thread_time() - start


def main() -> None:
    """Print the factors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", type=int, default=400)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=list(LAWS))
    args = parser.parse_args()
    tasks = truth.draw(args.tasks, args.seed, 200, wide=0.0)
    base = {}
    print(f"{'':20} {'certified':>9}  {'over the paper law':>24}  {'mean':>6}  over predicted")
    for name in dict.fromkeys(["bistable", *args.laws]):
        for certify in (False, True):
            found, predicted = [], []
            for target in TARGETS:
                integrator, model = choose(accuracy=target, certify=certify), Model(spring=LAWS[name])
                took = seconds(tasks, model, integrator, certify)
                base.setdefault((certify, target), took)
                found.append(took / base[certify, target])
                predicted.append(took / predict_work(tasks, integrator, certify, model).sum())
            told = " ".join(f"{x:8.2f}" for x in found)
            print(f"{name:20} {certify!s:>9} {told}  {np.mean(found):6.2f}  {np.mean(predicted):6.2f}", flush=True)
    soft = {name: x[tasks["N"] * tasks["zeta_T"] < 1.0] for name, x in tasks.items()}
    soft["N"] = np.full_like(soft["N"], LISTED)
    alike = Model(mass=[1.0] * LISTED)
    one = seconds(soft, Model(), choose("rk45"), True)
    print(f"not uniform: {seconds(soft, alike, choose('rk45'), True) / one:.2f}")


if __name__ == "__main__":
    main()
