"""The rows of a table as packed columns: what a page embeds, and what `analysis view` sends.

Which columns the first picture needs says `needed_first`. Every column is packed as its bytes, compressed, as base64.
A column of few values is a list of these and one code a row.
"""

import base64
import zlib
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.quantity import KE
from analysis.table import DONE_LABEL, TO_COME, checked, finished, flagged
from kernel.task import is_input
from sweep.store.meanings import meaning, unit

FEW = 1000  # values of a column that is packed as codes: more than any axis has pixels for
EXACT_ROWS = 200_000  # of tables with more rows the results are rounded to seven digits: half the size
NO, YES, UNKNOWN = 0, 1, 2  # of a flag
_SPEED = 1  # zlib's: 6 takes five times as long for a tenth less

Packed = dict[str, Any]


def payload(table: pd.DataFrame) -> Packed:
    """What the page must know of the rows: `rows` and `columns`, and how the rows ended.

    Parameters
    ----------
    table : pandas.DataFrame
        All rows, as `load(path, done_only=False)` gives them. Those that are not done are counted, and left out; a
        value of an input whose rows have all failed is among its values all the same, so that axes show it.

    Returns
    -------
    dict
        Ready for JSON.
    """
    done = finished(table)
    exact, failed = len(done) <= EXACT_ROWS, _failed(table)
    columns = [_packed("task", done.index.to_numpy(), exact)]
    for name in map(str, done.columns):
        if name not in ("status", "checked", "chaotic"):
            columns.append(_packed(name, _values(done[name]), exact, _values(failed[name])))
    columns.append(_chaotic(flagged(done), checked(done)))
    return {
        "rows": len(done),
        "all_rows": len(table),
        "left": _how_others_ended(table),
        "digits": 17 if exact else 7,
        "unchecked": int(np.count_nonzero(~checked(done))),
        "columns": columns,
    }


def needed_first(name: str) -> bool:
    """Whether the first picture of a page needs the column."""
    return is_input(name) or name in ("task", KE.ratio, "error", "chaotic")


def _values(column: "pd.Series[Any]") -> NDArray[Any]:
    if column.dtype.kind in "biuf":
        return column.to_numpy()
    return column.astype(str).to_numpy(dtype=object)


def _failed(table: pd.DataFrame) -> pd.DataFrame:
    """The rows that were computed and are not done; none of a table that tells no status."""
    if "status" not in table:
        return table.iloc[:0]
    return table[~table["status"].astype(str).isin((DONE_LABEL, *TO_COME))]


def _packed(name: str, values: NDArray[Any], exact: bool, failed: NDArray[Any] | None = None) -> Packed:
    """A column; `failed`: its values in rows that have none but their inputs."""
    about = {"name": name, "unit": unit(name), "meaning": meaning(name), "input": is_input(name)}
    text = values.dtype.kind == "O"
    if text or is_input(name):
        more = values[:0] if text or failed is None else failed
        codes, found = pd.factorize(np.concatenate([values, more]), sort=True)
        codes = codes[: len(values)]
        if text or 0 < len(found) <= FEW:
            listed = [str(one) if text else one.item() for one in np.asarray(found)]
            if len(empty := np.flatnonzero(codes < 0)):  # as in an edited .csv: they come last
                codes[empty] = len(listed)
                listed.append("" if text else None)
            kind = "u1" if len(listed) <= 1 << 8 else "u2" if len(listed) <= 1 << 16 else "u4"
            return about | {"kind": kind, "values": listed, "data": _text(codes.astype(f"<{kind}"))}
    if name == "task" and np.array_equal(values, np.arange(len(values))):
        return about | {"kind": "count", "data": ""}
    whole = values.dtype.kind in "iub"
    small = whole and np.array_equal(values, values.astype("<i4"))
    kind = "i4" if small else "f8" if whole or exact or is_input(name) else "f4"
    return about | {"kind": kind, "data": _text(values.astype(f"<{kind}"))}


def _chaotic(yes: NDArray[np.bool_], known: NDArray[np.bool_]) -> Packed:
    codes = np.where(known | yes, np.where(yes, YES, NO), UNKNOWN).astype("u1")
    about = {"name": "chaotic", "unit": "", "meaning": meaning("chaotic"), "input": False}
    return about | {"kind": "u1", "values": ["no", "yes", "not checked"], "data": _text(codes)}


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(zlib.compress(values.tobytes(), _SPEED)).decode()


def _how_others_ended(table: pd.DataFrame) -> dict[str, int]:
    """How many rows of each status, other than done, there are."""
    if "status" not in table:
        return {}
    counts = table["status"].astype(str).value_counts()
    return {str(label): int(n) for label, n in counts.items() if label != DONE_LABEL and n}
