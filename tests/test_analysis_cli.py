"""Claims about `analysis best` and `map`: picture, CSV, what is printed, and bad input."""

import itertools
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

import analysis
from analysis import commands
from analysis.cli import COMMANDS, main
from sweep.schema import ROW, seal

GRID = ((5, 20, 100), (0.0, 1e-5, 4e-4, 1e-2), (0.1, 1.0, 2.0), (1.0, 10.0))
MAP_AT = ["--at", "M_over_M0=2", "V_over_V0=10"]
COLUMNS = ["N", "zeta_T", "M_over_M0", "V_over_V0", "ke_ratio", "error", "chaotic", "checked"]
COLUMNS += ["spread_low", "spread_high"]


def rows(grid=GRID):
    """Finished, sealed rows of a grid; ke_ratio falls with N and zeta_T, a third of zeta_T = 0 is chaotic."""
    made = np.zeros(int(np.prod([len(axis) for axis in grid])), ROW)
    names = ("N", "zeta_T", "M_over_M0", "V_over_V0")
    for name, values in zip(names, zip(*itertools.product(*grid), strict=True), strict=True):
        made[name] = values
    size = made["N"] * (made["zeta_T"] + 1e-5)
    made["ke_ratio"] = 1e-3 / size + 0.01 * np.abs(made["M_over_M0"] - 1) + 0.1 / made["V_over_V0"]
    made["error"], made["method"], made["status"], made["checked"] = 1e-4, b"rk45", b"done", True
    made["chaotic"] = (made["zeta_T"] == 0) & ((made["N"] == 100) | (made["M_over_M0"] == 1))
    seal(made)
    return made


def write(path, data):
    with h5py.File(path, "w") as file:
        file["results"] = data
    return path


def exactly(path):
    """A CSV with its numbers read by Python, which unlike some versions of pandas rounds them correctly."""
    text = pd.read_csv(path, dtype=str, keep_default_na=False)
    read = text.map(lambda cell: cell == "True" if cell in ("True", "False") else float(cell or "nan"))
    return read.astype({"task": int}).set_index("task")


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "t.h5", rows())


@pytest.mark.parametrize(
    ("kind", "start"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml"), ("PNG", b"\x89PNG")]
)
def test_best_writes_a_picture_of_the_kind_that_its_name_says(table, tmp_path, kind, start):
    assert main(["best", str(table), "-o", str(tmp_path / f"best.{kind}")]) == 0
    assert (tmp_path / f"best.{kind}").read_bytes().startswith(start)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["t.h5", f"best.{kind}", "best.best.csv"])


def test_csv_of_best_equals_the_frame_exactly(table, tmp_path):
    main(["best", str(table), "-o", str(tmp_path / "best.png")])
    best = analysis.best(analysis.load(table))
    pd.testing.assert_frame_equal(exactly(tmp_path / "best.best.csv"), best, check_dtype=False)


def test_csv_of_map_equals_the_frame_exactly(table, tmp_path):
    main(["map", str(table), "-o", str(tmp_path / "map.png"), "--at", "M_over_M0=2", "V_over_V0=10"])
    read = exactly(tmp_path / "map.map.csv")
    plane = analysis.plane(analysis.load(table), at={"M_over_M0": 2, "V_over_V0": 10})
    assert list(read.columns) == COLUMNS
    pd.testing.assert_frame_equal(read, plane, check_dtype=False)


def test_best_ends_with_the_lowest_ratio_and_the_paths(table, tmp_path, capsys):
    picture = tmp_path / "best.png"
    main(["best", str(table), "-o", str(picture)])
    lowest, *paths = capsys.readouterr().out.splitlines()[-4:]
    top = analysis.best(analysis.load(table)).sort_values("ke_ratio").iloc[0]
    assert f"ke_ratio = {top['ke_ratio']:.4g} (estimated error 0.0001 relative)" in lowest
    assert "at N = 100, zeta_T = 0.01, M/M0 = 1, V/V0 = 10" in lowest
    assert [line.split()[-1] for line in paths] == [str(table), str(picture), str(tmp_path / "best.best.csv")]


def test_counts_of_a_half_finished_table_are_right(tmp_path, capsys):
    data = rows()
    data["status"][:5] = b"pending"
    data["status"][5:7] = b"failed"
    data["ke_ratio"][-1] = np.nan
    seal(data)
    data["ke_ratio"][-2] = 7.0  # torn
    table = write(tmp_path / "t.h5", data)
    assert main(["best", str(table), "-o", str(tmp_path / "best.png")]) == 0
    told, used, cells = capsys.readouterr().out.splitlines()[:3]
    assert told.split(maxsplit=1)[1] == "72: 64 done, 2 failed, 5 pending, 1 torn"
    # zeta_T = 0: at N = 5 all six are unfinished, at N = 20 two of six chaotic, at N = 100 all are.
    assert used.startswith("used      61 finished rows; left out: 1 without ke_ratio, 2 chaotic")
    assert cells == "cells     11 of 12 have a number; hatched: 1 cell with chaotic rows only"


def test_cells_of_a_line_that_is_wholly_to_come_are_counted_as_lacking(tmp_path, capsys):
    data = rows()
    data["status"][data["zeta_T"] == 1e-2] = b"pending"
    seal(data)
    table = write(tmp_path / "t.h5", data)
    for command, more in (("best", []), ("map", ["--at", "M_over_M0=2", "V_over_V0=10"])):
        assert main([command, str(table), "-o", str(tmp_path / f"{command}.png"), *more]) == 0
        assert "9 of 12 have a number" in capsys.readouterr().out


def test_a_table_that_was_not_checked_is_told_without_a_count_of_chaos(tmp_path, capsys):
    data = rows()
    data["chaotic"], data["checked"], data["error"] = False, False, np.nan
    seal(data)
    table = write(tmp_path / "t.h5", data)
    for command, more in (("best", []), ("map", MAP_AT), ("transition", []), ("collapse", []), ("findings", None)):
        picture = [] if more is None else ["-o", str(tmp_path / f"{command}.png"), *more]
        assert main([command, str(table), *picture]) == 0
        out = capsys.readouterr().out
        assert "not checked for chaos" in out
        assert not re.search(r"\b0 chaotic|chaotic, left out: 0", out), command
        assert " to " not in out.partition("optimum")[2].partition("\n")[0]


def test_lower_chaotic_cells_are_told_and_do_not_win(tmp_path, capsys):
    data = rows()
    data["ke_ratio"][(data["N"] == 100) & (data["zeta_T"] == 0)] = 1e-6
    seal(data)
    table = write(tmp_path / "t.h5", data)
    main(["best", str(table), "-o", str(tmp_path / "best.png")])
    chaotic, lowest = capsys.readouterr().out.splitlines()[-5:-3]
    assert chaotic.startswith("chaotic   1 cell is lower, down to ke_ratio = 1e-06")
    assert lowest.startswith("lowest")
    assert "1e-06" not in lowest


def test_hatched_cells_are_told_as_they_are_chosen(table, tmp_path, capsys):
    """Two cells have chaotic rows beside others, their lowest among them; one has chaotic rows only."""
    for more, told in (
        ([], "1 cell with chaotic rows only"),
        (["--chaotic-too"], "3 cells whose lowest row is chaotic"),
    ):
        assert main(["best", str(table), "-o", str(tmp_path / "best.png"), *more]) == 0
        assert f"hatched: {told}\n" in capsys.readouterr().out


def test_table_of_chaotic_rows_only_is_drawn_and_says_so(tmp_path, capsys):
    data = rows()
    data["chaotic"] = True
    seal(data)
    table = write(tmp_path / "t.h5", data)
    assert main(["best", str(table), "-o", str(tmp_path / "best.png")]) == 0
    assert "chaotic: sensitive to its inputs) at N = " in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(
    "grid",
    [
        ((200,), (4e-4,), (2.0,), (2.0,)),
        ((200,), (0.0,), (2.0,), (2.0,)),
        ((200,), GRID[1], (2.0,), (2.0,)),
        (GRID[0], (0.0,), (2.0,), (2.0,)),
        (range(5, 35), np.r_[0, np.logspace(-5, 0, 40)], (2.0,), (2.0,)),
    ],
)
@pytest.mark.parametrize("command", ["best", "map"])
def test_single_values_and_zero_damping_are_drawn(tmp_path, grid, command):
    table = write(tmp_path / "t.h5", rows(grid))
    assert main([command, str(table), "-o", str(tmp_path / "a.png")]) == 0
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_map_over_impacts_is_drawn(table, tmp_path):
    over = ["--over", "M_over_M0,V_over_V0", "--at", "N=20", "--at", "zeta_T=0"]
    assert main(["map", str(table), "-o", str(tmp_path / "a.svg"), *over]) == 0
    assert len(pd.read_csv(tmp_path / "a.map.csv")) == 6


def test_map_says_how_many_cells_it_lacks(tmp_path, capsys):
    data = rows((GRID[0], GRID[1], (2.0,), (2.0,)))
    data["status"][7] = b"failed"
    data["ke_ratio"][10] = np.nan
    seal(data)
    assert main(["map", str(write(tmp_path / "t.h5", data)), "-o", str(tmp_path / "a.png")]) == 0
    told = capsys.readouterr().out.splitlines()[:2]
    hatched = "hatched: 1 of 10 cells, chaotic: sensitive to their inputs"
    assert told == ["rows      12: 11 done, 1 failed", f"cells     10 of 12 have a number; {hatched}"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_same_table_gives_the_same_files(table, tmp_path, kind):
    made = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        main(["best", str(table), "-o", str(tmp_path / name / f"best.{kind}")])
        made.append([path.read_bytes() for path in sorted((tmp_path / name).iterdir())])
    assert made[0] == made[1]


def test_drawing_leaves_the_settings_of_matplotlib_alone(table, tmp_path):
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 31, "savefig.dpi": 17}):
        before = dict(mpl.rcParams)
        main(["best", str(table), "-o", str(tmp_path / "best.png")])
        assert dict(mpl.rcParams) == before


def test_transition_and_collapse_say_how_many_rows_they_used(table, tmp_path, capsys):
    chaotic = "0 failed, 10 chaotic"
    for command, left_out in (("transition", chaotic), ("collapse", f"{chaotic}, 8 without damping")):
        assert main([command, str(table), "-o", str(tmp_path / f"{command}.png")]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == "rows      72: 72 done"
        assert lines[1].endswith(f"left out: {left_out}")
        assert (tmp_path / f"{command}.{command}.csv").exists()


def test_every_file_of_commands_is_a_command():
    files = {path.stem for path in Path(commands.__file__).parent.glob("*.py")}
    assert files - {"__init__", "common"} == set(COMMANDS)


@pytest.mark.slow
def test_module_runs_as_a_command(table, tmp_path):
    command = [sys.executable, "-m", "analysis", "best", str(table), "-o", str(tmp_path / "best.png")]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-2].endswith("best.png")
    command[4] = "none.h5"
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "analysis: there is no table none.h5\n")
