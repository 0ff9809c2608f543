"""A search for the impact that survives finds the lowest worst case, or median, of all impacts around a candidate."""

import re

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.cli import main
from sweep.plan.lowest import around
from sweep.plan.spec import parse_spec
from sweep.tell import report

from .conftest import problems_of

GRID = """
name = "survives"
[grid]
N         = [9, 60]
zeta_T    = [5e-5, 1e-2]
M_over_M0 = {M}
V_over_V0 = {V}
"""
SEARCH = '[search]\nfind = "lowest"\nover = ["M_over_M0", "V_over_V0"]\nrobust = 0.02\n'
M, V = [0.15, 0.4, 1.0, 3.0], [0.5, 1.5, 4.0, 9.0]
ROBUST = GRID.format(M=M, V=V) + SEARCH


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Where the table of all tasks is kept from one test to the next."""
    return tmp_path_factory.mktemp("kept")


@pytest.fixture
def whole(sweep, kept):
    """Every task of every candidate: (cells, candidates, tasks around)."""
    if not (kept / "grid.h5").exists():
        (kept / "grid.toml").write_text(GRID.format(M=around(M, 0.02), V=around(V, 0.02)))
        assert sweep("run", kept / "grid.toml", "-o", kept / "grid.h5").returncode == 0
    df = analysis.load(kept / "grid.h5")
    ratio = np.where(df["chaotic"], np.nan, df["ke_ratio"]).reshape(4, 4, 3, 4, 3)
    return ratio.transpose(0, 1, 3, 2, 4).reshape(4, 16, 9)


@pytest.mark.mpi
@pytest.mark.parametrize(("by", "reduce"), [("worst", np.max), ("median", np.median)])
def test_the_lowest_is_that_of_all_candidates_and_the_same_bits_on_three_ranks(
    sweep, tmp_path, physics, whole, by, reduce, capsys
):
    (tmp_path / "s.toml").write_text(f'{ROBUST}by = "{by}"\n')
    assert sweep("run", "s.toml", "-o", "one.h5").returncode == 0
    assert sweep("run", "s.toml", "-o", "three.h5", ranks=3).returncode == 0
    assert physics(tmp_path / "three.h5") == physics(tmp_path / "one.h5")
    assert main(["best", str(tmp_path / "one.h5"), "-o", str(tmp_path / "best.png")]) == 0
    told = capsys.readouterr().out
    assert f"robust    {by} within 2 %: " in told
    assert re.search(r"^rows      \d+ candidates: .*\nused      \d+ finished candidates;", told, re.MULTILINE)
    found = pd.read_csv(tmp_path / "best.best.csv")
    assert by == "median" or (found["ke_ratio"] >= found["ke_ratio_here"]).all()
    assert found["ke_ratio"].to_numpy() == pytest.approx(np.nanmin(reduce(whole, axis=2), axis=1), rel=0.02)
    assert {*found["M_over_M0"]} <= {*M}
    assert {*found["V_over_V0"]} <= {*V}
    assert found["checked"].all()
    assert 0 < report.status(tmp_path / "one.h5")["done"] < whole.size


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ('"V_over_V0"]', '"N"]', "search.over: with robust must name M_over_M0 or V_over_V0 or both, and nothing else"),
        ("[0.15, 0.4,", "[0.392, 0.4,", "grid.M_over_M0: values must lie further apart than search.robust"),
        ("4.0, 9.0]", "4.0, 20.0]", "search.robust: leads to a V_over_V0: must be"),
        ("0.02", '0.02\nby = "best"', "search.by: must be one of worst, median, got 'best'"),
        ("0.02", "0.6", "search.robust: must be less than or equal to 0.5, got 0.6"),
    ],
)
def test_a_wrong_distance_is_one_problem(line, instead, problem):
    (found,) = problems_of(parse_spec, ROBUST.replace(line, instead), "x.toml")
    assert found.startswith(f"x.toml: {problem}")
