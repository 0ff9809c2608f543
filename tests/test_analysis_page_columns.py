"""Claims about the columns of a page: of a large table, and of one that was edited, where empty cells break nothing."""

import base64
import csv
import io
import json
import re
import zlib

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_hex

from analysis.cli import main
from analysis.colours import PLAIN_CMAP, RATIO_CMAP
from analysis.page import build, payload
from analysis.table import load

from . import browser
from .drawn import frame
from .test_analysis_cli import rows, write
from .test_analysis_page_table import GRID, choose, saved, slide, walk

# At which widths of the legend a mark's text begins on another line than the mark.
APART = """() => {
  const legend = document.querySelector("p.legend"), found = [];
  for (let width = 120; width < 600; width += 4) {
    legend.style.width = `${width}px`;
    for (const mark of legend.querySelectorAll(".swatch")) {
      const text = document.createRange();
      text.setStart(mark.nextSibling, 1);
      text.setEnd(mark.nextSibling, 2);
      if (text.getBoundingClientRect().top > mark.getBoundingClientRect().bottom) found.push(width);
    }
  }
  return found;
}"""


@pytest.mark.slow
def test_large_tables_are_rounded_to_seven_digits_and_say_so(tmp_path, monkeypatch):
    monkeypatch.setattr("analysis.page.columns.EXACT_ROWS", 10)
    held = payload(load(write(tmp_path / "t.h5", rows(GRID)), done_only=False))
    kinds = {column["name"]: column["kind"] for column in held["columns"]}
    assert held["digits"] == 7
    assert (kinds["ke_ratio"], kinds["zeta_T"], kinds["task"]) == ("f4", "u1", "count")


def test_a_value_whose_rows_have_all_failed_stays_on_its_axis_and_what_was_not_computed_does_not():
    df = frame(GRID).assign(status="done")
    df.loc[df["N"] == 20, "status"], df.loc[df["N"] == 40, "status"] = "step_budget", "unasked"
    held = {column["name"]: column for column in payload(df)["columns"]}
    kept = sorted({*GRID[0]} - {40})
    assert held["N"]["values"] == kept
    codes = np.frombuffer(zlib.decompress(base64.b64decode(held["N"]["data"])), "u1")
    np.testing.assert_array_equal(np.array(kept)[codes], df.loc[df["status"] == "done", "N"])


@pytest.mark.slow
def test_a_page_with_values_that_have_failed_rows_alone_is_walked_and_its_legend_says_what_white_is(tmp_path):
    df = frame(((5, 8, 13, 20, 32), (0.0, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 1e-2), (1.0,), (1.0,))).assign(status="done")
    df.loc[(df["zeta_T"] == 0) | (df["N"] == 20), "status"] = "not_finite"
    df.to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["page", str(tmp_path / "t.csv"), "-o", str(tmp_path / "t.html")]) == 0
    with browser.browser() as running:
        tab = browser.Tab(running, (tmp_path / "t.html").as_uri())
        walk(tab, "ArrowRight ArrowRight ArrowRight ArrowRight")
        assert "N 32, zeta_T 0.00001" in tab.text("#said")
        assert "no row done" in tab.text("p.legend")
        assert tab.page.evaluate(APART) == []
        assert tab.errors == []


@pytest.mark.slow
@pytest.mark.parametrize("first", [-(2**31) - 1, -(2**31), 7, 2**31 - 90, 2**31 - 89])
def test_numbers_of_tasks_stay_whole_however_large_they_are(tmp_path, monkeypatch, first):
    monkeypatch.setattr("analysis.page.columns.EXACT_ROWS", 10)
    table = load(write(tmp_path / "t.h5", rows(GRID)), done_only=False)
    held = payload(table.set_axis(table.index + first))
    (task,) = [column for column in held["columns"] if column["name"] == "task"]
    assert task["kind"] == ("i4" if -(2**31) <= first <= 2**31 - len(table) else "f8")
    told = np.frombuffer(zlib.decompress(base64.b64decode(task["data"])), f"<{task['kind']}")
    assert np.array_equal(told, table.index + first)


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


def test_the_page_has_both_rows_of_colours_from_one_end_to_the_other():
    facts = re.search(r'id="facts"[^>]*>(.*?)</script>', build(frame(GRID), "t.h5"), re.DOTALL)[1]
    for of, name in (("ratio", RATIO_CMAP), ("plain", PLAIN_CMAP)):
        colours = json.loads(facts)["colours"][of]
        assert [colours[0], colours[-1]] == [to_hex(colormaps[name](end)) for end in (0.0, 1.0)]
        assert len(set(colours)) > 200  # no steps that an eye could see
