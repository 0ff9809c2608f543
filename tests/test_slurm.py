"""Real jobs on a real SLURM: stopped, queued again, finished; shards that never talk; the bits of a single run."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.tell import report

from .conftest import BIN, SLOW, clean_environment
from .slurm import SYSTEM, Cluster, why_not

pytestmark = [pytest.mark.slurm, pytest.mark.mpi, pytest.mark.skipif(bool(why_not()), reason=why_not() or "possible")]
ROOT = Path(__file__).parent.parent
JOBS = ROOT / "jobs"
WAIT = 240.0  # seconds for anything that SLURM does
ENDED = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL"}


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """A SLURM of one node with four processors."""
    running = Cluster(Path(tempfile.mkdtemp(prefix="slurm-")))
    try:
        running.start()
        yield running
    finally:
        running.stop()


@pytest.fixture
def environment(cluster) -> dict[str, str]:
    """Of a user who submits: SLURM's commands on the path, the compiled kernel's cache where `make setup` left it."""
    ours = {"SLURM_CONF": str(cluster.conf), "SWEEP_BIN": str(BIN), "NUMBA_CACHE_DIR": ""}
    return clean_environment() | ours | {"PATH": f"{BIN}:{SYSTEM}"}


@pytest.fixture
def user(environment, tmp_path) -> Callable[..., "subprocess.CompletedProcess[str]"]:
    """user(*command): what a user types in tmp_path."""

    def run(*command: object) -> "subprocess.CompletedProcess[str]":
        words = [str(word) for word in command]
        return subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=WAIT)

    return run


@pytest.fixture(scope="module")
def slow_alone(tmp_path_factory) -> Path:
    """The table of the slow sweep by one uninterrupted run outside of SLURM."""
    folder = tmp_path_factory.mktemp("alone")
    (folder / "slow.toml").write_text(SLOW)
    command = [BIN / "mpirun", "-n", "2", BIN / "sweep", "run", "slow.toml", "-o", "alone.h5"]
    subprocess.run(command, cwd=folder, env=clean_environment(), check=True, timeout=WAIT)
    return folder / "alone.h5"


def ended(cluster: Cluster, job: str, folder: Path) -> dict[str, str]:
    """What SLURM says of a job once it has ended."""
    until(lambda: cluster.job(job)["JobState"] in ENDED, cluster, folder, pause=0.3)
    return cluster.job(job)


def logs(folder: Path) -> str:
    return "\n".join(f"{path.name}: {path.read_text()}" for path in sorted(folder.glob("*.log")))


def until(true: Callable[[], object], cluster: Cluster, folder: Path, pause: float = 0.05) -> None:
    """Wait for it; AssertionError with what the jobs and SLURM have said."""
    limit = time.monotonic() + WAIT
    while not true():
        assert time.monotonic() < limit, f"{logs(folder)}\n{cluster.logs()}"
        time.sleep(pause)


def stop_at_first_row(cluster: Cluster, job: str, path: Path) -> None:
    """Send the job the signal that SLURM sends before the time limit, as soon as a row is finished.

    Until it has arrived the ranks stand still: however slow SLURM and mpirun are, the sweep is not over by then.
    """

    def computing() -> bool:
        try:
            return bool(report.status(path)["done"])
        except InputError:
            return False

    until(computing, cluster, path.parent)
    ranks = ranks_of(path)
    assert ranks, logs(path.parent)
    for rank in ranks:
        os.kill(rank, signal.SIGSTOP)
    cluster.command("scancel", "--signal=USR1", "--batch", job)
    until(lambda: any(map(is_told, ranks)), cluster, path.parent)  # workers ignore it
    for rank in ranks:
        os.kill(rank, signal.SIGCONT)


def ranks_of(table: Path) -> list[int]:
    """The processes that compute a table."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended
            program, *arguments = (process / "cmdline").read_text().split("\0")
            python = Path(program).name.startswith("python")
            if python and {"run", table.name} <= set(arguments) and (process / "cwd").readlink() == table.parent:
                found.append(int(process.name))
    return found


def is_told(rank: int) -> bool:
    """Whether SIGUSR1 waits for a process that stands still."""
    waiting = re.search(r"^ShdPnd:\s*(\w+)$", Path(f"/proc/{rank}/status").read_text(), re.MULTILINE)
    return waiting is not None and bool(int(waiting[1], 16) & 1 << (signal.SIGUSR1 - 1))


def jobs_of(path: Path) -> list[str]:
    return [run["job"] for run in report.show(path)["runs"]]


def submitted(answer: "subprocess.CompletedProcess[str]") -> str:
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.strip()


def test_the_doctor_has_the_controllers_word_for_the_partition(user):
    told = user(sys.executable, "-c", "from sweep.site.slurm import Slurm; print(*Slurm().examine())")
    assert told.stdout == "True jobs can be submitted from here (sweep submit), to test\n"


def test_a_job_that_is_stopped_is_queued_again_and_completes(cluster, user, slow_spec, tmp_path, physics, slow_alone):
    command = ("sbatch", "--parsable", "--ntasks=2", "--time=60", JOBS / "sweep.sbatch", slow_spec, "t.h5")
    job = submitted(user(*command))
    stop_at_first_row(cluster, job, tmp_path / "t.h5")
    told = ended(cluster, job, tmp_path)
    assert (told["JobState"], told["ExitCode"]) == ("COMPLETED", "0:0"), logs(tmp_path)
    first, second = report.show(tmp_path / "t.h5")["runs"]
    # A busy machine starts a job too late now and then, and SLURM queues it again before anything has run.
    assert [first["job"].split()[0], second["job"]] == [job, f"{job} restart {told['Restarts']}"]
    assert 0 < first["rows"] < 492
    assert first["rows"] + second["rows"] == 492
    assert first["hosts"].endswith("*2")
    assert physics(tmp_path / "t.h5") == physics(slow_alone)


def test_a_job_whose_input_is_bad_is_not_queued_again(cluster, user, tmp_path):
    (tmp_path / "bad.toml").write_text("name = 3")
    job = submitted(user("sbatch", "--parsable", "--ntasks=2", JOBS / "sweep.sbatch", "bad.toml", "t.h5"))
    told = ended(cluster, job, tmp_path)
    assert (told["JobState"], told["ExitCode"], told["Restarts"]) == ("FAILED", "2:0", "0")
    assert "bad.toml: name: " in logs(tmp_path)
    assert not (tmp_path / "t.h5").exists()


def test_an_array_of_shards_merges_into_the_table_of_a_single_run(
    cluster, user, slow_spec, tmp_path, physics, slow_alone
):
    options = ("--array=1-3", "--ntasks=1", "--output=%x-%A_%a.log", "--time=60")  # as the script's head says
    command = ("sbatch", "--parsable", *options, JOBS / "sweep.sbatch", slow_spec, "t.h5")
    job = submitted(user(*command))
    stop_at_first_row(cluster, f"{job}_3", tmp_path / "t-3-of-3.h5")  # the one whose number is the array's too
    states = {task: ended(cluster, f"{job}_{task}", tmp_path) for task in (1, 2, 3)}
    assert {told["JobState"] for told in states.values()} == {"COMPLETED"}, logs(tmp_path)
    shards = [tmp_path / f"t-{task}-of-3.h5" for task in (1, 2, 3)]
    runs = [[name.split()[0] for name in jobs_of(shard)] for shard in shards]
    assert runs == [[f"{job}_1"], [f"{job}_2"], [f"{job}_3"] * 2], cluster.logs()
    assert user(BIN / "sweep", "merge", *shards, "-o", "t.h5").returncode == 0
    assert physics(tmp_path / "t.h5") == physics(slow_alone)


def test_submit_runs_a_sweep(cluster, user, small_spec, tmp_path, sweep, physics):
    answer = submitted(user(BIN / "sweep", "submit", small_spec, "--ranks", "2", "--time", "5"))
    assert answer.startswith("wrote small.sbatch; submitted as job ")
    told = ended(cluster, answer.split()[-1], tmp_path)
    facts = [told[name] for name in ("JobName", "JobState", "TimeLimit", "NumTasks")]
    assert facts == ["small", "COMPLETED", "00:05:00", "2"], logs(tmp_path)
    sweep("run", small_spec, "-o", "alone.h5")
    assert physics(tmp_path / "small.h5") == physics(tmp_path / "alone.h5")


def test_submit_runs_an_array_and_merges_it(cluster, user, small_spec, tmp_path, sweep, physics):
    answer = submitted(user(BIN / "sweep", "submit", small_spec, "-o", "t.h5", "--array", "2", "--time", "5"))
    last = answer.removesuffix(" merges its shards when all have ended").split()[-1]
    told = ended(cluster, last, tmp_path)
    assert told["JobState"] == "COMPLETED", logs(tmp_path)
    sweep("run", small_spec, "-o", "alone.h5")
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "alone.h5")


def test_the_documentations_lines_for_a_cluster_work_word_for_word(cluster, user, tmp_path, sweep, physics):
    section = (ROOT / "docs/clusters.md").read_text().partition("\n## ")[0]
    lines = [line.strip() for line in section.splitlines() if line.startswith("    ")]
    assert {line.split()[0] for line in lines} >= {".", "sweep", "sbatch"}
    (tmp_path / "jobs").symlink_to(JOBS)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    looking = [line for line in lines if line.startswith("sweep status")]
    answer = user("bash", "-ec", "\n".join(line for line in lines if line not in looking))
    assert answer.returncode == 0, answer.stdout + answer.stderr
    until(lambda: not cluster.command("squeue", "-h"), cluster, tmp_path, pause=0.3)
    answer = user("bash", "-ec", "\n".join([lines[0], *looking]))
    assert answer.returncode == 0, answer.stderr
    tables = sorted(path for path in tmp_path.glob("?.h5"))
    assert [path.name for path in tables] == ["a.h5", "q.h5", "r.h5"], logs(tmp_path)
    sweep("run", "jobs/quick.toml", "-o", "alone.h5")
    assert [physics(path) for path in tables] == [physics(tmp_path / "alone.h5")] * 3


def test_what_sbatch_refuses_is_told(user, small_spec):
    answer = user(BIN / "sweep", "submit", small_spec, "--partition", "none", "--ranks", "1", "--time", "5")
    assert answer.returncode == 2
    assert "sweep: sbatch refuses: sbatch: error: invalid partition specified: none" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_one_process_in_an_allocation_works_and_says_what_stays_idle(user, small_spec):
    answer = user("salloc", "-Q", "-n", "2", BIN / "sweep", "run", small_spec, "-o", "t.h5")
    assert answer.returncode == 0, answer.stderr
    assert "SLURM_NTASKS=2, but this is one process" in answer.stderr


def test_srun_without_the_mpi_it_needs_is_refused_and_with_it_works(user, small_spec, tmp_path):
    wrong = user("srun", "-n", "2", BIN / "sweep", "run", small_spec, "-o", "wrong.h5")
    assert wrong.returncode == 2
    assert "SLURM_STEP_NUM_TASKS=2, but MPI sees one process" in wrong.stderr
    assert not (tmp_path / "wrong.h5").exists()
    right = user("srun", "--mpi=pmi2", "-n", "2", BIN / "sweep", "run", small_spec, "-o", "right.h5")
    assert right.returncode == 0, right.stderr
    assert "; 2 ranks, " in right.stderr
