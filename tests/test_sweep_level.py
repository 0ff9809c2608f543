"""A search for a level brackets every crossing as a dense grid would, along any axis, whatever the ranks and orders."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import analysis
from analysis.cli import main
from sweep.plan.crossing import Crossing, bracket
from sweep.plan.fall import lattice
from sweep.plan.line import Axis, Line
from sweep.plan.lines import wanted
from sweep.plan.spec import parse_spec
from sweep.schema import DONE
from sweep.store import table
from sweep.tell import report
from sweep.tell.text import of_status

from .conftest import problems_of, rows_of

LEVEL = """
name = "falls"
[grid]
N         = [6, 20, 65, 200]
zeta_T    = [6e-4, 1e-3, 3e-3]
M_over_M0 = [1, 2]
V_over_V0 = 2
[search]
find = "level"
along = "N"
level = 0.6
until = 0.06
[accuracy]
target = 1e-2
"""
SPEED = (
    LEVEL.replace("V_over_V0 = 2", "V_over_V0 = { log = [0.2, 10], points = 4 }")
    .replace("[6, 20, 65, 200]", "[40, 65]")
    .replace('"N"', '"V_over_V0"\ncrossing = "last"')
)


@pytest.mark.mpi
def test_three_ranks_give_the_bits_of_one_along_any_axis(sweep, tmp_path, physics):
    (tmp_path / "s.toml").write_text(SPEED)
    assert sweep("run", "s.toml", "-o", "one.h5").returncode == 0
    assert sweep("run", "s.toml", "-o", "three.h5", ranks=3).returncode == 0
    assert physics(tmp_path / "three.h5") == physics(tmp_path / "one.h5")
    found = analysis.crossings(analysis.load(tmp_path / "one.h5"), 0.6, "V_over_V0", which="last")
    crossed = found[found["why_not"] == ""]
    assert len(crossed) > 0
    assert (crossed["high"] <= 1.06 * crossed["low"]).mean() > 0.6


@pytest.mark.mpi
def test_the_brackets_are_those_of_the_dense_grid(sweep, tmp_path):
    (tmp_path / "s.toml").write_text(LEVEL)
    assert sweep("run", "s.toml", "-o", "one.h5").returncode == 0
    found, along, which = analysis.load(tmp_path / "one.h5"), "N", "first"
    every = rows_of(tmp_path / "one.h5")
    assert len(found) < 0.5 * len(every)
    values = np.unique(every[along]).tolist()
    dense = LEVEL[: LEVEL.index("[search]")] + "[accuracy]\ntarget = 1e-2\n"
    lines = [f"{along} = {values}" if line.startswith(along) else line for line in dense.splitlines()]
    (tmp_path / "dense.toml").write_text("\n".join(lines))
    assert sweep("run", "dense.toml", "-o", "dense.h5", ranks=2).returncode == 0
    ours = analysis.crossings(found, 0.6, along, which=which)
    theirs = analysis.crossings(analysis.load(tmp_path / "dense.h5"), 0.6, along, which=which)
    same = (ours[["low", "high"]] == theirs[["low", "high"]]).all(axis=1) | (ours["why_not"] != "")
    assert (ours["why_not"] == "").any()
    crossed = ours[ours["why_not"] == ""]
    assert ((crossed["high"] <= 1.06 * crossed["low"]) | (crossed["high"] - crossed["low"] == 1)).mean() > 0.6
    assert same.mean() > 0.6  # between the values of the start more may be crossed, which only the dense grid sees


def test_plan_and_status_tell_how_much_at_most(sweep, planned, tmp_path):
    (tmp_path / "s.toml").write_text(LEVEL)
    plan = planned(tmp_path / "s.toml")
    told = sweep("run", "s.toml", "-o", "t.h5").stderr
    status = report.status(tmp_path / "t.h5")
    assert plan["tasks"] == 24 < status["done"] <= plan["at_most"] == 6 * 54
    assert "search, at most 324 tasks, 24 left; " in told
    assert (status["left"], status["search"]) == (0, True)
    assert "search          yes: the tasks are those that it has asked for\n" in of_status(status) + "\n"
    assert "yes: more tasks may follow" in of_status(status | {"left": 3})
    assert "screened" not in status


def test_the_picture_takes_what_was_searched_for_and_says_so(sweep, tmp_path, capsys):
    (tmp_path / "s.toml").write_text(LEVEL)
    sweep("run", "s.toml", "-o", "t.h5")
    assert main(["level", str(tmp_path / "t.h5"), "-o", str(tmp_path / "l.png")]) == 0
    told = capsys.readouterr().out
    assert "with the first crossing of ke_ratio = 0.6 along N" in told
    assert "search    A search: " in told
    numbers = pd.read_csv(tmp_path / "l.level.csv")
    assert (len(numbers), numbers.columns[0]) == (6, "zeta_T"), "no column of line numbers without a name"
    varied = [name for name in ("zeta_T", "M_over_M0", "V_over_V0") if len(numbers[name].unique()) > 1]
    (smallest,) = [line for line in told.splitlines() if line.startswith("smallest")]
    assert sorted(part.split(" = ")[0] for part in smallest.partition(" at ")[2].split(", ")) == sorted(varied)
    crossed = numbers[numbers["why_not"].isna()]
    assert ((crossed["at_low"] >= 0.6) != (crossed["at_high"] >= 0.6)).all()
    assert main(["level", str(tmp_path / "t.h5"), "-o", str(tmp_path / "m.png"), "--level", "1", "--along", "K"]) == 2
    assert "unknown parameters K; there are N, zeta_T, M_over_M0, V_over_V0" in capsys.readouterr().err
    assert main(["level", str(tmp_path / "t.h5"), "-o", str(tmp_path / "m.png"), "--of", "ke_bistable"]) == 2
    assert "give --level, as the search's, 0.6, is of ke_ratio, not of ke_bistable" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "instead", "problem"),
    [
        ("level = 0.6", "", 'search.level: is missing, which find = "level" needs'),
        ("level = 0.6", "level = inf", "search.level: must be a finite number, got inf"),
        ('along = "N"', 'along = "n"', "search.along: the grid has no axis 'n' (did you mean 'N'?)"),
        ("[6, 20, 65, 200]", "[6]", "grid.N: a line needs at least 2 values to start from, got [6]"),
        ("until = 0.06", 'over = ["N"]', 'search.over: stands only with find = "lowest" or "map", got'),
        ("until = 0.06", "until = 0.6", "search.until: must be less than or equal to 0.5, got 0.6"),
        ("until = 0.06", "most = 0", "search.most: must be greater than or equal to 1, got 0"),
    ],
)
def test_a_wrong_search_is_one_problem(line, instead, problem):
    (found,) = problems_of(parse_spec, LEVEL.replace(line, instead), "x.toml")
    assert found.startswith(f"x.toml: {problem}")


@pytest.mark.parametrize(("key", "found"), [("along", 'level"\nlevel = 0.6'), ("over", 'map"\nerror = 0.2')])
def test_nothing_is_looked_for_between_seeds(key, found):
    given = "'mass.seed'" if key == "along" else "['N', 'mass.seed']"
    search = f'"mass.seed" = [1, 2]\n[model]\nmass = {{ spread = 0.1 }}\n[search]\nfind = "{found}\n{key} = {given}\n'
    (problem,) = problems_of(parse_spec, LEVEL[: LEVEL.index("[search]")] + search, "x.toml")
    rule = "must not name a seed, as nothing lies between two of them"
    assert problem == f"x.toml: search.{key}: {rule}, got 'mass.seed'"


def replayed(axis, values, start, crossing, known=()):
    """All places that were asked for, one after the other; `known`: rows that were there before."""
    line, asked = Line(Axis(axis)), []
    line.known.update({k: float(values[k]) for k in known})
    while new := wanted(line, list(map(int, start)), crossing):
        assert not line.known.keys() & set(new)
        line.known.update({k: float(values[k]) for k in new})
        asked += new
    return asked


STARTS = st.lists(st.floats(0.01, 100).map(lambda x: float(f"{x:.12g}")), min_size=2, max_size=8, unique=True)


@given(STARTS, st.floats(0.005, 0.3), st.sampled_from(["first", "last"]), st.integers(0, 2**32 - 1))
def test_a_crossing_is_bracketed_to_the_width_or_to_what_has_a_value(start, until, which, seed):
    rng = np.random.default_rng(seed)
    axis = np.array(lattice(start, until, whole=False))
    values = np.cumsum(rng.normal(size=len(axis)))
    values[rng.random(len(axis)) < 0.1] = np.nan
    places = np.searchsorted(axis, sorted(start))
    crossing = Crossing(0.3, which, until, 10_000)
    asked = sorted(replayed(axis, values, places, crossing))
    told = [k for k in asked if np.isfinite(values[k])]
    found = bracket(values[told], 0.3, which)
    if found is not None:
        low, high = told[found], told[found + 1]
        between = set(range(low + 1, high))
        assert (
            axis[high] <= (1 + until) * axis[low]
            or not between - set(asked)
            or np.isnan(values[list(between & set(asked))]).all()
        )
    before = np.flatnonzero(rng.random(len(axis)) < 0.3).tolist()
    assert sorted(set(replayed(axis, values, places, crossing, before)) | set(before)) == sorted(
        set(asked) | set(before)
    )


@given(st.lists(st.floats(-2, 2), max_size=12), st.floats(-1, 1))
def test_the_first_crossing_of_a_curve_is_the_last_of_its_mirror_image(values, level):
    curve = np.array(values)
    first, last = bracket(curve, level, "first"), bracket(curve[::-1], level, "last")
    assert (first is None) == (last is None)
    if first is not None and last is not None:
        assert first == len(curve) - 2 - last


def test_a_picture_of_many_chains_and_few_speeds_has_a_curve_for_each_speed_and_names_what_does_not_vary(
    tmp_path, capsys
):
    N, zeta_T = [float(n) for n in range(10, 21)], [1e-4, 1e-3, 1e-2]
    rows = [
        {"N": n, "zeta_T": z, "M_over_M0": 0.5, "V_over_V0": v, "ke_ratio": 1e-3 / z, "error": 1e-9, "chaotic": False}
        for n in N for z in zeta_T for v in (1.0, 2.0, 4.0)
    ]  # fmt: skip
    pd.DataFrame(rows).to_csv(tmp_path / "t.csv", index=False)
    words = ["level", str(tmp_path / "t.csv"), "--level", "1", "--along", "zeta_T"]
    assert main([*words, "-o", str(tmp_path / "l.svg")]) == 0
    drawn = (tmp_path / "l.svg").read_text()
    assert "$M/M_0$ = 0.5" in drawn
    assert all(f"= {v}" in drawn for v in (1, 2, 4))
    more = pd.concat([pd.DataFrame(rows).assign(M_over_M0=0.1 * k) for k in range(1, 5)])
    more.to_csv(tmp_path / "more.csv", index=False)
    words[1] = str(tmp_path / "more.csv")
    assert main([*words, "-o", str(tmp_path / "more.png")]) == 2
    assert "fix a value, as in --at V_over_V0=VALUE" in capsys.readouterr().err


def test_between_zero_and_the_next_value_nothing_is_asked_for():
    assert lattice([0.0, 1.0], 0.1, whole=False) == [0.0, 1.0]


def test_negative_values_are_halved_as_their_amounts_are():
    mirrored = [-value for value in reversed(lattice([-1.0, -4.0], 0.02, whole=False))]
    assert mirrored == lattice([1.0, 4.0], 0.02, whole=False)
    assert len(mirrored) > 2
    assert lattice([-1.0, 0.0], 0.1, whole=False) == [-1.0, 0.0]


@given(st.floats(0.01, 100), st.floats(0.01, 100), st.floats(0.005, 0.3))
@example(94.865, 94.865, 0.25)
@example(42.3384, 40.92582164555243, 0.03072868750844541)
def test_between_a_negative_and_a_positive_value_places_lie_evenly_and_near(low, high, until):
    values = lattice([-low, high], until, whole=False)
    steps = np.diff(values)
    assert (steps > 0).all()
    assert steps.max() <= until * max(low, high)
    assert np.allclose(steps, (low + high) / len(steps), rtol=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("start", [(-4.0, -1.0), (-1.0, 1.0), (-3.0, 0.5, 2.0)])
def test_a_crossing_at_negative_values_is_bracketed_to_the_width(start):
    axis = np.array(lattice(start, 0.02, whole=False))
    places, crossing = np.searchsorted(axis, start), Crossing(0.0, "first", 0.02, 1000)
    for at in np.linspace(start[0], start[-1], 20)[1:-1]:
        asked = sorted(set(replayed(axis, at - axis, places, crossing)))
        k = bracket((at - axis)[asked], 0.0, "first")
        low, high = axis[asked[k]], axis[asked[k + 1]]
        assert low <= at <= high
        assert high - low <= 0.02 * max(map(abs, start))
        assert len(asked) < 20


def test_a_failed_row_is_asked_for_once(sweep, tmp_path):
    text = LEVEL.replace("target = 1e-2", "target = 1e-2\nmax_steps = 2")
    (tmp_path / "s.toml").write_text(text)
    assert sweep("run", "s.toml", "-o", "t.h5").returncode == 1
    status = report.status(tmp_path / "t.h5")
    assert (status["done"], status["failed"], status["left"]) == (0, 24, 0)
    again = sweep("run", "s.toml", "-o", "t.h5", "--retry-failed")
    assert "24 left; " in again.stderr
    assert again.returncode == 1
    with table.reading(tmp_path / "t.h5") as file:
        assert not (file["results"]["status"] == DONE).any()
