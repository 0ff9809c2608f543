"""Claims about `analysis.best`."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import analysis
from analysis.best import IMPACT, guessed_below, lowest_row
from analysis.cli import main
from analysis.draw import best_maps
from analysis.notes import of_best
from analysis.quantity import KE
from analysis.report import left_out_lower

from .drawn import stars

COLUMNS = ["N", "zeta_T", "ke_ratio", "M_over_M0", "V_over_V0", "error", "chaotic"]


def frame(rows):
    """Rows (N, zeta_T, ke_ratio, M_over_M0, V_over_V0, error, chaotic[, status])."""
    names = [*COLUMNS, "status"][: len(rows[0])] if rows else COLUMNS
    return pd.DataFrame(rows, columns=names).rename_axis(index="task")


def brute_force(df, chaotic_too):
    """The task that wins each cell, found by looking at one row after the other; of rows of one task the surest."""
    surest, winners = {}, {}
    for task, row in df.iterrows():
        if row["status"] != "done" or not math.isfinite(row["ke_ratio"]):
            continue
        rank = (math.inf if math.isnan(row["error"]) else row["error"], row["ke_ratio"], task)
        key = tuple(row[["N", "zeta_T", "M_over_M0", "V_over_V0"]])
        surest[key] = min(surest.get(key, rank), rank)
    for *_, task in surest.values():
        row = df.loc[task]
        last = row["chaotic"] and not chaotic_too
        rank = (last, row["ke_ratio"], row["M_over_M0"], row["V_over_V0"], task)
        cell = (row["N"], row["zeta_T"])
        winners[cell] = min(winners.get(cell, rank), rank)
    return [winners[cell][-1] for cell in sorted(winners)]


# Few values of each, so that ties, empty cells and cells with chaotic rows only are common.
ROWS = st.lists(
    st.tuples(
        st.sampled_from([5, 20]),
        st.sampled_from([0.0, 1e-5, 1.0]),
        st.sampled_from([math.nan, math.inf, 0.0, 1e-3, 0.5, 2.0]),
        st.sampled_from([0.1, 1.0]),
        st.sampled_from([0.1, 10.0]),
        st.sampled_from([math.nan, 1e-4]),
        st.booleans(),
        st.sampled_from(["done", "done", "done", "failed", "pending", "torn"]),
    ),
    min_size=1,
    max_size=40,
)


@given(rows=ROWS, chaotic_too=st.booleans(), random=st.randoms())
def test_best_equals_a_brute_force_loop_in_any_order_of_rows(rows, chaotic_too, random):
    df = frame(rows)
    expected = brute_force(df, chaotic_too)
    order = list(df.index)
    random.shuffle(order)
    if not expected:
        with pytest.raises(analysis.InputError, match="no finished row has a ke_ratio"):
            analysis.best(df.loc[order], chaotic_too=chaotic_too)
        return
    found = analysis.best(df.loc[order], chaotic_too=chaotic_too)
    pd.testing.assert_frame_equal(found, df.loc[expected, COLUMNS])


def test_determined_row_wins_over_lower_chaotic_row():
    df = frame([(5, 0.0, 0.001, 1.0, 1.0, 1e-4, True), (5, 0.0, 0.7, 1.0, 2.0, 1e-4, False)])
    assert list(analysis.best(df)["ke_ratio"]) == [0.7]
    assert list(analysis.best(df, chaotic_too=True)["ke_ratio"]) == [0.001]


def test_cell_with_chaotic_rows_only_is_marked():
    df = frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, True), (6, 0.0, 0.7, 1.0, 2.0, 1e-4, False)])
    assert list(analysis.best(df)["chaotic"]) == [True, False]


def test_the_lowest_is_firm_where_it_can_be_whatever_asks_for_it(tmp_path, capsys):
    """The cell with chaotic rows only is lower than all others."""
    df = frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, True), (6, 0.0, 0.7, 1.0, 2.0, 1e-4, False)]).assign(checked=True)
    df.to_csv(tmp_path / "t.csv")
    for too, (ratio, N) in {False: (0.7, 6), True: (0.2, 5)}.items():
        assert lowest_row(df, chaotic_too=too)["ke_ratio"].tolist() == [ratio]
        assert analysis.optimum(df, chaotic_too=too).ke_ratio == ratio
        picture = ["-o", str(tmp_path / "a.png"), *(["--chaotic-too"] if too else [])]
        assert main(["best", str(tmp_path / "t.csv"), *picture]) == 0
        told = {line[:10].strip(): line[10:] for line in capsys.readouterr().out.splitlines()}
        assert told["optimum"].startswith(f"ke_ratio = {ratio}")
        assert told["lowest"].startswith(f"ke_ratio = {ratio}")
        assert ("chaotic" in told) is not too
        cells = analysis.best(df, chaotic_too=too)
        figure = best_maps(cells, {name: df[name].unique() for name in IMPACT}, of_best(df, df, cells, too))
        assert [across for across, _ in stars(figure.axes[0])] == [N]
    assert analysis.optimum(df.iloc[:1]).chaotic is True


@pytest.mark.parametrize(("ratio", "told"), [(0.2, []), (0.1, ["chaotic   1 row left out is lower (--chaotic-too)"])])
def test_chaotic_rows_that_were_left_out_are_told_of_where_they_are_lower(ratio, told):
    df = frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, False), (5, 0.0, ratio, 1.0, 2.0, 1e-4, True)])
    assert [line.partition(",")[0] for line in left_out_lower(df.iloc[:1], df, KE)] == told


def test_chains_compete_only_where_that_is_asked_for():
    """As a search over a number of the model asks."""
    rows = [(5, 0.0, 0.4, 1.0, 1.0, 1e-4, False), (5, 0.0, 0.2, 1.0, 1.0, 1e-4, False)]
    df = frame([*rows, (6, 0.0, 0.3, 1.0, 1.0, 1e-4, False)]).assign(**{"spring.c2": [-4.0, -5.0, -4.0]})
    with pytest.raises(analysis.InputError, match=r"the table varies spring\.c2"):
        analysis.best(df)
    cells = analysis.best(df, among=["spring.c2"])
    assert cells[["N", "ke_ratio", "spring.c2"]].to_numpy().tolist() == [[5, 0.2, -5.0], [6, 0.3, -4.0]]
    found = analysis.optimum(df, among=["spring.c2"])
    assert found.between["spring.c2"] == (-5.0, -4.5)
    assert "spring.c2 = -5 (-5 to -4.5)" in str(found)


def test_equal_rows_are_the_lowest_in_the_order_of_cells_and_impacts():
    rows = [(6, 0.0, 0.2, 1.0, 1.0), (5, 0.0, 0.2, 2.0, 1.0), (5, 0.0, 0.2, 1.0, 2.0), (5, 0.1, 0.2, 1.0, 1.0)]
    assert lowest_row(frame([(*row, 1e-4, False) for row in rows])).index.tolist() == [2]


def test_frame_without_status_is_taken_as_finished():
    assert len(analysis.best(frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, False)]))) == 1


def test_input_frame_is_left_as_it_was():
    df = frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, True), (5, 0.0, 0.1, 1.0, 2.0, 1e-4, False)])
    before = df.copy(deep=True)
    analysis.best(df)
    pd.testing.assert_frame_equal(df, before)


def test_missing_columns_are_all_named():
    df = frame([(5, 0.0, 0.2, 1.0, 1.0, 1e-4, False)]).drop(columns=["error", "N"])
    with pytest.raises(analysis.InputError, match="lacks the columns N, error"):
        analysis.best(df)


def test_planted_winners_are_found_among_more_than_a_million_rows():
    rng = np.random.default_rng(8)
    axes = (np.arange(5, 55), np.logspace(-5, 0, 50), np.logspace(-1, 1, 21), np.logspace(-1, 1, 21))
    N, zeta_T, M, V = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    ke_ratio = rng.uniform(0.1, 10.0, N.size)
    planted = np.arange(2500) * 441 + rng.integers(0, 441, 2500)
    ke_ratio[planted] = rng.uniform(0.001, 0.1, 2500)
    chaotic = rng.random(N.size) < 0.2
    chaotic[planted] = False
    columns = {"N": N, "zeta_T": zeta_T, "ke_ratio": ke_ratio, "M_over_M0": M, "V_over_V0": V}
    df = pd.DataFrame({**columns, "error": 1e-4, "chaotic": chaotic})
    assert len(df) == 1_102_500
    np.testing.assert_array_equal(analysis.best(df).index, planted)


def test_the_star_stands_on_what_was_computed_and_says_how_many_inferred_cells_are_lower():
    rows = frame([(5, 1e-3, 0.5, 1, 1, 0, False), (5, 1e-2, 0.3, 1, 1, 0, False), (8, 1e-3, 0.2, 1, 1, 0, False)])
    rows["inferred"] = [False, False, True]
    top = lowest_row(rows)
    assert top["ke_ratio"].tolist() == [0.3]
    assert guessed_below(rows, top) == "1 inferred cell is lower, down to 0.2"
    assert guessed_below(rows[rows["ke_ratio"] > 0.25], top) == ""
