"""`sweep.run` from Python is the command line's sweep: same bits, same messages."""

import subprocess
import sys
import tomllib
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import analysis
import sweep as package
from analysis.table import reused
from sweep import caller
from sweep.errors import InputError
from sweep.plan.toml import as_toml
from sweep.tell import report

from .conftest import problems_of
from .waiting import wait_for_rows, wait_for_the_lock

refused = partial(problems_of, package.run)
GRID = {"N": np.array([5, 8]), "zeta_T": 1e-3, "M_over_M0": [0.5, 2], "V_over_V0": {"log": [0.3, 3], "points": 2}}


def test_a_dict_is_the_same_spec_as_its_text():
    assert as_toml({"name": "Stoß"}) == ('name = "Stoß"\n', [])
    text, _ = as_toml({"name": 'a "b"', "accuracy": {"certify": False, "target": np.float64(1e-2)}, "grid": GRID})
    assert tomllib.loads(text) == {
        "name": 'a "b"',
        "accuracy": {"certify": False, "target": 0.01},
        "grid": GRID | {"N": [5, 8]},
    }


def test_what_toml_has_no_word_for_is_named_with_its_key_beside_all_other_problems(tmp_path):
    grid = {"N": [object()], "zeta_T": -1, "M_over_M0": {"log": [None, 3], "points": 2}}
    lines = refused({"name": None, "grid": grid, "points": {"sample": "sobol", "n": None}}, tmp_path / "t.h5", ranks=0)
    told = [line.partition(", got")[0] for line in lines]
    no_word = "must be a number, a text, a list or a mapping of these"
    assert told[:4] == [f"{key}: {no_word}" for key in ("name", "grid.N", "grid.M_over_M0.log", "points.n")]
    assert {line.partition(":")[0] for line in told[4:]} == {"points", "grid.zeta_T", "grid.V_over_V0", "ranks"}


def test_problems_of_the_spec_and_of_the_table_are_told_beside_those_of_other_arguments(tmp_path):
    (tmp_path / "bad.toml").write_text("name = ''\n[grid]\n")
    axes = [f"grid.{name}" for name in ("N", "zeta_T", "M_over_M0", "V_over_V0")]
    for spec, own in (({"name": "", "grid": {}}, ""), (tmp_path / "bad.toml", f"{tmp_path}/bad.toml: ")):
        lines = refused(spec, tmp_path / "t.csv", ranks=0)
        keys = ["ranks", *(f"{own}{key}" for key in ("name", *axes)), f"{tmp_path}/t.csv"]
        told = zip(keys, lines, strict=True)
        assert [line for key, line in told if not line.startswith(f"{key}: ")] == []


def test_every_text_and_path_that_a_file_can_hold_is_written_as_it_is(tmp_path):
    given = {"name": "a\x7f\x00\n😀", "points": {"file": tmp_path / "p.csv"}, "😀 \x7f": {"é\x7f": {"\x00": 1}}}
    text, problems = as_toml(given)
    assert tomllib.loads(text) == given | {"points": {"file": str(tmp_path / "p.csv")}}
    assert not problems


def test_half_a_letter_is_told_with_its_key(tmp_path):
    lines = refused({"name": "\ud800", "grid": GRID | {"\udc00": 1}}, tmp_path / "t.h5")
    rule = "must be a text without half a letter (a surrogate), got"
    assert lines == (rf"name: {rule} '\ud800'", rf"grid.?: {rule} '\udc00'")


@pytest.mark.parametrize("path", ["a\0b", Path("a\0b"), "\ud800"])
def test_what_no_path_can_be_is_refused_everywhere(path):
    lines = refused(path, path, store=path)
    assert [line.partition(":")[0] for line in lines] == ["spec", "output", "store"]


def test_a_whole_number_of_numpy_is_a_number_of_ranks(tmp_path):
    with pytest.raises(InputError, match=r"^output: [^\n]+$"):
        package.run({"name": "a", "grid": GRID}, None, ranks=np.int64(2))


def test_the_package_has_the_error_that_it_raises():
    assert package.InputError is InputError


@pytest.mark.mpi
@pytest.mark.slow
def test_a_run_from_python_gives_the_bits_of_the_command_line_on_any_number_of_ranks(sweep, tmp_path, physics):
    spec = {"name": "small", "grid": GRID}
    (tmp_path / "small.toml").write_text(as_toml(spec)[0])
    assert sweep("run", "small.toml", "-o", "line.h5").returncode == 0
    for ranks in (1, 2):
        finished = package.run(spec, tmp_path / f"{ranks}.h5", ranks=ranks, progress=False, store=tmp_path / "rows")
        assert (finished.done, finished.failed, finished.left) == (8, 0, 0)
        assert physics(finished.table) == physics(tmp_path / "line.h5")
    assert len(analysis.load(finished)) == len(pd.DataFrame(finished.rows)) == 8
    assert set(finished.rows["status"]) == {"done"}
    assert "8 done, 0 failed, 0 left" in finished._repr_html_()
    assert sum(reused(finished.table).values()) == 8


@pytest.mark.slow
def test_bad_input_is_told_by_key_and_nothing_is_written(tmp_path):
    lines = refused({"name": "bad", "grid": GRID | {"N": 1, "zeta_T": -1}}, tmp_path / "t.h5", progress=False)
    assert [line.partition(":")[0] for line in lines] == ["grid.N", "grid.zeta_T"]
    with pytest.raises(InputError, match=r"none\.toml: cannot be read: No such file"):
        package.run(tmp_path / "none.toml", tmp_path / "t.h5", progress=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.mpi
@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_of_a_sweep_that_fails_under_way_the_problem_is_told_and_not_the_log(tmp_path, ranks):
    face = "class Sampler:\n    __init__ = lambda self, axes: None\n    tell = lambda self, rows: rows[9]\n"
    (tmp_path / "mine.py").write_text(f"{face}    ask = lambda self: [[0] * 4]\n")
    search = {"find": "own", "file": str(tmp_path / "mine.py")}
    (problem,) = refused({"name": "own", "grid": GRID, "search": search}, tmp_path / "t.h5", ranks, progress=False)
    assert problem.startswith(f"search.file: {tmp_path}/mine.py failed in Sampler.tell: IndexError")


@pytest.mark.slow
def test_a_path_that_begins_with_a_hyphen_is_no_option(small_spec, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    small_spec.rename("-s.toml")
    assert package.run("-s.toml", "-t.h5", progress=False, store="-rows").done == 24


@pytest.mark.mpi
@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_sweep_stops_when_its_caller_is_killed(slow_spec, tmp_path, ranks):
    code = f"import sweep; sweep.run('slow.toml', 't.h5', ranks={ranks}, progress=False)"
    slow_spec.write_text(slow_spec.read_text().replace("1e-7", "1e-11"))
    with subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path) as script:
        wait_for_rows(tmp_path / "t.h5", script)
        script.kill()
    wait_for_the_lock(tmp_path / "t.h5")
    assert report.status(tmp_path / "t.h5")["left"] > 0


@pytest.mark.slow
def test_no_bar_is_drawn_of_a_spec_that_is_refused(tmp_path, capfd):
    with pytest.raises(InputError, match="grid: is missing"):
        package.run({}, tmp_path / "t.h5")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("ranks", [0, True, 1.5, "2", 10**9])
def test_ranks_that_are_none_are_refused(ranks, tmp_path):
    with pytest.raises(InputError, match="ranks: must be a whole number from 1 to 1024"):
        package.run({}, tmp_path / "t.h5", ranks=ranks)
    with pytest.raises(InputError, match="store: must be the path of a folder, got 3"):
        package.run({}, tmp_path / "t.h5", store=3)
    with pytest.raises(InputError, match="store: must be the path of a folder, got ''"):
        package.run({}, tmp_path / "t.h5", store="")
    with pytest.raises(InputError, match="progress: must be True or False, got 'no'"):
        package.run({}, tmp_path / "t.h5", progress="no")


@pytest.mark.parametrize("spec", [3, [1], None, b"quick.toml"])
def test_a_spec_and_an_output_that_are_neither_path_nor_dict_are_told_together(spec):
    lines = refused(spec, None, ranks=0)
    assert [line.partition(":")[0] for line in lines] == ["spec", "output", "ranks"]


class _Process:
    """Ends at the fourth wait, or at once where nobody looks meanwhile."""

    returncode = None

    def __init__(self):
        self.waits = []

    def wait(self, seconds=None):
        self.waits.append(seconds)
        if seconds is not None and len(self.waits) < 4:
            raise subprocess.TimeoutExpired("sweep", seconds)
        self.returncode = 0


def test_looking_how_far_it_is_takes_a_hundredth_of_a_core_at_most_and_none_if_nobody_asks(monkeypatch):
    """To count the rows of a search is to search once more: seconds, of a large one."""
    used, costs = [7.0], [1e-3, 0.05, 2.0, 0.0]
    monkeypatch.setattr(caller.time, "thread_time", lambda: used[0])
    monkeypatch.setattr(caller, "_show", lambda *_: used.append(used.pop() + costs.pop(0)))
    looked_at, alone, mute = _Process(), _Process(), _Process()
    caller._follow(looked_at, Path("t.h5"), True)
    assert looked_at.waits == [0.3, 0.3, pytest.approx(5.0), pytest.approx(200.0)]
    assert costs == []  # the last look is at what there is in the end
    caller._follow(alone, Path("t.h5"), False)
    assert alone.waits == [None]
    monkeypatch.setattr(caller.sys, "stderr", None)  # as in a program with a window and no terminal
    caller._follow(mute, Path("t.h5"), True)
    assert mute.waits == [None]


def test_a_problem_advises_only_what_the_function_has_or_says_where_the_rest_is(tmp_path):
    """It advised -o and --reuse as if they were its own."""
    for name, N in (("one", [5]), ("other", [5, 8])):
        spec = {"name": name, "grid": {"N": N, "zeta_T": 1e-3, "M_over_M0": 1, "V_over_V0": 1}}
        if name == "one":
            package.run(spec, tmp_path / "t.h5", progress=False)
    (told,) = refused(spec, tmp_path / "t.h5", progress=False)
    assert "; give another output, and --reuse " in told
    assert told.endswith(" (--reuse: of `sweep run` on the command line)")
    assert "-o" not in told.replace("--reuse", "").replace("t.h5", "").split()
