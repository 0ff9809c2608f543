"""Where a quantity crosses a level: what is counted, what is sure, and how it is drawn."""

import numpy as np

from analysis.cli import main
from analysis.commands import level
from analysis.draw_level import level_figure
from analysis.level import crossings
from analysis.report import used_of_lines
from analysis.table import left_out

from .drawn import written
from .test_analysis_curves import ZETAS, N, falling


def test_the_line_of_a_level_breaks_where_it_is_not_crossed():
    """Before, it went on from the neighbours, across values that lie above throughout."""
    df = falling(((2.0, 2.0),))
    there = crossings(df, 1.0).query("why_not == ''")["zeta_T"].tolist()
    df.loc[df["zeta_T"] == there[1], "ke_ratio"] = 9.0
    line = level_figure(crossings(df, 1.0), "N", "zeta_T", []).axes[0].containers[0].lines[0]
    assert line.get_xdata().tolist() == there
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [1]


def test_of_any_quantity_a_crossing_within_the_error_is_not_sure_and_the_picture_says_so():
    df = falling(((2.0, 2.0),)).rename(columns={"ke_ratio": "rebound_ratio"}).assign(ke_ratio=1.0, rebound_error=1e-3)
    df["rebound_ratio"] = 1.0 + 1e-13 * (df["rebound_ratio"] - 1.0)
    for error, sure in ((1e-3, False), (1e-15, True)):
        found = crossings(df.assign(rebound_error=error), 1.0, of="rebound_ratio")
        crossed = found[found["why_not"] == ""]
        assert set(crossed["sure"]) == {sure}
        told = f"Of {len(crossed)} of {len(crossed)} an end is the level within its error."
        said = written(level_figure(found, "N", "zeta_T", []))
        assert (told in said) is not sure
    for untold in ("ke_bistable", "spread_low"):
        found = crossings(df.assign(**{untold: df["rebound_ratio"]}), 1.0, of=untold)
        assert not found["sure"].notna().any()


def test_rows_without_the_quantity_are_counted_and_lines_of_them_alone_are_no_gap():
    df = falling(((2.0, 2.0),)).assign(arrival=lambda rows: rows["ke_ratio"])
    df.loc[df["zeta_T"] == ZETAS[0], "arrival"] = np.nan
    df.loc[df.index[df["zeta_T"] == ZETAS[1]][:3], "arrival"] = np.nan
    found = crossings(df, 1.0, of="arrival").set_index("zeta_T")
    assert list(found.index) == list(ZETAS)
    assert found["without"].tolist() == [len(N), 3, 0, 0]
    assert found["rows"].tolist() == [0, len(N) - 3, len(N), len(N)]
    assert found["why_not"].tolist() == ["without arrival", "", "", ""]
    assert "left out: 0 failed, 27 without arrival, 0 chaotic" in used_of_lines(found, left_out(df, "arrival"))


def test_a_crossing_that_rows_without_a_number_may_hide_is_told(tmp_path, capsys, monkeypatch):
    said = []
    monkeypatch.setattr(level, "level_figure", lambda *given: said.append(given[4]) or level_figure(*given))
    df = falling(((2.0, 2.0),)).assign(status="done", chaotic=False)
    df.loc[df.index[df["zeta_T"] == ZETAS[0]][:2], "status"] = "step_budget"
    low, high = crossings(df, 1.0).iloc[-1][["low", "high"]]
    df.loc[(df["zeta_T"] == ZETAS[-1]) & (df["N"] == low), "chaotic"] = True
    df.loc[(df["zeta_T"] == ZETAS[-1]) & (df["N"] == high), "status"] = "step_budget"
    found = crossings(df, 1.0)
    assert found["failed"].tolist() == [2, 0, 0, 1]
    assert found["skipped"].tolist() == [0, 0, 0, 2]
    assert found["low"].iloc[-1] < low < high < found["high"].iloc[-1]
    wide = "1 of 4 crossings lie between N that are no neighbours: 2 between are chaotic, failed or not computed."
    words = "On 2 of 4 lines a crossing may hide behind rows that failed."
    for name, rows, told in (("some", df, True), ("whole", df[df["zeta_T"].isin(ZETAS[1:-1])], False)):
        rows.to_csv(path := tmp_path / f"{name}.csv", index=False)
        assert main(["level", str(path), "--level", "1", "-o", str(tmp_path / f"{name}.png")]) == 0
        printed = capsys.readouterr().out
        assert (f"hidden    {words}" in printed, f"skipped   {wide}" in printed) == (told, told)
        assert (words in said[-1], wide in said[-1]) == (told, told)


def test_rows_still_to_come_between_the_ends_are_counted_and_those_that_nobody_asked_for_are_not():
    df = falling(((2.0, 2.0),)).assign(status="done", chaotic=False)
    low, high = crossings(df, 1.0).iloc[-1][["low", "high"]]
    at_end = (df["zeta_T"] == ZETAS[-1]) & df["N"].isin([low, high])
    for status, skipped in (("pending", 2), ("torn", 2), ("unasked", 0)):
        assert crossings(df.assign(status=df["status"].mask(at_end, status)), 1.0)["skipped"].tolist() == [
            0,
            0,
            0,
            skipped,
        ]


def test_the_last_mark_stands_within_the_axes_where_zero_and_one_value_are_across():
    found = crossings(falling([(2, 10)]), 1.0)
    figure = level_figure(found[:2].assign(zeta_T=[0.0, 0.1]), "N", "zeta_T", [])
    low, high = figure.axes[0].get_xlim()
    assert low < 0
    assert high > 0.11


def test_the_only_value_across_which_a_level_is_drawn_is_the_only_number_there():
    found = crossings(falling([(2, 10)]), 1.0)
    figure = level_figure(found[:1].assign(zeta_T=0.1), "N", "zeta_T", [])
    axis = figure.axes[0].xaxis
    assert (axis.get_majorticklocs().tolist(), axis.get_minorticklocs().tolist()) == ([0.1], [])
    assert [tick.get_text() for tick in axis.get_ticklabels()] == ["0.1"]
