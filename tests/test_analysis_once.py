"""A task that a data frame holds more than once, as of a loose and a tight sweep put together, counts once."""

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.table import left_out, once

GRID = pd.MultiIndex.from_product(
    [[5, 10, 20, 40, 80], [1e-4, 1e-3, 1e-2], [0.5, 2.0], [0.1, 1.0, 3.0]],
    names=["N", "zeta_T", "M_over_M0", "V_over_V0"],
).to_frame(index=False)


def sweep_of(error, seed):
    """A whole grid, each ratio off by about its error."""
    true = (20 / GRID["N"]) ** (1 + 0.1 * GRID["M_over_M0"]) * GRID["V_over_V0"] ** -0.1
    off = 1 + error * np.random.default_rng(seed).standard_normal(len(GRID))
    return GRID.assign(ke_ratio=true * off, error=error, chaotic=False, checked=True, status="done")


TIGHT, LOOSE = sweep_of(1e-4, 1), sweep_of(0.1, 2)
ASKED = {
    "best": lambda df: analysis.best(df).drop(columns="error").reset_index(drop=True),
    "optimum": lambda df: analysis.optimum(df),
    "scatter": lambda df: analysis.collapse(df, "Pi_IE").scatter,
    "front": lambda df: str(analysis.collapse(df).front),
    "transition": lambda df: analysis.transition(df),
    "crossings": lambda df: analysis.crossings(df, 1.0, along="N"),
    "plane": lambda df: analysis.plane(df, ("N", "zeta_T"), {"M_over_M0": 2.0, "V_over_V0": 1.0}).reset_index(
        drop=True
    ),
}


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("both", [[TIGHT, LOOSE], [LOOSE, TIGHT], [TIGHT, TIGHT]])
def test_a_loose_and_a_tight_sweep_together_tell_what_the_tight_one_does(asked, both):
    told, expected = (ASKED[asked](df) for df in (pd.concat(both, ignore_index=True), TIGHT))
    if isinstance(expected, pd.DataFrame):
        pd.testing.assert_frame_equal(told, expected)
    else:
        assert told == expected


def test_rows_of_a_task_that_another_tells_better_are_counted_as_such():
    assert left_out(pd.concat([LOOSE, TIGHT]), "ke_ratio") == {
        "failed": 0,
        "of a task with a better row": 90,
        "chaotic": 0,
    }


def test_a_row_without_an_error_gives_way_to_one_with_it_and_one_without_a_number_counts_nowhere():
    unsure = LOOSE.assign(error=np.nan)
    pd.testing.assert_frame_equal(once(pd.concat([unsure, TIGHT]), "ke_ratio"), TIGHT)
    lost = TIGHT.assign(ke_ratio=np.nan, error=0.0)
    assert analysis.optimum(pd.concat([lost, TIGHT])) == analysis.optimum(TIGHT)
