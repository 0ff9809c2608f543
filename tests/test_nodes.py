"""Two nodes, a shared disk, SLURM, all real but the machines: what one node cannot show."""

import json
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from sweep.errors import InputError
from sweep.store import table
from sweep.tell import report

from .chaos import content
from .conftest import BIN, SLOW, clean_environment
from .nodes.cluster import Cluster, why_not
from .nodes.machines import Machine
from .slurm import SYSTEM

pytestmark = [pytest.mark.nodes, pytest.mark.mpi, pytest.mark.skipif(bool(why_not()), reason=why_not() or "possible")]
JOBS = Path(__file__).parent.parent / "jobs"
WAIT = 200.0  # seconds for any run; Gluster takes 42 to notice a dead node
SPEC, TASKS = SLOW.replace("points = 41", "points = 21"), 252


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """Both nodes are on, nothing runs."""
    running = Cluster()
    try:
        running.start()
        (running.brick / "slow.toml").write_text(SPEC)
        yield running
    finally:
        running.close()


@pytest.fixture(scope="module")
def alone(tmp_path_factory) -> bytes:
    """The bits of the table by one machine."""
    folder = tmp_path_factory.mktemp("alone")
    (folder / "slow.toml").write_text(SPEC)
    command = [BIN / "mpirun", "-n", "2", BIN / "sweep", "run", "slow.toml", "-o", "t.h5"]
    subprocess.run(command, cwd=folder, env=clean_environment(), check=True, timeout=WAIT)
    return content(folder / "t.h5")


def launched(cluster: Cluster, table: str, *more: str) -> "subprocess.Popen[str]":
    """A rank on each node, rank 0 and the launcher on node1."""
    where = ("-launcher", "ssh", "-launcher-exec", cluster.ssh, "-hosts", "node1,node2", "-n", "2")
    run = ("run", cluster.work / "slow.toml", "-o", cluster.work / table, *more)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": clean_environment()}
    return cluster.node1.start(BIN / "mpirun", *where, BIN / "sweep", *run, **pipes)


def run_on(cluster: Cluster, node: Machine, table: str) -> "subprocess.CompletedProcess[str]":
    """A run of one process."""
    command = (BIN / "sweep", "run", cluster.work / "slow.toml", "-o", cluster.work / table)
    return node.on(*command, env=clean_environment(), timeout=WAIT)


def wait_for_rows(path: Path, at_least: int = 1) -> None:
    """As they arrive on the disk itself."""
    until = time.monotonic() + WAIT
    while time.monotonic() < until:
        try:
            if report.status(path)["done"] >= at_least:
                return
        except InputError:  # it is not there yet
            pass
        time.sleep(0.1)
    raise AssertionError("no rows")


def seen_from(cluster: Cluster, node: Machine, table: str) -> tuple[int, int, int]:
    answer = node.on(BIN / "sweep", "status", cluster.work / table, "--json", env=clean_environment())
    assert answer.returncode == 0, answer.stderr
    told = json.loads(answer.stdout)
    return told["done"], told["failed"], told["left"]


@pytest.mark.parametrize("writer", ["auto", "mpio"])
def test_every_node_sees_all_rows_and_a_cut_of_20_seconds_costs_nothing(cluster, alone, writer):
    table = f"{writer}.h5"
    process = launched(cluster, table, "--writer", writer)
    wait_for_rows(cluster.brick / table)
    if writer == "auto":
        cluster.node2.cut()
        time.sleep(20)
        cluster.node2.mend()
    said, log = process.communicate(timeout=WAIT)
    assert (process.returncode, said[:29]) == (0, f"{TASKS} done, 0 failed, 0 left; wall"[:29]), log
    if writer == "auto":
        assert "writer gather (2 nodes on fuse.glusterfs, where only one should write a file)" in log
    assert [seen_from(cluster, node, table) for node in (cluster.node1, cluster.node2)] == [(TASKS, 0, 0)] * 2
    assert content(cluster.brick / table) == alone


def test_a_process_on_another_node_joins_over_the_disk_alone(cluster, alone):
    run = (BIN / "sweep", "run", cluster.work / "slow.toml", "-o", cluster.work / "joined.h5")
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": clean_environment()}
    process = cluster.node1.start(*run, **pipes)
    wait_for_rows(cluster.brick / "joined.h5")
    joined = cluster.node2.on(BIN / "sweep", "join", cluster.work / "joined.h5", env=clean_environment(), timeout=WAIT)
    said, log = process.communicate(timeout=WAIT)
    assert (process.returncode, joined.returncode) == (0, 0), log + joined.stderr
    assert f"{TASKS} done, 0 failed, 0 left" in said
    assert f"{TASKS} done, 0 failed, 0 left" in joined.stdout
    assert "on node2 has joined as rank 1" in log
    with table.reading(cluster.brick / "joined.h5") as file:
        assert 1 in file["results"]["rank"]
    assert content(cluster.brick / "joined.h5") == alone


HOLD = """
import sys
from pathlib import Path
from sweep.store.lock import only_run
with only_run(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_table_that_another_node_writes_is_refused(cluster):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    holder = cluster.node1.start(BIN / "python", "-c", HOLD, cluster.work / "held.h5", **pipes)
    assert holder.stdout.readline() == "held\n"
    refused = run_on(cluster, cluster.node2, "held.h5")
    holder.communicate(timeout=WAIT)
    assert refused.returncode == 2
    assert "held.h5: a run on node1 (process " in refused.stderr
    assert "is writing this table; wait for it or stop it" in refused.stderr


WRITE = """
import sys, time
from pathlib import Path
from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.schema import RUNS
from sweep.store import moved, structure, table
from sweep.store.runs import new_run
from sweep.store.writers import Gather, Waiting

path, moved.LOOK_EVERY, moved.SHARED_FOR = Path(sys.argv[1]), 0.5, 3.0
table.create(path, Tasks({"N": (5,), "zeta_T": (0.0,), "M_over_M0": (1.0,), "V_over_V0": (1.0,)}), {})
with table.reading(path) as file:
    at = structure.place(file[RUNS])[0]
writer, row = Gather(path, 1.0), new_run(1, "gather", "0")
looked, until = moved.Moved(path, at, Waiting()), time.monotonic() + 8.0
def write():
    while not looked.is_so and time.monotonic() < until:
        row["updated"] = time.time()
        writer.log(0, row)
        looked.look()
        time.sleep(0.1)
write()
print("lost" if looked.is_so else "kept", flush=True)
sys.stdin.readline()
until += 60.0
write()
try:
    looked.refuse()
except InputError as error:
    print(error)
"""


@pytest.mark.parametrize("harm", ["rm {0}", "mv {0} {0}.elsewhere", "cp {0} {0}.copy && mv {0}.copy {0}"])
def test_a_table_that_another_node_takes_away_is_missed_and_what_it_held_is_saved(cluster, harm):
    name = f"taken-{harm[:2]}.h5"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    command = (BIN / "python", "-P", "-c", WRITE, cluster.work / name)
    writer = cluster.node1.start(*command, **pipes, env=clean_environment())
    assert writer.stdout.readline() == "kept\n"
    cluster.node2.on("sh", "-c", harm.format(cluster.work / name), check=True)
    said, _ = writer.communicate("\n", timeout=WAIT)
    assert f"saved as {cluster.work / name}.saved: " in said
    with table.reading(cluster.brick / f"{name}.saved") as file:
        assert len(table.runs(file)) == 1


def test_a_job_over_two_nodes_leaves_no_cache_behind(cluster, alone):
    ours = {"SLURM_CONF": str(cluster.folder / "slurm.conf"), "SWEEP_BIN": str(BIN), "NUMBA_CACHE_DIR": ""}
    environment = clean_environment() | ours | {"PATH": f"{BIN}:{SYSTEM}"}
    options = ("--parsable", "--hold", "--nodes=2", "--ntasks=2", "--time=60", f"--chdir={cluster.work}")
    script = (JOBS / "sweep.sbatch", "slow.toml", "job.h5")
    submitted = cluster.node1.on("sbatch", *options, *script, env=environment)
    job = submitted.stdout.strip()
    for node in (cluster.node1, cluster.node2):
        node.on("mkdir", f"/tmp/numba-{job}", check=True)
    cluster.node1.on("scontrol", "release", job, env=environment, check=True)
    until, state = time.monotonic() + WAIT, ""
    while "JobState=COMPLETED" not in state:
        said = (cluster.brick / f"sweep-{job}.log").read_text() if "RUNNING" in state else ""
        assert time.monotonic() < until and "JobState=FAILED" not in state, f"{state}\n{said}"
        state = cluster.node1.on("scontrol", "show", "job", job, env=environment).stdout
        time.sleep(0.5)
    left = [node.on("ls", "/tmp").stdout for node in (cluster.node1, cluster.node2)]
    assert not any(f"numba-{job}" in each for each in left)
    assert content(cluster.brick / "job.h5") == alone


def test_a_dead_nodes_table_is_waited_for_and_completed(cluster, alone):
    process = launched(cluster, "dead.h5")
    wait_for_rows(cluster.brick / "dead.h5", 20)
    cluster.node1.power_off()
    process.communicate(timeout=WAIT)
    reported = seen_from(cluster, cluster.node2, "dead.h5")[0]
    answer = run_on(cluster, cluster.node2, "dead.h5")
    assert "a run on node1 holds this table; waiting up to " in answer.stderr
    assert answer.returncode == 0, answer.stderr
    assert 20 <= reported <= TASKS
    assert content(cluster.brick / "dead.h5") == alone
