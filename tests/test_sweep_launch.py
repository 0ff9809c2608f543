"""One process without MPI when alone; N processes that do not see each other are refused, not run N times."""

import subprocess
import sys
from pathlib import Path

import pytest

from sweep import cli
from sweep.errors import InputError
from sweep.site import launch

FOREIGN = [{"OMPI_COMM_WORLD_SIZE": "4"}, {"SLURM_STEP_NUM_TASKS": "4"}, {"PMI_SIZE": "3"}, {"MPI_LOCALNRANKS": "2"}]


@pytest.mark.parametrize(
    ("environment", "told"),
    [
        ({}, (1, "")),
        ({"PMI_SIZE": "4"}, (4, "PMI_SIZE")),
        ({"PMI_SIZE": "1", "SLURM_STEP_NUM_TASKS": "8"}, (8, "SLURM_STEP_NUM_TASKS")),
        ({"PMI_SIZE": "four", "SLURM_STEP_NUM_TASKS": ""}, (1, "")),
        ({"SLURM_STEP_NUM_TASKS": "-1"}, (1, "")),
        ({"SLURM_NTASKS": "8"}, (1, "")),
        ({"UNRELATED_SIZE": "4"}, (1, "")),
    ],
)
def test_the_largest_size_that_a_launcher_tells_counts(environment, told):
    assert launch.stated_size(environment) == told


@pytest.mark.parametrize(
    ("environment", "rank"),
    [({}, 0), ({"PMI_RANK": "3"}, 3), ({"SLURM_PROCID": "2"}, 2), ({"PMI_RANK": "x"}, 0)],
)
def test_the_rank_is_known_before_mpi_starts(environment, rank):
    assert launch.stated_rank(environment) == rank


@pytest.mark.parametrize(("tasks", "idle"), [("", False), ("1", False), ("2", True), ("16", True), ("2(x3)", False)])
def test_alone_there_is_no_communicator_and_what_stays_idle_is_told(monkeypatch, environment, capsys, tasks, idle):
    monkeypatch.setattr(launch.os, "environ", environment | {"SLURM_NTASKS": tasks})
    assert launch.communicator() is None
    assert (f"SLURM_NTASKS={tasks}, but this is one process" in capsys.readouterr().err) is idle


@pytest.mark.parametrize("size", ["1", "2"])
def test_without_an_mpi_library_one_process_is_alone_and_several_are_refused(monkeypatch, environment, size):
    monkeypatch.setattr(launch.os, "environ", environment | {"PMI_SIZE": size})
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    if size == "1":
        assert launch.communicator() is None
    else:
        with pytest.raises(InputError, match=r"^PMI_SIZE=2, but mpi4py finds no MPI library "):
            launch.communicator()


@pytest.mark.parametrize("foreign", FOREIGN)
def test_a_process_of_many_that_sees_only_itself_is_refused(monkeypatch, environment, foreign):
    monkeypatch.setattr(launch.os, "environ", environment | foreign)
    (name, size), *_ = foreign.items()
    with pytest.raises(InputError, match=rf"^{name}={size}, but MPI sees one process: .* mpirun "):
        launch.communicator()


@pytest.mark.parametrize("foreign", FOREIGN)
def test_a_run_under_a_wrong_launcher_exits_2_and_writes_nothing(sweep, small_spec, environment, foreign):
    before = sorted(small_spec.parent.iterdir())
    answer = sweep("run", small_spec, "-o", "t.h5", env=environment | foreign)
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert len(answer.stderr.splitlines()) == 1
    assert answer.stderr.startswith(f"sweep: {next(iter(foreign))}=")
    assert sorted(small_spec.parent.iterdir()) == before


def test_the_commands_that_run_nothing_work_under_any_launcher(sweep, small_spec, environment):
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    foreign = environment | {"OMPI_COMM_WORLD_SIZE": "4", "SLURM_STEP_NUM_TASKS": "4"}
    for arguments in (("plan", small_spec), ("status", "t.h5"), ("show", "t.h5")):
        answer = sweep(*arguments, env=foreign)
        assert (answer.returncode, answer.stderr) == (0, "")


def test_a_launcher_of_one_process_needs_no_mpi(sweep, small_spec, environment):
    answer = sweep("run", small_spec, "-o", "t.h5", env=environment | {"SLURM_STEP_NUM_TASKS": "1"})
    assert answer.returncode == 0
    assert "1 rank," in answer.stderr


def test_a_command_that_runs_nothing_is_done_by_the_first_rank_alone(monkeypatch, capsys):
    told = {}
    for rank in ("0", "1"):
        monkeypatch.setenv("PMI_RANK", rank)
        told[rank] = cli.main(["show", "none.h5"]), capsys.readouterr().err
    assert told == {"0": (2, "sweep: none.h5: cannot be read: No such file or directory\n"), "1": (0, "")}


@pytest.mark.mpi
def test_a_rank_that_is_interrupted_before_mpi_starts_leaves_no_other_waiting_for_it(small_spec, tmp_path, environment):
    code = (
        "import sys; from sweep import cli\n"
        "def interrupted(args): raise KeyboardInterrupt\n"
        "cli._done = interrupted\n"
        f"sys.exit(cli.main(['run', {str(small_spec)!r}, '-o', 't.h5']))"
    )
    folder, run = Path(sys.executable).parent, ["run", str(small_spec), "-o", "t.h5"]
    first, second = [sys.executable, "-P", "-c", code], [folder / "sweep", *run]
    command = [folder / "mpirun", "-n", "1", *first, ":", "-n", "1", *second]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 130
    assert "sweep: interrupted" in done.stderr
