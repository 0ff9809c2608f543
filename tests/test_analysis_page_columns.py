"""Claims about the columns of a page: of a large table, and of one that was edited, where empty cells break nothing."""

import csv
import io

import numpy as np
import pytest

from analysis.cli import main
from analysis.page import payload
from analysis.table import load

from . import browser
from .drawn import frame
from .test_analysis_cli import rows, write
from .test_analysis_page_table import GRID, choose, saved, slide, walk


@pytest.mark.slow
def test_large_tables_are_rounded_to_seven_digits_and_say_so(tmp_path, monkeypatch):
    monkeypatch.setattr("analysis.page.columns.EXACT_ROWS", 10)
    held = payload(load(write(tmp_path / "t.h5", rows(GRID)), done_only=False))
    kinds = {column["name"]: column["kind"] for column in held["columns"]}
    assert held["digits"] == 7
    assert (kinds["ke_ratio"], kinds["zeta_T"], kinds["task"]) == ("f4", "u1", "count")


@pytest.mark.slow
def test_numbers_of_tasks_stay_whole_however_large_they_are(tmp_path, monkeypatch):
    monkeypatch.setattr("analysis.page.columns.EXACT_ROWS", 10)
    table = load(write(tmp_path / "t.h5", rows(GRID)), done_only=False)
    held = payload(table.set_axis(table.index + 2**31 + 1))
    (kind,) = [column["kind"] for column in held["columns"] if column["name"] == "task"]
    assert kind == "f8"


@pytest.mark.slow
def test_cells_that_are_empty_in_an_edited_table_are_not_known_and_the_rest_is_as_ever(tmp_path):
    """Of text, and of a number of the model: on its slider, and as an axis."""
    c2 = np.resize([4.0, np.nan, 5.0], 90)
    made = frame(GRID).assign(**{"mine": np.resize(["a", None, "b"], 90), "spring.c2": c2})
    made.to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["page", str(tmp_path / "t.csv"), "-o", str(tmp_path / "t.html")]) == 0
    with browser.browser() as running:
        tab = browser.Tab(running, (tmp_path / "t.html").as_uri())
        slide(tab, "spring.c2", 3)
        assert tab.text("#title").endswith("spring.c2 = not known")
        walk(tab, "ArrowRight")
        assert (tab.row()["mine"], tab.row()["spring.c2"]) == ("", "not known")
        choose(tab, "across", "spring.c2")
        walk(tab, "ArrowRight ArrowRight ArrowRight ArrowRight")
        assert "spring.c2 5" in tab.text("#said")
        found = list(csv.DictReader(io.StringIO(saved(tab, "Save the rows in view").decode())))
        assert [row["spring.c2"] for row in found] == [f"{x:g}" for x in c2[np.isfinite(c2)]]
        assert tab.errors == []


def test_an_empty_column_of_a_number_of_the_model_is_packed_without_a_slider():
    held = payload(frame(GRID).assign(**{"spring.c2": np.nan}))
    assert [one["kind"] for one in held["columns"] if one["name"] == "spring.c2"] == ["f8"]
