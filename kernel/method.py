"""Which integrator, how tight: a value that the compiled code takes as it is, and which method then serves a chain."""

import math
from typing import Any, NamedTuple

import numpy as np

from kernel.hints import shown, unknown
from kernel.problems import ProblemsError
from kernel.task import RTOL_MAX, RTOL_MIN, broken_rule

AUTO, RK45 = range(2)
METHODS = ("auto", "rk45")
MAX_STEPS = 200_000_000
ACCURACY = 1e-3  # wanted relative error of ke_ratio unless another one is asked for: what a fit needs

# ode45's default AbsTol over its default RelTol; the absolute tolerance follows the relative one at this ratio.
ATOL_OVER_RTOL = 1e-3

# Measured on the reference tasks (tests/data/references.csv), so that 95 of 100 well-conditioned ones reach their
# target: "auto" is set to this share of it. Steps cannot be longer than at COARSEST. A certified run is
# tighter: coarser ones agree with their companions by chance, and find too little of the chaos.
SHARE, COARSEST, COARSEST_CERTIFIED = 0.3, 3e-2, 1e-3
# Accuracy from which on two runs of the implicit splitting are extrapolated. What is left is of twice their order: as
# much smaller than the accuracy as that is than this.
EXTRAPOLATED = 1e-4
# Accuracy below which "auto" is Dormand-Prince where dampers are weak: the slope of the contact's force, which jumps as
# it closes, caps the order of the explicit splitting. Of 250 random tasks certified ones take 0.85 of Dormand-Prince's
# time at a target of 1e-6, and 1.4 times it at 1e-7.
FINEST_SPLITTING = 1e-7
RTOL_OVER_ACCURACY = 1e-3

# A run that blew up, or whose middle site has all the energy and by its error more, is done again, this much tighter.
RETRIES, RETRY_TIGHTER = 3, 8.0

# The companion run, from which the error is estimated, is NEAR times looser where the run's accuracy is above
# NEAR_FROM, as the errors of coarse steps do not fall regularly yet; FAR times, which costs less, where it is below.
# A refinement of "auto" is as much tighter. Of 10679 random tasks the median estimate is 10 times the error at a
# target of 1e-3; with FAR it would be 17 times.
NEAR, FAR, NEAR_FROM, COMPANION_RTOL = math.sqrt(10.0), 10.0, 2e-4, 4.0
PROBE_ACCURACY = 3e-5  # of the splitting that asks for chaos where Dormand-Prince was wanted

# Accuracy of the steps after sound has crossed the chain, which show what comes later (kernel.arrival), and the longest
# runs of which they do, in times that sound takes to cross. With these steps a linear chain at 3e-4 takes 0.6 of its
# time, one at 3e-5 half; strongly damped bistable ones 0.83 and 0.74. Of 1471 random linear chains and 1648 damped
# ones, each at three to five accuracies, the peak of none changes. Sharp crests lose height with each reflection: of
# random chains of any contact that run for 1 to 3 such times the peak of none in 196768 changed, for 3 to 16 that of 15
# in 37646, by up to 21 % (no program repeats this).
AFTERWARDS, COARSE_TO = 1e-2, 3.0

# When a search screens tasks, tasks that differ in impact speed share one linear chain, struck at the nearest of a few
# speeds. This is the ratio of two neighbouring ones. The linear chain answers in proportion to the speed, except that
# the contact lasts longer at lower speeds (as V^(-1/5)). Of 600 random tasks of the domain 99 in 100 are then off by
# less than 3 % in energy over TE, less than screening is off anyway; with ratios from 2 to one speed for all, searches
# find the same lowest. With a contact a hundred thousand times softer the error is 16 %, and would be 50 % with one
# speed for all (python -m tests.search_constants --speeds).
SHARED_SPEED_RATIO = 4.0


class Integrator(NamedTuple):
    """A method and how it is set. `choose` makes checked ones."""

    kind: int  # AUTO or RK45
    target: float  # wanted relative error of ke_ratio; infinite where the caller set the tolerances
    accuracy: float  # of "auto": relative error of the peak energy that the steps are chosen for
    rtol: float  # of rk45
    atol: float
    max_steps: int  # tried steps of one run, after which it ends with a status

    def __str__(self) -> str:
        if self.kind == AUTO:
            return f"auto at target {self.target:g}"
        return f"rk45 at rtol {self.rtol:g}, atol {self.atol:g}"


def choose(
    method: str = "auto",
    accuracy: float = ACCURACY,
    rtol: float | None = None,
    atol: float | None = None,
    max_steps: int = MAX_STEPS,
    *,
    certify: bool = True,
) -> Integrator:
    """The integrator for a wanted relative error of ke_ratio, or rk45 at tolerances of the caller's own.

    certify: whether its results are judged by a companion run.

    Raises ValueError naming every argument that breaks its rule.
    """
    given: dict[str, object] = {"accuracy": accuracy, "max_steps": max_steps}
    given |= {name: value for name, value in (("rtol", rtol), ("atol", atol)) if value is not None}
    broken = [line for name, value in given.items() if (line := broken_rule(name, value))]
    if not isinstance(method, str) or method not in METHODS:
        broken.append(unknown("method", method, METHODS))
    if broken := [*broken, *stray(method, rtol, atol)]:
        raise ProblemsError(broken)
    kind = AUTO if method == "auto" else RK45
    target = float(accuracy) if rtol is None else math.inf
    if rtol is None:
        rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * accuracy)
    atol = ATOL_OVER_RTOL * rtol if atol is None else atol
    reached = min(COARSEST_CERTIFIED if certify else COARSEST, SHARE * float(accuracy))
    return Integrator(kind, target, reached, float(rtol), float(atol), int(max_steps))


def stray(method: object, rtol: object, atol: object) -> list[str]:
    """What is wrong with tolerances beside "auto", which has its own: a line for each."""
    given = {"rtol": rtol, "atol": atol} if isinstance(method, str) and method == "auto" else {}
    rule = 'stands only with method = "rk45", since "auto" chooses its steps by the accuracy wanted'
    return [f"{name}: {rule}, got {shown(value)}" for name, value in given.items() if value is not None]


def reference(x: Integrator) -> Integrator:
    """What serves chains that are not uniform: Dormand-Prince, in place of "auto" at its tolerances for the target."""
    if x.kind == RK45:
        return x
    rtol = max(RTOL_MIN, RTOL_OVER_ACCURACY * x.target)
    return Integrator(RK45, x.target, x.accuracy, rtol, ATOL_OVER_RTOL * rtol, x.max_steps)


def looser(x: Integrator) -> Integrator:
    """The companion's method. Compiled where it is used, as `methods_of` is: this file needs no compiler."""
    rtol, step = min(RTOL_MAX, x.rtol * COMPANION_RTOL), NEAR if x.accuracy > NEAR_FROM else FAR
    return Integrator(x.kind, x.target, x.accuracy * step, rtol, x.atol * COMPANION_RTOL, x.max_steps)


def suited_to(zeta: float, x: Integrator) -> Integrator:
    """What serves a chain of this intersite damping ratio; compiled as `looser` is."""
    beyond = x.kind == AUTO and x.accuracy < FINEST_SPLITTING and zeta < SWITCH
    return Integrator(RK45 if beyond else x.kind, x.target, x.accuracy, x.rtol, x.atol, x.max_steps)


def loosened(x: Integrator) -> Integrator:
    """What begins a task whose first two runs are extrapolated; compiled as `looser` is."""
    reached = math.sqrt(EXTRAPOLATED * min(x.target, EXTRAPOLATED))
    return Integrator(x.kind, x.target, max(x.accuracy, reached), x.rtol, x.atol, x.max_steps)


def at_accuracy(accuracy: float, x: Integrator) -> Integrator:
    """What "auto" takes for this accuracy, within the bounds of x; compiled as `looser` is."""
    return Integrator(AUTO, x.target, accuracy, x.rtol, x.atol, x.max_steps)


def shared_speed(V_over_V0: Any) -> Any:
    """The speeds, over V0, at which linear chains that tasks share are struck instead of at these, (n,)."""
    return SHARED_SPEED_RATIO ** np.round(np.log(V_over_V0) / math.log(SHARED_SPEED_RATIO))


# From this intersite damping ratio on the dampers are implicit. Below, they hardly limit the explicit step.
SWITCH = 0.4
# What an Integrator leaves to be chosen for each chain. EXPLICIT and IMPLICIT: kernel.splitting; MODES: kernel.linear.
EXPLICIT, IMPLICIT, DORMAND_PRINCE, MODES = range(4)
METHOD_WORDS = ("explicit", "implicit", "rk45", "modes")
# From this accuracy on the explicit splitting keeps the chain in single precision, twice as many sites to an operation:
# rounding then moves the peak energy of a well-conditioned task by 1e-6 in the median (5e-6 at most, of 120 chains in
# tests/test_kernel_precision.py), steps by a tenth of the accuracy and more. Not of springs without stiffness at rest,
# whose tension is far below their strain. Nor does the implicit splitting: strong dampers leave motion so slow that
# single strains stand still, which moved peaks of 1000 sites by 1e-4 for a gain of a tenth up to 500 sites.
SINGLE_FROM = 5e-5
# Where dampers are implicit, Dormand-Prince is cheaper for
#     n (N zeta_T)^DAMPING_POWER < COST_FACTOR accuracy^ACCURACY_POWER
# with n = N, or SITES_COUNTED where the impact's own steps no longer count: measured on 166 tasks of 2 to 1000 sites,
# N zeta_T from 0.4 to 30, at four targets (no program repeats it). With RTOL_SHARE of the accuracy as its rtol it was
# within a third of the target; a looser one is no cheaper, as dampers bound its steps.
SITES_COUNTED, COST_FACTOR, DAMPING_POWER, ACCURACY_POWER, RTOL_SHARE = 200, 1.27, 0.65, -0.42, 1.0 / 30.0


def methods_of(N: Any, zeta: Any, linear: bool, integrator: Integrator) -> Any:
    """The method that integrates a chain of N sites and intersite damping ratio zeta = N zeta_T; a pure function.

    Without branches on either: it takes arrays (n,) in NumPy, and numbers in compiled code.
    """
    if integrator.kind == RK45:
        return DORMAND_PRINCE + 0 * N
    damped = MODES
    if not linear:
        sites = np.minimum(N, SITES_COUNTED)
        cheaper = sites * zeta**DAMPING_POWER < COST_FACTOR * integrator.accuracy**ACCURACY_POWER
        damped = IMPLICIT + (DORMAND_PRINCE - IMPLICIT) * cheaper
    return EXPLICIT + (damped - EXPLICIT) * (zeta >= SWITCH)
