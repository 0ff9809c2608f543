"""Claims about what a user has chosen on a page: it stands for values, whatever becomes of places, cells and rows."""

import csv
import io

import pytest

from analysis.cli import main

from . import browser
from .test_analysis_cli import write
from .test_analysis_page_table import choose, data, saved, walk

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


def test_where_the_user_points_stays_the_same_row_while_points_are_zoomed(tab):
    choose(tab, "across", "ke_ratio")
    choose(tab, "up", "t_peak_linear")
    walk(tab, "ArrowRight ArrowRight ArrowRight")
    pointed, said = tab.row(), tab.text("#said")
    for key in "+++-":
        tab.page.keyboard.press(key)
        tab.page.wait_for_timeout(100)
        assert (tab.row(), tab.text("#said")) == (pointed, said)
