"""Many tasks as columns, from whatever the user has them in."""

from collections.abc import Iterable, Mapping
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.hints import did_you_mean, shown
from kernel.task import BOX, PARAMETERS, Task

Columns = dict[str, NDArray[np.float64]]
NO_N = -1  # in a column of whole numbers, what is none
FORMS = (
    "a mapping, structured array or data frame with the columns N, zeta_T, M_over_M0, V_over_V0, an array (n, 4) in "
    "that order, or a sequence of Task"
)


def columns_of(tasks: Any) -> Columns:
    """The four parameters, each (n,); ValueError naming every problem of form, whatever the values are."""
    named = _names(tasks)
    if named is None:
        return dict(zip(PARAMETERS, _table(tasks).T, strict=True))
    problems = [
        f"lacks the column {name}{did_you_mean(name, map(str, named))}" for name in PARAMETERS if name not in named
    ]
    found: Columns = {}
    for name in PARAMETERS:
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


def bad_rows(columns: Columns) -> NDArray[np.bool_]:
    """Which tasks, (n,), have a parameter that breaks its rule."""
    good = np.all([(low <= columns[name]) & (columns[name] <= high) for name, (low, high) in BOX.items()], axis=0)
    return ~(good & (columns["N"] == np.rint(columns["N"])))


def whole(N: NDArray[np.float64]) -> NDArray[np.int64]:
    """N as whole numbers, NO_N where it is none."""
    fits = (np.abs(N) < 2.0**63) & (np.rint(N) == N)
    return np.where(fits, N, NO_N).astype(np.int64)


def _names(tasks: Any) -> list[str] | None:
    """Of its columns; None where they have no names."""
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
        raise ValueError(f"tasks: must be {FORMS}, got {shown(tasks)}")
    rows = [[getattr(task, name) for name in PARAMETERS] if isinstance(task, Task) else task for task in tasks]
    if not rows:
        return np.empty((0, len(PARAMETERS)))
    table = _numbers("tasks", rows)
    if table.ndim != 2 or table.shape[1] != len(PARAMETERS):
        raise ValueError(f"tasks: must be {FORMS}, got shape {table.shape}")
    return table


def _numbers(name: str, values: Any) -> NDArray[np.float64]:
    try:
        array = np.asarray(values)
    except ValueError:  # numpy's own words tell of inhomogeneous shapes
        raise ValueError(f"{name}: must hold rows of one length, got {shown(values)}") from None
    if array.dtype.kind == "O" and all(isinstance(x, Real) and not isinstance(x, bool) for x in array.flat):
        array = array.astype(np.float64)
    if array.dtype.kind not in "iuf":
        raise ValueError(f"{name}: must hold numbers, got {shown(values)}")
    return array.astype(np.float64)
