"""A search for a map computes what interpolation needs, the same tasks in any order, and says what it has inferred."""

import json
import re

import h5py
import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import analysis
from analysis.cli import main
from analysis.searched import said
from sweep.errors import InputError
from sweep.plan.refine import ROUND, Planes, Refine
from sweep.plan.spec import parse_spec
from sweep.plan.spline import ROUGH
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank, seal
from sweep.store.structure import seal_structure
from sweep.tell import report

from .conftest import changed, problems_of

GRID = """
name = "plane"
[grid]
N         = { log = [5, 100], points = 25 }
zeta_T    = { log = [1e-4, 0.3], points = 24 }
M_over_M0 = 2
V_over_V0 = [1, 2]
"""
SEARCH = '[search]\nfind = "map"\nover = ["N", "zeta_T"]\nerror = 0.2\n'
MAP = ["--at", "V_over_V0=2"]


@pytest.mark.mpi
def test_what_is_inferred_is_mostly_within_the_error_of_the_whole_grid(sweep, tmp_path, physics, planned, capsys):
    (tmp_path / "s.toml").write_text(GRID + SEARCH)
    (tmp_path / "grid.toml").write_text(GRID)
    answer = sweep("run", "s.toml", "-o", "one.h5")
    assert answer.returncode == 0
    assert re.search(r"at most 1152 computed, 11[5-9]\d left, screening included; ", answer.stderr)
    assert sweep("run", "s.toml", "-o", "three.h5", ranks=3).returncode == 0
    assert physics(tmp_path / "three.h5") == physics(tmp_path / "one.h5")
    sweep("run", "grid.toml", "-o", "grid.h5")
    status, plan = report.status(tmp_path / "one.h5"), planned(tmp_path / "s.toml")
    whole = analysis.load(tmp_path / "grid.h5")
    assert plan["tasks"] <= status["done"] < 0.15 * len(whole)
    assert plan["at_most"] == plan["screened"] == len(whole)
    assert "tried" not in plan
    assert (status["left"], status["screened"], status["tried"]) == (0, len(whole), 0)

    assert main(["map", str(tmp_path / "one.h5"), "-o", str(tmp_path / "m.png"), *MAP]) == 0
    told = capsys.readouterr().out
    assert f"A search: {status['done']} of {len(whole)} rows computed (dots); the others are run once, loosely" in told
    assert "no number is told where all computed ones near are chaotic or failed" in told
    other = said(tmp_path / "one.h5", analysis.load(tmp_path / "one.h5", done_only=False), "arrival_ratio")
    assert f"{status['done']} of {len(whole)} rows computed, of which alone arrival_ratio is known." in other
    cells = pd.read_csv(tmp_path / "m.map.csv").set_index("task")
    assert f"of {len(whole) // 2} have a number; {cells['inferred'].sum()} more inferred" in told
    plane = whole[(whole["V_over_V0"] == 2)]
    assert cells["inferred"].sum() > 0.8 * len(plane)
    computed = cells[~cells["inferred"]]
    assert (computed["ke_ratio"] == plane.loc[computed.index, "ke_ratio"]).all()
    guesses = cells[cells["inferred"]]
    truth = plane.loc[guesses.index]
    calm = ~truth["chaotic"].to_numpy(bool)
    off = np.abs(np.log(guesses["ke_ratio"] / truth["ke_ratio"]))[calm]
    assert (off <= 0.2).mean() > 0.97
    assert guesses["error"].isna().all()
    lowest = float(told.split("lowest    ke_ratio = ")[1].split()[0])
    least = computed.loc[computed["chaotic"] == False, "ke_ratio"].min()  # noqa: E712
    assert lowest == pytest.approx(least, rel=1e-3)
    lower = guesses.loc[guesses["ke_ratio"] < least, "ke_ratio"]
    line = f"{len(lower)} inferred cell{'s are' if len(lower) > 1 else ' is'} lower, down to {lower.min():.4g}\n"
    assert (line in told) == (len(lower) > 0)


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ("error = 0.2", "", 'search.error: is missing, which find = "map" needs'),
        ("error = 0.2", "error = 0.0", "search.error: must be greater than or equal to 0.001, got 0.0"),
        ("error = 0.2", "error = 0.2\nround = 0", "search.round: must be greater than or equal to 0.001, got 0"),
        ('"N", "zeta_T"', '"N", "zeta_T", "M_over_M0", "V_over_V0"', "search.over: a map has at most 3 axes"),
        ("{ log = [5, 100], points = 25 }", "[9, 5]", "grid.N: the values of a map's axis must ascend, got [9, 5]"),
        ("error", "level = 1.0\nerror", 'search.level: stands only with find = "level", got find = "map"'),
    ],
)
def test_a_wrong_map_is_one_problem(line, instead, problem):
    (found,) = problems_of(parse_spec, (GRID + SEARCH).replace(line, instead), "x.toml")
    assert found.startswith(f"x.toml: {problem}")


def unscreened(sweep, folder):
    (folder / "s.toml").write_text((GRID + SEARCH).replace("points = 2", "points = 1") + "screen = false\n")
    assert sweep("run", "s.toml", "-o", "t.h5").returncode == 0


def test_a_map_shows_what_is_inferred_in_its_own_plane_alone(sweep, tmp_path):
    unscreened(sweep, tmp_path)
    table, cells = str(tmp_path / "t.h5"), tmp_path / "m.map.csv"
    row = analysis.load(table).iloc[0]
    line = ["map", table, "-o", str(tmp_path / "m.png"), "--force"]
    place = [f"{name}={float(row[name])!r}" for name in ("N", "zeta_T")]
    assert main([*line, "--over", "M_over_M0,V_over_V0", "--at", *place]) == 0
    both = pd.read_csv(cells)  # speeds at one place, which are computed alike
    assert not both["inferred"].any()
    with changed(table) as rows:
        rows["status"][(rows["status"] == DONE) & (rows["V_over_V0"] == 1)] = b"step_budget"
        seal(rows)
    assert main(line) == 0  # without --at: one speed alone has finished rows
    found = pd.read_csv(cells)
    assert found["inferred"].any()
    assert (found["V_over_V0"] == 2).all()


def without(path, *keys):
    """Take these keys of [search] from the spec that the table keeps."""
    with h5py.File(path, "r+") as file:
        resolved = json.loads(file["provenance/resolved"][()])
        for key in keys:
            del resolved["search"][key]
        file["provenance/resolved"][()] = json.dumps(resolved)
    seal_structure(path)


@pytest.mark.mpi
def test_without_screening_more_is_computed_and_the_rest_is_interpolated(sweep, tmp_path, capsys):
    unscreened(sweep, tmp_path)
    (tmp_path / "s.toml").write_text((tmp_path / "s.toml").read_text().replace("screen = false", ""))
    assert sweep("run", "s.toml", "-o", "screened.h5").returncode == 0
    status = report.status(tmp_path / "t.h5")
    assert status["left"] == 0
    assert "screened" not in status
    assert status["done"] > 1.5 * report.status(tmp_path / "screened.h5")["done"]
    assert main(["map", str(tmp_path / "t.h5"), "-o", str(tmp_path / "m.png"), *MAP]) == 0
    assert "the others are interpolated" in capsys.readouterr().out


def test_a_table_of_a_version_that_did_not_screen_is_drawn_and_known_to_be_ended(sweep, tmp_path, capsys):
    unscreened(sweep, tmp_path)
    without(tmp_path / "t.h5", "screen")
    assert report.status(tmp_path / "t.h5")["left"] == 0
    assert main(["map", str(tmp_path / "t.h5"), "-o", str(tmp_path / "m.png"), *MAP]) == 0
    assert "the others are interpolated" in capsys.readouterr().out


def test_a_table_of_an_earlier_rule_is_drawn_and_not_carried_on(sweep, tmp_path, capsys):
    unscreened(sweep, tmp_path)
    without(tmp_path / "t.h5", "screen", "round")
    assert main(["map", str(tmp_path / "t.h5"), "-o", str(tmp_path / "m.png"), *MAP]) == 0
    assert "the others are interpolated" in capsys.readouterr().out
    with pytest.raises(InputError, match="an earlier version has chosen its rows by another rule"):
        report.status(tmp_path / "t.h5")
    again = sweep("run", "s.toml", "-o", "t.h5")
    assert again.returncode == 2
    assert "it differs in search.round" in again.stderr
    assert "--reuse t.h5" in again.stderr


AXES = {"N": [*range(5, 25)], "zeta_T": np.geomspace(1e-4, 1, 17).tolist(), "M_over_M0": [1.0], "V_over_V0": [1.0, 2.0]}
OVER = ("N", "zeta_T")


def rounds(rng, values, seen=None, known=(), axes=AXES, over=OVER, share=ROUND):
    """The orders of a search whose results arrive in random order and portions, as they are asked for.

    seen: what screening gives, None without; known: orders whose results are known before it begins.
    """
    n, search = len(values), Refine(Tasks(axes), over, "ke_ratio", 0.1, share, screen=seen is not None)
    rows = blank(n)
    rows["status"], rows["ke_ratio"], rows["chaotic"] = DONE, np.nan_to_num(values, nan=1.0), np.isnan(values)

    def tell(orders):
        ids, screened = orders[orders < n], orders[orders >= n]
        search.tell(ids, rows[ids])
        if seen is not None:
            search.tell_seen(screened, seen[screened - n])

    tell(np.array(known, np.int64))
    waiting, given = [], set()
    while len(new := search.ask().tolist()) or waiting:
        yield new
        assert not {*new} & given
        given |= {*new}
        waiting += new
        rng.shuffle(waiting)
        tell(np.array([waiting.pop() for _ in range(rng.integers(1, len(waiting) + 1))]))


def played(*args, **options):
    """Every order of a search, ascending."""
    return sorted(task for new in rounds(*args, **options) for task in new)


def landscape(rng):
    n = len(Tasks(AXES))
    values = np.exp(np.cumsum(rng.normal(scale=rng.choice([0.01, 0.3]), size=n)))
    return np.where(rng.random(n) < rng.choice([0, 0.3]), np.nan, values)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_what_is_asked_for_depends_on_no_order_and_on_nothing_known_besides(seed, screen):
    rng = np.random.default_rng(seed)
    values = landscape(rng)
    n = len(values)
    seen = np.exp(rng.normal(size=n)) if screen else None
    once = played(rng, values, seen, share=0.05)
    assert played(rng, values, seen, share=0.05) == once
    known = np.flatnonzero(rng.random(2 * n if screen else n) < 0.2).tolist()
    assert played(rng, values, seen, known=known, share=0.05) == sorted(set(once) - set(known))


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_what_screening_shows_alike_is_looked_at_once_and_its_own_hills_are_followed(seed):
    rng = np.random.default_rng(seed)
    values, n = landscape(rng), len(Tasks(AXES))
    calm = np.isfinite(values)
    assert n + FIRST < len(played(rng, values, np.nan_to_num(values, nan=1.0) * 1.3)) <= n + FIRST + ROUGH_MOST
    off = np.where(np.isin(Tasks(AXES).columns(np.arange(n))["N"], range(9, 13)), 3.0, 1.0)
    assume(calm.mean() > 0.9)
    asked = [order for order in played(rng, values, np.nan_to_num(values, nan=1.0) * off) if order < n]
    assert len(asked) > 2 * FIRST


def test_what_could_not_be_screened_tells_of_no_other_place_and_is_not_inferred():
    tasks = Tasks(AXES)
    planes, rng = Planes(tasks, OVER), np.random.default_rng(0)
    values, seen = np.exp(rng.normal(size=len(tasks))), np.full(len(tasks), np.nan)
    computed = rng.random(len(tasks)) < 0.3
    assert np.isnan(planes.inferred(np.where(computed, values, np.nan), seen, computed)).all()
    assert len(played(rng, values, seen)) == len(tasks) + FIRST


ROUGH_MOST = 2 * round(ROUGH * 20 * 17)  # of both planes
FIRST = 2 * 4 * 3  # of both planes: 4 of the 20 values of N, 3 of the 17 of zeta_T


def test_where_numbers_are_a_power_law_or_all_chaotic_nothing_is_added_to_the_first_tasks():
    tasks, rng = Tasks(AXES), np.random.default_rng(0)
    columns = tasks.columns(np.arange(len(tasks)))
    assert len(played(rng, columns["N"] ** 2.0 * columns["zeta_T"] ** -0.7)) == FIRST
    assert len(played(rng, np.full(len(tasks), np.nan))) == FIRST


def test_a_cliff_is_followed_and_its_sides_are_left():
    tasks, rng = Tasks(AXES), np.random.default_rng(0)
    columns = tasks.columns(np.arange(len(tasks)))
    asked = np.array(played(rng, np.where(columns["N"] < 13.5, 1.0, 0.01)))
    near = np.isin(columns["N"], [13, 14])
    assert np.isin(np.flatnonzero(near), asked).mean() > 0.8
    far = np.abs(columns["N"] - 13.5) > 3
    assert np.isin(np.flatnonzero(far), asked).mean() < 0.25


@pytest.mark.parametrize("over", [("N",), ("N", "zeta_T"), ("N", "zeta_T", "V_over_V0")])
def test_a_bent_map_of_one_to_three_axes_is_known_within_the_error_from_a_part_of_its_tasks(over):
    axes = AXES | {"N": [*range(5, 45)], "V_over_V0": np.geomspace(0.5, 8, 12).tolist()}
    tasks, rng = Tasks(axes), np.random.default_rng(0)
    columns = tasks.columns(np.arange(len(tasks)))
    logs = np.sin(2 * np.log(columns["N"])) + np.cos(np.log(columns["zeta_T"] / columns["V_over_V0"]) / 2)
    asked = np.isin(np.arange(len(tasks)), played(rng, np.exp(logs), axes=axes, over=over))
    planes = Planes(tasks, over)
    off = planes.inferred(np.where(asked, np.exp(logs), np.nan), np.ones(len(logs)), asked) - logs
    assert np.mean(np.abs(off) <= 0.1) > 0.95
    assert asked.mean() < 0.4


def test_no_round_but_the_first_asks_for_more_than_its_share_of_every_plane():
    rng = np.random.default_rng(0)
    first, *others = rounds(rng, np.exp(rng.normal(size=len(Tasks(AXES)))))
    assert len(first) == FIRST
    assert 0 < max(map(len, others)) <= 2 * round(ROUND * 20 * 17)
