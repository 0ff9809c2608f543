"""Contacts as hard as the paper's and harder: what chains are off by, and what the substeps of an open contact do.

    python -m tests.hard_contacts [--random 450] [--seed S] [--accuracies 1e-1 1e-2 1e-3 1e-4]

Lightly damped chains of 2 to 60 sites, struck by impactors of 0.1 to 100 M0 through contacts of 1e6 to 1e12, of which
the first site, that at a fifth of the chain, or the middle one is watched. The truth is Dormand-Prince's at rtol 1e-10,
and calm are tasks whose condition number, certified at 1e-5, is below WELL. Told of each site and accuracy, certified
rows: how many of the calm ones are called chaotic, or miss it, the worst, and the share of errors that `error` covers;
rows that are not certified: how many miss it, by more than FAR times, the worst. Then of either chain alone by the
explicit splitting the same, and the cost, with the substeps of an open contact as they are and with the paper's for
all contacts (PERIOD_OF_PARTS in kernel.splitting.rules).
"""

import argparse
import math
import time
from functools import partial
from typing import NamedTuple

import numpy as np

from kernel import Hertz, KeRatio, Model, ke_ratio
from kernel.method import EXPLICIT, SHARE
from kernel.model import frequency_of, lattice_chain, linear_chain
from kernel.splitting.rules import PERIOD_OF_PARTS
from kernel.task import M0, V0
from tests.steps import Case, explicit, varied

WELL, FAR = 100.0, 5.0
SITES = (1e-4, 0.2, 0.5)
PLACES = ("first site", "a fifth", "middle")


class Struck(NamedTuple):
    """A task, and its chain."""

    task: tuple[int, float, float, float]
    model: Model


def draw(count: int, seed: int) -> list[Struck]:
    """Random tasks; every third is watched at each of SITES."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    found = []
    for k in range(count):
        N = round(between(2, 60))
        zeta_T = 0.0 if rng.random() < 0.15 else between(1e-5, 0.39 / N)
        contact = Hertz(between(1e6, 1e12), float(rng.choice([1.2, 1.5, 2.0, 3.0], p=[0.15, 0.55, 0.15, 0.15])))
        t_end = 2.25 if rng.random() < 0.7 else between(1, 6)
        model = Model(contact=contact, site=SITES[k % 3], t_end=t_end)
        found.append(Struck((N, zeta_T, between(0.1, 100), between(0.05, 20)), model))
    return found


def calm(drawn: list[Struck]) -> list[tuple[Struck, KeRatio]]:
    """Those that are calm, with what is true of them."""
    found = []
    for one in drawn:
        known = ke_ratio(*one.task, 1e-5, model=one.model)
        if known.status == "done" and not known.chaotic and known.condition < WELL:
            true = ke_ratio(*one.task, method="rk45", rtol=1e-10, atol=1e-14, certify=False, model=one.model)
            found += [(one, true)] if true.status == "done" else []
    return found


def of_rows(some: list[tuple[Struck, KeRatio]], accuracy: float) -> str:
    """What certified rows, and rows that are not, are off by."""
    rows = [ke_ratio(*one.task, accuracy, model=one.model) for one, _ in some]
    plain = [ke_ratio(*one.task, accuracy, certify=False, model=one.model) for one, _ in some]
    off = np.array(
        [
            [abs(row.ke_ratio / true.ke_ratio - 1) for row, (_, true) in zip(all_, some, strict=True)]
            for all_ in (rows, plain)
        ]
    )
    flagged = np.array([bool(row.chaotic) or row.status != "done" for row in rows])
    error = np.array([row.error for row in rows])
    held = off[0][~flagged]
    return (
        f"certified {flagged.sum():4} flagged, {(held > accuracy).sum():4} beyond, worst {held.max() / accuracy:8.3g}, "
        f"covers {np.mean(error[~flagged] >= held):6.1%}; {_beyond(off[1] / accuracy)}"
    )


def of_chains(some: list[tuple[Struck, KeRatio]], accuracy: float, as_is: bool) -> tuple[str, int]:
    """What chains alone are off by at this accuracy of their steps, and their site evaluations."""
    off, cost = [], 0
    for one, true in some:
        N, zeta_T, M, V = one.task
        lattice = one.model.lattice(N)
        for make, KE in ((lattice_chain, true.ke_bistable), (linear_chain, true.ke_linear)):
            chain = make(N, zeta_T, M * M0, lattice)
            share = 1.0 if as_is else math.sqrt(min(1.0, chain.contact.period(1.0, 0.5) / PERIOD_OF_PARTS))
            change = partial(varied, name="parts", factor=share, chain=chain, accuracy=accuracy)
            found, sites = explicit(Case(chain, V * V0 / frequency_of(lattice), KE, EXPLICIT), accuracy, change)
            off.append(abs(found / KE - 1.0) / accuracy)
            cost += sites
    return f"{len(off):5} chains, {_beyond(np.array(off))}", cost


def _beyond(off: np.ndarray) -> str:
    return f"{(off > 1).sum():4} beyond, {(off > FAR).sum():4} by far, worst {off.max():8.3g}"


def main() -> None:
    """Draw and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=450, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--accuracies", type=float, nargs="+", default=[1e-1, 1e-2, 1e-3, 1e-4])
    args = parser.parse_args()
    found = calm(draw(args.random, args.seed))
    print(f"{len(found)} calm tasks of seed {args.seed}")
    for accuracy in args.accuracies:
        for site, place in zip(SITES, PLACES, strict=True):
            some = [pair for pair in found if pair[0].model.site == site]
            print(f"{accuracy:.0e} {place:10} of {len(some):4}: {of_rows(some, accuracy)}", flush=True)
        steps = SHARE * accuracy
        (here, cost), (there, other) = (of_chains(found, steps, as_is) for as_is in (True, False))
        print(f"{accuracy:.0e} alone, as it is:      {here}")
        print(f"{accuracy:.0e} alone, as the paper's: {there}, cost {other / cost:.3f}", flush=True)


if __name__ == "__main__":
    main()
