"""The name of a file need not be text, nor need the locale know the letters of a text."""

import os
import subprocess
import sys

import pytest

from analysis.cli import main as analysis
from sweep import caller, cli
from sweep.site import doctor, schedulers
from sweep.store import provenance, table

from .conftest import SMALL

BYTES = os.fsdecode(b"t\xff.h5")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """The current folder, with two specs."""
    monkeypatch.chdir(tmp_path)
    for name, steps in ((b"s\xff.toml", "[5, 8]"), (b"other.toml", "[8, 13]")):
        (tmp_path / os.fsdecode(name)).write_text(SMALL.replace("[5, 8, 13]", steps))
    return tmp_path


@pytest.mark.parametrize(("scheduler", "ending"), [("LSF", "lsf"), ("PBS", "pbs"), ("SLURM", "sbatch")])
def test_a_script_holds_names_as_they_are(here, monkeypatch, scheduler, ending):
    monkeypatch.setenv("PATH", "")  # none of the schedulers is asked
    for _ in range(2):  # the second time it is there already, and says the same
        assert cli.main(["submit", os.fsdecode(b"s\xff.toml"), "-o", BYTES, "--scheduler", scheduler]) == 0
    script = here / os.fsdecode(b"t\xff." + ending.encode())
    for name in (b"s\xff.toml", b"t\xff.h5"):
        assert b"/" + name + b"'\n" in script.read_bytes()
    assert str(script) in " ".join(schedulers.chosen(scheduler).submit(script))


def test_what_tells_where_rows_come_from_escapes_what_is_no_text(here, capsys):
    assert cli.main(["run", os.fsdecode(b"s\xff.toml"), "-o", BYTES, "--store", "kept"]) == 0
    assert cli.main(["run", "other.toml", "-o", "other.h5", "--store", "kept"]) == 0
    assert "8 rows taken from the store kept" in capsys.readouterr().err
    assert cli.main(["show", "other.h5"]) == 0
    assert rf"{here}/t\xff.h5" in capsys.readouterr().out
    assert cli.main(["merge", BYTES, "other.h5", "-o", "both.h5"]) == 0
    with table.reading(here / "both.h5") as file:
        known = table.attributes(file)
    assert known["spec"].startswith("# t\\xff.h5\n")
    assert r'"t\\xff.h5"' in known["merged"]


def test_what_another_program_says_need_not_be_text_either(tmp_path, monkeypatch):
    said = r"printf 'fatal: gr\xf6\xdfe\n' >&2"
    (tmp_path / "git").write_text(f"#!/bin/bash\n{said}; exit 128\n")
    (tmp_path / "git").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    assert provenance.collect("", "", tmp_path, "")["git"] == "not in a git checkout"
    assert caller._watched(["bash", "-c", said], tmp_path / "t.h5", False) == (0, ["fatal: gr\ufffd\ufffde"])
    monkeypatch.setattr(doctor.launch, "mpirun", lambda: str(tmp_path / "git"))
    assert doctor._written(tmp_path, 2)[1].endswith("wrote nothing: fatal: gr\ufffd\ufffde")


def test_a_locale_that_knows_ascii_alone_changes_no_text(environment, tmp_path):
    code = """
from sweep import caller
from sweep.store.reuse import entry
with caller._written("gr\\xf6\\xdfe") as file:
    print(ascii(file.read_text("utf-8")))
print(ascii(entry(1, "gr\\xf6\\xdfe", "", "")["hosts"][0].decode()))
"""
    ascii_only = environment | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-P", "-c", code]
    told = subprocess.run(command, cwd=tmp_path, env=ascii_only, capture_output=True, timeout=60, check=True)
    assert told.stdout.split() == [rb"'gr\xf6\xdfe'"] * 2


@pytest.mark.parametrize("name", [b"t\xff.h5", "größe.h5".encode()])
def test_a_page_a_picture_and_an_export_of_a_name_that_need_not_be_text_are_made(here, capsys, name):
    path = os.fsdecode(name)
    assert cli.main(["run", "other.toml", "-o", path]) == 0
    assert cli.main(["export", path, "-o", f"{path}.parquet"]) == 0
    assert analysis(["page", path, "-o", "p.html"]) == 0
    assert name.decode(errors="backslashreplace").replace("\\", "\\\\") in (here / "p.html").read_text("utf-8")
    assert analysis(["tradeoff", path, "-o", "t.svg", "--tasks", "1"]) == 0
    assert analysis(["best", path, "-o", "b.svg", "--title", os.fsdecode("größe".encode())]) == 0
    assert "größe" in (here / "b.svg").read_text("utf-8")
    capsys.readouterr()
    assert analysis(["best", path, "-o", "b.svg", "--title", os.fsdecode(b"\xff")]) == 2
    assert capsys.readouterr().err == "analysis: --title: must be text in UTF-8, got '\\udcff'\n"


def test_a_title_is_read_where_the_locale_knows_ascii_alone(environment, tmp_path):
    code = "import sys; from analysis import options; print(ascii(options._title(sys.argv[1])))"
    ascii_only = environment | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    command = [sys.executable, "-P", "-c", code, "größe"]
    answer = subprocess.run(
        command, env=ascii_only, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=True
    )
    assert answer.stdout == ascii("größe") + "\n"
