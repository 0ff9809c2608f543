"""Other numbers in the rules of the steps: what they would miss, and what they would cost, on random tasks.

    python -m tests.steps [--random 400] [--seed S] [--longest 150] [--accuracies 1e-2 1e-3 1e-4]

A rule is a value (kernel.splitting.rules, kernel.linear), so that a run can be given another one: one of its numbers
after the other is multiplied by each of FACTORS, the rest left as it is. Chains run alone, by the method that serves
them, without coarser steps at the end and without a second try; those of condition number 30 and more are left out.
The steps that an implicit run takes are a grid of halvings: longer ones allowed can mean shorter ones taken.
Told of each: the chains within the accuracy, the error that 90 % keep and the largest, over the accuracy, and the site
evaluations, over those with the number as it is.
"""

import argparse
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from kernel.ke import PARAMETERS
from kernel.linear import impact_of, modes
from kernel.linear.spectrum import chain_modes
from kernel.method import EXPLICIT, IMPLICIT, MAX_STEPS, MODES, SINGLE_FROM, choose, methods_of
from kernel.model import Chain, make_chain
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import ETA, REFERENCE_ACCURACY, collision, explicit_rule, implicit_rule, whole_substeps
from kernel.status import DONE
from kernel.task import V0
from kernel.watch import PARTS, new_watch
from tests import truth
from tests.convergence import WELL

FACTORS = (0.25, 0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0, 4.0)
# The numbers of each rule, by the name that they have there.
VARIED = {
    EXPLICIT: ("theta", "h_max", "eta", "parts", "fade"),
    IMPLICIT: ("theta", "h_max", "first", "growth", "near_event", "shortest"),
    MODES: ("force_bend", "speed_bend", "steps_per_collision", "longest"),
}
NAMES = {EXPLICIT: "explicit", IMPLICIT: "implicit", MODES: "modes"}
LEAST = 20  # chains of a line: fewer tell nothing


class Case(NamedTuple):
    """One chain, and what is true of it."""

    chain: Chain
    V: float
    KE: float
    method: int


def cases(tasks: Mapping[str, np.ndarray], true: truth.Truth) -> list[Case]:
    """The well-conditioned chains of the tasks."""
    found = []
    for i, (N, zeta_T, M, V) in enumerate(zip(*(tasks[name].tolist() for name in PARAMETERS), strict=True)):
        for k, name in enumerate(truth.CHAINS):
            if true.condition[i, k] < WELL:
                method = int(methods_of(N, N * zeta_T, name == "linear", choose()))
                chain = make_chain(N, zeta_T, M, bistable=name == "bistable")
                found.append(Case(chain, V * V0, float(true.KE[i, k]), method))
    return found


def varied(rule: Any, name: str, factor: float, chain: Chain, accuracy: float) -> Any:
    """The rule with one of its numbers multiplied; a whole number of substeps fills a collision still."""
    if name != "eta":
        return rule._replace(**{name: factor * getattr(rule, name)})
    wanted = factor * ETA * np.sqrt(accuracy / REFERENCE_ACCURACY)
    return rule._replace(eta=whole_substeps(collision(chain), wanted))


def explicit(case: Case, accuracy: float, change: Callable[[Any], Any]) -> tuple[float, int]:
    """Largest KE/TE and site evaluations."""
    rule = change(explicit_rule(case.chain, accuracy))
    one = SINGLE if accuracy >= SINGLE_FROM else DOUBLE
    run = run_explicit(case.chain, case.V, rule, rule, MAX_STEPS, 0.0, new_watch(()), one)
    return told(case, run.speed, run.status), run.site_evaluations


def implicit(case: Case, accuracy: float, change: Callable[[Any], Any]) -> tuple[float, int]:
    """The same by the implicit splitting."""
    rule = change(implicit_rule(case.chain, case.V, accuracy))
    run = run_implicit(case.chain, case.V, rule, rule, MAX_STEPS, new_watch(()))
    return told(case, run.speed, run.status), run.site_evaluations


def by_modes(case: Case, accuracy: float, change: Callable[[Any], Any]) -> tuple[float, int]:
    """The same by the modes."""
    chain = case.chain
    impact = change(impact_of(chain, chain.contact.at_unit_speed(case.V), accuracy))
    exact = chain_modes(chain.N, chain.zeta, chain.site)
    status, steps, speed, _ = modes.march(exact, chain.zeta, impact, chain.t_end, MAX_STEPS, np.zeros(PARTS))
    return told(case, speed * case.V, status), steps * exact.number


RUNS = {EXPLICIT: explicit, IMPLICIT: implicit, MODES: by_modes}


def told(case: Case, speed: float, status: int) -> float:
    """KE/TE of the watched site at this speed; infinite where the run failed, which is beyond any accuracy."""
    return speed**2 / (case.chain.impactor_mass * case.V**2) if status == DONE else np.inf


def tell(some: list[Case], method: int, accuracy: float) -> None:
    """Print the lines of one method."""
    run, cost_as_is = RUNS[method], 0.0
    for name in VARIED[method]:
        for factor in sorted(FACTORS, key=lambda x: x != 1.0):
            errors, cost = [], 0
            for case in some:
                change = partial(varied, name=name, factor=factor, chain=case.chain, accuracy=accuracy)
                KE, sites = run(case, accuracy, change)
                errors.append(abs(KE / case.KE - 1.0) / accuracy)
                cost += sites
            cost_as_is = cost if factor == 1.0 else cost_as_is
            within, most = np.mean(np.array(errors) <= 1.0), np.quantile(errors, 0.9, method="higher")
            print(
                f"{accuracy:.0e} {NAMES[method]:9}{name:20}{factor:5.2f}: {within:7.2%} within, "
                f"90 % {most:8.3g}, worst {max(errors):8.3g}, cost {cost / cost_as_is:6.3f}",
                flush=True,
            )


def main() -> None:
    """Draw and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=400, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--longest", type=int, default=150, metavar="N")
    parser.add_argument("--accuracies", type=float, nargs="+", default=[1e-2, 1e-3, 1e-4])
    args = parser.parse_args()
    tasks = truth.draw(args.random, args.seed, args.longest)
    soft = {name: values[~truth.stiff(tasks)] for name, values in tasks.items()}
    found = cases(soft, truth.truth(soft))
    for method in VARIED:
        some = [case for case in found if case.method == method]
        print(f"{NAMES[method]}: {len(some)} chains of seed {args.seed}")
        if len(some) >= LEAST:
            for accuracy in args.accuracies:
                tell(some, method, accuracy)


if __name__ == "__main__":
    main()
