"""A table as netCDF: named axes, units and meanings, which xarray, ncview or Matlab read by themselves.

A whole grid has one axis for each parameter; any other list of tasks has the axis `task`, with the parameters along it.
"""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError
from sweep.store.meanings import meaning, unit

NO_WHOLE, NO_FLAG = -1, -1  # what stands for a whole number, and for a flag, that is not known

Columns = Mapping[str, NDArray[Any]]


def grid_of(columns: Columns, parameters: Sequence[str]) -> dict[str, NDArray[Any]] | None:
    """The values of every axis where the rows are a whole grid, the last varying fastest; None where they are not."""
    axes = {
        name: values[np.sort(np.unique(values, return_index=True)[1])]
        for name, values in columns.items()
        if name in parameters
    }
    shape = [len(values) for values in axes.values()]
    if not axes or int(np.prod(shape)) != len(next(iter(columns.values()))):
        return None
    whole = np.meshgrid(*axes.values(), indexing="ij")
    same = all(np.array_equal(one.ravel(), columns[name]) for name, one in zip(axes, whole, strict=True))
    return axes if same else None


def about(name: str) -> dict[str, str]:
    """What a variable says of itself."""
    text = {"long_name": meaning(name)}
    return text | {"units": unit(name)} if unit(name) else text


def write_netcdf(path: Path, columns: Columns, parameters: Sequence[str], known: Mapping[str, str]) -> None:
    """Write columns, each (rows,), of all tasks of a table; masked values are not known. `known`: its provenance."""
    try:
        import h5netcdf
    except ImportError:
        raise InputError(".nc needs h5netcdf: pip install 'bistable-sweep[netcdf]'; .csv does not") from None
    axes = grid_of(columns, parameters)
    dimensions = tuple(axes) if axes else ("task",)
    shape = tuple(len(values) for values in axes.values()) if axes else (len(columns["task"]),)
    whole = io.BytesIO()  # a disk that is full while HDF5 writes a file can crash it
    with h5netcdf.File(whole, "w") as file:
        for name, text in known.items():
            file.attrs[name] = text
        for name, length in zip(dimensions, shape, strict=True):
            file.dimensions[name] = length
        for name, values in (axes or {}).items():
            _write(file, name, (name,), values, "")
        beside = "" if axes else " ".join(name for name in parameters if name in columns)
        for name, values in columns.items():
            if name not in (axes or {}):
                _write(file, name, dimensions, values.reshape(shape), "" if name in (*parameters, "task") else beside)
    path.write_bytes(whole.getbuffer())


def _write(file: Any, name: str, dimensions: tuple[str, ...], values: NDArray[Any], coordinates: str) -> None:
    unknown, data = np.ma.getmaskarray(values), np.ma.getdata(values)
    fill, more = None, about(name)
    if data.dtype.kind == "b":
        data, fill = data.astype("i1"), np.int8(NO_FLAG)
        more |= {"flag_meanings": "no yes", "flag_values": np.array([0, 1], "i1")}  # type: ignore[dict-item]
    elif data.dtype.kind in "iu" and unknown.any():
        fill = data.dtype.type(NO_WHOLE)
    if fill is not None:
        data = np.where(unknown, fill, data)
    if data.dtype.kind in "US":
        variable = file.create_variable(name, dimensions, h5py.string_dtype())
        variable[...] = data.astype(object)
    else:
        variable = file.create_variable(name, dimensions, data.dtype, data=data, fillvalue=fill)
    for key, text in more.items():
        variable.attrs[key] = text
    if coordinates:
        variable.attrs["coordinates"] = coordinates
