"""Claims about what a user has chosen on a page: it stands for values, whatever becomes of places, cells and rows."""

import csv
import io

import numpy as np
import pytest

from analysis.cli import main

from . import browser
from .test_analysis_cli import write
from .test_analysis_page_table import choose, data, saved, walk

FIGURE = "Bokeh.documents.flatMap(one => one.roots()).at(-1)"
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def running():
    with browser.browser() as found:
        yield found


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
