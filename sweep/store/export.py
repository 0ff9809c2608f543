"""`sweep export`: a table's rows for other programs."""

import csv
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from sweep.errors import InputError, writing
from sweep.files import replacing
from sweep.schema import DONE, RAISED, RESULTS, TORN, inputs_of, is_claimed, is_sealed, today, without_numbers
from sweep.store import table

ENDINGS = (".csv", ".parquet", ".nc")


def export(path: Path, output: Path, everything: bool = False, force: bool = False) -> int:
    """Write the done rows of a table, or all with `everything`; how many. `output` appears only when complete.

    A .nc file holds every task: the places in the grid of those that are not done must not be lost.

    A first column `task` holds the row's number in the table. Numbers are exact in every form. An unknown number is
    nan, or an empty cell (null) in a column that cannot hold nan: `chaotic` of a row that was not checked, `steps` and
    `rank` of one that was not computed, `steps` of one that raised an exception.

    InputError where `output` exists and is not to be replaced (`force`).
    """
    if output.suffix not in ENDINGS:
        raise InputError(f"{output}: must end with {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")
    if os.path.realpath(output) == os.path.realpath(path):
        raise InputError(f"{output}: is the table itself; give another -o")
    if os.path.lexists(output) and not force:
        raise InputError(f"{output}: exists; give another -o, or --force to replace it")
    with table.reading(path) as file:
        write = {".csv": _write_csv, ".parquet": _write_parquet, ".nc": _write_nc}[output.suffix]
        with writing(output), replacing(output) as partial:
            count = write(partial, file, _parts(file, everything or write is _write_nc))
    return count


def _parts(file: h5py.File, everything: bool) -> Iterator[dict[str, NDArray[Any]]]:
    """Columns of the wanted rows, part by part; a row whose checksum fails has the status "torn" and no numbers."""
    for part, rows in table.chunks(file):
        claimed, torn = is_claimed(rows), is_claimed(rows) & ~is_sealed(rows)
        rows = without_numbers(rows, torn)
        rows["status"][torn] = TORN
        wanted = np.arange(len(rows)) if everything else np.flatnonzero(rows["status"] == DONE)
        absent, raised = ~claimed | torn, rows["status"] == RAISED
        unknown = {"rank": absent, "steps": absent | raised, "chaotic": ~rows["checked"]}
        columns: dict[str, NDArray[Any]] = {"task": part.start + wanted}
        for name in columns_of(rows.dtype):
            column = rows[name][wanted]
            columns[name] = np.char.decode(column, "ascii", "replace") if rows.dtype[name].kind == "S" else column
            if name in unknown:
                columns[name] = np.ma.masked_array(column, unknown[name][wanted])
        yield columns


def columns_of(layout: np.dtype[Any]) -> list[str]:
    """The columns that other programs get: a checksum tells them nothing."""
    return [name for name in layout.names or () if name != "checksum"]


def _write_csv(path: Path, file: h5py.File, parts: Iterator[dict[str, NDArray[Any]]]) -> int:
    count = 0
    with path.open("w", newline="") as text:
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["task", *columns_of(today(file[RESULTS].dtype))])
        for columns in parts:
            writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
            count += len(columns["task"])
    return count


def _write_parquet(path: Path, file: h5py.File, parts: Iterator[dict[str, NDArray[Any]]]) -> int:
    """Write the columns; the table's provenance becomes the file's key-value metadata."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise InputError(".parquet needs pyarrow: pip install 'bistable-sweep[parquet]'; .csv does not") from None
    layout = today(file[RESULTS].dtype)
    kinds: Sequence[tuple[str, Any]] = [
        (name, pyarrow.string() if layout[name].kind == "S" else pyarrow.from_numpy_dtype(layout[name]))
        for name in columns_of(layout)
    ]
    schema = pyarrow.schema([("task", pyarrow.int64()), *kinds], metadata=table.attributes(file))
    count = 0
    with path.open("wb") as out, parquet.ParquetWriter(out, schema) as writer:  # it takes no name that is not text
        for columns in parts:
            arrays = {name: pyarrow.array(column, schema.field(name).type) for name, column in columns.items()}
            writer.write_table(pyarrow.table(arrays, schema=schema))
            count += len(columns["task"])
    return count


def _write_nc(path: Path, file: h5py.File, parts: Iterator[dict[str, NDArray[Any]]]) -> int:
    """Write the columns of all tasks, with the table's provenance; how many there are."""
    from sweep.store.netcdf import write_netcdf

    all_parts = list(parts)
    join: Any = np.ma.concatenate
    columns = {name: join([part[name] for part in all_parts]) for name in all_parts[0]}
    write_netcdf(path, columns, inputs_of(today(file[RESULTS].dtype)), table.attributes(file))
    return len(columns["task"])
