"""What `--at NAME=VALUE` takes of a table: the value whose cell on a map holds the one that was given."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.errors import InputError
from analysis.plane import same
from analysis.ruler import ruler
from analysis.table import finished


def pairs(texts: Sequence[str]) -> dict[str, float]:
    """NAME=VALUE each; InputError names all that are not, or come twice."""
    values: dict[str, float] = {}
    problems = []
    for text in texts:
        name, _, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            problems.append(f"--at {text}: write NAME=VALUE with a number, for example N=200")
            continue
        if name in values:
            problems.append(f"--at gives {name} twice")
        values[name] = value
    if problems:
        raise InputError("\n".join(problems))
    return values


def taken(table: pd.DataFrame, at: Mapping[str, float]) -> tuple[dict[str, float], list[str]]:
    """For each value that of the finished rows which has it within half a cell, and a line where it is another.

    A value that is in no cell is given back as it is: `plane` then says what there is.
    """
    found, lines = dict(at), []
    rows = finished(table)
    for name, value in at.items():
        values = np.unique(rows[name].dropna().to_numpy(np.float64))
        cells = ruler(values).cells if len(values) else np.empty((0, 2))
        inside = np.flatnonzero((cells[:, 0] <= value) & (value <= cells[:, 1]))
        if value in values or not len(inside) or (value == 0) != (values[inside[0]] == 0):
            continue
        found[name] = float(values[inside[0]])
        if not same(found[name], value):
            lines.append(f"at        {name} = {found[name]!r}, which is nearest to {value:g}")
    return found, lines
