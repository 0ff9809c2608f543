"""What the system refuses is one line and exit status 2, what a user interrupts is one line; no pipe is waited for."""

import os
import signal
import subprocess
import sys

import pytest

from sweep import cli, grammar
from sweep.files import HEAD_BYTES, page_problem


@pytest.fixture
def told(capsys, small_spec, tmp_path, monkeypatch):
    """told(*arguments): exit status of `sweep` in tmp_path, and the lines on stderr."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        status = cli.main(list(map(str, arguments)))
        return status, capsys.readouterr().err.splitlines()

    return run


@pytest.fixture
def pipe(tmp_path):
    """A pipe that holds as much as anybody reads of a file, so that who reads it all the same need not wait."""
    os.mkfifo(tmp_path / "pipe.html")
    descriptor = os.open(tmp_path / "pipe.html", os.O_RDWR)
    os.write(descriptor, b" " * HEAD_BYTES)
    yield "pipe.html"
    os.close(descriptor)


@pytest.mark.parametrize("force", [False, True])
def test_a_page_is_not_written_to_a_pipe(tmp_path, pipe, force):
    assert page_problem(tmp_path / pipe, force).endswith("pipe.html is a device or pipe, it cannot be written")


def test_a_pipe_is_not_repaired(told, pipe, tmp_path):
    pipe = (tmp_path / pipe).rename(tmp_path / "pipe.h5").name
    problem = "sweep: pipe.h5: is a device or pipe, not a table"
    assert told("run", "small.toml", "-o", pipe, "--repair") == (2, [problem])


@pytest.mark.parametrize("command", [["run", "small.toml", "-o", "t.h5", "--page"], ["submit", "small.toml", "-o"]])
def test_a_folder_whose_name_is_too_long_is_refused_by_its_option(told, command):
    status, (line,) = told(*command, f"{'x' * 300}/{'p.html' if '--page' in command else 't.h5'}")
    assert status == 2
    assert line.startswith(f"sweep: {'--page' if '--page' in command else '--output'}: 'xxx")
    assert line.endswith("cannot be written: File name too long")


def test_a_file_that_may_not_be_read_is_one_line(unprivileged, small_spec, tmp_path):
    for name, options in (("p.html", ("-o", "new.h5", "--page")), ("t.h5", ("--repair", "-o"))):
        (tmp_path / name).write_text("mine")
        (tmp_path / name).chmod(0o200)
        answer = unprivileged("run", small_spec, *options, name)
        assert (answer.returncode, answer.stderr) == (2, f"sweep: {name}: Permission denied\n")


@pytest.mark.parametrize("command", ["run", "submit", "merge"])
def test_in_a_folder_that_is_gone_a_relative_name_is_one_line(told, small_spec, tmp_path, command):
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    status, lines = told(command, small_spec, "-o", "t.h5")
    assert (status, lines[-1]) == (2, "sweep: the current folder: No such file or directory")


def test_an_error_of_ours_that_names_no_file_is_no_ones_bad_input():
    def work():
        raise OSError("unexpected")

    with pytest.raises(OSError, match="unexpected"):
        grammar.answer("sweep", work, ())


def test_a_ctrl_c_ends_a_command_with_one_line(capsys):
    assert grammar.answer("sweep", lambda: signal.raise_signal(signal.SIGINT), ()) == 130
    assert capsys.readouterr().err == "sweep: interrupted\n"


@pytest.mark.parametrize("closed", ["0<&-", "1>&-", "2>&-", "0<&- 1>&- 2>&-"])
def test_a_stream_that_is_closed_changes_nothing_and_its_number_is_no_files(environment, small_spec, tmp_path, closed):
    # Ends with 10 and the number of the next file that is opened.
    code = "import os, sys, sweep.cli; os._exit(sweep.cli.main(sys.argv[1:]) or 10 + os.open('/', os.O_RDONLY))"
    words = [sys.executable, "-P", "-c", code, "submit", "--dry-run", "--ranks=1", "--time=10", small_spec]
    shell = ["sh", "-c", f'exec "$@" {closed}', "sh", *words]
    assert subprocess.run(shell, cwd=tmp_path, env=environment, timeout=60, check=False).returncode > 12
