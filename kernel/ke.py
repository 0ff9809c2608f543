"""ke_ratio of many tasks or of one: both chains, their peaks, an error estimate.

A task is computed by itself: its bits depend neither on its neighbours in the batch nor on who computes it.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.columns import RESULT, KeRatio, bad_rows, columns_of, columns_of_quantity, result_type, whole
from kernel.lattice import PAPER_MODEL, Model, check_comparable, names_of_numbers
from kernel.method import ACCURACY, MAX_STEPS, METHOD_WORDS, Integrator, choose, reference, shared_speed
from kernel.model import time_of_sound
from kernel.solve import CODED, screen, solve
from kernel.status import BAD_INPUT, WORDS
from kernel.task import M0, V0, Task, check, gathered
from kernel.task import PARAMETERS as PARAMETERS
from kernel.threads import in_threads

WORDS_OF = {"method": METHOD_WORDS, "status": WORDS}
NO_QUANTITIES: Mapping[str, Any] = {}


def ke_ratio(
    N: int,
    zeta_T: float,
    M_over_M0: float,
    V_over_V0: float,
    accuracy: float = ACCURACY,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    *,
    certify: bool = True,
    max_steps: int = MAX_STEPS,
    model: Model = PAPER_MODEL,
) -> KeRatio:
    """Peak kinetic energy of the middle site, bistable over linear chain, for one impact (paper section 3).

    Parameters
    ----------
    N : int
        Number of unit cells, 2 to 10 000; 200.0 is 200.
    zeta_T : float
        Bulk damping ratio, 0 to 10.
    M_over_M0 : float
        Impactor mass over the nominal one (0.159 of the chain's mass), 0.01 to 100.
    V_over_V0 : float
        Impact speed over the nominal one (0.26 long-wave sound speeds), 0.01 to 20.
    accuracy : float
        Wanted relative error of ke_ratio, 1e-8 to 0.1; beside `rtol` it does not count.
    method : str
        "auto" chooses by accuracy and physics; "rk45" is Dormand-Prince 5(4), the paper's.
    rtol, atol : float, optional
        Relative (1e-13 to 0.1) and absolute (above 0) tolerance of a step, with method="rk45" only; without them they
        follow from `accuracy`.
    certify : bool
        False leaves out error and check for chaos, and most of the work; above an accuracy of 1e-3 it takes looser
        steps, too.
    max_steps : int
        Tried steps of one integration, 1 to 10**15, after which the status is "step_budget"; a step of the explicit
        splitting in which the impactor touches the chain is asked for as a whole, substeps included.
    model : Model
        The chain: its laws, how long and at which site it is watched; the paper's by default. Another spring law, a
        contact of another exponent and a chain that is not uniform are compiled when they are first used, which takes
        half a minute to three minutes, once.

    Returns
    -------
    KeRatio
        `ke_ratio`, below 1 where the bistable chain protects better, its estimated relative `error`, whether it is
        `chaotic`, `status`, "done" or why not, and what else stands at `kernel.KeRatio`. What is not known is nan.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule, with the rule and the value.

    Examples
    --------
    >>> import kernel
    >>> r = kernel.ke_ratio(N=20, zeta_T=4e-4, M_over_M0=2, V_over_V0=2)
    >>> print(f"{r.ke_ratio:.3f} {r.status} {r.chaotic}")
    2.155 done False
    """
    task, integrator, _, _ = gathered(
        lambda: Task(N, zeta_T, M_over_M0, V_over_V0),
        lambda: choose(method, accuracy, rtol, atol, max_steps, certify=certify),
        lambda: check({"certify": certify}),
        lambda: check_comparable(model, N),
    )
    columns = {name: np.array([getattr(task, name)]) for name in PARAMETERS}
    row = results_of(columns, integrator, bool(certify), model=model)[0]
    told = {name: row[name].item() for name in RESULT.names or () if name not in PARAMETERS}
    return KeRatio(**told | {"chaotic": told["chaotic"] if told["checked"] else None})


def ke_ratios(
    tasks: Any,
    accuracy: float = ACCURACY,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    *,
    certify: bool = True,
    max_steps: int = MAX_STEPS,
    model: Model = PAPER_MODEL,
    workers: int = 1,
) -> NDArray[np.void]:
    """ke_ratio of many tasks, each with the bits that `ke_ratio` gives.

    Parameters
    ----------
    tasks : mapping, structured array, data frame, array (n, 4), or sequence of Task
        The columns N, zeta_T, M_over_M0, V_over_V0, each a number or (n,), or these four in that order; units and
        ranges are those of `ke_ratio`. N may be floats without a fraction. Columns that are named as numbers of the
        model, as "spring.c2", give each task its own; the result has them too. A column whose name begins with
        "spring.", "contact.", "mass.", "stiffness." or "damping." must be one of these; others are left alone.
    accuracy, method, rtol, atol, certify, max_steps, model
        As of `ke_ratio`.
    workers : int
        Threads, 1 to 1024, that share the tasks: as many as there are cores to use. The bits do not depend on it.
        Ctrl-C is obeyed after the tasks that are being computed.

    Returns
    -------
    structured array (n,)
        In the tasks' order, ready for pandas.DataFrame: the inputs N (int64), zeta_T, M_over_M0, V_over_V0, then the
        results of `ke_ratio`; `method` and `status` are str. `chaotic` is False where not `checked`. A task whose
        parameters break a rule has the status "bad_input" and no numbers; the others are computed. Its inputs are as
        given, but for an N that is no whole number, which such a column cannot hold: it is -1.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule, every column that is missing, of another length or shape, holds
        something else than numbers, or is named as a number that the model lacks.

    Examples
    --------
    >>> import kernel
    >>> rows = kernel.ke_ratios({"N": [10, 1], "zeta_T": 1e-3, "M_over_M0": 1, "V_over_V0": 1})
    >>> rows["N"].tolist(), rows["status"].tolist()
    ([10, 1], ['done', 'bad_input'])
    """
    columns, integrator, _, _ = gathered(
        lambda: columns_of(tasks, also=names_of_numbers(model)),
        lambda: choose(method, accuracy, rtol, atol, max_steps, certify=certify),
        lambda: check({"certify": certify, "workers": workers}),
        lambda: check_comparable(model),
    )
    return rows_of(columns, integrator, bool(certify), model, NO_QUANTITIES, int(workers))


def rows_of(
    columns: Mapping[str, NDArray[Any]],
    integrator: Integrator,
    certify: bool,
    model: Model,
    quantities: Mapping[str, Any],
    workers: int,
) -> NDArray[np.void]:
    """A row of every task, also of those whose parameters break a rule."""
    axes = tuple(name for name in columns if name not in PARAMETERS)
    bad = bad_rows(columns) | bad_models(columns, model)
    if model.sites is not None:
        bad |= columns["N"] != model.sites
    results = np.zeros(len(bad), result_type(*quantities, axes=axes))
    for name in results.dtype.names or ():
        if results.dtype[name].kind == "f":
            results[name] = np.nan
    for name in columns:
        results[name] = whole(columns[name]) if name == "N" else columns[name]
    results["status"] = WORDS[BAD_INPUT]
    good = {name: values[~bad] for name, values in columns.items()}

    def rows(part: slice) -> NDArray[np.void]:
        some = {name: values[part] for name, values in good.items()}
        return results_of(some, integrator, certify, quantities=quantities, model=model)

    results[~bad] = in_threads(int(np.sum(~bad)), workers, rows)
    return results


def _groups(
    columns: Mapping[str, NDArray[Any]], more: tuple[str, ...] = ()
) -> Iterator[tuple[dict[str, float], NDArray[np.intp]]]:
    """The tasks that share all numbers of the model that have columns, and these `more`: these numbers, and where."""
    names = [*more, *(name for name in columns if name not in PARAMETERS)]
    count = len(columns[PARAMETERS[0]])
    if not count:
        return
    if not names:
        yield {}, np.arange(count)
        return
    values = np.stack([np.asarray(columns[name], np.float64) for name in names], axis=1)
    each, which = np.unique(values, axis=0, return_inverse=True)
    ends = np.cumsum(np.bincount(which.ravel()))[:-1]
    for numbers, places in zip(each, np.split(np.argsort(which.ravel(), kind="stable"), ends), strict=True):
        yield dict(zip(names, numbers.tolist(), strict=True)), places


def bad_models(columns: Mapping[str, NDArray[Any]], model: Model) -> NDArray[np.bool_]:
    """Which tasks, (n,), have a number of the model that breaks its rule, or leaves no linear chain to compare with."""
    bad = np.zeros(len(columns[PARAMETERS[0]]), np.bool_)
    for numbers, places in _groups(columns):
        try:
            check_comparable(model.with_numbers(numbers))
        except ValueError:
            bad[places] = True
    return bad


def results_of(
    columns: Mapping[str, NDArray[Any]],
    integrator: Integrator,
    certify: bool,
    disturbance: float = 0.0,
    quantities: Mapping[str, Any] = NO_QUANTITIES,
    model: Model = PAPER_MODEL,
    until: float = math.inf,
    shared: bool = False,
) -> NDArray[np.void]:
    """ke_ratios for parameters and an integrator that are checked already.

    disturbance: of mass, speed, damping and first velocities (kernel.pairs.beside); with `certify` it must be 0.
    quantities: those of kernel.quantities that are asked for, by name; their columns follow the others. Columns that
    are none of the four parameters are numbers of the model. until: runs end after so many times what sound takes to
    the watched site, if not before; those of the linear chain do not. shared: the linear chain is struck at the nearest
    of some speeds, so that tasks that differ in speed alone share its run (kernel.solve.screen), nothing is certified,
    quantities are nan.
    """
    axes = tuple(name for name in columns if name not in PARAMETERS)
    results = np.empty(len(columns["N"]), result_type(*quantities, axes=axes))
    for name in columns:
        results[name] = columns[name]
    if not model.is_uniform:
        integrator = reference(integrator)
    for numbers, places in _groups(columns, () if model.is_uniform else ("N",)):
        length = int(numbers.pop("N", 0))  # of all chains of the group, where they are not uniform
        lattice = (model.with_numbers(numbers) if numbers else model).lattice(length)
        if until < math.inf:
            lattice = lattice._replace(until=until * time_of_sound(lattice, length))
        if shared:  # those that share a run one after the other
            near = shared_speed(columns["V_over_V0"][places])
            places = places[np.lexsort((near, *(columns[name][places] for name in PARAMETERS[2::-1])))]
        N = np.ascontiguousarray(columns["N"][places], np.int64)
        zeta_T, M, V = (np.ascontiguousarray(columns[name][places], np.float64) for name in PARAMETERS[1:])
        coded, more = np.empty(len(N), CODED), np.full((len(N), len(quantities), 4), np.nan)
        asked = tuple(quantities.values())
        if shared:
            screen(N, zeta_T, M * M0, V * V0, shared_speed(V) * V0, lattice, integrator, coded)
        else:
            solve(N, zeta_T, M * M0, V * V0, lattice, asked, integrator, certify, disturbance, coded, more)
        for name in CODED.names or ():
            words = WORDS_OF.get(name)
            results[name][places] = coded[name] if words is None else np.array(words, RESULT[name])[coded[name]]
        for k, name in enumerate(quantities):
            for column, values in zip(columns_of_quantity(name), more[:, k].T, strict=True):
                results[column][places] = values
    results["checked"] = np.isfinite(results["condition"])
    return results
