"""A data frame as an xarray.Dataset: an axis for each parameter, units and meanings with every variable."""

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.checks import inputs, require
from analysis.quantity import KE
from sweep.errors import InputError
from sweep.schema import PARAMETERS

if TYPE_CHECKING:
    import xarray


def to_xarray(df: pd.DataFrame) -> "xarray.Dataset":
    """The rows as labelled arrays.

    Parameters
    ----------
    df : pandas.DataFrame
        Rows of `load`; with `load(path, done_only=False)` those of a whole grid fill it.

    Returns
    -------
    xarray.Dataset
        Dimensions N, zeta_T, M_over_M0, V_over_V0, and the numbers of the model that are columns of `df`, where the
        rows are a whole grid of them, in any order; else `task` with these along it.
        Every variable has `long_name` and `units`; `chaotic` is 0, 1, or nan where the row was not checked.

    Raises
    ------
    InputError
        Where columns are missing, or xarray is not installed.

    Examples
    --------
    >>> import analysis
    >>> ds = analysis.to_xarray(analysis.load("quick.h5", done_only=False))
    >>> ds["ke_ratio"].sel(N=50, method="nearest").dims
    ('zeta_T', 'M_over_M0', 'V_over_V0')
    """
    try:
        import xarray
    except ImportError:
        raise InputError("to_xarray needs xarray: pip install 'bistable-sweep[netcdf]'") from None
    from sweep.store.netcdf import about, grid_of  # only here: readers of tables do without the sweep's store

    require(df, [*PARAMETERS, KE.ratio, "chaotic"])
    known = inputs(df)
    columns = _columns(df)
    axes = grid_of(columns, known)
    if axes is None:  # a whole grid in another order is one
        in_order = df[[*known, *df.columns.drop(known)]].sort_values(known, kind="stable")
        if (axes := grid_of(_columns(in_order), known)) is not None:
            columns = _columns(in_order)
    if axes is None:
        along = {name: (("task",), columns.pop(name), about(name)) for name in known}
        rows: dict[str, Any] = {name: (("task",), values, about(name)) for name, values in columns.items()}
        return xarray.Dataset(rows, along | {"task": df.index.to_numpy()})
    shape = tuple(len(values) for values in axes.values())
    inside = {name: values for name, values in columns.items() if name not in axes}
    data: dict[str, Any] = {name: (tuple(axes), one.reshape(shape), about(name)) for name, one in inside.items()}
    return xarray.Dataset(data, {name: ((name,), values, about(name)) for name, values in axes.items()})


def _columns(df: pd.DataFrame) -> dict[str, NDArray[Any]]:
    return {str(name): _plain(df[name]) for name in df.columns}


def _plain(column: "pd.Series[Any]") -> NDArray[Any]:
    """A column as numpy holds it: a flag that may be unknown as numbers, text as objects."""
    if column.dtype == "boolean":
        return column.to_numpy(float, na_value=np.nan)
    return column.to_numpy() if column.dtype.kind in "biuf" else column.astype(str).to_numpy(object)
