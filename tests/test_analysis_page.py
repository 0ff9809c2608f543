"""Claims about the page: whole, self-contained, readable in a browser at two widths."""

import json
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import kernel
from analysis.cli import main
from analysis.look import MARK
from analysis.output import output
from analysis.paper import convention
from analysis.paper.answers import ANSWERS
from analysis.paper.compare import AGREES, DIFFERS, ILL, OTHER, UNKNOWN, point_verdict, tally, verdict
from analysis.paper.measured import MEASURED, Ours
from analysis.paper.numbers import DOMAIN, POINTS, Point
from analysis.paper.page import NAME, build, pictures
from analysis.paper.recipe import Source
from analysis.paper.sweeps import history
from kernel.ke import PARAMETERS
from sweep.schema import seal

from . import browser
from .paper_source import JOBS, SMALL
from .pictures import paper as made_paper
from .sketch import assert_kept
from .test_analysis_cli import rows, write

pytestmark = pytest.mark.slow

MEASURE = """<script>addEventListener("load", () => {
  const root = document.documentElement, pictures = [...document.images];
  const shown = {width: innerWidth, page: root.scrollWidth, pictures: pictures.length,
                 broken: pictures.filter(p => !p.complete || !p.naturalWidth).length};
  root.dataset.measured = JSON.stringify(shown);
})</script>"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page, the folder of its pictures, and what they hold."""
    folder = tmp_path_factory.mktemp("page")
    made, sketches = made_paper(folder)
    return made, folder, sketches


def test_the_page_and_its_pictures_hold_what_they_held_when_they_were_last_looked_at(page):
    assert_kept(page[2], "paper")


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def test_the_page_holds_every_figure_with_a_text_for_those_who_do_not_see(page):
    pictures = [attrs for tag, attrs in Tags(page[0].html).found if tag == "img"]
    assert len(pictures) == 16
    assert all(attrs["alt"] and attrs["src"].startswith("data:image/png;base64,") for attrs in pictures)


def test_the_page_tells_the_five_findings_with_rule_verdict_and_numbers_of_every_table(page):
    section = page[0].html.partition('<section id="findings">')[2].partition("</section>")[0]
    assert re.findall(r"<h3>(\d)\. ", section) == ["1", "2", "3", "4", "5"]
    assert section.count("Rule: ") == 5
    shown = re.findall(r'class="verdict (holds|does|cannot)"', section)
    assert len(shown) == section.count('<th scope="row">') == sum(len(tables) for *_, tables in ANSWERS)
    assert "rows: 18; failed, left out: " in section  # of figure 1's small table
    assert '<a href="#findings">' in page[0].html
    assert any(line.startswith("findings  5, on their tables: ") for line in page[0].lines)


def test_the_page_needs_no_network_and_is_of_modest_size(page):
    html = page[0].html
    assert not re.search(r'(src|href)="(?!data:|#)', html)
    assert not re.search(r"https?://|@import|<script|<link", html)
    assert len(html) < 15e6


def test_the_page_and_its_pictures_are_known_as_ours_when_they_are_made_again(page):
    assert MARK in page[0].html
    for picture in pictures(page[1]):
        output(picture, NAME)


def test_every_picture_has_its_numbers_beside_it(page):
    names = sorted(path.name for path in page[1].iterdir())
    assert len(names) == 32
    assert [name.removesuffix(".paper.csv") for name in names[::2]] == [name[:-4] for name in names[1::2]]


@browser.needed
@pytest.mark.parametrize("width", [1280, 400])
def test_in_a_browser_all_pictures_load_and_nothing_overflows(page, width, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(page[0].html.replace("</body>", MEASURE + "</body>"), encoding="utf-8")
    command = [browser.BINARY, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--dump-dom"]
    command += [f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},2000", path.as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    (attrs,) = (attrs for tag, attrs in Tags(dom).found if tag == "html")
    shown = json.loads(attrs["data-measured"])
    assert shown == {"width": width, "page": width, "pictures": 16, "broken": 0}


def test_how_a_table_came_to_be_is_told_by_its_done_rows_and_by_what_is_known_of_them(tmp_path):
    made = rows()
    made["status"][:12], made["checked"][-15:], made["seconds"] = b"pending", False, 2.0
    made["error"][made["chaotic"]] = 1.0
    seal(made)
    assert history(write(tmp_path / "t.h5", made)) == {
        "table": "t",
        "rows": "60 done, 12 pending",
        "chaotic": "8 (17.8 %); 15 not checked for chaos",
        "accuracy": "not stated in the table",
        "error": "median 0.0001, 95 % below 0.0001",
        "seconds": "120 s of computing",
    }


def test_a_verdict_follows_from_what_tasks_that_print_alike_give():
    firm, wild, far = np.array([1.0, 1.001]), np.array([0.5, 2.0]), np.array([9.0, 9.1])
    assert point_verdict(1.0, firm, far) == AGREES
    assert point_verdict(1.0, wild, far) == ILL
    assert point_verdict(9.0, firm, far) == OTHER
    assert point_verdict(100.0, firm, far) == DIFFERS


def test_the_other_mass_explains_a_number_with_an_error_only_within_that_error():
    assert verdict(1.0, 1.0, Ours(1.2, error=0.05, other_mass=1.1)) == DIFFERS
    assert verdict(1.0, 1.0, Ours(1.2, error=0.05, other_mass=1.04)) == OTHER
    assert verdict(1.0, 1.0, Ours(1.2, other_mass=1.1)) == OTHER  # both lie on a grid


def test_an_error_that_nobody_knows_is_not_none():
    assert verdict(1.0, 1.1, Ours(1.05, error=np.nan)) == AGREES
    assert verdict(1.0, 1.1, Ours(1.2, error=np.nan)) == UNKNOWN
    assert verdict(1.0, 1.1, Ours(1.2, error=np.nan, chaotic=True)) == ILL
    assert verdict(1.0, 1.1, Ours(1.2)) == DIFFERS


@pytest.mark.parametrize("chaotic", [True, False, pd.NA])
def test_a_number_of_a_table_has_its_rows_error_and_chaos(chaotic):
    row = {"N": 200, "zeta_T": 4e-5, "M_over_M0": 1.0, "V_over_V0": 2.0, "ke_ratio": 0.5, "error": 0.1}
    df = pd.DataFrame([row]).assign(chaotic=pd.array([chaotic], dtype="boolean"))
    source = Source(Path("nowhere"), _tables={"fig5": df, "fig4": df, "fig4-mass": df})
    ours = MEASURED["min5h"](source)
    assert (ours.chaotic, np.isnan(ours.error)) == (chaotic is True, chaotic is True)
    source._tables["fig5"] = df.assign(error=np.nan)
    assert np.isnan(MEASURED["min5h"](source).error)
    assert MEASURED["min4"](source).note.endswith(", chaotic") == (chaotic is True)


def test_verdicts_are_counted_in_a_sentence():
    assert tally([DIFFERS, *[AGREES] * 3, OTHER, OTHER]) == f"3 agree, 2 {OTHER.replace('agrees', 'agree')}, 1 differs"
    assert tally(["does not hold", "does not hold", "holds"]) == "2 do not hold, 1 holds"


def test_a_number_made_with_half_the_mass_is_explained_by_the_mass_alone():
    half = kernel.ke_ratio(20, 4e-3, 0.5, 2.0).ke_ratio
    point = Point("small", "nowhere", 20, 4e-3, 1.0, 2.0, half, (0, 0, 0))
    other = Point("other", "nowhere", 12, 2e-2, 2.0, 2.0, kernel.ke_ratio(12, 2e-2, 1.0, 2.0).ke_ratio, (0, 0, 0))
    best = convention.summary(convention.scan((point, other), np.array([0.5, 0.7, 1.0, 1.5]))).iloc[0]
    assert (best["family"], best["factor"], best["count"]) == ("impactor mass", 0.5, 2)


def test_draws_stay_within_what_the_paper_prints_and_begin_with_the_task_itself_which_lies_in_its_domain():
    for point in POINTS:
        assert all(low <= getattr(point, name) <= high for name, (low, high) in DOMAIN.items())
        draws = point.ensemble(8)
        np.testing.assert_array_equal(draws[0], [getattr(point, name) for name in PARAMETERS])
        limits = np.maximum(point.rounding, (0, 0, 1e-6 * point.V_over_V0))
        assert (np.abs(draws[:, 1:] - draws[0, 1:]) <= limits * (1 + 1e-9)).all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "page.txt"], "page.txt: a page ends in .html"),
        (["-o", "none/page.html"], "-o: there is no directory 'none' to write 'page.html' in"),
        (["-o", "page.html", "--tables", "none"], "there is no directory none with tables"),
        (["-o", "page.html", "--tables", ".", "--jobs", "none"], "there is no directory none/scenes"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["paper", "--jobs", str(JOBS), *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert len(told.err.splitlines()) == 1
    assert said in told.err
    assert not list(tmp_path.iterdir())


def test_a_failure_half_way_leaves_the_old_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "page.html").write_text("old")

    def fail(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr("analysis.paper.page.build", fail)
    assert main(["paper", "-o", "page.html", "--force", "--tables", ".", "--jobs", str(JOBS)]) == 2
    assert "disk full" in capsys.readouterr().err
    assert (tmp_path / "page.html").read_text() == "old"


def test_a_figure_whose_table_is_missing_is_named_as_left_out_and_the_others_take_the_place_of_what_is_there(tmp_path):
    from analysis.paper.figures import ALL

    recipes = [recipe for recipe in ALL if recipe.number in ("8", "12")]
    pictures = [tmp_path / f"{stem}.png" for stem in (recipes[1].stem, "convention")]
    for picture in pictures:
        picture.write_text("another program's")
    told: list[str] = []
    page = build(Source(tmp_path, JOBS), tmp_path, recipes, points=(SMALL,), progress=told.append)
    assert told == ["figure 8", "figure 12", "numbers", "findings", "conventions"]
    assert "figures   1 drawn, 1 left out" in page.lines
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    assert any(line.startswith("left out  figure 8: there is no table") for line in page.lines)


def test_numbers_that_cannot_be_computed_say_why(tmp_path):
    from analysis.paper.compare import compare

    found = compare(Source(tmp_path, JOBS)).set_index("key")
    assert found.loc["min8", "verdict"] == "not computed"
    assert "there is no table" in found.loc["min8", "note"]
    assert isinstance(found, pd.DataFrame)
