"""Claims about a served page whose table changes: it shows what there is, and what is looked at stays what it is."""

import csv
import io
import threading
from contextlib import contextmanager

import numpy as np
import pytest

from analysis.view import Server
from analysis.view import rows as growing
from sweep.schema import seal

from . import browser
from .test_analysis_cli import rows, write
from .test_analysis_page_table import choose, saved, slide, walk

pytestmark = pytest.mark.slow

GRID = ((5, 10, 20, 40), (1e-5, 1e-4, 1e-3, 1e-2), (0.5, 1.0, 2.0), (0.3, 1.0, 3.0))


def data(least=(0, 0, 0, 0)):
    """Rows of which those are done whose inputs are no lower; the largest tasks of a sweep come first."""
    made = rows(GRID)
    names = ("N", "zeta_T", "M_over_M0", "V_over_V0")
    done = np.all([made[name] >= low for name, low in zip(names, least, strict=True)], axis=0)
    made["status"][~done] = b"pending"
    seal(made)
    return made


@pytest.fixture(scope="module")
def running():
    with browser.browser() as found:
        yield found


@pytest.fixture
def served(running, tmp_path, monkeypatch):
    """What serves a table of given rows: the tab with its page, and what writes other rows in its place."""
    monkeypatch.setattr(growing, "REST", 0.0)

    @contextmanager
    def serve(made):
        path = write(tmp_path / "t.h5", made)
        with Server(path) as server:
            thread = threading.Thread(target=server.serve_forever, daemon=True)
            thread.start()
            tab = browser.Tab(running, server.address)
            # At once: HDF5 refuses to write what a thread of the same process is reading.
            yield tab, lambda rows: write(path.with_suffix(".new"), rows).replace(path)
            assert tab.errors == []
            tab.page.close()
            server.shutdown()
            thread.join(30)

    return serve


def grow(tab, put, made):
    """Put other rows in the table's place, and wait for their picture."""
    tab.redrawn(lambda: put(made))


def chosen(tab):
    """What every slider says."""
    return tab.page.evaluate("[...document.querySelectorAll('label.slice')].map(e => e.innerText.split(/\\s+/))")


def test_a_slice_holds_its_value_and_its_focus_while_lower_values_come(served):
    with served(data((20, 1e-3, 1.0, 1.0))) as (tab, put):
        slide(tab, "M_over_M0", 1)
        slide(tab, "V_over_V0", 2)
        title, values = tab.text("#title"), [["M_over_M0", "1"], ["V_over_V0", "3"]]
        assert title == "colour: ke_ratio at M_over_M0 = 1, V_over_V0 = 3"
        tab.page.locator("label.slice", has_text="V_over_V0").locator("input").focus()
        grow(tab, put, data())
        assert (tab.text("#title"), chosen(tab)) == (title, values)
        assert tab.page.evaluate("document.activeElement.closest('label').innerText.startsWith('V_over_V0')")
        walk(tab, "ArrowRight")
        assert "M_over_M0 1, V_over_V0 3" in tab.text("#said")


def test_the_cell_that_the_user_points_to_holds_its_values_while_lower_ones_come(served):
    with served(data((20, 1e-3, 1.0, 1.0))) as (tab, put):
        walk(tab, "ArrowRight ArrowRight")
        said = tab.text("#said")
        assert " at N 40, zeta_T 0.001, M_over_M0 1, V_over_V0 3" in said
        slide(tab, "M_over_M0", 1)
        slide(tab, "V_over_V0", 2)
        grow(tab, put, data())
        assert (tab.text("#said"), tab.row()["N"], tab.row()["zeta_T"]) == (said, "40", "0.001")


def in_view(tab):
    """The values of N, and those of zeta_T, of the rows in view."""
    found = list(csv.DictReader(io.StringIO(saved(tab, "Save the rows in view").decode())))
    return [sorted({float(row[name]) for row in found}) for name in ("N", "zeta_T")]


@pytest.mark.parametrize("scale", ["auto", "log", "linear"])
def test_all_of_a_growing_table_stays_in_view(served, scale):
    with served(data((20, 1e-3, 0, 0))) as (tab, put):
        choose(tab, "scale across", scale)
        assert in_view(tab) == [[20, 40], [1e-3, 1e-2]]
        grow(tab, put, data())
        assert in_view(tab) == [[*GRID[0]], [*GRID[1]]]


@pytest.mark.parametrize("scale", ["even", "log", "linear"])
def test_what_the_user_has_zoomed_to_stays_in_view_while_lower_values_come(served, scale):
    with served(data((20, 1e-4, 0, 0))) as (tab, put):
        choose(tab, "scale across", scale)
        choose(tab, "scale up", scale)
        walk(tab, "ArrowRight ArrowRight ArrowUp ArrowUp")
        walk(tab, "+ + + +")
        assert in_view(tab) == [[40], [1e-2]]
        grow(tab, put, data())
        assert in_view(tab) == [[40], [1e-2]]
        walk(tab, "0")
        assert in_view(tab) == [[*GRID[0]], [*GRID[1]]]
