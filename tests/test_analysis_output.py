"""No file that the command line did not name is replaced, nor one that was not left there by this program."""

import errno
import os
import subprocess
import sys

import pandas as pd
import pytest

from analysis.cli import main
from analysis.output import output
from sweep.errors import InputError

from .conftest import BIN
from .test_analysis_cli import rows, write
from .test_analysis_refusals import refused

USERS = "raise SystemExit('this file is the user\\'s own')\n"


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "t.h5", rows())


AT = ["--at", "M_over_M0=2", "V_over_V0=10"]


def drawn(command, table, picture, *more):
    """The exit status of a drawing command."""
    return main([command, str(table), "-o", str(picture), *(AT if command == "map" else []), *more])


def test_no_other_command_writes_a_file_of_the_name_that_the_numbers_get(table, tmp_path):
    (tmp_path / "a.csv").write_text("precious")
    made = {}
    for command in ("best", "map", "collapse", "transition"):
        assert drawn(command, table, tmp_path / f"a.{'png' if command == 'best' else 'svg'}") == 0
        made[command] = (tmp_path / f"a.{command}.csv").read_bytes()
    assert (tmp_path / "a.csv").read_text() == "precious"
    assert len(set(made.values())) == 4


@pytest.mark.slow
def test_one_command_may_draw_in_several_formats_and_again(table, tmp_path):
    assert [drawn("best", table, tmp_path / f"a.{kind}") for kind in ("png", "svg", "pdf", "PNG", "png")] == [0] * 5


@pytest.mark.slow
def test_commands_may_take_turns_at_one_picture(table, tmp_path):
    turns = ("best", "collapse", "transition", "best", "collapse", "best")
    assert [drawn(command, table, tmp_path / "a.png") for command in turns] == [0] * 6


def test_what_was_edited_is_not_taken_over_as_ours_by_another_commands_picture(table, tmp_path):
    drawn("best", table, tmp_path / "a.png")
    (tmp_path / "a.best.csv").write_text("mine")
    assert drawn("collapse", table, tmp_path / "a.png") == 0
    assert drawn("best", table, tmp_path / "a.png") == 2
    assert (tmp_path / "a.best.csv").read_text() == "mine"


def test_numbers_whose_picture_is_gone_are_kept_unless_forced(table, tmp_path):
    drawn("best", table, tmp_path / "a.png")
    (tmp_path / "a.png").unlink()
    assert drawn("best", table, tmp_path / "a.png") == 2
    assert not (tmp_path / "a.png").exists()
    assert drawn("best", table, tmp_path / "a.png", "--force") == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_the_same_command_simply_runs_again(table, tmp_path, kind):
    arguments = ["best", str(table), "-o", str(tmp_path / f"a.{kind}")]
    assert [main(arguments), main(arguments)] == [0, 0]


@pytest.mark.parametrize("name", ["a.png", "a.best.csv"])
def test_a_file_that_is_not_ours_is_kept_unless_forced(table, tmp_path, capsys, name):
    (tmp_path / name).write_text("precious")
    arguments = ["best", str(table), "-o", str(tmp_path / "a.png")]
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert name in told
    assert "--force" in told
    assert (tmp_path / name).read_text() == "precious"
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["t.h5", name])
    assert main([*arguments, "--force"]) == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_numbers_that_were_edited_since_are_kept_unless_forced(table, tmp_path):
    arguments = ["best", str(table), "-o", str(tmp_path / "a.png")]
    main(arguments)
    numbers = tmp_path / "a.best.csv"
    numbers.write_text(numbers.read_text() + "mine\n")
    assert main(arguments) == 2
    assert numbers.read_text().endswith("mine\n")
    assert main([*arguments, "--force"]) == 0
    assert len(pd.read_csv(numbers)) == 12


def test_a_picture_of_another_command_is_ours_but_its_numbers_stay(table, tmp_path):
    main(["best", str(table), "-o", str(tmp_path / "a.png")])
    before = (tmp_path / "a.best.csv").read_bytes()
    assert main(["collapse", str(table), "-o", str(tmp_path / "a.png")]) == 0
    assert (tmp_path / "a.best.csv").read_bytes() == before


def test_the_page_replaces_nothing_of_the_users(tmp_path, monkeypatch, capsys):
    from .paper_source import JOBS

    monkeypatch.chdir(tmp_path)
    (tmp_path / "tables").mkdir()
    (tmp_path / "page").mkdir()
    (tmp_path / "page/fig4.png").write_text("precious")
    (tmp_path / "page/convention.paper.csv").write_text("precious")
    arguments = ["paper", "-o", "page.html", "--tables", "tables", "--jobs", str(JOBS)]
    assert main(arguments) == 2
    told = capsys.readouterr().err.splitlines()
    assert ["fig4.png" in told[0], "convention.paper.csv" in told[1]] == [True, True]
    (tmp_path / "page.html").write_text("precious")
    assert main(arguments) == 2
    assert "page.html is not as this program left it" in capsys.readouterr().err


def test_output_names_both_files_that_are_in_the_way(tmp_path):
    for name in ("a.png", "a.best.csv"):
        (tmp_path / name).write_text("precious")
    with pytest.raises(InputError, match=r"a\.png and .*a\.best\.csv are not as"):
        output(tmp_path / "a.png", "best")


@pytest.mark.parametrize(
    ("error", "told"),
    [(OSError(errno.ENOSPC, "No space left on device"), "No space left on device"), (OSError("gone"), "gone")],
)
def test_full_disk_leaves_the_earlier_picture_and_csv(table, tmp_path, capsys, monkeypatch, error, told):
    (tmp_path / "a.png").write_text("earlier picture")
    (tmp_path / "a.best.csv").write_text("earlier numbers")

    def full(figure, path, *_):
        path.write_bytes(b"half a pict")
        raise error

    monkeypatch.setattr("analysis.output.save", full)
    refused(["best", str(table), "--force", "-o", str(tmp_path / "a.png")], f"a.best.csv: {told}", capsys)
    assert (tmp_path / "a.png").read_text() == "earlier picture"
    assert (tmp_path / "a.best.csv").read_text() == "earlier numbers"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.best.csv", "a.png", "t.h5"]


def test_a_full_disk_is_told_with_the_name_of_the_page(table, tmp_path, capsys, monkeypatch):
    def full(path, *_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    page = tmp_path / "t.html"
    refused(["page", str(table), "-o", str(page)], f"cannot write {page}: No space left on device", capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_a_disk_that_has_no_room_for_the_whole_picture_is_one_line(table, tmp_path, ending):
    limited = ["bash", "-c", 'ulimit -f 8 && exec "$@"', "bash", BIN / "analysis", "best", "t.h5", "-o", f"a.{ending}"]
    done = _run(tmp_path, *limited)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.endswith(f"cannot write a.{ending} and a.best.csv: File too large\n")
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def _run(folder, *command):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)


@pytest.mark.slow
def test_the_script_is_ours_whatever_python_files_lie_in_the_folder(table, tmp_path):
    for name in ("analysis", "kernel", "sweep", "random"):
        (tmp_path / f"{name}.py").write_text(USERS)
    done = _run(tmp_path, BIN / "analysis", "best", "t.h5", "-o", "a.png")
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "a.best.csv").exists()


@pytest.mark.slow
def test_the_module_is_ours_but_for_a_users_file_of_its_very_name(table, tmp_path):
    for name in ("kernel", "sweep", "random"):
        (tmp_path / f"{name}.py").write_text(USERS)
    done = _run(tmp_path, sys.executable, "-m", "analysis", "best", "t.h5", "-o", "a.png")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
def test_a_program_of_the_users_own_that_imports_it_finds_its_files_as_before(tmp_path):
    program = "import sys; before = [*sys.path]; import analysis; sys.exit(sys.path != before)"
    assert _run(tmp_path, sys.executable, "-c", program).returncode == 0


@pytest.mark.slow
def test_a_reader_that_leaves_gets_no_traceback(table, tmp_path):
    command = [BIN / "analysis", "best", "t.h5", "-o", "a.png"]
    read, write_end = os.pipe()
    os.close(read)
    done = subprocess.run(command, cwd=tmp_path, stdout=write_end, stderr=subprocess.PIPE, text=True, timeout=120)
    os.close(write_end)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.slow
def test_the_script_tells_its_version_and_what_a_mistyped_word_may_have_meant(tmp_path):
    assert _run(tmp_path, BIN / "analysis", "--version").stdout.startswith("analysis ")
    assert "'collapse'" in _run(tmp_path, BIN / "analysis", "colapse", "t.h5").stderr
    assert "--limits" in _run(tmp_path, BIN / "analysis", "best", "t.h5", "-o", "a.png", "--limit", "1,2").stderr
