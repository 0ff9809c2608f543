"""The page of the open questions: what it asks, answers and refuses, and the specs of its tables."""

import csv
import re
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import kernel
from analysis import style
from analysis.cli import main
from analysis.look import MARK
from analysis.outlook.draw_laws import Shown, against
from analysis.outlook.laws import C2, C3, CANDIDATES, SHAPE, with_numbers
from analysis.outlook.page import NAME, build, lacks, pictures
from analysis.outlook.questions import ALL
from analysis.output import output
from analysis.paper.recipe import Source
from sweep.plan.spec import read_spec

from .drawn import FOUR
from .outlook_source import (
    small_source,
)
from .pictures import outlook as made_outlook
from .sketch import assert_kept

JOBS = Path(__file__).parent.parent / "jobs" / "outlook"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page, the folder of its pictures, and what they hold."""
    folder = tmp_path_factory.mktemp("outlook")
    made, sketches = made_outlook(folder)
    return made, folder, sketches


@pytest.mark.slow
def test_the_page_and_its_pictures_hold_what_they_held_when_they_were_last_looked_at(page):
    assert_kept(page[2], "outlook")


@pytest.mark.slow
def test_the_page_asks_five_questions_and_answers_each_with_a_picture_a_table_and_its_rules(page):
    html = page[0].html
    assert [question.letter for question in ALL] == list("abcde")
    for question in ALL:
        section = html.partition(f'<section id="{question.letter}">')[2].partition("</section>")[0]
        assert '<div class="answer">' in section
        assert section.count("<img") == len(question.stems) == section.count("<figcaption>")
        assert "<table>" in section
        assert section.count("Rule: ") == len(question.rules)
    assert not re.search(r">\s*nan|nan to", html)


@pytest.mark.parametrize("log", [True, False])
def test_the_bars_of_every_law_lie_within_the_picture(log):
    _, axes = style.canvas(1, 1, 4, 3)
    laws = pd.DataFrame({"x": [1.0, 2.0], "b": [0.4, 0.5], "b_low": [0.3, 0.45], "b_high": [0.6, 0.7]})
    against(axes[0, 0], laws, "x", Shown("b", "b_low", "b_high", "$b$", log), ("black",))
    low, high = axes[0, 0].get_ylim()
    assert low < 0.3
    assert high > 0.7


@pytest.mark.slow
@pytest.mark.parametrize("question", ALL, ids=lambda question: question.letter)
def test_panels_at_the_left_say_what_goes_up_and_those_below_what_goes_across(question):
    for picture in question.part(small_source()).pictures:
        for ax in picture.figure.axes:
            place = ax.get_subplotspec()
            assert ax.get_ylabel() or place is None or not place.is_first_col()
            assert ax.get_xlabel() or place is None or not place.is_last_row()


@pytest.mark.slow
def test_the_page_tells_what_the_made_up_tables_hold(page):
    told = page[0].lines
    assert float(re.search(r"its median is ([0-9.]+)", told[0])[1]) == pytest.approx(0.5, abs=0.02)
    assert "V/snap strain" in page[0].html
    assert told[1].startswith("b         ")
    assert "1.5 (1.5 to 1.5) times, survives" in told[4]


@pytest.mark.slow
def test_the_page_needs_no_network_and_every_picture_has_its_numbers(page):
    assert MARK in page[0].html
    assert not re.search(r'(src|href)="(?!data:|#)|https?://|@import|<script|<link', page[0].html)
    names = {path.name for path in page[1].iterdir()}
    wanted = [path.name for path in pictures(page[1])]
    assert names == {*wanted, *(name.replace(".png", f".{NAME}.csv") for name in wanted)}
    for picture in pictures(page[1]):
        output(picture, NAME)


def test_a_question_that_its_table_cannot_answer_is_left_out_and_says_why(tmp_path):
    source = small_source()
    source._tables["disorder"] = source._tables["disorder"].query("`mass.seed` > 0")
    there = tmp_path / f"{ALL[3].stems[0]}.png"
    there.write_text("another program's, whose place it takes")
    made = build(source, tmp_path, [question for question in ALL if question.letter in "de"])
    assert there.read_bytes().startswith(b"\x89PNG")
    assert made.lines[1].startswith("e         left out: no uniform chain")
    assert "<b>Left out:</b> no uniform chain" in made.html


def test_missing_tables_are_named_all_at_once_and_nothing_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["outlook", "--tables", "nowhere"]) == 2
    assert "`make outlook` makes it" in capsys.readouterr().err
    (tmp_path / "outlook").mkdir()
    assert main(["outlook"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"analysis: {lacks(Source(Path('outlook')))}"
    assert [path.name for path in tmp_path.iterdir()] == ["outlook"]


def test_a_page_of_somebody_else_stays(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "outlook.html").write_text("precious")
    assert main(["outlook"]) == 2
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "outlook.html").read_text() == "precious"


def test_every_table_of_the_page_has_a_spec_and_every_larger_spec_a_smaller_one():
    names = {name for question in ALL for name in question.tables}
    assert names == {path.stem for path in JOBS.glob("*.toml")}
    assert {path.stem for path in (JOBS / "full").glob("*.toml")} < names
    for path in (JOBS / "full").glob("*.toml"):
        assert read_spec(path)[0].tasks > 2 * read_spec(JOBS / path.name)[0].tasks


def test_the_papers_own_law_is_among_those_that_are_asked():
    for name in ("threshold", "optimum"):
        grid = tomllib.loads((JOBS / f"{name}.toml").read_text())["grid"]
        own = kernel.Bistable()
        for number in ("c2", "c3"):
            (a, b), points = grid[f"spring.{number}"]["log"], grid[f"spring.{number}"]["points"]
            assert np.geomspace(a, b, points)[points // 2] == pytest.approx(getattr(own, number), rel=1e-9)


def test_every_optimum_is_drawn_as_often_with_each_kind_of_disorder():
    with (JOBS / "disorder.csv").open() as file:
        points = pd.DataFrame(list(csv.DictReader(file))).astype(float)
    counts = points.groupby([*FOUR, "mass.spread", "stiffness.spread"]).size()
    uniform = counts.index.get_level_values("mass.spread") + counts.index.get_level_values("stiffness.spread") == 0
    assert len(counts) == 9 * 10
    assert set(counts[uniform]) == {1}
    assert set(counts[~uniform]) == {20}
    assert (points["N"].nunique(), points["zeta_T"].nunique()) == (3, 3)


def test_every_candidate_is_a_number_of_a_law():
    found = with_numbers(pd.DataFrame({C2: [5.0], C3: [5.0]}))
    assert set(CANDIDATES) <= {*found.columns}
    assert SHAPE in found
