"""One impact on one chain, by the method that the chain and the accuracy ask for."""

import math
from typing import Any, NamedTuple

from kernel import rk45
from kernel.arrival import may_be_coarse
from kernel.jit import either, outer
from kernel.linear import is_soft_enough, run_modes
from kernel.method import (
    AFTERWARDS,
    ATOL_OVER_RTOL,
    DORMAND_PRINCE,
    EXPLICIT,
    IMPLICIT,
    MODES,
    RETRIES,
    RETRY_TIGHTER,
    RK45,
    RTOL_SHARE,
    SINGLE_FROM,
    Integrator,
    methods_of,
)
from kernel.model import Array, Chain
from kernel.run import Run
from kernel.simd import DOUBLE, SINGLE
from kernel.splitting.explicit import run_explicit
from kernel.splitting.implicit import run_implicit
from kernel.splitting.rules import explicit_rule, implicit_rule
from kernel.status import DONE, NOT_FINITE
from kernel.subnormals import flush_subnormals, restore_subnormals
from kernel.varied import MASS, own
from kernel.watch import Watch, blind_watch, forget, largest_of, new_watch, told_by_splittings

method_of = outer(methods_of)


@outer
def suited(varied: Any, method: int) -> int:
    """The method, or Dormand-Prince where the chain is not uniform."""
    if varied is None:
        return method
    return DORMAND_PRINCE


@outer
def told_by_modes(chain: Chain, V: float) -> bool:
    """Whether modes tell the watched site: near the struck end, and before sound comes, they all but cancel there."""
    return 2 * chain.site >= chain.N and chain.t_end >= chain.site and is_soft_enough(chain, V)


class Peak(NamedTuple):
    """The largest kinetic energy of the middle site, and the run that tells it."""

    run: Run
    method: int  # index into kernel.method.METHOD_WORDS
    KE: float  # over continuous time, over TE
    crests: Array  # (PARTS,): the same of each part of the run
    largest: Array  # (quantities,): largest magnitudes of what else was asked for, over its scale


@outer
def peak_of(chain: Chain, V: float, noise: float, integrator: Integrator, quantities: Any, watched: bool) -> Peak:
    """Run one impact at speed V to the end.

    noise: size of random first velocities of the sites, over V; where dampers are strong they are left at rest;
    quantities: tuple of kernel.quantities; watched: whether they are looked at, which changes no peak.
    """
    unit = own(chain.varied, MASS, chain.site) / (chain.impactor_mass * V * V)  # of KE over TE, per squared speed
    method = suited(chain.varied, method_of(chain.N, chain.zeta, chain.spring.is_linear(), integrator))
    if method == MODES and not told_by_modes(chain, V):
        method = IMPLICIT
    watch = new_watch(quantities) if watched else blind_watch(quantities)
    if method == DORMAND_PRINCE:
        run = _by_dormand_prince(chain, V, noise, integrator, watch)
    else:
        run = _fast(chain.varied)(method, chain, V, noise, integrator.accuracy, integrator.max_steps, watch)
    crests, largest = unit * watch.crests**2, largest_of(watch, chain, V)
    if len(quantities) > 0 and watched and run.status == DONE:
        again = method  # one call for both: numba would compile each with a method of its own
        if method != DORMAND_PRINCE and not told_by_splittings(chain, quantities):
            again = DORMAND_PRINCE
        elif method == MODES:  # which know of the watched site and the contact alone
            again = IMPLICIT
        if again != method:
            run, largest = _seen_again(chain, V, integrator, quantities, run, again)
    return Peak(run, method, unit * run.speed**2, crests, largest)


@outer
def _seen_again(
    chain: Chain, V: float, integrator: Integrator, quantities: Any, run: Run, method: int
) -> tuple[Run, Array]:
    """The quantities of a chain by another method than that of `run`; its steps with those that this took."""
    watch = new_watch(quantities)
    if method == DORMAND_PRINCE:
        more = _by_dormand_prince(chain, V, 0.0, integrator, watch)
    else:
        more = _fast(chain.varied)(method, chain, V, 0.0, integrator.accuracy, integrator.max_steps, watch)
    largest = largest_of(watch, chain, V)
    if more.status != DONE:
        largest[:] = math.nan
    steps, evaluations = run.steps + more.steps, run.evaluations + more.evaluations
    sites = run.site_evaluations + more.site_evaluations
    return Run(run.status, run.speed, run.t, steps, evaluations, sites, run.energy, run.retries), largest


@outer
def _by_dormand_prince(chain: Chain, V: float, noise: float, integrator: Integrator, watch: Watch) -> Run:
    """At the caller's tolerances, or at those with which it reaches the accuracy."""
    rtol, atol = integrator.rtol, integrator.atol
    if integrator.kind != RK45:
        whole = chain.impactor_mass / chain.N * V  # the speed of a chain that has all the momentum
        rtol = RTOL_SHARE * integrator.accuracy
        atol = ATOL_OVER_RTOL * rtol * min(1.0, whole)
    return rk45.integrate(chain, V, rtol, atol, integrator.max_steps, chain.t_end, watch, noise)


@outer
def accuracy_afterwards(chain: Chain, accuracy: float, watch: Watch) -> float:
    """The accuracy of the steps that a run takes after sound has crossed the chain: coarse where nothing is lost by it.

    Where quantities or a film look at more than the watched site, all steps have the accuracy of the run.
    """
    alone = len(watch.quantities) == 0 and watch.film is None
    return max(AFTERWARDS, accuracy) if alone and may_be_coarse(chain) else accuracy


@outer
def run_by(method: int, chain: Chain, V: float, noise: float, accuracy: float, max_steps: int, watch: Watch) -> Run:
    """One impact by EXPLICIT, IMPLICIT or MODES; a run that blew up is done again with smaller steps.

    accuracy: wanted relative error of the peak energy; max_steps: retries included; noise: of EXPLICIT only. The speed
    is nan where every run blew up.
    """
    retries, steps, evaluations, sites = 0, 0, 0, 0
    word = flush_subnormals()
    while True:
        forget(watch)
        left = max_steps - steps
        after = accuracy_afterwards(chain, accuracy, watch)
        if method == EXPLICIT:
            rule, later = explicit_rule(chain, accuracy), explicit_rule(chain, after)
            if accuracy >= SINGLE_FROM and chain.spring.stiffness_at(0.0) > 0.0:
                run = run_explicit(chain, V, rule, later, left, noise, watch, SINGLE)
            else:
                run = run_explicit(chain, V, rule, later, left, noise, watch, DOUBLE)
        elif method == IMPLICIT:
            run = run_implicit(chain, V, implicit_rule(chain, V, accuracy), implicit_rule(chain, V, after), left, watch)
        else:
            run = run_modes(chain, V, accuracy, left, watch.crests)
        steps += run.steps
        evaluations += run.evaluations
        sites += run.site_evaluations
        if run.status != NOT_FINITE or retries == RETRIES:
            break
        retries += 1
        accuracy /= RETRY_TIGHTER
    restore_subnormals(word)
    speed, t = (run.speed, run.t) if run.status != NOT_FINITE else (math.nan, math.nan)
    return Run(run.status, speed, t, steps, evaluations, sites, run.energy, retries)


@outer
def _by_none(method: int, chain: Chain, V: float, noise: float, accuracy: float, max_steps: int, watch: Watch) -> Run:
    return Run(NOT_FINITE, math.nan, math.nan, 0, 0, 0, math.nan, 0)


_fast = either(run_by, _by_none)  # by the other methods, which no chain that is not uniform asks for
