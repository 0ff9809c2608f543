"""Claims about a served page whose table changes: it shows what there is, and what is looked at stays what it is."""

import csv
import io
import re
import threading
from contextlib import contextmanager

import numpy as np
import pytest

from analysis.cli import main
from analysis.view import Server
from analysis.view import rows as growing
from sweep.schema import seal

from . import browser
from .test_analysis_cli import rows, write
from .test_analysis_page_table import choose, saved, slide, walk
from .test_analysis_part import LOWEST, best_impact, searched

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
            tab.path = path
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


def done_of(made, done):
    """The same rows, of which the first are done."""
    made["status"][done:] = b"pending"
    seal(made)
    return made


def failing(failed):
    made = done_of(data(), failed)
    made["status"][:failed] = b"step_budget"
    seal(made)
    return made


def another_value(made):
    made["ke_ratio"][1] *= 2


def another_input(made):
    made["V_over_V0"] *= 2


def made_anew(made):
    made["status"] = b"pending"


def test_rows_that_fail_are_counted_as_they_come(served):
    with served(failing(10)) as (tab, put):
        assert "134 pending, 10 step_budget" in tab.text("#status")
        put(failing(144))
        tab.wait("document.getElementById('status').textContent.includes('144 step_budget')")
        assert "pending" not in tab.text("#status")


@pytest.mark.parametrize("change", [another_value, another_input, made_anew])
def test_of_a_table_that_takes_the_place_of_another_no_row_is_mixed_with_those_shown(served, change):
    with served(data()) as (tab, put):
        walk(tab, "ArrowRight Enter")
        row, other = tab.row(), data()
        change(other)
        seal(other)
        put(other)
        tab.wait("document.getElementById('lost').textContent.includes('another table')")
        assert tab.row() == row
        walk(tab, "ArrowRight Enter")
        tab.wait("document.getElementById('scene-said').textContent.endsWith('load this page anew')")
        tab.errors.clear()  # the browser tells of the answer, which is not of the kind that brings an impact
        (kept, _) = csv.DictReader(io.StringIO(saved(tab, "Save these rows").decode()))
        assert kept["task"] == row["task"]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda path: path.unlink(), "there is no table"),
        (lambda path: path.write_bytes(path.read_bytes()[:1000]), "damaged"),
        (lambda path: path.write_text("notes"), "not a table"),
    ],
)
def test_a_table_that_cannot_be_read_for_long_is_said_on_the_page_until_it_can(served, monkeypatch, damage, said):
    monkeypatch.setattr(growing, "PATIENCE", 0.1)
    with served(data((10, 0, 0, 0))) as (tab, put):
        damage(tab.path)
        tab.wait(f"document.getElementById('lost').textContent.includes('{said}')")
        assert tab.text("#lost").startswith("The page shows what it had: ")
        grow(tab, put, data())
        tab.wait("document.getElementById('lost').textContent === ''")
        assert tab.text("#status") == "144 of 144 rows done."


def test_a_table_is_the_same_while_rows_come_others_fail_and_one_is_torn(tmp_path, monkeypatch):
    monkeypatch.setattr(growing, "REST", 0.0)
    path, made = tmp_path / "t.h5", done_of(data(), 30)
    table, versions = growing.Growing(write(path, made)), []
    for task, status in ((30, b"done"), (31, b"step_budget"), (31, b"not_finite"), (31, b"done")):
        made["status"][task] = status
        seal(made)
        write(path, made)
        versions.append(table.now().version)
    made["ke_ratio"][3] = 7.0  # and is not sealed: it is being written
    write(path, made)
    versions.append(table.now().version)
    assert len(set(versions)) == 5
    assert table.now().number == 1


@pytest.mark.parametrize("more", [{}, {"robust": 0.02, "by": "worst"}])
def test_the_served_page_tells_of_a_search_what_the_page_does_and_anew_with_every_row(tmp_path, monkeypatch, more):
    monkeypatch.setattr(growing, "REST", 0.0)
    path = searched(tmp_path / "s.h5", LOWEST | more, best_impact)
    assert main(["page", str(path), "-o", str(tmp_path / "s.html")]) == 0
    with Server(path) as server:
        pages = [(tmp_path / "s.html").read_text(), server.page().decode()]
        said = [re.search('<p id="part">(.*?)</p>', page)[1] for page in pages]
        assert said[0] == said[1]
        assert said[0].startswith("A search: 0 of 180 rows screened")
        assert ("The search counts the worst within 2 % of an impact" in said[0]) == bool(more)
        searched(path, LOWEST | more, lambda data: data["N"] > 5)
        told = server.answer("/rows", {})
    assert "150 that may be the lowest of their cell computed" in told["part"]
    assert told["part"] in told["version"]
