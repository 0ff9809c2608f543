"""Numbers of the model and ratios may be negative or zero: pictures, optima and levels of them are drawn and true."""

import itertools
import warnings

import numpy as np
import pandas as pd
import pytest

from analysis.cli import main
from analysis.ruler import ruler
from analysis.ticks import ticks

AXES = {
    "falling below zero": (-100.0, -10.0, -1.0),
    "up to zero": (-1.0, 0.0),
    "across zero": (-2.0, -1.0, 3.0),
    "one": (-2.0,),
    "zero alone": (0.0,),
}


@pytest.fixture(autouse=True)
def _no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def table(c2, N=(5, 50, 500), **columns):
    """Finished rows of a grid with a number of the model; ke_ratio falls with N, the most at the lowest c2."""
    grid = {"N": N, "zeta_T": (1e-3,), "M_over_M0": (2.0,), "V_over_V0": (2.0,), "spring.c2": c2}
    df = pd.DataFrame(list(itertools.product(*grid.values())), columns=list(grid))
    ratio = 20 / df["N"] * (1 + 0.01 * df["spring.c2"].rank())
    rest = {"ke_ratio": ratio, "error": 1e-4, "chaotic": False, "checked": True, "status": "done"}
    return df.assign(**(rest | columns)).rename_axis(index="task")


def run(tmp_path, df, *words):
    path = tmp_path / "t.csv"
    df.to_csv(path)
    command, *rest = words
    return main([command, str(path), "-o", str(tmp_path / "p.png"), *rest])


@pytest.mark.parametrize("values", AXES.values(), ids=AXES)
def test_an_axis_that_is_not_all_positive_has_an_even_scale_and_a_cell_for_every_value(values):
    values = np.array(values)
    axis = ruler(values)
    assert not axis.log
    assert not axis.gap
    assert ((axis.cells[:, 0] < values) & (values < axis.cells[:, 1])).all()
    assert (np.diff(axis.borders) > 0).all()
    assert ticks(axis, 2.6, across=True).places


@pytest.mark.parametrize("values", AXES.values(), ids=AXES)
@pytest.mark.parametrize("command", ["map", "points", "best"])
def test_a_table_along_a_number_of_any_sign_is_drawn(tmp_path, command, values):
    assert run(tmp_path, table(values), command, "--over", "N,spring.c2") == 0


def test_a_negative_value_is_chosen_by_the_cell_that_holds_it(tmp_path, capsys):
    assert run(tmp_path, table((-3.0, -2.0, -1.0)), "map", "--over", "N,zeta_T", "--at", "spring.c2=-2.2") == 0
    assert "at        spring.c2 = -2.0, which is nearest to -2.2" in capsys.readouterr().out
