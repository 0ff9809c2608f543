"""The option --at NAME=VALUE: which value of a table is meant, and the rows that have it."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from analysis.plane import check_names, same
from analysis.ruler import ruler
from analysis.table import finished
from kernel.problems import tried
from kernel.task import is_number_of_model
from sweep.errors import InputError

At = dict[str, float]


def pairs(texts: Sequence[str]) -> At:
    """The values by name of texts NAME=VALUE; InputError names each text that is none, or repeats a name."""
    values: At = {}
    problems, names = [], []
    for text in texts:
        name, equals, number = text.partition("=")
        names += [name] if name and equals and not is_number_of_model(name) else []
        try:
            value = float(number)
        except ValueError:
            problems.append(f"--at {text}: write NAME=VALUE with a number, for example N=200")
            continue
        if name in values:
            problems.append(f"--at gives {name} twice")
        values[name] = value
    if problems:  # else names are judged beside the table, which may vary numbers of the model
        problems += tried([lambda: check_names(names)], InputError, lambda error: error.problems)[1]
        raise InputError(*problems)
    return values


def nearest(table: pd.DataFrame, at: Mapping[str, float]) -> tuple[At, list[str]]:
    """Replace each value by the table's whose cell on the map holds it, with a line to print for each that changes.

    A value that is in no cell stays as it is; `chosen` then refuses it and lists the table's.
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
            lines.append(f"at        {name} = {repr(found[name]).removesuffix('.0')}, which is nearest to {value:g}")
    return found, lines
