"""Claims about the page of a table: it shows the table's own numbers, alone, to everybody, in a real browser."""

import csv
import html
import io
import re

import numpy as np
import pandas as pd
import pytest

from analysis.best import best
from analysis.cli import main
from analysis.colours import PLAIN_CMAP, RATIO_CMAP
from analysis.exported import read_exported
from analysis.page import build, payload
from analysis.table import load
from sweep.schema import seal
from sweep.store.meanings import meaning, unit

from . import browser
from .drawn import frame
from .test_analysis_cli import rows, write

pytestmark = pytest.mark.slow

GRID = ((5, 10, 20, 40, 80), (1e-4, 1e-3, 1e-2), (0.5, 1.0, 2.0), (0.3, 3.0))


def data():
    """Rows of every kind: chaotic ones, a whole cell of them, of large error, unchecked, failed, open."""
    made = rows(GRID)
    random = np.random.default_rng(7)
    made["ke_ratio"] = 10 ** random.uniform(-2, 1, len(made))
    made["error"], made["condition"], made["checked"], made["chaotic"] = 1e-4, 10.0, True, False
    made["spread_low"] = made["spread_high"] = np.nan
    made["chaotic"][(made["N"] == 5) & (made["zeta_T"] == 1e-4)] = True
    made["chaotic"][(made["N"] == 40) & (made["M_over_M0"] == 1.0)] = True
    made["error"][(made["N"] == 80) & (made["zeta_T"] == 1e-2)] = 0.5
    made["checked"][7], made["error"][7] = False, np.nan
    made["status"][-1], made["ke_ratio"][-1] = b"step_budget", np.nan
    made["status"][-2] = b"pending"
    seal(made)
    return made


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = write(tmp_path_factory.mktemp("page") / "wild.h5", data())
    assert main(["page", str(path), "-o", str(path.with_suffix(".html"))]) == 0
    return path


@pytest.fixture
def tab(running, table):
    made = browser.Tab(running, table.with_suffix(".html").as_uri())
    yield made
    assert made.errors == []
    assert made.asked == []
    made.page.close()


def slide(tab, name, place):
    slider = tab.page.locator("label.slice", has_text=name).locator("input")
    tab.redrawn(lambda: slider.fill(str(place)))


def choose(tab, label, value):
    found = tab.page.locator("label", has=tab.page.locator(f"span:text-is('{label}')")).locator("select")
    tab.redrawn(lambda: found.select_option(value))


def walk(tab, keys):
    tab.page.focus("#plot")
    for key in keys.split():
        tab.page.keyboard.press(key)


def test_every_cell_shows_the_lowest_calm_row_of_its_place_by_keyboard_alone(tab, table):
    df = load(table)
    calm = df[~df["chaotic"].fillna(False)]
    for k, N in enumerate(GRID[0]):
        walk(tab, "ArrowRight" if k else "ArrowRight ArrowUp")
        tab.wait(f"document.getElementById('said').textContent.includes(' at N {N}, zeta_T 0.001,')")
        place = (calm["N"] == N) & (calm["zeta_T"] == 1e-3)
        tab.wait("document.querySelectorAll('#row dd').length")
        assert float(tab.row()["ke_ratio"]) == pytest.approx(calm[place]["ke_ratio"].min(), rel=1e-9)
        assert tab.row()["task"] == str(calm[place]["ke_ratio"].idxmin())


def test_a_cell_that_is_chaotic_all_over_says_so_and_one_that_is_not_does_not(tab):
    walk(tab, "ArrowRight")
    assert tab.text("#said").endswith(", chaotic")
    walk(tab, "ArrowRight")
    assert "chaotic" not in tab.text("#said")
    choose(tab, "chaotic rows", "left out")
    walk(tab, "ArrowLeft")
    assert tab.text("#said") == "6 rows, chaotic: left out"


def test_a_slice_shows_one_impact(tab, table):
    slide(tab, "M_over_M0", 3)
    slide(tab, "V_over_V0", 1)
    assert tab.text("#title") == "colour: ke_ratio at M_over_M0 = 2, V_over_V0 = 0.3"
    walk(tab, "ArrowRight ArrowRight ArrowUp")
    df = load(table)
    row = df.query("N == 10 and zeta_T == 1e-3 and M_over_M0 == 2 and V_over_V0 == 0.3")
    assert float(tab.row()["ke_ratio"]) == pytest.approx(float(row["ke_ratio"].iloc[0]), rel=1e-9)


def test_axes_colours_and_the_way_of_taking_one_row_of_many_can_be_chosen(tab, table):
    df = load(table)
    choose(tab, "across", "M_over_M0")
    choose(tab, "up", "V_over_V0")
    choose(tab, "of many rows", "highest")
    choose(tab, "colour", "error")
    walk(tab, "ArrowRight")
    place = (df["M_over_M0"] == 0.5) & (df["V_over_V0"] == 0.3)
    calm = df[place & ~df["chaotic"].fillna(False)]
    assert float(tab.row()["error"]) == pytest.approx(calm["error"].max())
    choose(tab, "colour", "rows")
    walk(tab, "ArrowRight ArrowLeft")
    assert tab.text("#said") == f"rows {place.sum()}"


def test_results_on_an_axis_are_drawn_as_points(tab, table):
    choose(tab, "up", "ke_ratio")
    walk(tab, "ArrowRight ArrowRight")
    found = tab.row()
    assert float(found["ke_ratio"]) == pytest.approx(load(table)["ke_ratio"][int(found["task"])], rel=1e-9)


def test_the_pointer_and_the_keys_find_the_same_row(tab):
    walk(tab, "ArrowRight ArrowRight ArrowUp")
    by_keys = tab.row()
    box = tab.page.locator("#figure canvas").first.bounding_box()
    for dx in np.linspace(0.15, 0.8, 40):
        tab.page.mouse.move(box["x"] + dx * box["width"], box["y"] + 0.5 * box["height"])
        if f"at N {by_keys['N']}," in tab.text("#said"):
            break
    assert tab.row() == by_keys


def test_what_is_not_known_is_said_and_never_a_number(tab):
    ended = "88 of 90 rows done (1 pending, 1 step_budget)"
    assert tab.text("#status") == f"{ended}; 1 row not checked for chaos; unfinished when this page was made."
    slide(tab, "M_over_M0", 2)
    slide(tab, "V_over_V0", 2)
    walk(tab, "ArrowRight")
    assert tab.row()["spread_low"] == "not known"


def saved(tab, button):
    with tab.page.expect_download() as download:
        tab.page.get_by_role("button", name=button).click()
    return download.value.path().read_bytes()


def test_the_rows_in_view_are_saved_bit_for_bit(tab, table):
    slide(tab, "M_over_M0", 1)
    found = list(csv.DictReader(io.StringIO(saved(tab, "Save the rows in view").decode())))
    df = load(table).query("M_over_M0 == 0.5")
    assert [int(row["task"]) for row in found] == df.index.tolist()
    for name in ("N", "zeta_T", "ke_ratio", "t_peak_linear"):
        assert [float(row[name]) for row in found] == df[name].tolist()
    assert {(row["chaotic"], row["checked"]) for row in found} == {("True", "True"), ("False", "True"), ("", "False")}


def test_the_rows_that_were_saved_are_read_as_those_of_the_table(tab, table, tmp_path):
    (tmp_path / "saved.csv").write_bytes(saved(tab, "Save the rows in view"))
    read = read_exported(tmp_path / "saved.csv").set_index("task")
    pd.testing.assert_frame_equal(best(read), best(load(table)), check_dtype=False, check_categorical=False)


def test_the_mean_of_a_cell_tells_of_how_many_rows_it_is(tab, table):
    """Chaotic rows are counted only where they are part of it."""
    df = load(table).query("N == 40 and zeta_T == 1e-3")
    choose(tab, "of many rows", "mean")
    walk(tab, "ArrowRight ArrowUp ArrowRight ArrowRight ArrowRight")
    mean = df[~df["chaotic"]]["ke_ratio"].mean()
    assert (len(df), tab.text("#said")) == (6, f"mean ke_ratio of 4 rows {mean:.4g}")


def test_a_row_kept_is_listed_and_saved(tab):
    walk(tab, "ArrowRight ArrowRight Enter")
    tab.wait("!document.getElementById('picked').hidden")
    (row,) = csv.DictReader(io.StringIO(saved(tab, "Save these rows").decode()))
    assert row["task"] == tab.row()["task"]
    tab.page.get_by_role("button", name=f"remove task {row['task']}").click()
    tab.wait("document.getElementById('picked').hidden")


def test_the_picture_is_saved_as_it_is_seen(tab):
    from PIL import Image

    picture = np.asarray(Image.open(io.BytesIO(saved(tab, "Save the picture"))).convert("RGB"))
    assert picture.shape[0] > 400
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 15  # colours of cells and scale, not a blank


def test_the_saved_picture_says_of_which_table_it_is_and_what_its_marks_mean(tab):
    tab.page.evaluate("""() => {
        const write = CanvasRenderingContext2D.prototype.fillText;
        window.written = [];
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
            window.written.push(text);
            return write.call(this, text, ...at);
        };
    }""")
    saved(tab, "Save the picture")
    words = " ".join(tab.page.evaluate("window.written"))
    assert tab.text("h1") in words
    assert tab.text("#title") in words
    assert "hatched: chaotic: sensitive to its inputs; dotted: estimated error above the chosen one" in words


def test_chaos_and_large_errors_are_marked_by_patterns_not_by_colour_alone(tab):
    choose(tab, "of many rows", "highest")
    marked = ink(tab)
    choose(tab, "dots above error", "Infinity")
    without_dots = ink(tab)
    choose(tab, "chaotic rows", "left out")
    assert marked > without_dots > ink(tab)


def ink(tab):
    """How many pixels are nearly black."""
    from PIL import Image

    return int((np.asarray(Image.open(io.BytesIO(tab.page.screenshot())).convert("L")) < 40).sum())


def test_dots_mark_the_error_of_what_is_shown(running, tmp_path):
    wall = {"wall_force": 1.0, "wall_force_linear": 2.0, "wall_force_ratio": 0.5, "wall_force_error": 0.5}
    frame(GRID, **wall).to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["page", str(tmp_path / "t.csv"), "-o", str(tmp_path / "t.html")]) == 0
    tab = browser.Tab(running, (tmp_path / "t.html").as_uri())
    for of, dotted in (("ke_ratio", False), ("wall_force_ratio", True)):
        choose(tab, "colour", of)
        choose(tab, "dots above error", "0.01")
        marked = ink(tab)
        choose(tab, "dots above error", "Infinity")
        assert (marked > ink(tab)) == dotted, of
    assert tab.errors == []
    tab.page.close()


@pytest.mark.parametrize("width", [1200, 400])
def test_nothing_overflows_and_the_picture_keeps_room(running, table, width):
    tab = browser.Tab(running, table.with_suffix(".html").as_uri(), width=width)
    assert tab.page.evaluate("document.documentElement.scrollWidth") == width
    assert tab.page.locator("#plot").bounding_box()["width"] > 0.4 * width
    walk(tab, "ArrowRight ArrowUp Enter")
    tab.wait("document.querySelector('#row dd') && !document.getElementById('picked').hidden")
    tab.page.click("#columns summary")
    assert tab.page.evaluate("document.documentElement.scrollWidth") == width
    assert tab.errors == []
    tab.page.close()


def test_every_column_says_what_it_is_to_those_who_hover_and_to_those_who_cannot(tab, table):
    names = {*load(table).columns, "task"} - {"status", "checked"}
    tab.page.click("#columns summary")
    both = "[...document.querySelectorAll('#meanings dt')].map(e => [e.innerText, e.nextSibling.innerText])"
    said = dict(tab.page.evaluate(both))
    assert said == {name: meaning(name) + (f", in {unit(name)}" if len(unit(name)) > 1 else "") for name in names}
    walk(tab, "ArrowRight Enter")
    tab.wait("document.querySelector('#row dd') && !document.getElementById('picked').hidden")
    for place in ("#row dt", "#picked-rows th", "#choices option"):
        titles = tab.page.evaluate(f"[...document.querySelectorAll('{place}')].map(e => [e.innerText, e.title])")
        assert all(title == meaning(name) for name, title in titles if name in names)
        assert any(name == "ke_ratio" for name, _ in titles)


def test_every_control_has_a_name_and_can_be_reached_by_the_tab_key(tab):
    reached, active = set(), "document.activeElement.id || document.activeElement.closest('label')?.innerText"
    for _ in range(40):
        tab.page.keyboard.press("Tab")
        reached.add(tab.page.evaluate(active))
    assert {"plot", "save-picture", "save-view"} <= reached
    controls = "[...document.querySelectorAll('#choices select, #choices input, button')]"
    assert tab.page.evaluate(f"{controls}.filter(e => !e.labels?.length && !e.innerText).length") == 0


def test_the_colours_are_two_that_every_kind_of_colour_vision_tells_apart():
    assert (RATIO_CMAP, PLAIN_CMAP) == ("RdYlBu_r", "viridis")


def test_a_table_without_a_finished_row_is_a_page_that_says_so(running, tmp_path):
    made = rows(GRID)
    made["status"] = b"pending"
    path = write(tmp_path / "new.h5", made)
    assert main(["page", str(path), "-o", str(tmp_path / "new.html")]) == 0
    tab = browser.Tab(running, (tmp_path / "new.html").as_uri())
    assert tab.text("#status") == f"No row is done yet: {len(made)} pending."
    assert tab.errors == []
    tab.page.close()


def test_the_page_asks_nobody_even_by_mistake(table):
    text = html.unescape(table.with_suffix(".html").read_text())
    assert "connect-src 'none'" in text
    assert not re.search(r'<(script|link|img)[^>]* (src|href)="(?!data:)', text)


@pytest.mark.parametrize("name", ["site", "t_end", "mass", "stiffness", "damping", "spring.c2", "mass.spread"])
def test_a_number_of_the_model_is_what_the_user_chose_and_has_a_slider(running, tmp_path, name):
    """Whatever its name: not only those with a dot are axes."""
    made = rows(((5, 10), (1e-3, 1e-2), (1.0,), (2.0,)))
    made["status"] = b"done"
    seal(made)
    frame = load(write(tmp_path / "t.h5", made)).assign(**{name: [0.25, 0.75, 0.25, 0.75]})
    inputs = [one["name"] for one in payload(frame)["columns"] if one["input"]]
    assert inputs == ["N", "zeta_T", "M_over_M0", "V_over_V0", name]
    (tmp_path / "t.html").write_text(build(frame, "t.h5"))
    tab = browser.Tab(running, (tmp_path / "t.html").as_uri())
    assert tab.page.locator("label.slice", has_text=name).locator("input").count() == 1
    tab.page.close()
