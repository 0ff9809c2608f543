"""The commands and the Python that the README shows run as they stand, and none of them takes a file away."""

import hashlib
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from analysis.cli import parser

from .conftest import clean_environment
from .test_analysis_cli import rows, write

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
COMMANDS = ("sweep", "mpirun", "analysis", ".")
MADE = {  # what each line is there for
    "mpirun -n 2 sweep run jobs/quick.toml -o quick.h5": ["quick.h5"],
    "sweep export quick.h5 -o quick.csv": ["quick.csv"],
    "analysis best quick.h5 -o quick.png": ["quick.png", "quick.best.csv"],
    "analysis transition quick.h5 -o N.png": ["N.png", "N.transition.csv"],
    "analysis collapse quick.h5 -o Pi.png": ["Pi.png", "Pi.collapse.csv"],
}


def block():
    """The lines of the first shell block of "A sweep", as they stand."""
    text = README.partition("## A sweep")[2]
    lines = text.partition(". .venv/bin/activate")[2].split("\n\n")[0].splitlines()[1:]
    return [line.strip() for line in lines]


def files(folder):
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.iterdir()
        if path.is_file() and not path.name.startswith(".")
    }


def python_block():
    """The Python of the same section, as it stands."""
    text = README.partition("## A sweep")[2].partition("In Python:\n\n")[2].partition("\n\n")[0]
    return textwrap.dedent(text)


def test_the_python_runs_from_top_to_bottom(tmp_path, monkeypatch):
    write(tmp_path / "quick.h5", rows())
    monkeypatch.chdir(tmp_path)
    found = {}
    exec(compile(python_block(), "README.md", "exec"), found)
    assert found["r"].status == "done"
    assert len(found["df"]) == len(rows())


def test_every_command_in_the_text_is_in_the_grammar(capsys):
    shown = re.findall(r"`(analysis [a-z]+ [^`]*)`", README)
    assert any(command.startswith("analysis atlas ") for command in shown)
    for command in shown:
        assert callable(parser().parse_args(shlex.split(command)[1:]).command)


@pytest.mark.mpi
def test_the_block_of_commands_runs_from_top_to_bottom_and_every_file_it_made_is_still_there(tmp_path):
    shutil.copytree(ROOT / "jobs", tmp_path / "jobs", symlinks=True)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    lines, before = block(), dict[str, str]()
    assert len(lines) >= 11
    assert all(line.split()[0] in COMMANDS for line in lines)
    for line in lines:
        script = f". .venv/bin/activate\n{line}\n"
        done = subprocess.run(
            ["bash", "-ec", script], cwd=tmp_path, env=clean_environment(), capture_output=True, text=True, timeout=240
        )
        assert done.returncode == 0, (line, done.stderr)
        assert "Traceback" not in done.stderr
        after = files(tmp_path)
        assert before.items() <= after.items(), f"{line!r} changed a file that was there"
        made = next((names for start, names in MADE.items() if line.startswith(start)), [])
        assert set(made) <= set(after) - set(before), f"{line!r} did not make {made}"
        before = after
    assert set().union(*MADE.values()) <= set(before)


@pytest.mark.mpi
def test_the_map_over_spring_laws_is_made_by_the_spec_and_the_commands_shown(tmp_path):
    shown = README.partition("analysis map laws.h5")[2].partition("\n\n")[2].split("\n\n")[0]
    keys = [re.sub(r"\s+", " ", line.partition("#")[0]).strip() for line in shown.splitlines()]
    spec = {
        re.sub(r"\s+", " ", line.partition("#")[0]).strip()
        for line in (ROOT / "jobs/laws.toml").read_text().splitlines()
    }
    assert len(keys) == 4
    assert set(keys) <= spec
    shutil.copytree(ROOT / "jobs", tmp_path / "jobs", symlinks=True)
    draw = re.search(r"`(analysis map laws.h5 [^`]*)`", README)
    lines = ["sweep run jobs/laws.toml -o laws.h5", draw[1]]
    for line in map(str.split, lines):
        command = [str(Path(sys.prefix) / "bin" / line[0]), *line[1:]]
        done = subprocess.run(
            command, cwd=tmp_path, env=clean_environment(), capture_output=True, text=True, timeout=240
        )
        assert done.returncode == 0, (line, done.stderr)
    assert "130 of 130 have a number" in done.stdout
    assert (tmp_path / "laws.png").stat().st_size > 10_000
