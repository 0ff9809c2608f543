"""Bad tables, arguments and paths: one line, exit status 2, no file."""

import os

import h5py
import numpy as np
import pandas as pd
import pytest

from analysis.at import pairs
from analysis.cli import main
from sweep.errors import InputError
from sweep.schema import seal

from .test_analysis_cli import GRID, rows, write


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "t.h5", rows())


def _no_columns(path):
    write(path, np.zeros(3, [("N", "i4"), ("ke_ratio", "f8")]))


def _nothing_finished(path):
    data = rows()
    data["status"] = b"pending"
    seal(data)
    write(path, data)


def _no_ratio(path):
    data = rows(((5,), (0.0,), (2.0,), (2.0,)))
    data["ke_ratio"] = np.nan
    seal(data)
    write(path, data)


def test_a_column_that_is_needed_itself_is_not_what_another_was_meant_by(tmp_path, capsys):
    """V_over_V0 was taken for a misspelt M_over_M0, which was there."""
    path = tmp_path / "t.csv"
    pd.DataFrame({"N": [5], "zeta_T": [0.0], "M_over_M0": [1.0], "ke_ratio": [0.5], "error": [0.1]}).to_csv(path)
    assert main(["map", str(path), "-o", str(tmp_path / "a.png")]) == 2
    told = capsys.readouterr().err
    assert "V_over_V0" in told
    assert "did you mean" not in told


def test_spaces_about_the_sign_of_a_fixed_value_name_no_parameter():
    with pytest.raises(InputError) as caught:
        pairs(["N", "=", "147"])
    assert [line.partition(":")[0] for line in caught.value.problems] == ["--at N", "--at =", "--at 147"]


BAD_TABLES = [
    (lambda path: None, "there is no table"),
    (lambda path: path.mkdir(), "is a directory"),
    (lambda path: path.write_text("no table"), "is a text file, not a table"),
    (lambda path: h5py.File(path, "w").close(), "no dataset /results"),
    (_no_columns, "lacks the columns zeta_T, M_over_M0, V_over_V0, ke_bistable"),
    (_nothing_finished, "no finished row (72 pending)"),
    (_no_ratio, "has a ke_ratio"),
]
BAD_ARGUMENTS = [
    (["map", "-o", "a.png", "--over", "N,mass"], "unknown parameters mass"),
    (["map", "-o", "a.png", "--over", "N"], "two different parameters"),
    (["map", "-o", "a.png", "--at", "mass=1"], "unknown parameters mass"),
    (["map", "-o", "a.png", "--at", "M_over_M0"], "write NAME=VALUE"),
    (["map", "-o", "a.png", "--at", "M_over_M0=two"], "write NAME=VALUE"),
    (["map", "-o", "a.png", "--at", "M_over_M0=2", "M_over_M0=1"], "gives M_over_M0 twice"),
    (["map", "-o", "a.png", "--at", "M_over_M0=3"], "there is 0.1, 1, 2"),
    (["map", "-o", "a.png", "--at", "N=5"], "N cannot be fixed"),
    (["map", "-o", "a.png"], "choose a value of M_over_M0 (there is 0.1, 1, 2) and of V_over_V0"),
    (["best", "-o", "a.jpg"], "a picture ends in .png, .pdf, .svg"),
    (["best", "-o", "a"], "a picture ends in"),
    (["best", "-o", "none/a.png"], "there is no directory"),
    (["best", "-o", "t.h5/a.png"], "there is no directory"),
    (["best", "-o", "folder.png"], "is a directory"),
    (["best", "-o", "data.png"], "data.best.csv is a directory"),
    (["best", "-o", "/proc/a.png"], "writ"),
    (["best", "-o", "a" * 300 + ".png"], "name too long"),
]


def refused(arguments, told, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("analysis: ")
    assert told in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("command", ["best", "map", "transition", "collapse"])
@pytest.mark.parametrize(("make", "told"), BAD_TABLES)
def test_bad_table_exits_2_with_one_line_and_leaves_no_file(tmp_path, capsys, command, make, told):
    make(tmp_path / "t.h5")
    before = sorted(tmp_path.iterdir())
    refused([command, str(tmp_path / "t.h5"), "-o", str(tmp_path / "a.png")], told, capsys)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("command", ["best", "map", "points", "transition", "level", "collapse", "findings", "page"])
def test_an_export_without_rows_is_told_as_that(tmp_path, capsys, command):
    pd.DataFrame(columns=rows().dtype.names).to_csv(tmp_path / "t.csv", index_label="task")
    out = [] if command == "findings" else ["-o", str(tmp_path / ("a.html" if command == "page" else "a.png"))]
    refused([command, str(tmp_path / "t.csv"), *out], "t.csv has no finished row (no rows at all)", capsys)


@pytest.mark.parametrize("name", ["pipe.h5", "pipe.csv"])
@pytest.mark.parametrize("command", ["best", "points", "findings", "page"])
def test_a_pipe_is_no_table_and_is_not_opened(tmp_path, capsys, monkeypatch, command, name):
    def waits(*_, **__):
        raise AssertionError("whoever opens a pipe waits for ever")

    for module, opens in ((h5py, "File"), (h5py, "is_hdf5"), (pd, "read_csv")):
        monkeypatch.setattr(module, opens, waits)
    os.mkfifo(tmp_path / name)
    out = [] if command == "findings" else ["-o", str(tmp_path / ("a.html" if command == "page" else "a.png"))]
    refused([command, str(tmp_path / name), *out], "is a device or pipe, not a table", capsys)


@pytest.mark.parametrize(("arguments", "told"), BAD_ARGUMENTS)
def test_bad_argument_exits_2_with_one_line_and_leaves_no_file(table, tmp_path, capsys, monkeypatch, arguments, told):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "data.best.csv").mkdir()
    before = sorted(tmp_path.iterdir())
    monkeypatch.chdir(tmp_path)
    refused([arguments[0], "t.h5", *arguments[1:]], told, capsys)
    assert sorted(tmp_path.iterdir()) == before


ALL_AT_ONCE = [
    (
        ["map", "--at", "M_over_M0=7", "V_over_V0=99", "--limits", "5,1", "--of", "foo", "-o", "none/a.png"],
        [
            "--limits: must",
            "-o: there is no directory",
            "has M_over_M0 = 7;",
            "has V_over_V0 = 99;",
            "of: must be one of",
        ],
    ),
    (
        ["collapse", "--against", "Pi", "--at", "N=7000", "mass=1", "--of", "error", "--dpi", "3", "-o", "a.jpg"],
        [
            "--dpi: must",
            "a.jpg: a picture",
            "--against: invalid choice: 'Pi'",
            "parameters mass;",
            "N = 7000;",
            "of: must be",
        ],
    ),
    (
        ["best", "--over", "a,b", "--of", "error", "-o", "a.jpg"],
        ["a.jpg: a picture", "parameters a, b;", "of: must be"],
    ),
    (["level", "--level", "x", "--of", "foo", "-o", "a.png"], ["--level: invalid float", "lacks the columns foo"]),
    (
        ["transition", "--of", "error", "--at", "N=7000", "-o", "a.jpg"],
        ["a.jpg: a picture", "has N = 7000;", "of: must be"],
    ),
    (
        ["points", "--of", "error", "--at", "N=7000", "-o", "a.jpg"],
        ["a.jpg: a picture", "has N = 7000;", "of: must be"],
    ),
]


@pytest.mark.parametrize(("arguments", "told"), ALL_AT_ONCE)
def test_all_that_is_wrong_with_options_is_told_at_once(table, tmp_path, capsys, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    assert main([arguments[0], "t.h5", *arguments[1:]]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [one for one, line in zip(told, lines, strict=True) if one not in line] == []
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


ALL_CHAOTIC = ((5, 20, 100), (0.0,), (1.0,), tuple(np.geomspace(0.1, 10, 9)))
CHAOTIC = [("transition", ALL_CHAOTIC, "every finished row is chaotic"), ("collapse", ALL_CHAOTIC, "0 are left")]
ONE_N = [("transition", ((5,), *GRID[1:]), "needs at least 3 different N")]


@pytest.mark.parametrize(("command", "grid", "told"), CHAOTIC + ONE_N)
def test_a_table_that_cannot_tell_exits_2_with_one_line_and_leaves_no_file(tmp_path, capsys, command, grid, told):
    made = write(tmp_path / "t.h5", rows(grid))
    refused([command, str(made), "-o", str(tmp_path / "a.png")], told, capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_table_is_never_overwritten_by_its_picture_or_csv(tmp_path, capsys):
    for name in ("x.png", "x.best.csv"):
        path = write(tmp_path / name, rows())
        before = path.read_bytes()
        assert main(["best", str(path), "-o", str(tmp_path / "x.png")]) == 2
        assert "is the table itself" in capsys.readouterr().err
        assert path.read_bytes() == before
        path.unlink()


@pytest.mark.parametrize("arguments", [[], ["draw"], ["best"], ["best", "t.h5"], ["map", "-o", "a.png"]])
def test_usage_error_exits_2(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage: " in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("command", ["best", "map"])
def test_the_table_may_stand_behind_the_values_of_at(table, tmp_path, command, capsys, monkeypatch):
    at = ["--at", "M_over_M0=2", "V_over_V0=10"]
    assert main([command, "-o", str(tmp_path / "a.png"), *at, str(table), "--dpi", "80"]) == 0
    assert main([command, str(table), "-o", str(tmp_path / "b.png"), *at, "--dpi", "80"]) == 0
    capsys.readouterr()
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    refused([command, str(table), "-o", str(tmp_path / "c.png"), "--at", "M_over_M0"], "NAME=VALUE", capsys)
    (tmp_path / "N").touch()
    monkeypatch.chdir(tmp_path)
    refused([command, str(table), "-o", "c.png", "--at", "N"], "NAME=VALUE", capsys)
    (tmp_path / "x=1.h5").write_bytes(table.read_bytes())
    assert main([command, "-o", "c.png", *at, "x=1.h5"]) == 0
