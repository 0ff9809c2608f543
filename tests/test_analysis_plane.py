"""Claims about `analysis.plane` and `analysis.map_over`."""

import itertools
import math

import numpy as np
import pandas as pd
import pytest

import analysis

GRID = {
    "N": (5, 20, 100),
    "zeta_T": (0.0, 1e-5, 4e-4),
    "M_over_M0": (0.1, 0.1 * 3, 2.0),
    "V_over_V0": (1.0, 10.0),
}


@pytest.fixture
def df():
    made = pd.DataFrame(list(itertools.product(*GRID.values())), columns=list(GRID))
    made["ke_ratio"] = np.arange(len(made)) + 0.5
    made["error"], made["chaotic"], made["status"] = 1e-4, False, "done"
    return made.rename_axis(index="task")


def test_map_over_n_and_zeta_holds_each_ratio_at_its_place(df):
    found = analysis.map_over(df, ("N", "zeta_T"), {"M_over_M0": 2, "V_over_V0": 10})
    assert list(found.columns) == list(GRID["N"])
    assert list(found.index) == list(GRID["zeta_T"])
    for _, row in df[(df["M_over_M0"] == 2) & (df["V_over_V0"] == 10)].iterrows():
        assert found.loc[row["zeta_T"], row["N"]] == row["ke_ratio"]


def test_map_over_impacts_is_at_the_chosen_chain(df):
    found = analysis.map_over(df, ("M_over_M0", "V_over_V0"), {"N": 20, "zeta_T": 0})
    chosen = df[(df["N"] == 20) & (df["zeta_T"] == 0)]
    assert found.shape == (2, 3)
    assert sorted(found.to_numpy().ravel()) == sorted(chosen["ke_ratio"])


def test_parameters_with_one_value_need_no_choice(df):
    some = df[(df["M_over_M0"] == 2) & (df["V_over_V0"] == 10)]
    assert analysis.map_over(some).shape == (3, 3)


def test_value_matches_to_rounding_and_not_beyond(df):
    assert len(analysis.plane(df, at={"M_over_M0": 0.3, "V_over_V0": 1})) == 9
    with pytest.raises(analysis.InputError, match=r"no finished row has M_over_M0 = 0.3001"):
        analysis.plane(df, at={"M_over_M0": 0.3001, "V_over_V0": 1})


def test_a_refused_whole_value_is_told_as_one(df):
    with pytest.raises(analysis.InputError, match=r"no finished row has M_over_M0 = 100; there is 0\.1"):
        analysis.plane(df, at={"M_over_M0": 100.0, "V_over_V0": 1})


def test_refused_value_lists_values_that_are_accepted(df):
    with pytest.raises(analysis.InputError) as caught:
        analysis.plane(df, at={"M_over_M0": 7.0, "V_over_V0": 1})
    listed = str(caught.value).split("there is ")[1].split(", ")
    assert len(listed) == 3
    for text in listed:
        assert len(analysis.plane(df, at={"M_over_M0": float(text), "V_over_V0": 1})) == 9


def test_unfinished_rows_leave_holes(df):
    df.loc[df.index[-1], "status"] = "failed"
    found = analysis.map_over(df, at={"M_over_M0": 2, "V_over_V0": 10})
    assert math.isnan(found.loc[4e-4, 100])
    assert found.notna().to_numpy().sum() == 8


def test_of_repeated_cells_the_smallest_error_stands(df):
    better = df.assign(error=1e-6, ke_ratio=df["ke_ratio"] + 100)
    unknown = df.assign(error=math.nan, ke_ratio=df["ke_ratio"] + 200)
    both = pd.concat([df, unknown, better], ignore_index=True)
    cells = analysis.plane(both, at={"M_over_M0": 2, "V_over_V0": 10})
    assert len(cells) == 9
    assert (cells["ke_ratio"] > 100).all()
    assert (cells["error"] == 1e-6).all()


@pytest.mark.parametrize(
    ("over", "at", "told"),
    [
        (("N", "zeta_T"), {}, "choose a value of M_over_M0 .* and of V_over_V0"),
        (("N", "zeta_T"), {"M_over_M0": 2}, r"choose a value of V_over_V0 \(there is 1, 10\)"),
        (("N", "mass"), {"ke_ratio": 1}, "unknown parameters mass, ke_ratio; there are N, zeta_T"),
        (("N",), {}, "two different parameters"),
        (("N", "N"), {}, "two different parameters"),
        (("N", "zeta_T"), {"N": 5}, "N cannot be fixed"),
        (("N", "zeta_T"), {"M_over_M0": math.nan}, "no finished row has M_over_M0 = nan"),
        (("N", "zeta_T"), {"M_over_M0": math.inf}, "no finished row has M_over_M0 = inf"),
        (("N", "zeta_T"), [2, 1], r"^at: must be a mapping of names to values, got \[2, 1\]$"),
    ],
)
def test_choice_that_makes_no_plane_is_refused_in_one_line(df, over, at, told):
    with pytest.raises(analysis.InputError, match=told) as caught:
        analysis.plane(df, over, at)
    assert "\n" not in str(caught.value)


def test_values_that_never_meet_make_no_plane(df):
    apart = df[(df["N"] == 5) ^ (df["zeta_T"] == 0)]
    with pytest.raises(analysis.InputError, match="no finished row"):
        analysis.plane(apart, ("M_over_M0", "V_over_V0"), {"N": 5, "zeta_T": 0})
