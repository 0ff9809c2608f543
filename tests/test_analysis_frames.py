"""Claims about data frames that users make themselves: put together, sorted, indexed, read from text."""

import io

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis import InputError

AXES = {"N": (10, 20, 40, 80), "zeta_T": (1e-4, 1e-3, 1e-2), "M_over_M0": (0.5, 2.0), "V_over_V0": (1.0, 3.0)}


def table():
    """A whole grid on which the ratio falls with N, and most quickly where dampers are weak."""
    grid = pd.MultiIndex.from_product(AXES.values(), names=AXES).to_frame(index=False)
    ratio = 4.0 / (grid["N"] * grid["zeta_T"] ** 0.25 * grid["M_over_M0"] * grid["V_over_V0"])
    known = {"error": 1e-3, "chaotic": np.arange(len(grid)) % 7 == 0, "checked": True, "status": "done"}
    return grid.assign(ke_ratio=ratio, **known)


@pytest.mark.parametrize("changed", [lambda df: df.sample(frac=1, random_state=3), lambda df: df[df.columns[::-1]]])
def test_a_whole_grid_becomes_arrays_with_its_axes_in_whatever_order_it_stands(changed):
    found = analysis.to_xarray(changed(table()))
    assert {name: len(values) for name, values in AXES.items()} == dict(found.sizes)
    chosen = table().query("N == 40 and zeta_T == 1e-3 and M_over_M0 == 2 and V_over_V0 == 3")["ke_ratio"].item()
    assert float(found["ke_ratio"].sel(N=40, zeta_T=1e-3, M_over_M0=2, V_over_V0=3)) == chosen


@pytest.mark.parametrize("answer", [analysis.best, analysis.optimum, analysis.transition, analysis.collapse])
def test_inputs_that_stand_in_the_index_too_are_refused_in_words(answer):
    with pytest.raises(InputError, match=r"^df: must not have N, zeta_T in its index and as columns: reset_index"):
        answer(table().set_index(["N", "zeta_T"], drop=False))


def test_a_spread_that_holds_text_is_named():
    text = table().assign(spread_low=np.nan, spread_high=np.nan).to_csv(index=False)
    read = pd.read_csv(io.StringIO(text), keep_default_na=False)
    with pytest.raises(InputError, match=r"must hold numbers in the columns .*spread_low, spread_high"):
        analysis.optimum(read)
