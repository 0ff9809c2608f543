"""The predicted cost of a task, from its parameters: it sets the order of the work, the plan and the ETA."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel import method
from kernel.method import AFTERWARDS, AUTO, COARSE_TO, PROBE_ACCURACY, RTOL_OVER_ACCURACY, Integrator, looser
from kernel.task import PARAMETERS, T_END_OVER_N
from sweep.plan import chains, laws
from sweep.plan.laws import (
    AUTO_RK45_LAW,
    EXPLICIT_LAW,
    EXPLICIT_MORE,
    FIRST_SITES,
    IMPLICIT_LAW,
    IMPLICIT_MORE,
    RK45_LAW,
    RK45_MORE,
)
from sweep.plan.tasks import Ids, TaskList

TASKS_AT_ONCE = 1 << 16  # bounds the memory of a prediction to some 10 MB
# Of a looser run of both chains by the explicit splitting, what is run: nine in ten linear chains, which take 0.43 of
# the bistable one's time, are not run again (python -m tests.measure, tests.convergence).
COMPARED = 0.73
# The middle of the fit's tasks, by which `features` scales: sites, N zeta_T, to which so much is added that undamped
# tasks have a logarithm, and accuracy; and the decades to which the fit's tasks reach on either side of it.
MIDDLE_N, FEATURE_ZETA, MIDDLE_ACCURACY, DECADES = 50, 0.003, 1e-4, 3.0
LAW_ZETA = 0.01  # in the law of a run (sweep.plan.laws.Law): where dampers are weaker than that they cost nothing
MORE_RANGE = (np.log(1e-3), np.log(5.0))  # of log `more`: few tasks lie outside (python -m tests.calibrate)


def predict_work(
    columns: Mapping[str, NDArray[Any]],
    integrator: Integrator,
    certify: bool,
    model: Any = None,
    quantities: int = 0,
) -> NDArray[np.float64]:
    """Predicted work of each task: seconds on the machine on which the cost model was fitted.

    For tasks that may be chaotic or need refinement this is a mean, from which single tasks differ by far. model: the
    kernel.Model, None for the paper's; quantities: how many are asked for beside the kinetic energy.
    """
    times: Any = chains.factor(model, certify)
    if model is not None:
        columns, integrator = chains.in_own_units(columns, model), chains.integrator_for(model, integrator)
    times = times * chains.of_quantities(columns, integrator, quantities)
    work = np.zeros(len(columns["N"]))
    for which, begun in begun_with(columns, integrator):
        some = {name: values[which] for name, values in columns.items()}
        run = first_run(some, begun)
        if certify:
            work[which] = run + checks(some, begun) + more(some, begun) * run
        elif begun.accuracy > integrator.accuracy:  # two runs are extrapolated
            work[which] = run + first_run(some, looser(begun))
        else:
            work[which] = run
    return np.asarray(work * times)


def begun_with(
    columns: Mapping[str, NDArray[Any]], integrator: Integrator
) -> Iterator[tuple[NDArray[np.bool_], Integrator]]:
    """Which tasks begin with which integrator, as of kernel.extrapolate.first_of."""
    loose, zeta = method.loosened(integrator), columns["N"] * columns["zeta_T"]
    looser_ones = methods(columns, loose) == method.IMPLICIT
    weak = ~looser_ones & (zeta < method.SWITCH)
    yield looser_ones, loose
    yield weak, method.suited_to(0.0, integrator)
    yield ~(looser_ones | weak), integrator


def predict_all(
    tasks: TaskList, ids: Ids, integrator: Integrator, certify: bool, model: Any = None, quantities: int = 0
) -> NDArray[np.float64]:
    """`predict_work` for many tasks of a sweep, part by part."""
    work = np.empty(len(ids))
    for first in range(0, len(ids), TASKS_AT_ONCE):
        part = slice(first, first + TASKS_AT_ONCE)
        work[part] = predict_work(tasks.columns(ids[part]), integrator, certify, model, quantities)
    return work


def checks(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> NDArray[np.float64]:
    """Predicted seconds of the runs that certify always makes: a looser one, and for rk45 two that look for chaos."""
    companion = first_run(columns, looser(integrator))
    if integrator.kind == AUTO:
        return np.where(methods(columns, integrator) == method.EXPLICIT, COMPARED, 1.0) * companion
    return companion + 2.0 * first_run(columns, integrator._replace(kind=AUTO, accuracy=PROBE_ACCURACY))


def more(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> NDArray[np.float64]:
    """Predicted work, over that of the first run, of what certify runs where it finds a reason: disturbed, refined."""
    used = (RK45_MORE,) if integrator.kind != AUTO else (EXPLICIT_MORE, IMPLICIT_MORE)
    exponents: list[Any] = [0.0 for _ in used]
    for i, feature in enumerate(features(columns, integrator)):
        exponents = [exponent + law[i] * feature for exponent, law in zip(exponents, used, strict=True)]
    exponent = np.where(methods(columns, integrator) == method.EXPLICIT, exponents[0], exponents[-1])
    return np.asarray(np.exp(np.clip(exponent, *MORE_RANGE)))


def features(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> Iterator[NDArray[np.float64]]:
    """The terms of log `more`, each (n,): products of two logarithms of parameters; for rk45 a flag too."""
    N, zeta_T, M, V = (np.asarray(columns[name], np.float64) for name in PARAMETERS)
    accuracy = np.full(len(N), integrator.rtol / RTOL_OVER_ACCURACY)
    # Scaled to the middle of the fit's tasks and clipped to its range, outside of which squares grow without reason.
    scaled = (N / MIDDLE_N, FEATURE_ZETA + N * zeta_T, M, V, accuracy / MIDDLE_ACCURACY)
    logs = [np.ones(len(N)), *(np.clip(np.log10(x), -DECADES, DECADES) for x in scaled)]
    yield from (a * b for i, a in enumerate(logs) for b in logs[i:])
    if integrator.kind != AUTO:  # "auto" takes no tolerances of the caller's own
        yield np.full(len(N), float(np.isinf(integrator.target)))


def first_run(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> NDArray[np.float64]:
    """Predicted seconds of one run of both chains."""
    if integrator.kind != AUTO:
        return by_law(columns, RK45_LAW, integrator.rtol)
    served = methods(columns, integrator)
    by_method = {
        method.EXPLICIT: (EXPLICIT_LAW, FIRST_SITES["EXPLICIT"]),
        method.IMPLICIT: (IMPLICIT_LAW, FIRST_SITES["IMPLICIT"]),
        method.DORMAND_PRINCE: (AUTO_RK45_LAW, np.inf),
    }
    choices = [by_law(columns, law, integrator.accuracy, first) for law, first in by_method.values()]
    return np.select([served == code for code in by_method], choices)


def methods(columns: Mapping[str, NDArray[Any]], integrator: Integrator) -> NDArray[np.int64]:
    """The integrator of the bistable chain of each task, as kernel.method numbers them."""
    N, zeta_T = np.ascontiguousarray(columns["N"], np.int64), np.ascontiguousarray(columns["zeta_T"], np.float64)
    return np.asarray(method.methods_of(N, N * zeta_T, False, integrator), np.int64)


def by_law(
    columns: Mapping[str, NDArray[Any]], law: laws.Law, a: float | NDArray[np.float64], first: float = np.inf
) -> NDArray[np.float64]:
    """Predicted seconds of one run of both chains; first: sites that are integrated before the wave comes."""
    N, zeta_T, M, V = (np.asarray(columns[name], np.float64) for name in PARAMETERS)
    zeta, at_once, run = N * zeta_T, np.minimum(first, N), np.asarray(columns.get("crossings", T_END_OVER_N))
    fewer = (AFTERWARDS / np.minimum(a, AFTERWARDS)) ** law.a
    later = np.maximum(run - 1.0, 0.0) * np.where(run > COARSE_TO, 1.0, 1.0 - law.coarse * (1.0 - fewer))
    front = N * np.minimum(run, 1.0)
    beyond = np.maximum(front, at_once)
    each = N * N * later + at_once * np.minimum(front, at_once) + (beyond**2 - at_once**2) / 2.0
    size = law.impact * (at_once + law.sites) + each + law.sites * (front + N * later)
    smooth = law.c * a**law.a * V**law.V * M**law.M * (LAW_ZETA + zeta) ** law.damping
    return np.asarray((smooth + law.stiff * zeta) * size + law.start)
