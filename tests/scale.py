"""How far one master goes: its request rate, measured, then the scheduler's own policy simulated for many ranks.

    python -m tests.scale [--spec SPEC ...] [--targets 1e-3 1e-6] [--times 1] [--ranks 10 ...] [--rate R] [--keep]

Measures with real messages of the real master and worker loops, without computing: requests a second from workers
that ask at once, the share of a core that an idle master takes, how long an answer takes. Then simulates, event by
event, sweep.plan.batches.Batches with these figures and predicted costs: efficiency against ranks, as it is, in
shards that have a master each, and for several least batches. Beside it the bounds: no scheduler ends before its
share of the work or the longest task is done ("at best"), and one master starts the ranks one after the other ("1
master"). At last what else grows with the ranks (tests.start_costs): files opened at the start, signs of life, rows
that rank 0 writes; --keep keeps this table, of the first target, for the documentation.
"""

import argparse
import heapq
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from kernel.method import choose
from sweep.plan import batches
from sweep.plan.cost import predict_all
from sweep.plan.shard import dealt
from sweep.plan.spec import read_spec
from sweep.serve.master import Master
from sweep.serve.messages import REPORT, WORK, Orders, send_report
from tests import start_costs
from tests.measured import keep

ROOT = Path(__file__).parent.parent
FIGURE_8 = ROOT / "jobs" / "paper" / "fig8.toml"
LARGE = (1000, 10_000, 100_000)
RANKS = (10, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)
LEAST = (0.002, 0.02, 0.2, 2.0)  # predicted seconds of the smallest batch
REQUESTS, IDLE, ASKS = 100_000, 3.0, 300
SIZE = 32  # tasks of a batch while the rate is measured
SCATTER = 1.5  # a task's real over its predicted seconds: one standard deviation, log-normal, mean 1
WIRE = 2e-6  # seconds of a small message between nodes, one way: assumed, one machine cannot tell


class Measured(NamedTuple):
    """Of one master."""

    rate: float  # requests a second
    idle: float  # share of a core
    answer: float  # seconds from a worker's request to its answer, nobody else asking


def nowhere(*_: object) -> None:
    """Takes the place of a table: only messages are measured."""


def busy(comm: Any) -> float:
    """Requests a second from workers that ask again at once."""
    from mpi4py import MPI

    if comm.rank:
        status, ids, report = MPI.Status(), np.empty(batches.BATCH_MAX, np.int64), np.array([SIZE, 0, 0], np.int64)
        comm.Recv(ids, 0, WORK, status)  # a worker that sleeps while it waits would not ask at once
        while status.Get_count(MPI.INT64_T):
            comm.Send(report, 0, REPORT)
            comm.Recv(ids, 0, WORK, status)
        return 0.0
    work = batches.Batches(np.arange(SIZE * REQUESTS), np.full(SIZE * REQUESTS, batches.SECONDS_MAX / SIZE), 1)
    master = Master(comm, work, None, nowhere, False)
    start = time.perf_counter()
    master.run(lambda: None)
    return master.count.requests / (time.perf_counter() - start)


def idle(comm: Any) -> tuple[float, float]:
    """Share of a core that the master takes while all workers compute; then the median delay of an answer."""
    if comm.rank:
        orders, delays = Orders(comm), []
        ids = orders.wait()
        time.sleep(IDLE)
        while len(ids):
            start = time.perf_counter()
            send_report(comm, len(ids), 0, 0.0, None)
            ids = orders.wait()
            delays.append(time.perf_counter() - start)
            time.sleep(0.01)
        return comm.gather((0.0, float(np.median(delays))))
    work = batches.Batches(np.arange(ASKS), np.full(ASKS, batches.SECONDS_MAX), 1)
    master, start, cpu, share = Master(comm, work, None, nowhere, False), time.perf_counter(), time.thread_time(), []

    def tick() -> None:
        if not share and time.perf_counter() - start > 0.9 * IDLE:
            share.append((time.thread_time() - cpu) / (time.perf_counter() - start))

    master.run(tick)
    answers = comm.gather(None)
    return share[0], float(np.median([answer for _, answer in answers[1:]]))


def measured() -> Measured:
    """In mpirun: the best of three rates with 2 and 3 ranks, and an idle master with one worker."""
    rate = max(_under_mpirun("busy", ranks) for ranks in (2, 3) for _ in range(3))
    share, answer = _under_mpirun("idle", 2)
    return Measured(rate, share, answer)


def _under_mpirun(what: str, ranks: int) -> Any:
    command = ["mpirun", "-n", str(ranks), sys.executable, "-m", "tests.scale", "--inside", what]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"PATH": path}, check=True, capture_output=True, timeout=300
    )
    return json.loads(done.stdout)


class Simulated(NamedTuple):
    """One run."""

    efficiency: float
    requests: int
    queued: float  # share of the time that the master was serving


def simulate(predicted: np.ndarray, real: np.ndarray, ranks: int, master: Measured) -> Simulated:
    """A run of all tasks from their predicted and real seconds; rank 0 computes or serves as in sweep.conduct."""
    work, service = batches.Batches(np.arange(len(predicted)), predicted, ranks), 1.0 / master.rate
    computes = batches.computing_ranks(ranks) == ranks
    free, end, requests = 0.0, 0.0, 0
    asking = [(0.0, rank) for rank in range(0 if computes else 1, ranks)]  # a heap: all are sorted
    while asking:
        now, rank = heapq.heappop(asking)
        end = max(end, now)
        if not len(ids := work.take()):
            continue
        delay = 0.0
        if rank or not computes:
            arrives = now + WIRE
            free = max(free, arrives) + service
            # A master that has nothing to do sleeps: the measured answer includes its waking, and the worker's.
            delay = max(free + WIRE, now + master.answer if now else 0.0) - now
            requests += 1
        heapq.heappush(asking, (now + delay + float(real[ids].sum()), rank))
    return Simulated(float(real.sum()) / (ranks * end), requests, requests * service / end)


def scattered(predicted: np.ndarray) -> np.ndarray:
    """Real seconds that a cost model with SCATTER could have predicted like that."""
    sigma = np.log(SCATTER)
    return predicted * np.exp(np.random.default_rng(1).normal(-0.5 * sigma**2, sigma, len(predicted)))


def costs(spec: Path, target: float) -> np.ndarray:
    """Predicted seconds of every task of a spec at a target."""
    given = read_spec(spec)[0]
    tasks = given.task_list()
    return predict_all(tasks, np.arange(len(tasks)), choose("auto", target), given.accuracy.certify)


def sharded(predicted: np.ndarray, real: np.ndarray, ranks: int, master: Measured) -> float:
    """Efficiency of shards that start together, each a job of its own with as many ranks as a computing master has."""
    count = max(1, round(ranks / batches.COMPUTING_MASTER_MAX))
    if count > len(predicted):
        return np.nan
    each, shards, longest = ranks // count, dealt(predicted, count), 0.0
    order = np.argsort(shards, kind="stable")
    for ids in np.split(order, np.searchsorted(shards[order], np.arange(1, count))):
        efficiency = simulate(predicted[ids], real[ids], each, master).efficiency
        longest = max(longest, float(real[ids].sum()) / (each * efficiency))
    return float(real.sum()) / (ranks * longest)


def bounds(real: np.ndarray, ranks: int, master: Measured) -> tuple[float, float]:
    """Efficiency that no scheduler can exceed, and that none can whose one master starts the ranks after each other."""
    share, longest, service = float(real.sum()) / ranks, float(real.max()), 1.0 / master.rate
    started = share + 0.5 * ranks * service if share > 0.5 * ranks * service else (2 * ranks * share * service) ** 0.5
    return share / max(share, longest), share / max(started, longest)


def table(predicted: np.ndarray, ranks: list[int], master: Measured) -> None:
    """Print efficiency against ranks: bounds, the policy as it is, in shards, then with other least batches."""
    real, kept = scattered(predicted), (batches.SECONDS_MIN, batches.SECONDS_MIN_PER_RANK)
    columns = [(f"{least:g} s", least, 0.0) for least in LEAST]
    print(f"{'ranks':>8} {'s a rank':>9} {'at best':>8} {'1 master':>8} {'policy':>16} {'shards':>8} ", end="")
    print("".join(f"{name:>17}" for name, *_ in columns))
    for count in ranks:
        cells = [_cell(predicted, real, count, master)]
        at_best, with_master = bounds(real, count, master)
        shards = sharded(predicted, real, count, master)
        for _, batches.SECONDS_MIN, batches.SECONDS_MIN_PER_RANK in columns:
            cells.append(_cell(predicted, real, count, master))
        batches.SECONDS_MIN, batches.SECONDS_MIN_PER_RANK = kept
        print(
            f"{count:8} {real.sum() / count:9.3f} {at_best:8.1%} {with_master:8.1%} {cells[0]} {shards:8.1%} ", end=""
        )
        print(" ".join(cells[1:]), flush=True)


def beyond(predicted: np.ndarray, master: Measured) -> list[dict[str, str]]:
    """Of large jobs what the master, the disk and the scheduling take."""
    costs, real, lines = start_costs.measured(), scattered(predicted), []
    print(f"a rank opens {costs.files} files and takes {costs.seconds:.1f} s of a core to start, the kernel compiled;")
    print(f"rank 0 takes {1e6 * costs.row:.1f} us to write a row for another")
    for ranks in LARGE:
        efficiency = simulate(predicted, real, ranks, master).efficiency
        shards = sharded(predicted, real, ranks, master)
        lines.append(start_costs.told(ranks, costs, master.rate, float(real.mean()), efficiency, shards))
        print("; ".join(f"{name}: {value}" for name, value in lines[-1].items()), flush=True)
    return lines


def _cell(predicted: np.ndarray, real: np.ndarray, ranks: int, master: Measured) -> str:
    run = simulate(predicted, real, ranks, master)
    return f"{run.efficiency:9.1%} ({run.queued:4.0%})"


def main() -> None:
    """Measure, simulate, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spec", type=Path, default=FIGURE_8)
    parser.add_argument("--targets", type=float, nargs="+", default=[1e-3, 1e-6])
    parser.add_argument("--times", type=int, default=1, help="so many times as many tasks: a finer grid")
    parser.add_argument("--ranks", type=int, nargs="+", default=RANKS)
    parser.add_argument("--rate", type=float, help="requests a second, as measured when the machine had no other work")
    parser.add_argument("--keep", action="store_true", help="keep the last table for the documentation")
    parser.add_argument("--inside", choices=("busy", "idle"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.inside:
        from mpi4py import MPI

        answer = {"busy": busy, "idle": idle}[args.inside](MPI.COMM_WORLD)
        if MPI.COMM_WORLD.rank == 0:
            print(json.dumps(answer))
        return
    master = measured()
    master = master._replace(rate=args.rate or master.rate)
    print(f"a master that only serves: {master.rate:.0f} requests a second; idle: {master.idle:.1%} of a core;")
    print(f"an answer takes {1e6 * master.answer:.0f} us; between nodes {1e6 * WIRE:.0f} us more each way (assumed)")
    for target in args.targets:
        predicted = np.tile(costs(args.spec, target), args.times)
        print(
            f"\n{args.spec.name} at target {target:g}: {len(predicted)} tasks, {predicted.sum() / 3600:.2f} core-hours"
        )
        print("efficiency (in brackets: how much of the time the master serves) with a least batch of")
        table(predicted, args.ranks, master)
    predicted = np.tile(costs(args.spec, args.targets[0]), args.times)
    lines = beyond(predicted, master)
    if args.keep:
        keep("scale", lines, f"{len(predicted)} tasks at {args.targets[0]:g}, {predicted.sum() / 3600:.2f} core-hours")


if __name__ == "__main__":
    main()
