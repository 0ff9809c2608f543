"""The columns that tasks come in, from whatever the user has them in, and those that results come in."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.hints import meant_or_known, shown, taken_for
from kernel.notebook import ShownAsTable
from kernel.task import BOX, PARAMETERS, Task, is_disguised, is_number_of_model

KE, PEAK_KE = "ke", "peak_ke"  # two names of the quantity that every task has
# Of a column, by what one value is.
DTYPES: dict[Any, str] = {
    float: "f8",
    int: "i8",
    str: "U16",
    bool: "?",
    bool | None: "?",
}


@dataclass(frozen=True)
class KeRatio(ShownAsTable):
    """What one task gives. These are the columns of results, too; a number that is not known is nan.

    Attributes
    ----------
    ke_bistable, ke_linear : float
        Largest m v^2 / 2 of the watched site, of the chain and of its linear companion, over the impactor's energy.
    ke_ratio : float
        The one over the other; below 1 the bistable chain protects better.
    t_peak_bistable, t_peak_linear : float
        When these peaks are, in cell transit times over N (0 to `t_end` of the model).
    error : float
        Estimated relative error of ke_ratio; nan where it was not asked for.
    condition : float
        Relative change of ke_ratio over that of the inputs and of the first state, estimated.
    chaotic : bool or None
        Whether `condition` exceeds 1000: neighbours at 1e-6 differ by more than 1e-3. None (False in a column) where it
        was not `checked`.
    checked : bool
        Whether `condition` is known.
    spread_low, spread_high : float
        Of a chaotic task: between them lie the ke_ratio of its neighbours.
    method : str
        What integrated the bistable chain: "explicit" or "implicit" splitting, "modes" or "rk45".
    steps, evaluations, site_evaluations : int
        Of all integrations: accepted steps; force evaluations in whole chains; force evaluations times the sites that
        the wave had reached.
    status : str
        "done", or why not: "not_finite" (the state; or the ratio, as the watched site has not moved), "step_budget"
        (`max_steps` are spent), "step_too_small" (for a tolerance), "not_converged" (the best value and its error are
        given), "bad_input"; of a sweep's row also "error" (the kernel raised an exception).

    Examples
    --------
    >>> import kernel
    >>> kernel.ke_ratio(N=20, zeta_T=4e-4, M_over_M0=2, V_over_V0=2, certify=False).chaotic is None
    True
    """

    ke_bistable: float
    ke_linear: float
    ke_ratio: float
    t_peak_bistable: float
    t_peak_linear: float
    error: float
    condition: float
    chaotic: bool | None
    checked: bool
    spread_low: float
    spread_high: float
    method: str
    steps: int
    evaluations: int
    site_evaluations: int
    status: str


# One row per task: the task as it was given, and what it gives.
_INPUTS = [(name, "i8" if name == "N" else "f8") for name in PARAMETERS]
RESULT = np.dtype([*_INPUTS, *((field.name, DTYPES[field.type]) for field in fields(KeRatio))])

Columns = dict[str, NDArray[np.float64]]
NO_N = -1  # in a column of whole numbers, what is none
TASK_FORMS = (
    "a mapping, structured array or data frame with the columns N, zeta_T, M_over_M0, V_over_V0, an array (n, 4) in "
    "that order, or a sequence of Task"
)


def columns_of(tasks: Any, also: Iterable[str] | None) -> Columns:
    """The four parameters, each (n,), and those of the columns `also`, numbers of the model, that there are.

    ValueError naming every problem of form, whatever the values are, and every column that is named as if it were a
    number of the model (`is_number_of_model`) and is none; also: None where the model is not known. Other columns are
    left alone: a data frame may hold anything besides.
    """
    named = _names(tasks)
    if named is None:
        return dict(zip(PARAMETERS, _table(tasks).T, strict=True))
    others, numbers = [str(name) for name in named if name not in PARAMETERS], list(also or ())
    plain = [name for name in others if "." not in name]
    problems = [f"lacks the column {name}{taken_for(name, plain)}" for name in PARAMETERS if name not in named]
    problems += [
        f"{name}: the model has no such number{meant_or_known(name, numbers)}"
        for name in others
        if also is not None and is_number_of_model(name) and name not in numbers
    ]
    found: Columns = {}
    for name in (*PARAMETERS, *numbers):
        if name in named:
            try:
                found[name] = _column(name, tasks[name])
            except ValueError as error:
                problems.append(str(error))
    lengths = {name: len(values) for name, values in found.items()}
    if len(set(lengths.values()) - {1}) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        problems.append(f"the columns must be of one length, got {told}")
    if problems:
        raise ValueError(f"tasks: {'; '.join(problems)}")
    return dict(zip(found, np.broadcast_arrays(*found.values()), strict=True))


def bad_rows(columns: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """Which tasks, (n,), have a parameter that breaks its rule."""
    return np.any([out_of_box(name, columns[name]) for name in BOX], axis=0)


def out_of_box(name: str, column: NDArray[Any]) -> NDArray[np.bool_]:
    """Which values, (n,), break the rule of this parameter."""
    low, high = BOX[name]
    return np.asarray(~((low <= column) & (column <= high)) | ((name == "N") & (column != np.rint(column))))


def whole(N: NDArray[np.float64]) -> NDArray[np.int64]:
    """N as whole numbers, NO_N where it is none."""
    fits = (np.abs(N) < 2.0**63) & (np.rint(N) == N)
    return np.where(fits, N, NO_N).astype(np.int64)


def _names(tasks: Any) -> list[str] | None:
    """The names of the columns that `tasks` has; None where they have none."""
    if isinstance(tasks, Mapping):
        return list(tasks)
    names = getattr(getattr(tasks, "dtype", None), "names", None)
    if names is None and hasattr(tasks, "columns"):
        names = tasks.columns
    return None if names is None else list(names)


def _column(name: str, values: Any) -> NDArray[np.float64]:
    column = _numbers(name, values)
    if column.ndim > 1:
        raise ValueError(f"{name}: must be a number or one column of numbers, got shape {column.shape}")
    return np.atleast_1d(column)


def _table(tasks: Any) -> NDArray[np.float64]:
    if isinstance(tasks, str) or not isinstance(tasks, Iterable):
        raise ValueError(f"tasks: must be {TASK_FORMS}, got {shown(tasks)}")
    rows: Any = tasks  # a large array is not taken apart
    if not (isinstance(tasks, np.ndarray) and tasks.ndim > 1):
        rows = [[getattr(task, name) for name in PARAMETERS] if isinstance(task, Task) else task for task in tasks]
    if not len(rows):
        return np.empty((0, len(PARAMETERS)))
    table = _numbers("tasks", rows)
    if table.ndim != 2 or table.shape[1] != len(PARAMETERS):
        raise ValueError(f"tasks: must be {TASK_FORMS}, got shape {table.shape}")
    return table


def _numbers(name: str, values: Any) -> NDArray[np.float64]:
    if is_disguised(values):
        raise ValueError(f"{name}: must hold numbers, none of them True, False or masked, got {shown(values)}")
    try:
        array = np.asarray(values)
    except ValueError:  # numpy's own words tell of inhomogeneous shapes
        raise ValueError(f"{name}: must hold rows of one length, got {shown(values)}") from None
    if array.dtype.kind == "O" and all(isinstance(x, Real) and not isinstance(x, bool) for x in array.flat):
        try:
            array = array.astype(np.float64)
        except OverflowError:
            raise ValueError(f"{name}: must hold numbers that a float can hold, got {shown(values)}") from None
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name}: must hold numbers, got {shown(values)}")
    return array.astype(np.float64)


@cache
def result_type(*quantities: str, axes: tuple[str, ...] = ()) -> np.dtype[Any]:
    """RESULT, and the columns of the quantities of these names; before them those of numbers of the model, `axes`."""
    more = [(name, "f8") for name in axes]
    more += [(column, "f8") for name in quantities for column in columns_of_quantity(name)]
    return np.dtype([*RESULT.descr, *more])


def columns_of_quantity(name: str) -> tuple[str, str, str, str]:
    """Of the chain, of the linear chain, their ratio, the estimated relative error of these three."""
    return name, f"{name}_linear", f"{name}_ratio", f"{name}_error"
