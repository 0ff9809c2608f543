"""Merged tables: the rows of all, never a lost or a doubtful one, and a table like any other."""

import json
import shutil
import signal
import subprocess

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.errors import InputError
from sweep.plan.tasks import Listed, Tasks, keys_of
from sweep.schema import blank_of, seal
from sweep.store import table
from sweep.store.join import DisagreementError
from sweep.store.lock import only_run
from sweep.store.merge import merge
from sweep.store.structure import seal_structure
from sweep.tell import report

from .conftest import BIN, SMALL, TIME_LIMIT, clean_environment, rows_of

POINTS = """
name = "points"
[points]
sample    = "latin"
n         = 9
N         = { linear = [5, 20] }
zeta_T    = { log = [1e-3, 1e-1] }
M_over_M0 = 1
V_over_V0 = 1
[accuracy]
target = 1e-2
"""


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    """computed(*options, **changes): a table of the small sweep with its spec's text changed; each is computed once."""
    known = {}

    def compute(*options, **changes):
        if (key := (options, *changes.items())) not in known:
            folder, text = tmp_path_factory.mktemp("table"), SMALL
            for name, value in changes.items():
                line = next(line for line in text.splitlines() if line.split(" ")[0] == name)
                text = text.replace(line, f"{name} = {value}")
            (folder / "spec.toml").write_text(text)
            command = [BIN / "sweep", "run", "spec.toml", "-o", "t.h5", *options]
            subprocess.run(command, cwd=folder, env=clean_environment(), check=True, timeout=TIME_LIMIT)
            known[key] = folder / "t.h5"
        return known[key]

    return compute


@pytest.fixture
def made(computed, tmp_path):
    """made(name, *options, **changes): a copy of that table for this test; its path."""
    return lambda name, *options, **changes: shutil.copy(computed(*options, **changes), tmp_path / name)


@pytest.fixture
def target(tmp_path):
    """Where the merged table goes."""
    return tmp_path / "t.h5"


def change(path, number, **columns):
    """Change a row and seal it, as a table of another machine or another kernel would have it."""
    with h5py.File(path, "r+") as file:
        rows = file["results"][number : number + 1]
        for name, value in columns.items():
            rows[name] = value
        seal(rows)
        file["results"][number : number + 1] = rows


def provenance(path, **texts):
    """Change its texts and seal it, as a table of another kernel would have them."""
    with h5py.File(path, "r+") as file:
        for name, text in texts.items():
            del file[f"provenance/{name}"]
            file[f"provenance/{name}"] = np.bytes_(text)
    seal_structure(path)


@pytest.mark.slow
def test_shards_merge_into_the_table_of_a_single_run(made, target, physics):
    one = made("one.h5")
    shards = [made(f"{k}.h5", "--shard", f"{k}/3") for k in (1, 2, 3)]
    told = merge(shards[::-1], target)
    assert (told["kind"], told["tasks"], told["done"], told["failed"], told["left"]) == ("grid", 24, 24, 0, 0)
    assert [source["taken"] for source in told["sources"]] == [8, 8, 8]
    assert physics(target) == physics(one)


def test_what_no_shard_has_is_left_and_a_run_completes_it(made, sweep, small_spec, target, physics):
    one = made("one.h5")
    answer = sweep("merge", made("1.h5", "--shard", "1/3"), made("3.h5", "--shard", "3/3"), "-o", "t.h5")
    assert answer.returncode == 75
    again = sweep("run", small_spec, "-o", "t.h5")
    assert again.returncode == 0
    assert "24 tasks, 8 left; " in again.stderr
    assert physics(target) == physics(one)


def test_a_merged_table_takes_what_comes_later_and_loses_nothing(made, target, physics):
    one, shards = made("one.h5"), [made(f"{k}.h5", "--shard", f"{k}/2") for k in (1, 2)]
    assert merge(shards[:1], target)["left"] == 12
    assert merge(shards[1:], target)["left"] == 0
    assert physics(target) == physics(one)


def test_the_merged_table_tells_where_it_comes_from(made, sweep, target):
    assert sweep("merge", made("1.h5", "--shard", "1/2"), made("2.h5", "--shard", "2/2"), "-o", "t.h5").returncode == 0
    told = report.show(target)
    assert [origin["shard"] for origin in told["merged"]] == ["1/2", "2/2"]
    assert [run["writer"] for run in told["runs"]] == ["gather", "gather", "merge"]
    assert [(run["rows"], run["ranks"]) for run in told["runs"]] == [(12, 1), (12, 1), (0, 1)]
    status = report.status(target)
    assert "shard" not in status
    assert (status["done"], status["running"], status["eta_s"]) == (24, False, None)


@pytest.fixture
def shards(sweep, tmp_path):
    """The three shards of a sweep of nine points."""
    (tmp_path / "p.toml").write_text(POINTS)
    for k in (1, 2, 3):
        assert sweep("run", "p.toml", "-o", f"{k}.h5", "--shard", f"{k}/3").returncode == 0
    return [tmp_path / f"{k}.h5" for k in (1, 2, 3)]


def test_points_of_a_shard_that_is_missing_are_left_until_it_is_joined(shards, sweep, target):
    assert merge(shards[:1], target)["left"] == 6
    answer = sweep("merge", shards[1], "-o", "t.h5", "--json")
    told = json.loads(answer.stdout)
    assert (answer.returncode, told["tasks"], told["done"], told["left"]) == (75, 9, 6, 3)
    assert answer.stderr.startswith("sweep: t.h5: lacks 3 tasks, whose rows are damaged or in none of the tables;")
    told = merge(shards[2:], target)
    assert (told["tasks"], told["done"], told["left"]) == (9, 9, 0)


def test_a_torn_row_of_a_list_is_left_unless_another_table_has_it(shards, made, tmp_path, target):
    whole = shutil.copy(shards[1], tmp_path / "whole.h5")
    with h5py.File(shards[1], "r+") as file:
        row = file["results"][0]
        row["ke_ratio"] += 1.0
        file["results"][0] = row
    told = merge(shards, target)
    assert (told["tasks"], told["done"], told["left"]) == (9, 8, 1)
    assert merge([*shards, whole], tmp_path / "again.h5")["left"] == 0
    assert merge([shards[1], made("a.h5", N="[5]")], tmp_path / "others.h5")["left"] == 1


def test_overlapping_sweeps_whose_union_is_a_grid_give_that_grid(made, sweep, small_spec, target, physics):
    low, high, whole = made("low.h5", N="[5, 8]"), made("high.h5", N="[8, 13]"), made("whole.h5")
    told = merge([high, low], target)
    assert (told["kind"], told["tasks"], told["done"]) == ("grid", 24, 24)
    assert [source["taken"] for source in told["sources"]] == [16, 8]
    assert physics(target) == physics(whole)
    assert sweep("run", small_spec, "-o", "t.h5").stdout.startswith("24 done, 0 failed, 0 left")


def test_sweeps_whose_union_is_no_grid_give_a_list_that_is_a_table_like_any_other(made, sweep, small_spec, target):
    a, b = made("a.h5", N="[5, 8]"), made("b.h5", N="[8, 13]", M_over_M0="[0.5]")
    told = merge([a, b], target)
    assert (told["kind"], told["tasks"], told["done"]) == ("list", 20, 20)
    rows = {row.tobytes()[:28]: row["ke_ratio"] for row in rows_of(target)}
    assert rows == {row.tobytes()[:28]: row["ke_ratio"] for path in (a, b) for row in rows_of(path)}
    for command in (["status", "t.h5"], ["show", "t.h5"], ["export", "t.h5", "-o", "t.csv"], ["audit", "t.h5"]):
        assert sweep(*command).returncode == 0
    refused = sweep("run", small_spec, "-o", "t.h5")
    assert refused.returncode == 2
    assert "holds another sweep (it differs in grid.M_over_M0, grid.N, " in refused.stderr


def test_a_list_merges_on(made, target, tmp_path):
    a, b = made("a.h5", N="[5, 8]"), made("b.h5", N="[8, 13]", M_over_M0="[0.5]")
    merge([a, b], tmp_path / "list.h5")
    told = merge([tmp_path / "list.h5", made("whole.h5")], target)
    assert (told["kind"], told["tasks"], told["done"]) == ("grid", 24, 24)
    assert [source["taken"] for source in told["sources"]] == [20, 4]


def test_tables_that_disagree_are_refused_with_task_columns_and_values(made, sweep, tmp_path):
    a, b = made("a.h5"), made("b.h5")
    change(b, 7, ke_ratio=0.25, steps=3)
    answer = sweep("merge", a, b, "-o", "t.h5")
    assert answer.returncode == 2
    row = rows_of(a)[7]
    task = f"N {row['N']}, zeta_T {row['zeta_T']}, M_over_M0 {row['M_over_M0']}, V_over_V0 {row['V_over_V0']}"
    assert answer.stderr == (
        f"sweep: {a}, {b} disagree: task {task}: ke_ratio {row['ke_ratio']} or 0.25, steps {row['steps']} or 3\n"
    )
    assert not (tmp_path / "t.h5").exists()
    assert not list(tmp_path.glob(".*"))


def test_what_may_differ_between_runs_is_no_disagreement(made, target):
    a, b = made("a.h5"), made("b.h5")
    change(b, 7, seconds=99.0, rank=5)
    assert merge([a, b], target)["done"] == 24


def test_a_row_that_raised_gives_way_and_a_torn_one_counts_as_missing(made, target, physics):
    a, b, whole = made("a.h5"), made("b.h5"), made("whole.h5")
    change(a, 3, status=b"error", ke_ratio=np.nan)
    with h5py.File(a, "r+") as file:
        row = file["results"][5]
        row["ke_ratio"] = 1.0
        file["results"][5] = row
    for order in ((a, b), (b, a)):
        target.unlink(missing_ok=True)
        merge(order, target)
        assert physics(target) == physics(whole)


def test_another_accuracy_or_kernel_is_refused_all_at_once(made, sweep, tmp_path):
    a, b, c = made("a.h5"), made("b.h5", target="1e-3"), made("c.h5")
    provenance(c, kernel="0123456789abcdef")
    answer = sweep("merge", a, b, c, tmp_path / "none.h5", "-o", "t.h5")
    assert answer.stderr.splitlines() == [f"sweep: {tmp_path / 'none.h5'}: cannot be read: No such file or directory"]
    answer = sweep("merge", a, b, c, "-o", "t.h5")
    assert answer.returncode == 2
    first, second = answer.stderr.splitlines()
    assert "b.h5: asks for other numbers than" in first
    assert "accuracy.target 0.01 and 0.001" in first
    assert "several versions of the kernel" in second
    assert "0123456789abcdef" in second
    assert sweep("merge", a, c, "-o", "t.h5", "--keep-rows").returncode == 0


def test_tables_that_went_to_the_disk_at_other_times_are_merged(made, target, physics):
    whole, parts = made("whole.h5"), [made("a.h5", N="[5, 8]"), made("b.h5", N="[8, 13]")]
    with h5py.File(parts[1]) as file:
        text = file["provenance/resolved"][()].decode()
    provenance(parts[1], resolved=text.replace('"flush_every": 30.0', '"flush_every": 5.0'))
    assert merge(parts, target)["done"] == 24
    assert physics(target) == physics(whole)
    provenance(parts[1], resolved=text.replace('"certify": true', '"certify": false'))
    with pytest.raises(InputError, match=r"asks for other numbers than .* \(accuracy.certify True and False\)"):
        merge(parts, target)


def test_an_output_that_is_a_shard_is_left_alone(made):
    shards = [made(f"{k}.h5", "--shard", f"{k}/2") for k in (1, 2)]
    before = shards[0].read_bytes()
    for named in (shards, shards[::-1], shards[1:]):
        with pytest.raises(InputError, match="exists and is shard 1/2 of a sweep"):
            merge(named, shards[0])
    assert shards[0].read_bytes() == before


@pytest.mark.parametrize("content", [b"", b"not a table", None])
def test_an_output_that_is_no_table_is_left_alone(made, target, content):
    a = made("a.h5")
    target.write_bytes(content) if content is not None else target.mkdir()
    with pytest.raises(InputError, match=r"t\.h5: is "):
        merge([a], target)
    assert target.is_dir() if content is None else target.read_bytes() == content


def test_a_merge_that_is_killed_leaves_the_output_as_it_was(made, tmp_path, monkeypatch):
    a, b = made("a.h5", N="[5]"), made("b.h5", N="[8]")
    before = a.read_bytes()

    def interrupted(*_):
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(table, "_to_disk", interrupted)
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            merge([b], a)
    finally:
        signal.signal(signal.SIGINT, handler)
    assert a.read_bytes() == before
    assert not list(tmp_path.glob(".*"))


def test_what_a_killed_merge_has_left_goes_with_the_next_run(made, sweep, small_spec, tmp_path):
    a = made("a.h5")
    (tmp_path / f".{a.name}.partial").write_bytes(b"half of a table")
    sweep("run", small_spec, "-o", a)
    assert not list(tmp_path.glob(".*"))


def test_an_output_that_a_run_is_writing_is_refused(made, target):
    a = made("a.h5")
    with only_run(target), pytest.raises(InputError, match="another run is writing this table"):
        merge([a], target)


PARTS = st.tuples(st.integers(2, 10_000), st.floats(0, 8), st.floats(0.25, 64), st.floats(0.25, 16))


@given(st.lists(PARTS, min_size=1, max_size=40), PARTS)
def test_a_list_finds_each_of_its_tasks_and_no_other(parts, other):
    names = ("N", "zeta_T", "M_over_M0", "V_over_V0")
    columns = {name: np.array(values) for name, values in zip(names, zip(*parts, strict=True), strict=True)}
    listed = Listed(keys_of(columns))
    assert len(listed) == len(set(parts))
    back = listed.columns(listed.find(columns))
    assert all((back[name] == columns[name]).all() for name in names)
    found = listed.find({name: np.array([value]) for name, value in zip(names, other, strict=True)})
    assert (found[0] >= 0) == (other in parts)


def test_a_grid_finds_each_of_its_tasks_and_no_other():
    grid = Tasks({"N": [8, 5], "zeta_T": [0.0, 1e-3], "M_over_M0": [2.0, 0.5], "V_over_V0": [1.0]})
    every = np.arange(len(grid))
    assert (grid.find(grid.columns(every)) == every).all()
    near = {"N": np.array([5, 6]), "zeta_T": np.array([np.nextafter(1e-3, 1), 0.0])}
    assert grid.find(near | {"M_over_M0": np.array([2.0, 2.0]), "V_over_V0": np.array([1.0, 1.0])}).tolist() == [-1, -1]


def test_minus_zero_names_the_task_that_zero_names():
    points = {"N": np.array([5, 5]), "zeta_T": np.array([0.0, -0.0]), "M_over_M0": np.ones(2), "V_over_V0": np.ones(2)}
    for tasks in (Listed(keys_of(points)), Tasks({name: [values[0]] for name, values in points.items()})):
        assert (len(tasks), tasks.find(points).tolist()) == (1, [0, 0])


def test_of_many_tasks_that_disagree_a_few_are_shown_and_the_others_counted():
    ones = np.ones(8)
    there = blank_of({"N": np.arange(5, 13), "zeta_T": ones, "M_over_M0": ones, "V_over_V0": ones})
    rows = there.copy()
    there["ke_ratio"], rows["ke_ratio"] = 0.25, 0.5
    *shown, rest = DisagreementError(there, rows, np.arange(8)).lines()
    assert shown[0] == "task N 5, zeta_T 1.0, M_over_M0 1.0, V_over_V0 1.0: ke_ratio 0.25 or 0.5"
    assert (len(shown), rest) == (5, "and 3 more tasks")
    assert len(DisagreementError(there[:5], rows[:5], np.arange(5)).lines()) == 5
