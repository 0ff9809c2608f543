"""Numbers of the model and ratios may be negative or zero: pictures, optima and levels of them are drawn and true."""

import itertools
import warnings

import numpy as np
import pandas as pd
import pytest

from analysis import InputError, best, collapse, crossings, optimum, transition
from analysis.cli import main
from analysis.colours import plain_scale, ratio_scale
from analysis.draw_level import level_figure
from analysis.ruler import ruler
from analysis.ticks import label, ticks

from .drawn import assert_nested, crowded, frame, written

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
    assert "at        spring.c2 = -2, which is nearest to -2.2" in capsys.readouterr().out


def level_bars(low, high, **columns):
    """The drawn ends of one bar, and its middle."""
    told = {"at_low": 2.0, "at_high": 0.5, "sure": True, "why_not": "", "rows": 3, "unchecked": 0, "chaotic": 0}
    found = pd.DataFrame([{"N": 5, "low": low, "high": high} | told | columns])
    ax = level_figure(found, "spring.c2", "N", []).axes[0]
    middle = ax.containers[0].lines[0].get_ydata()
    return float(middle[0]), [float(line.get_segments()[0][k][1]) for line in ax.collections for k in (0, 1)]


@pytest.mark.parametrize(
    ("low", "high", "middle"), [(1.0, 4.0, 2.0), (-4.0, -1.0, -2.5), (-1.0, 3.0, 1.0), (0.0, 4.0, 2.0)]
)
def test_the_bar_of_a_level_spans_what_it_lies_between_whatever_the_signs(low, high, middle):
    drawn, ends = level_bars(low, high)
    assert drawn == pytest.approx(middle)
    assert ends == pytest.approx([low, high])


@pytest.mark.parametrize("name", ["x", "y"])
def test_on_both_axes_of_a_level_a_zero_stands_before_decades_that_are_as_wide_as_each_other(name):
    zetas, told = [0.0, 1e-5, 1e-4, 1e-3, 1e-2], {"sure": True, "rows": 3, "unchecked": 0, "chaotic": 0}
    if name == "x":
        found = pd.DataFrame({"zeta_T": zetas, "low": 5, "high": 8, "why_not": ""}).assign(**told)
        ax = level_figure(found, "N", "zeta_T", []).axes[0]
    else:
        found = pd.DataFrame({"N": [5, 6, 7, 8], "low": zetas[:-1], "high": zetas[1:], "why_not": ""}).assign(**told)
        ax = level_figure(found, "zeta_T", "N", []).axes[0]
    axis = getattr(ax, f"{name}axis")
    assert [tick.get_text() for tick in axis.get_ticklabels()] == ["0", "$10^{-5}$", "$10^{-4}$", "$10^{-3}$", "0.01"]
    places = axis.get_transform().transform(np.array(zetas))
    assert np.diff(places) == pytest.approx(np.diff(places)[-1], rel=0.2)
    low, high = axis.get_transform().transform(np.array(axis.get_view_interval()))
    assert low < places[0]
    assert high > places[-1]
    assert places[-1] - places[0] > 0.8 * (high - low)


def test_a_level_along_negative_values_is_drawn_by_its_command(tmp_path):
    df = table((-4.0, -2.0, -1.0)).assign(ke_ratio=lambda rows: -rows["spring.c2"] / 2.5)
    assert run(tmp_path, df, "level", "--level", "1", "--along", "spring.c2") == 0


def pictured(tmp_path, monkeypatch, df, command, *more):
    """The figure of a command on this table."""
    seen = []
    monkeypatch.setattr(f"analysis.commands.{command}.write", lambda _, figure, *rest: seen.append(figure))
    assert run(tmp_path, df, command, *more) == 0
    return seen[0]


def levels(tmp_path, monkeypatch, df, *more):
    """The figure of `level` on this table."""
    return pictured(tmp_path, monkeypatch, df, "level", "--level", "1", *more)


LINES = frame(((5, 10, 20, 40), (1e-4, 1e-3, 1e-2), (1.0, 2.0, 4.0), (2.0,)))


def test_curves_that_cross_a_level_at_the_same_places_are_all_seen(tmp_path, monkeypatch):
    figure = levels(tmp_path, monkeypatch, LINES)
    assert len(figure.axes[0].containers) == 3
    assert_nested(figure.axes[0])
    assert crowded(figure) == []


def test_a_level_that_is_never_crossed_is_said_to_be_so_on_axes_of_the_table(tmp_path, monkeypatch):
    figure = levels(tmp_path, monkeypatch, LINES.assign(ke_ratio=0.5), "--at", "M_over_M0=1")
    ax = figure.axes[0]
    assert [text.get_text() for text in ax.texts] == ["No crossing: below throughout on 3 lines."]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert ax.get_xlim()[0] < 1e-4 < 1e-2 < ax.get_xlim()[1] < 2e-2
    assert 4 < ax.get_ylim()[0] < 5 < 40 < ax.get_ylim()[1] < 50
    assert "Sought is the first crossing of KE ratio = 1 along $N$, at $M/M_0$ = 1, $V/V_0$ = 2." in written(figure)
    assert "Bars:" not in written(figure)


def test_a_line_with_one_value_is_not_said_to_stay_on_one_side_of_a_level(tmp_path, monkeypatch):
    """As where all rows but the cheapest failed; the axis is that of the table."""
    failed = LINES["N"].gt(5) & LINES["zeta_T"].lt(1e-2) | LINES["N"].gt(10)
    some = LINES.assign(ke_ratio=0.5, status=np.where(failed, "step_budget", "done"))
    figure = levels(tmp_path, monkeypatch, some, "--at", "M_over_M0=1")
    (text,) = figure.axes[0].texts
    said = "No crossing: fewer than 2 values on 2 lines; below throughout on 1 line."
    assert text.get_text().replace("\n", " ") == said
    assert 40 < figure.axes[0].get_ylim()[1] < 50
    some["status"] = some["status"].where(some["N"] > 20, "done")
    assert 40 < pictured(tmp_path, monkeypatch, some, "transition").axes[0].get_ylim()[1] < 50


def test_the_lines_that_do_not_cross_a_level_are_counted_below_the_picture(tmp_path, monkeypatch):
    some = LINES["ke_ratio"].where(LINES["zeta_T"] < 1e-2, 3.0)
    figure = levels(tmp_path, monkeypatch, LINES.assign(ke_ratio=some))
    text = written(figure)
    assert "No crossing: above throughout on 3 lines." in text
    assert "neighbours among those that are computed and not chaotic" in text
    assert "KE ratio: largest kinetic energy" in text
    assert not any(name in text for name in ("ke_ratio", "M_over_M0", "V_over_V0", "zeta_T "))


def test_whether_a_negative_quantity_crosses_a_level_for_sure_is_told_by_its_error():
    rows = table((1.0,), N=(5, 50), ke_ratio=[-0.9, -1.1], error=0.5)
    assert crossings(rows, -1.0)["sure"].tolist() == [False]
    assert crossings(rows.assign(error=0.01), -1.0)["sure"].tolist() == [True]


def test_an_optimum_below_zero_lies_within_its_error_and_has_its_rivals():
    found = optimum(table((1.0,), ke_ratio=[0.5, -0.026, -0.025], error=0.1))
    assert (found.low, found.high) == pytest.approx((-0.0286, -0.0234))
    assert found.rivals == 1
    assert found.between["N"] == pytest.approx((250**0.5, 500))


@pytest.mark.parametrize("ratio", [0.0, -0.5])
def test_a_ratio_of_zero_or_below_can_be_the_best(tmp_path, capsys, ratio):
    stored = [0.3, ratio, ratio, 0.2, 0.1, 0.2]
    df = table((1.0, 2.0)).assign(stored_ratio=stored, stored_error=0.1)
    assert best(df, over=("N", "spring.c2"), of="stored_ratio")["stored_ratio"].tolist() == stored
    for command in ("best", "map", "points"):
        words = (command, "--over", "N,spring.c2", "--of", "stored_ratio", "--force")
        assert run(tmp_path, df, *words) == 0
        assert f"lowest    stored_ratio = {ratio:.4g} (" in capsys.readouterr().out


def test_rows_of_a_ratio_that_has_no_logarithm_are_not_called_failed():
    stored = {"stored_ratio": [0.0, -1.0, *np.linspace(0.1, 1, 38)], "stored_error": 0.1}
    df = table((1.0,), N=range(5, 45), **stored)
    df.loc[39, "status"] = "step_budget"
    left_out = collapse(df, of="stored_ratio").left_out
    assert left_out == {"failed": 1, "without stored_ratio above 0": 2, "chaotic": 0, "without damping": 0}
    for judge in (collapse, transition):
        with pytest.raises(InputError, match=r"^no finished row has a stored_ratio above 0$"):
            judge(df.assign(stored_ratio=-1.0), of="stored_ratio")


def test_a_negative_power_of_ten_is_labelled_as_a_positive_one_is():
    assert [label(value) for value in (1e5, -1e5, -2e5)] == ["$10^{5}$", "$-10^{5}$", r"$-2{\times}10^{5}$"]


@pytest.mark.parametrize("scale", [plain_scale, ratio_scale])
@pytest.mark.parametrize("values", [[], [np.nan, np.inf], [0.0, 0.0], [-2.0], [-3.0, 0.0, 5.0], [-1e-9, 1e300]])
@pytest.mark.parametrize("limits", [None, (0.5, 2.0)])
def test_any_numbers_have_a_scale_that_rises(scale, values, limits):
    found = scale(np.array(values), limits)
    assert found.shown[0] < found.shown[1]
    shares = found.norm(np.array(found.shown))
    assert shares[0] < shares[1]
