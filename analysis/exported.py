"""Read a .csv that `sweep export` made, and that anybody may have edited since: what no table holds is told by line."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import FLAGS
from analysis.reading import refuse_no_file
from kernel.hints import shown
from kernel.task import BOX, RULES, is_number_of_model
from sweep.errors import InputError
from sweep.schema import ROW

FIRST_LINE = 2  # of the rows, below the names of the columns
SIGNED = ("rank",)  # -1 where no rank computed the row
_FLAG_WORDS = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
_FINITE, _FROM_0 = "must be a finite number, or empty", "must be a finite number of 0 or more, or empty"


def read_exported(path: Path) -> pd.DataFrame:
    """The rows of a .csv, their flags as `load` has them.

    InputError, of every column that holds what it cannot, with the first line where it does.
    """
    refuse_no_file(path)
    try:
        table = pd.read_csv(path, low_memory=False)  # else the kind of a column may change on the way
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"there is no table {path}") from None
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors, and so is text that is not UTF-8
        raise InputError(f"{path} cannot be read as CSV: {str(error).splitlines()[0]}") from None
    names = list(map(str, table.columns))
    if problems := [f"{path}: {line}" for name in names for line in _wrong(name, table[name], names)]:
        raise InputError(*problems)
    return table.assign(**{name: _flags(table[name]) for name in FLAGS if name in names})


def _flags(column: "pd.Series[Any]") -> "pd.Series[Any]":
    """As True, False, or missing where a row was not checked, or where it is none."""
    return column.astype(str).str.lower().map(_FLAG_WORDS).astype("boolean")


def _wrong(name: str, column: "pd.Series[Any]", names: list[str]) -> Iterator[str]:
    """What is wrong with a column: the rule, the first value that breaks it, its line, how many others do."""
    if name in FLAGS:
        rule, good = "must be True, False or empty", _flags(column).notna()
    elif rule := _rule(name, names):
        numbers = pd.to_numeric(column, errors="coerce").astype(float)
        low, high = BOX.get(name, (-np.inf if rule == _FINITE else 0.0, np.inf))
        whole = (numbers == np.rint(numbers)) | (name != "N")
        good = numbers.between(low, high) & np.isfinite(numbers) & whole & (column.dtype != bool)
    else:
        return
    bad = np.flatnonzero(~good if name in BOX else column.notna() & ~good)  # without its inputs a row is no task
    if len(bad):
        more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
        first = column.tolist()[bad[0]]
        told = "nothing" if pd.isna(first) else shown(first)
        yield f"{name}, line {bad[0] + FIRST_LINE}: {rule}, got {told}{more}"


def _rule(name: str, names: list[str]) -> str:
    """What the numbers of a column must be; empty of a column of text, or that is none of ours."""
    if name in BOX:
        return RULES[name][1]
    if name == "task" or (name in (ROW.names or ()) and ROW[name].kind in "fiu"):
        return _FINITE if name in SIGNED else _FROM_0
    quantity = next((name.removesuffix(end) for end in ("_linear", "_ratio", "_error") if name.endswith(end)), name)
    return _FINITE if is_number_of_model(name) or f"{quantity}_error" in names else ""
