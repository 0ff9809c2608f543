"""A search for the lowest finds what the whole grid has, the same bits whatever the ranks, the writer and the kills."""

import os
import re
import signal

import h5py
import numpy as np
import pandas as pd
import pytest

from analysis.cli import main
from sweep.errors import InputError
from sweep.plan.spec import parse_spec
from sweep.schema import DONE, ROW, SCREENED, UNASKED, seal
from sweep.tell import report

from .conftest import changed, problems_of, rows_of
from .waiting import wait_for_rows, wait_for_the_lock

WRITERS = ("mpio", "gather") if h5py.get_config().mpi else ("gather",)
GRID = """
name = "cells"
[grid]
N         = [8, 30, 90]
zeta_T    = [2e-5, 1e-3, 0.1]
M_over_M0 = { log = [0.1, 10], points = 7 }
V_over_V0 = { log = [0.1, 10], points = 9 }
"""
SEARCH = '[search]\nfind = "lowest"\nover = ["M_over_M0", "V_over_V0"]\n'
LOWEST = GRID + SEARCH
FINER = GRID.replace("8, 30, 90", "30, 90, 200").replace("= 7", "= 10").replace("= 9", "= 12")
SLOW = FINER + SEARCH + '[accuracy]\nmethod = "rk45"\nrtol = 1e-11\n'  # seconds of work, so that a kill comes in time
CELLS, EACH = 9, 63


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "cells.toml"
    path.write_text(LOWEST)
    return path


def bits(rows, where) -> dict[str, bytes]:
    names = [name for name in ROW.names if name not in ("seconds", "rank", "checksum")]
    return {name: rows[name][where].tobytes() for name in names}


def lowest_of(rows) -> np.ndarray:
    calm = (rows["status"] == DONE) & ~rows["chaotic"]
    return np.where(calm, rows["ke_ratio"], np.inf).reshape(CELLS, EACH).min(axis=1)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Where tables are kept from one test to the next."""
    return tmp_path_factory.mktemp("kept")


@pytest.fixture
def alone(sweep, kept):
    """The table of one process."""
    (kept / "cells.toml").write_text(LOWEST)
    if not (kept / "one.h5").exists():
        assert sweep("run", kept / "cells.toml", "-o", kept / "one.h5").returncode == 0
    return kept / "one.h5"


def test_the_lowest_of_every_cell_is_that_of_the_whole_grid_and_certified(sweep, alone, tmp_path):
    (tmp_path / "grid.toml").write_text(GRID)
    sweep("run", "grid.toml", "-o", "grid.h5")
    whole, found = rows_of(tmp_path / "grid.h5"), rows_of(alone)
    assert lowest_of(found) == pytest.approx(lowest_of(whole), rel=0.02)
    done = found["status"] == DONE
    assert np.count_nonzero(done) < 0.4 * len(found)
    assert found["checked"][done].all()
    assert not found["checked"][~done].any()
    assert bits(found, done) == bits(whole, done)


@pytest.mark.mpi
def test_three_ranks_give_the_bits_of_one(sweep, spec, alone, tmp_path, physics):
    answer = sweep("run", spec, "-o", "three.h5", "--writer", "gather", ranks=3)
    assert answer.returncode == 0, answer.stderr
    assert physics(tmp_path / "three.h5") == physics(alone)
    assert rows_of(tmp_path / "three.h5", SCREENED).tobytes() == rows_of(alone, SCREENED).tobytes()


@pytest.mark.parametrize(("name", "column"), [("results", "zeta_T"), ("results", "status"), (SCREENED, "value")])
def test_what_is_damaged_where_nothing_is_computed_is_mended(sweep, spec, alone, tmp_path, name, column):
    (tmp_path / "t.h5").write_bytes(alone.read_bytes())
    with changed(tmp_path / "t.h5", name) as rows:
        nowhere = np.flatnonzero(rows["checksum"] == 0)  # of what nobody asked for
        rows[column][nowhere[3]] = b"unaskee" if column == "status" else 0.5
    assert ", 0 left; " in sweep("run", spec, "-o", "t.h5").stderr
    for each in ("results", SCREENED):
        assert rows_of(tmp_path / "t.h5", each).tobytes() == rows_of(alone, each).tobytes()


def test_plan_start_and_status_tell_what_is_screened_and_what_is_computed(sweep, spec, alone, planned, tmp_path):
    plan, status, done = planned(spec), report.status(alone), int(np.sum(rows_of(alone)["status"] == DONE))
    assert (plan["tasks"], plan["screened"], plan["at_most"]) == (0, CELLS * EACH, CELLS * EACH)
    assert plan["table_bytes"] == pytest.approx(alone.stat().st_size, rel=0.02)
    assert (status["done"], status["left"], status["screened"], status["search"]) == (done, 0, CELLS * EACH, True)
    tried = report.status(alone)["tried"]
    assert 0 < done < tried < CELLS * EACH / 2
    told = sweep("plan", spec).stdout
    assert "567 screened, at most 567 tried and computed: a search" in told
    assert " core hours for screening; the rest is at most" in told
    assert report.show(alone)["search"] == f"{done} of 567 rows computed, 567 screened, {tried} tried"
    again = sweep("run", spec, "-o", alone)
    assert again.returncode == 0
    assert "search, 567 tasks to screen, at most 567 tried and computed, 0 left; " in again.stderr
    assert again.stdout.startswith(f"{done} done, 0 failed, 0 left; 567 screened, {tried} tried; ")


@pytest.mark.parametrize(("name", "column"), [("results", "ke_ratio"), (SCREENED, "value")])
def test_what_is_torn_is_computed_again_and_nothing_else(sweep, spec, alone, tmp_path, physics, name, column):
    (tmp_path / "t.h5").write_bytes(alone.read_bytes())
    with h5py.File(tmp_path / "t.h5", "r+") as file:
        rows = file[name][()]
        rows[column][np.flatnonzero(file["results"]["status"] == DONE)[7]] = 1e-9
        file[name][()] = rows
    assert report.status(tmp_path / "t.h5")["left"] == 1
    assert ", 1 left; " in sweep("run", spec, "-o", "t.h5").stderr
    assert physics(tmp_path / "t.h5") == physics(alone)
    assert rows_of(tmp_path / "t.h5", SCREENED).tobytes() == rows_of(alone, SCREENED).tobytes()


@pytest.mark.mpi
@pytest.mark.parametrize(("ranks", "writer"), [(1, "gather"), (3, WRITERS[0])])
def test_a_killed_search_resumes_to_the_same_table(sweep, start, tmp_path, physics, kept, ranks, writer):
    (tmp_path / "slow.toml").write_text(SLOW)
    if not (kept / "whole.h5").exists():
        assert sweep("run", tmp_path / "slow.toml", "-o", kept / "whole.h5", ranks=2).returncode == 0
    process = start("run", "slow.toml", "-o", "t.h5", "--writer", writer, ranks=ranks)
    wait_for_rows(tmp_path / "t.h5", process, 20)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait(60)
    wait_for_the_lock(tmp_path / "t.h5")
    before = rows_of(tmp_path / "t.h5")
    done = before["checksum"] != 0
    assert 20 <= np.count_nonzero(done) < np.count_nonzero(rows_of(kept / "whole.h5")["checksum"])
    again = sweep("run", "slow.toml", "-o", "t.h5", "--writer", writer, ranks=ranks)
    assert again.returncode == 0, again.stderr
    assert rows_of(tmp_path / "t.h5")[done].tobytes() == before[done].tobytes()
    assert physics(tmp_path / "t.h5") == physics(kept / "whole.h5")
    assert rows_of(tmp_path / "t.h5", SCREENED).tobytes() == rows_of(kept / "whole.h5", SCREENED).tobytes()


def test_rows_of_a_grid_are_taken_over_and_change_nothing(sweep, spec, alone, tmp_path, physics):
    (tmp_path / "grid.toml").write_text(GRID.replace("[8, 30, 90]", "[8]"))
    sweep("run", "grid.toml", "-o", "old.h5")
    answer = sweep("run", spec, "-o", "t.h5", "--reuse", "old.h5")
    assert "189 rows taken from old.h5" in answer.stderr
    ours, theirs = rows_of(tmp_path / "t.h5"), rows_of(alone)
    asked = theirs["status"] == DONE
    assert bits(ours, asked) == bits(theirs, asked)
    assert set(np.flatnonzero(ours["status"] == DONE)) == set(np.flatnonzero(asked)) | set(range(189))


def test_its_rows_merge_and_nothing_is_merged_into_it(sweep, alone, tmp_path):
    (tmp_path / "grid.toml").write_text(GRID.replace("[8, 30, 90]", "[5]"))
    sweep("run", "grid.toml", "-o", "b.h5")
    assert sweep("merge", alone, "b.h5", "-o", "t.h5").returncode == 0
    status = report.status(tmp_path / "t.h5")
    assert (status["done"], status["left"]) == (report.status(alone)["done"] + 189, 0)
    answer = sweep("merge", "b.h5", "-o", alone)
    assert answer.returncode == 2
    assert answer.stderr.endswith("exists and is a search, which could not go on; give another -o\n")


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ('"lowest"', '"highest"', "search.find: must be one of lowest, level, map, own, got 'highest'"),
        ('over = ["M_over_M0", "V_over_V0"]', "", 'search.over: is missing, which find = "lowest" needs'),
        ('"M_over_M0", "V_over_V0"', '"M_over_M0", "M"', "search.over: the grid has no axis 'M'"),
        ('"M_over_M0", "V_over_V0"', "", "search.over: must name distinct axes, at least one, got []"),
        ("\nover", '\nof = "ke_rato"\nover', "search.of: must be one of ke_bistable, ke_linear, ke_ratio"),
        ("\nover", '\nalong = "N"\nover', 'search.along: stands only with find = "level", got find = "lowest"'),
        ("\nover", '\nby = "median"\nover', 'search.by: needs robust, got by = "median" alone'),
        ("\nover", "\nrobust = 0.6\nover", "search.robust: must be less than or equal to 0.5, got 0.6"),
        (
            "[search]",
            "[accuracy]\ncertify = false\n[search]",
            "accuracy.certify: must be true, as the lowest of numbers",
        ),
        ("[search]", "[adaptive]\n[search]", "adaptive: must not stand beside a section [search]"),
    ],
)
def test_a_wrong_search_is_one_problem(line, instead, problem):
    (found,) = problems_of(parse_spec, LOWEST.replace(line, instead), "x.toml")
    assert found.startswith(f"x.toml: {problem}")


@pytest.mark.parametrize(
    ("of", "observed"), [("wall_force_ratio", False), ("wall_force_error", False), ("arrival", True)]
)
def test_a_search_for_what_is_not_observed_says_how_to_observe_it(of, observed):
    """An estimated error is nothing to search for, observed or not."""
    text = LOWEST.replace("\nover", f'\nof = "{of}"\nover') + '[output]\nobserve = ["ke", "impulse"]\n' * observed
    with pytest.raises(InputError) as caught:
        parse_spec(text, "x.toml")
    way = "" if of.endswith("_error") else f" (add '{of.partition('_ratio')[0]}' to output.observe)"
    assert caught.value.problems[0].endswith(f", got '{of}'{way}")


def test_a_search_needs_a_grid():
    points = '[points]\nsample = "sobol"\nn = 4\nN = 5\nzeta_T = 0\nM_over_M0 = 1\nV_over_V0 = { log = [1, 2] }\n'
    assert problems_of(parse_spec, 'name = "x"\n' + points + SEARCH, "x") == ("x: search: needs a section [grid]",)


def test_the_picture_says_that_it_was_a_search_and_what_it_looked_at(alone, tmp_path, capsys):
    assert main(["best", str(alone), "-o", str(tmp_path / "best.svg")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    done = report.status(alone)["done"]
    words = f"A search: 567 of 567 rows screened, which is coarse and not certified; {done} that may be the lowest"
    assert words in told
    assert "It has not ended." not in told
    text = " ".join(re.findall(r">([^<>]+)</text>", (tmp_path / "best.svg").read_text())) or "outlines"
    assert text == "outlines" or "A search: 567 of 567 rows screened" in text


def test_a_row_that_says_nothing_of_its_chaos_is_not_shown_as_the_lowest(alone, tmp_path):
    (tmp_path / "t.h5").write_bytes(alone.read_bytes())
    with changed(tmp_path / "t.h5") as rows:
        one = rows[(rows["status"] == DONE) & ~rows["chaotic"]][:1].copy()
        one["ke_ratio"], one["condition"], one["error"], one["checked"] = 1e-9, np.nan, np.nan, False
        seal(one)
        rows[np.flatnonzero((rows["status"] == DONE) & ~rows["chaotic"])[0]] = one[0]
    assert main(["best", str(tmp_path / "t.h5"), "-o", str(tmp_path / "best.png")]) == 0
    assert pd.read_csv(tmp_path / "best.best.csv")["ke_ratio"].min() > 1e-6


def test_an_interrupted_search_is_not_drawn_as_a_whole_one(alone, tmp_path, capsys):
    (tmp_path / "t.h5").write_bytes(alone.read_bytes())
    with changed(tmp_path / "t.h5") as rows:
        rows["status"][np.flatnonzero(rows["status"] == DONE)[:3]] = UNASKED
    assert main(["best", str(tmp_path / "t.h5"), "-o", str(tmp_path / "best.png")]) == 0
    assert "It has not ended." in capsys.readouterr().out


def test_the_lowest_over_a_number_of_the_model_is_drawn_with_the_number_that_gave_it(sweep, tmp_path, capsys):
    text = LOWEST.replace("[8, 30, 90]", '[8, 12]\n"spring.c2" = [4.0, 4.8]').replace("points = 7", "points = 2")
    text = text.replace("points = 9", "points = 2").replace('over = ["M_over_M0", "V_over_V0"]', 'over = ["spring.c2"]')
    (tmp_path / "laws.toml").write_text(text)
    assert sweep("run", "laws.toml", "-o", "laws.h5").returncode == 0
    assert main(["best", str(tmp_path / "laws.h5"), "-o", str(tmp_path / "best.png")]) == 0
    told, cells = capsys.readouterr().out, pd.read_csv(tmp_path / "best.best.csv")
    assert len(cells) == 6
    assert cells["spring.c2"].isin([4.0, 4.8]).all()
    assert re.search(r"optimum .* spring\.c2 = 4", told)


def test_the_lowest_of_one_quantity_is_not_shown_as_that_of_another(sweep, tmp_path, capsys):
    """What shows it is named, and does."""
    for of, shown in (("ke_bistable", ["page"]), ("wall_force_ratio", ["best", "--of", "wall_force_ratio"])):
        text = LOWEST.replace("[8, 30, 90]", "8").replace("\nover", f'\nof = "{of}"\nover')
        (tmp_path / "other.toml").write_text(text + '[output]\nobserve = ["peak_ke", "wall_force"]\n')
        table = tmp_path / f"{of}.h5"
        assert sweep("run", "other.toml", "-o", table.name).returncode == 0
        assert main(["best", str(table), "-o", str(tmp_path / "best.png"), "--of", "ke_ratio"]) == 2
        said = f"is a search for the lowest {of}, which tells nothing of ke_ratio; `analysis {' '.join(shown)}` shows"
        assert said in capsys.readouterr().err
        ending = "html" if shown == ["page"] else "png"
        assert main([shown[0], str(table), "-o", str(tmp_path / f"{of}.{ending}"), *shown[1:]]) == 0
        capsys.readouterr()
