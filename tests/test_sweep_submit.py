"""The script that submit writes is the one in jobs, with this sweep's names and settings."""

import errno
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep import cli
from sweep.site.slurm import Slurm, notice, render

JOBS = Path(__file__).parent.parent / "jobs"


def options(text: str) -> dict[str, str]:
    lines = (line.removeprefix("#SBATCH --") for line in text.splitlines() if line.startswith("#SBATCH"))
    return {name: value for name, _, value in (line.partition("=") for line in lines)}


def test_the_script_in_jobs_is_what_submit_starts_from():
    assert (JOBS / "sweep.sbatch").read_text() == render({}, {})


def test_a_copy_of_the_folder_jobs_is_whole(tmp_path):
    """As `cp -r` and archives make it, which keep links: none may lead out of it."""
    shutil.copytree(JOBS, tmp_path / "jobs", symlinks=True)
    copied = [path for path in (tmp_path / "jobs").rglob("*") if not path.is_dir()]
    assert not [path for path in copied if path.is_symlink()]
    assert (tmp_path / "jobs" / "sweep.sbatch").read_text() == render({}, {})


def test_without_sbatch_the_script_is_written_and_submit_says_so(sweep, small_spec, environment, tmp_path):
    answer = sweep("submit", small_spec, env=environment | {"PATH": ""})
    assert answer.returncode == 0
    assert answer.stdout == (
        "wrote small.sbatch; no sbatch here: where there is one, run sbatch --parsable small.sbatch\n"
    )
    told = options((tmp_path / "small.sbatch").read_text())
    assert (told["job-name"], told["ntasks"], told["time"]) == ("small", "1", "0:11:00")


def test_an_array_tells_how_to_merge(sweep, small_spec, environment):
    answer = sweep("submit", small_spec, "-o", "t.h5", "--array", "2", env=environment | {"PATH": ""})
    assert "merge" in answer.stdout
    assert "t-1-of-2.h5" in answer.stdout
    assert "t-2-of-2.h5" in answer.stdout


def test_a_dry_run_prints_the_script_and_writes_nothing(sweep, small_spec, tmp_path):
    command = ("--ranks", 8, "--time", "1-00", "--partition", "p", "--account", "a", "--sbatch=--mem=4G", "--dry-run")
    answer = sweep("submit", small_spec, *command)
    told = options(answer.stdout)
    assert (told["ntasks"], told["time"], told["partition"], told["account"]) == ("8", "1-00", "p", "a")
    assert (told["mem"], told["signal"]) == ("4G", "B:USR1@300")
    assert list(tmp_path.iterdir()) == [small_spec]
    subprocess.run(["bash", "-n"], input=answer.stdout, text=True, check=True, timeout=60)


@pytest.mark.parametrize("more", [[], ["--dry-run"]])
def test_a_table_in_a_folder_that_is_not_there_is_refused_before_the_job_waits(sweep, small_spec, tmp_path, more):
    answer = sweep("submit", small_spec, "-o", "no/t.h5", "--ranks", "0", *more)
    assert (answer.returncode, answer.stdout) == (2, "")
    assert answer.stderr.splitlines() == [
        "sweep: --output: there is no directory 'no' to write 't.h5' in",
        "sweep: --ranks: must be at least 1, got 0",
    ]
    assert list(tmp_path.iterdir()) == [small_spec]


def test_a_dry_run_of_an_array_shows_the_job_that_merges_its_tables_too(sweep, small_spec, tmp_path):
    odd = tmp_path / "it's.h5"
    shown = sweep("submit", small_spec, "-o", odd, "--array", 2, "--time", "9", "--partition", "p", "--dry-run").stdout
    comment = shown.splitlines()[-1]
    command = shlex.split(comment.removeprefix("#"))
    assert command[:2] == ["sbatch", "--parsable"]
    assert {"--dependency=afterany:ARRAY_JOB", "--partition=p", "--job-name=small-merge"} <= set(command)
    merge = shlex.split(command[-1].removeprefix("--wrap="))
    tables = [str(tmp_path / f"it's-{k}-of-2.h5") for k in (1, 2)]
    assert merge[1:] == ["merge", *tables, "-o", str(odd)]
    subprocess.run(["bash", "-n"], input=shown, text=True, check=True, timeout=60)
    assert list(tmp_path.iterdir()) == [small_spec]


def test_names_with_spaces_and_quotes_stay_whole(sweep, small_spec, tmp_path):
    odd = small_spec.rename(tmp_path / "it's a $spec.toml")
    answer = sweep("submit", odd, "-o", "a b.h5", "--ranks", 2, "--time", "9", "--dry-run")
    names = [line for line in answer.stdout.splitlines() if line.startswith(("spec=", "table="))]
    shown = subprocess.run(
        ["bash", "-c", "\n".join([*names, 'printf "%s\\n" "$spec" "$table"'])],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert shown.stdout.splitlines() == [str(odd), str(tmp_path / "a b.h5")]


LONG = """name = "long"
[grid]
N = [10000]
zeta_T = [0, 1e-3, 10]
M_over_M0 = [0.01, 100]
V_over_V0 = [20]
[accuracy]
target = 1e-8
[model]
t_end = 1000
"""


@pytest.mark.parametrize("name", ["SLURM", "PBS", "LSF"])
def test_no_more_ranks_than_tasks_are_asked_for_and_a_limit_that_no_task_ends_in_is_told(tmp_path, capsys, name):
    spec = tmp_path / "long.toml"
    spec.write_text(LONG)
    assert cli.main(["submit", str(spec), "--scheduler", name, "--dry-run"]) == 0
    said = capsys.readouterr()
    assert re.search(r"--ntasks=6$|select=6:|-n 6$", said.out, re.MULTILINE)
    assert re.search(
        r"--time: 12:00\S* is shorter than the longest task, which is predicted to take \d\S* d$", said.err
    )


def test_a_script_that_was_edited_is_not_overwritten(sweep, small_spec, environment, tmp_path):
    command = ("submit", small_spec, "--ranks", 2, "--time", "9")
    assert sweep(*command, env=environment | {"PATH": ""}).returncode == 0
    assert sweep(*command, env=environment | {"PATH": ""}).returncode == 0
    (tmp_path / "small.sbatch").write_text("mine")
    answer = sweep(*command, env=environment | {"PATH": ""})
    assert answer.returncode == 2
    assert "small.sbatch: exists and says something else" in answer.stderr
    assert (tmp_path / "small.sbatch").read_text() == "mine"


@pytest.mark.parametrize(("name", "ending"), [("SLURM", "sbatch"), ("ssh", "sh")])
def test_of_a_script_that_finds_no_room_nothing_is_left_and_one_that_is_there_stays(
    small_spec, tmp_path, monkeypatch, capsys, name, ending
):
    def full(path, *_):
        path.write_bytes(b"#!/bin")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    command = ["submit", str(small_spec), "--scheduler", name]
    script = tmp_path / f"small.{ending}"
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        assert cli.main(command) == 2
        assert capsys.readouterr().err == f"sweep: small.{ending}: cannot be written: No space left on device\n"
        assert not script.exists()
    assert cli.main(command) == 0
    whole = script.read_text()
    monkeypatch.setattr(Path, "write_text", full)
    assert cli.main(command) == 0
    assert script.read_text() == whole


@pytest.mark.parametrize(
    ("name", "command"),
    [("LSF", "bash -c 'bsub < small.lsf'"), ("PBS", "qsub -J 1-2 small.pbs"), ("ssh", "bash -c 'setsid nohup bash -c")],
)
def test_where_its_command_is_not_there_it_is_told_how_to_submit_by_hand(
    small_spec, tmp_path, monkeypatch, capsys, name, command
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    assert cli.main(["submit", str(small_spec), "--scheduler", name, "--array", "2"]) == 0
    assert f" here: where there is one, run {command}" in capsys.readouterr().out


def test_what_more_follows_from_is_no_further_option_of_sbatch(sweep, small_spec):
    """The signal before the limit was that of another limit."""
    wrong = ("--sbatch=--time=3", "--sbatch=--ntasks=8", "--sbatch=--array=1-4", "--sbatch=--time-min=3", "--dry-run")
    answer = sweep("submit", small_spec, "--scheduler", "SLURM", *wrong)
    assert answer.returncode == 2
    assert answer.stderr.splitlines() == [
        f"sweep: --sbatch: must be given to sweep submit, as {ours}, got {given!r}"
        for ours, given in (("--time", "--time=3"), ("--ranks", "--ntasks=8"), ("--array", "--array=1-4"))
    ]


def test_every_wrong_option_is_told_at_once(sweep, small_spec, tmp_path):
    wrong = ("--ranks", 0, "--array", 25, "--time", "soon", "--partition", "a b", "--sbatch", "mem=4G")
    answer = sweep("submit", small_spec, *wrong)
    assert answer.returncode == 2
    assert [line.split(":")[1] for line in answer.stderr.splitlines()] == [
        " --ranks",
        " --array",
        " --sbatch",
        " --partition",
        " --time",
    ]
    assert list(tmp_path.iterdir()) == [small_spec]


@pytest.mark.parametrize(
    ("time", "seconds"),
    [("90", 5400), ("1:30", 90), ("1:02:03", 3723), ("2-00", 172800), ("1-02:03", 93780), ("1-02:03:04", 93784)],
)
def test_times_are_read_as_slurm_reads_them(time, seconds):
    assert Slurm().seconds_of(time) == seconds


@given(st.floats(1, 1e7))
def test_a_time_is_written_in_whole_minutes_and_never_too_short(seconds):
    assert seconds <= Slurm().seconds_of(Slurm().time_of(seconds)) < seconds + 60.001


@pytest.mark.parametrize(("time", "seconds"), [("1", 15), ("10", 150), ("20", 300), ("12:00:00", 300)])
def test_a_short_job_is_told_to_stop_at_three_quarters(time, seconds):
    assert notice(Slurm().seconds_of(time)) == seconds


@pytest.mark.parametrize(("said", "told"), [(0, 75), (10, 75), (75, 75), (1, 1), (2, 2)])
def test_a_job_that_was_told_to_stop_goes_on_unless_its_launcher_says_why_not(environment, tmp_path, said, told):
    launcher = tmp_path / "sweep"  # one that has passed a signal on says now this, now that
    launcher.write_text(f"#!/bin/sh\ntrap 'exit {said}' USR1\nwhile kill -USR1 $PPID; do sleep 0.1; done\n")
    launcher.chmod(0o755)
    command = ["bash", JOBS / "sweep.sbatch", "spec.toml", "t.h5"]
    job = environment | {"SWEEP_BIN": str(tmp_path), "SLURM_JOB_ID": "1", "SLURM_RESTART_COUNT": "20"}
    assert subprocess.run(command, cwd=tmp_path, env=job, timeout=60, check=False).returncode == told
