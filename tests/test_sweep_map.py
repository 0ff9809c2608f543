"""A search for a map computes what interpolation needs, the same tasks in any order, and says what it has inferred."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import analysis
from analysis.cli import main
from sweep.errors import InputError
from sweep.plan.mesh import corners, expected, first_boxes, halfway, halves, leaves, scale_of
from sweep.plan.refine import Refine
from sweep.plan.spec import parse_spec
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank
from sweep.tell import report

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
    assert sweep("run", "s.toml", "-o", "one.h5").returncode == 0
    assert sweep("run", "s.toml", "-o", "three.h5", ranks=3).returncode == 0
    assert physics(tmp_path / "three.h5") == physics(tmp_path / "one.h5")
    sweep("run", "grid.toml", "-o", "grid.h5")
    status, plan = report.status(tmp_path / "one.h5"), planned(tmp_path / "s.toml")
    whole = analysis.load(tmp_path / "grid.h5")
    assert plan["tasks"] < status["done"] < 0.5 * len(whole)
    assert plan["at_most"] == len(whole)
    assert status["left"] == 0

    assert main(["map", str(tmp_path / "one.h5"), "-o", str(tmp_path / "m.png"), *MAP]) == 0
    told = capsys.readouterr().out
    assert f"A search: {status['done']} of {len(whole)} rows computed (dots); the others are interpolated" in told
    cells = pd.read_csv(tmp_path / "m.map.csv").set_index("task")
    plane = whole[(whole["V_over_V0"] == 2)]
    assert cells["inferred"].sum() > 0.4 * len(plane)
    computed = cells[~cells["inferred"]]
    assert (computed["ke_ratio"] == plane.loc[computed.index, "ke_ratio"]).all()
    guesses = cells[cells["inferred"]]
    truth = plane.loc[guesses.index]
    calm = ~truth["chaotic"].to_numpy(bool)
    off = np.abs(np.log(guesses["ke_ratio"] / truth["ke_ratio"]))[calm]
    assert (off <= 0.2).mean() > 0.9
    assert guesses["error"].isna().all()
    lowest = float(told.split("lowest    ke_ratio = ")[1].split()[0])
    assert lowest == pytest.approx(computed.loc[computed["chaotic"] == False, "ke_ratio"].min(), rel=1e-3)  # noqa: E712


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ("error = 0.2", "", 'search.error: is missing, which find = "map" needs'),
        ("error = 0.2", "error = 0.0", "search.error: must be greater than or equal to 0.001, got 0.0"),
        ('"N", "zeta_T"', '"N", "zeta_T", "M_over_M0", "V_over_V0"', "search.over: a map has at most 3 axes"),
        ("{ log = [5, 100], points = 25 }", "[9, 5]", "grid.N: the values of a map's axis must ascend, got [9, 5]"),
        ("error", "level = 1.0\nerror", 'search.level: stands only with find = "level", got find = "map"'),
    ],
)
def test_a_wrong_map_is_one_problem(line, instead, problem):
    with pytest.raises(InputError) as caught:
        parse_spec((GRID + SEARCH).replace(line, instead), "x.toml")
    (found,) = caught.value.problems
    assert found.startswith(f"x.toml: {problem}")


AXES = {"N": [*range(5, 25)], "zeta_T": np.geomspace(1e-4, 1, 17).tolist(), "M_over_M0": [1.0], "V_over_V0": [1.0, 2.0]}


def played(rng, values, error=0.1, known=(), axes=AXES, over=("N", "zeta_T")):
    """Every order of a search whose results arrive in random order and portions; `known`: computed before it began."""
    search = Refine(Tasks(axes), over, "ke_ratio", error)
    rows = blank(len(values))
    rows["status"], rows["ke_ratio"], rows["chaotic"] = DONE, np.nan_to_num(values, nan=1.0), np.isnan(values)
    search.tell(np.array(known, np.int64), rows[list(known)])
    waiting = search.ask().tolist()
    given = [*waiting]
    while waiting:
        rng.shuffle(waiting)
        part = np.array([waiting.pop() for _ in range(rng.integers(1, len(waiting) + 1))])
        search.tell(part, rows[part])
        new = search.ask().tolist()
        assert not {*new} & {*given}
        waiting, given = waiting + new, given + new
    return sorted(given)


def landscape(rng):
    n = len(Tasks(AXES))
    values = np.exp(np.cumsum(rng.normal(scale=rng.choice([0.01, 0.3]), size=n)))
    return np.where(rng.random(n) < rng.choice([0, 0.3]), np.nan, values)


@given(st.integers(0, 2**32 - 1))
def test_what_is_asked_for_depends_on_no_order_and_on_nothing_known_besides(seed):
    rng = np.random.default_rng(seed)
    values = landscape(rng)
    once = played(rng, values)
    assert played(rng, values) == once
    known = np.flatnonzero(rng.random(len(values)) < 0.2).tolist()
    assert played(rng, values, known=known) == sorted(set(once) - set(known))


def first():
    return len({p for box in first_boxes((20, 17)) for p in (*corners(box), *halfway(box))}) * 2


def test_where_numbers_are_a_power_law_or_all_chaotic_nothing_is_added_to_the_first_tasks():
    tasks, rng = Tasks(AXES), np.random.default_rng(0)
    columns = tasks.columns(np.arange(len(tasks)))
    assert len(played(rng, columns["N"] ** 2.0 * columns["zeta_T"] ** -0.7)) == first()
    assert len(played(rng, np.full(len(tasks), np.nan))) == first()


def test_a_cliff_is_followed_and_its_sides_are_left():
    tasks, rng = Tasks(AXES), np.random.default_rng(0)
    columns = tasks.columns(np.arange(len(tasks)))
    cliff = np.where(columns["N"] < 13.5, 1.0, 0.01)
    asked = np.array(played(rng, cliff))
    near = np.isin(columns["N"], [13, 14])
    assert np.isin(np.flatnonzero(near), asked).all()
    assert len(asked) < 0.5 * len(tasks)


@given(st.lists(st.integers(1, 30), min_size=1, max_size=3))
def test_the_first_boxes_and_their_halves_fill_the_map(shape):
    boxes = first_boxes(shape)
    for _ in range(4):
        covered = np.zeros(shape, bool)
        for box in boxes:
            covered[tuple(slice(a, b + 1) for a, b in box)] = True
        assert covered.all()
        boxes = [half for box in boxes[:20] for half in halves(box)] + boxes[20:]


@given(st.integers(0, 2**32 - 1))
def test_a_function_linear_in_the_logarithms_is_interpolated_exactly(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(2, 20, size=2).tolist())
    scales = [scale_of(np.sort(rng.lognormal(size=n))) for n in shape]
    slope = rng.normal(size=2)
    logs = np.add.outer(slope[0] * scales[0], slope[1] * scales[1])
    for box in leaves(shape, scales, lambda place: logs[place], 0.1):
        place = tuple(int(rng.integers(a, b + 1)) for a, b in box)
        assert expected(box, place, scales, lambda p: logs[p]) == pytest.approx(logs[place], abs=1e-9)
