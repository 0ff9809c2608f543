"""Another scheduler is one object and its name in one list: everything else asks the object."""

from pathlib import Path

import pytest

import sweep
from sweep import cli
from sweep.site import doctor, launch, schedulers, walltime
from sweep.site.scheduler import Scheduler

NOON = 1_900_000_000.0  # seconds since 1970


class Bell(Scheduler):
    name, command, ending = "BELL", "ring", ".bell"
    rank_variable, size_variable = "BELL_RANK", "BELL_RANKS"

    def job(self, environment):
        return environment.get("BELL_JOB", "")

    def end(self, environment):
        return float(environment["BELL_END"]) if "BELL_END" in environment else None

    def seconds_of(self, time):
        return 3600.0 * float(time)

    def time_of(self, seconds):
        return f"{seconds / 3600:g}"

    def script(self, request):
        return f"#BELL {request.name} {request.ranks} ranks {request.time} h\nsweep run {request.spec}\n"

    def submit(self, script):
        return ["ring", str(script)]

    def follow(self, request, job, then):
        return ["ring", "--after", job, "--", then]

    def examine(self):
        return True, "the bell can be rung"


@pytest.fixture
def bell(monkeypatch, tmp_path):
    monkeypatch.setattr(schedulers, "ALL", (Bell(),))
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    monkeypatch.chdir(tmp_path)
    ring = tmp_path / "ring"
    ring.write_text('#!/bin/sh\necho "$@" >> rung\necho 7\n')
    ring.chmod(0o755)


def test_its_script_and_its_commands_are_what_submit_prints(bell, small_spec, capsys):
    command = ["submit", str(small_spec), "--ranks", "2", "--time", "1.5", "--dry-run"]
    assert cli.main(command) == 0
    script = f"#BELL small 2 ranks 1.5 h\nsweep run {small_spec}\n"
    assert capsys.readouterr().out == script
    assert cli.main([*command, "--array", "2"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(script)
    assert "#   ring --after ARRAY_JOB -- " in printed
    assert "merge" in printed.splitlines()[-1]


def test_its_command_submits(bell, small_spec, tmp_path, capsys):
    assert cli.main(["submit", str(small_spec), "--array", "2"]) == 0
    assert capsys.readouterr().out == (
        "wrote small.bell; submitted as job 7; job 7 merges its shards when all have ended\n"
    )
    first, second = (tmp_path / "rung").read_text().splitlines()
    assert first == f"{tmp_path}/small.bell"
    assert second.startswith("--after 7 -- ")


def test_inside_its_job_its_deadline_its_job_and_its_rank_are_found(bell):
    inside = {"BELL_END": str(NOON + 7200), "BELL_JOB": "7", "BELL_RANK": "3", "BELL_RANKS": "4"}
    assert walltime.deadline(None, inside, NOON) == NOON + 7200 - walltime.MARGIN
    assert schedulers.job(inside) == "7"
    assert (launch.stated_rank(inside), launch.stated_size(inside)) == (3, (4, "BELL_RANKS"))
    assert walltime.deadline(None, {"SLURM_JOB_ID": "7", "SLURM_JOB_END_TIME": str(NOON)}, NOON) is None


def test_the_doctor_and_the_help_name_it(bell, capsys):
    assert doctor.scheduler(schedulers.ALL[0]) == doctor.Examined("BELL", "good", "the bell can be rung")
    with pytest.raises(SystemExit):
        cli.main(["submit", "--help"])
    text = capsys.readouterr().out
    assert "--ring" in text
    assert "as BELL writes it" in text
    assert "--scheduler" not in text


def test_of_several_the_user_chooses_and_else_it_is_the_one_that_is_there(monkeypatch, small_spec, capsys):
    monkeypatch.setattr(schedulers, "ALL", (*schedulers.ALL, Bell()))
    monkeypatch.setattr(schedulers.shutil, "which", lambda command: command == "ring" or None)
    command = ["submit", str(small_spec), "--ranks", "1", "--time", "9", "--dry-run"]
    for name, begins in (("auto", "#BELL"), ("BELL", "#BELL"), ("SLURM", "#!/bin/bash")):
        assert cli.main([*command, "--scheduler", name]) == 0
        assert capsys.readouterr().out.startswith(begins)
    with pytest.raises(SystemExit):
        cli.main([*command, "--scheduler", "OGE"])


def test_a_schedulers_name_stands_in_its_own_file_and_in_the_list():
    files = Path(sweep.__file__).parent.rglob("*.py")
    assert {file.name for file in files if "slurm" in file.read_text().lower()} == {"slurm.py", "schedulers.py"}
