"""What the tests of the splitting integrators share: their tasks, and a run by either scheme."""

import numpy as np

from kernel.integrate import run_by
from kernel.laws.bistable import Bistable
from kernel.laws.hertz import ThreeHalves
from kernel.method import EXPLICIT, IMPLICIT, SWITCH
from kernel.model import make_chain
from kernel.simd import DOUBLE
from kernel.splitting import (
    explicit,
    implicit,
    lanes,
    rules,
)
from kernel.task import M0, V0
from kernel.watch import new_watch

LAWS = ("bistable", "linear")
LINEAR = Bistable(0.0, 0.0)


def peak(N, zeta_T, M, V, accuracy=1e-3, law="bistable", max_steps=10**8, K=None):
    """A task in the paper's ratios by a splitting; the run and the peak energy over the initial one."""
    chain = make_chain(N, zeta_T, M, bistable=law == "bistable")
    chain = chain if K is None else chain._replace(contact=ThreeHalves(K))
    method = EXPLICIT if chain.zeta < SWITCH else IMPLICIT
    out = run_by(method, chain, V * V0, 0.0, accuracy, max_steps, new_watch(()))
    return out, out.speed**2 / (N * M * M0 * (V * V0) ** 2)


def random_tasks(count, seed, largest):
    """Log-uniform in the paper's domain, one in four undamped."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        N = int(np.exp(rng.uniform(np.log(2), np.log(largest + 1))))
        zeta_T, M, V = 10 ** rng.uniform((-5, -1, -1), (0, 1, 1))
        yield N, 0.0 if i % 4 == 0 else float(zeta_T), float(M), float(V)


def runs(N, zeta_T, M, V, accuracy, law, method, one=DOUBLE):
    """One attempt by either scheme, whatever the rule says; one: of the explicit one's precision."""
    chain, speed = make_chain(N, zeta_T, M, bistable=law == "bistable"), V * V0
    if method == EXPLICIT:
        rule = rules.explicit_rule(chain, accuracy)
        return chain, explicit.run_explicit(chain, speed, rule, rule, 10**8, 0.0, new_watch(()), one)
    rule = rules.implicit_rule(chain, speed, accuracy)
    return chain, implicit.run_implicit(chain, speed, rule, rule, 10**8, new_watch(()))


def numbered_lanes(N):
    f = lanes.new_lanes(N)
    lanes.number(f, N)
    return f
