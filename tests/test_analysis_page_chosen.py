"""Claims about what a user has chosen on a page: it stands for values, whatever becomes of places, cells and rows."""

import csv
import io

import numpy as np
import pandas as pd
import pytest

from analysis.cli import main

from . import browser
from .drawn import frame
from .test_analysis_cli import write
from .test_analysis_page_table import GRID, choose, data, saved, slide, walk

FIGURE = "Bokeh.documents.flatMap(one => one.roots()).at(-1)"
pytestmark = pytest.mark.slow


@pytest.fixture
def tab(running, tmp_path):
    assert main(["page", str(write(tmp_path / "t.h5", data())), "-o", str(tmp_path / "t.html")]) == 0
    made = browser.Tab(running, (tmp_path / "t.html").as_uri())
    yield made
    assert made.errors == []
    made.page.close()


def test_where_the_user_points_is_no_cell_of_other_axes_and_is_the_same_again_on_those_from_before(tab):
    walk(tab, "ArrowRight ArrowRight ArrowRight ArrowRight ArrowRight ArrowUp ArrowUp")
    said, invitation = tab.text("#said"), "Point at a cell, or move with the arrow keys."
    assert " at N 80, zeta_T 0.01," in said
    for across, up, shown in (("V_over_V0", "M_over_M0", invitation), ("N", "zeta_T", said)):
        choose(tab, "across", across)
        choose(tab, "up", up)
        assert tab.text("#said") == shown
    choose(tab, "across", "V_over_V0")
    choose(tab, "up", "M_over_M0")
    walk(tab, "+ Enter 0")
    assert (tab.page.locator("#picked").is_hidden(), tab.text("#row")) == (True, "")
    walk(tab, "ArrowLeft ArrowRight Enter")
    tab.wait("!document.getElementById('picked').hidden")
    (row,) = csv.DictReader(io.StringIO(saved(tab, "Save these rows").decode()))
    assert (row["task"], row["V_over_V0"], row["M_over_M0"]) == (tab.row()["task"], "3", "0.5")


@pytest.mark.parametrize("scale", ["log", "linear", "even"])
def test_zooming_ends_not_far_beyond_the_whole_and_where_digits_end_and_0_brings_all_back(tab, scale):
    for side in ("across", "up"):
        choose(tab, f"scale {side}", scale)
    every = saved(tab, "Save the rows in view")
    box = tab.page.locator("#figure canvas").first.bounding_box()
    tab.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for keys, turned in (("- " * 40, 0), ("+ " * 80, 0), ("0", 3000), ("0", -3000)):
        walk(tab, keys)
        for _ in range(20 if turned else 0):
            tab.page.mouse.wheel(0, turned)
        assert tab.page.evaluate(f"({FIGURE}).x_range.end > ({FIGURE}).x_range.start")
        ends = tab.page.evaluate(f"[({FIGURE}).x_range, ({FIGURE}).y_range].flatMap(one => [one.start, one.end])")
        assert np.isfinite(ends).all()
        assert max(np.abs(ends)) < 1e6
        walk(tab, "0")
        tab.page.wait_for_timeout(100)
        assert saved(tab, "Save the rows in view") == every


def test_where_the_user_points_stays_the_same_row_while_points_are_zoomed(tab):
    choose(tab, "across", "ke_ratio")
    choose(tab, "up", "t_peak_linear")
    walk(tab, "ArrowRight ArrowRight ArrowRight")
    pointed, said = tab.row(), tab.text("#said")
    for key in "+++-":
        tab.page.keyboard.press(key)
        tab.page.wait_for_timeout(100)
        assert (tab.row(), tab.text("#said")) == (pointed, said)


def opened(running, folder, made):
    """The tab with the page of a table."""
    made.to_csv(folder / "t.csv", index_label="task")
    assert main(["page", str(folder / "t.csv"), "-o", str(folder / "t.html")]) == 0
    return browser.Tab(running, (folder / "t.html").as_uri())


@pytest.mark.parametrize(
    ("statuses", "said"),
    [
        (["step_budget"], ["No row is done: 90 step_budget.", "No row has a number to show."]),
        (
            ["step_budget", "pending"],
            [
                "No row is done yet: 45 step_budget, 45 pending.",
                "A page that is made later shows the rows that there are then.",
            ],
        ),
    ],
)
def test_a_page_without_a_finished_row_promises_none_that_cannot_come(running, tmp_path, statuses, said):
    tab = opened(running, tmp_path, frame(GRID).assign(status=np.resize(statuses, 90)))
    assert [tab.text("#status"), tab.text("#nothing")] == said
    assert tab.errors == []


def test_what_a_cell_lacks_is_said_in_words_that_fit(running, tmp_path):
    """A chaotic row left out has a number; one row is no rows; what is not known has no unit."""
    nothing = np.where(np.arange(90) % 6 == 1, np.nan, 1.0)
    made = frame(((5, 10), *GRID[1:]), t_peak_linear=np.nan).assign(status="done")
    made.loc[made["N"] == 5, "chaotic"] = True
    made["ke_ratio"] *= nothing[: len(made)]
    tab = opened(running, tmp_path, made)
    choose(tab, "chaotic rows", "left out")
    walk(tab, "ArrowRight")
    assert tab.text("#said") == "6 rows: 5 chaotic, left out; 1 without a number"
    walk(tab, "ArrowRight")
    assert tab.row()["t_peak_linear"] == "not known"
    slide(tab, "M_over_M0", 1)
    slide(tab, "V_over_V0", 2)
    assert tab.text("#said") == "1 row, no number"
    slide(tab, "V_over_V0", 1)
    walk(tab, "ArrowLeft")
    assert tab.text("#said") == "1 row, chaotic: left out"
    assert "left out" in tab.text("p.legend")
    assert tab.errors == []


def test_the_arrow_keys_reach_every_point_and_return_to_their_line_behind_a_gap(running, tmp_path):
    places = [(5, 1e-4), (10, 1e-4), (20, 1e-3), (40, 1e-4), (40, 2e-3), (20, 3e-3), (80, 3e-4)]
    made = pd.concat([frame(((N,), (zeta_T,), (1.0,), (1.0,))) for N, zeta_T in places], ignore_index=True)
    tab = opened(running, tmp_path, made)
    for keys, where in (
        ("ArrowRight ArrowRight", "N 10, zeta_T 0.0001"),
        ("ArrowRight", "N 20, zeta_T 0.001"),
        ("ArrowRight", "N 40, zeta_T 0.0001"),
        ("ArrowUp", "N 80, zeta_T 0.0003"),
        ("ArrowUp", "N 20, zeta_T 0.001"),
        ("ArrowUp", "N 40, zeta_T 0.002"),
        ("ArrowUp ArrowUp", "N 20, zeta_T 0.003"),
        ("ArrowLeft ArrowLeft ArrowLeft", "N 5, zeta_T 0.0001"),
    ):
        walk(tab, keys)
        assert where in tab.text("#said")
    assert tab.errors == []


def test_values_that_are_close_are_told_apart_wherever_they_are_named(running, tmp_path):
    made = frame(((5, 10), (1e-3, 1.0001e-3, 1.0002e-3), (0.55301, 0.55302), (1.0001, 1.0002, 1.0003)))
    tab = opened(running, tmp_path, made)
    slide(tab, "M_over_M0", 1)
    slide(tab, "V_over_V0", 2)
    assert tab.text("#title") == "colour: ke_ratio at M_over_M0 = 0.55301, V_over_V0 = 1.0002"
    outputs = "[...document.querySelectorAll('label.slice output')].map(e => e.innerText)"
    assert tab.page.evaluate(outputs) == ["0.55301", "1.0002"]
    walk(tab, "ArrowRight ArrowUp")
    assert tab.text("#said").endswith(" at N 5, zeta_T 0.0010001, M_over_M0 0.55301, V_over_V0 1.0002")
    ticks = f"[...({FIGURE}).yaxes[0].major_label_overrides.values()]"
    assert tab.page.evaluate(ticks) == ["0.001", "0.0010001", "0.0010002"]
    choose(tab, "scale up", "linear")
    labels = tab.page.evaluate(ticks)
    assert len(set(labels)) == len(labels) > 3
    assert tab.errors == []


def test_the_title_tells_what_all_rows_have_in_common(running, tmp_path):
    tab = opened(running, tmp_path, frame(((5, 10), (1e-3, 1e-2), (1.0,), (0.5, 2.0))))
    slide(tab, "V_over_V0", 1)
    assert tab.text("#title") == "colour: ke_ratio at V_over_V0 = 0.5, M_over_M0 = 1"
    choose(tab, "across", "M_over_M0")
    assert tab.text("#title") == "colour: ke_ratio, lowest over N at V_over_V0 = 0.5"
    assert tab.errors == []
