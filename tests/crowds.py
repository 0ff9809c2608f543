"""How many processes may join one run: what rank 0 takes for each, measured, then its policy simulated for many.

    python -m tests.crowds [--guests 10 ...] [--seconds 60 600] [--spec SPEC] [--target 1e-3] [--keep]

Measured, in a real folder on this disk, with real orders and rows but without computing: a look at a guest that is at
work, and an order with its answer. Then simulated look by look, with sweep.plan.batches.Batches and
sweep.serve.guests.next_order and predicted costs: the efficiency of one process that so many others join at once,
beside that of one job of the same size (tests.scale). The sweep is the spec's tasks, repeated or sampled until every
process has so many seconds of work.
"""

import argparse
import os
import sys
import tempfile
import time
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from kernel.method import choose
from sweep import guest
from sweep.plan.batches import Batches
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank_of, seal
from sweep.serve import guests as served
from sweep.serve.guests import Guests, next_order
from sweep.serve.worker import Job
from sweep.store import lease, mailbox
from sweep.store.mailbox import GUEST, ROWS

from . import scale
from .measured import keep

GUESTS, SECONDS = (10, 100, 1000), (60.0, 600.0)  # seconds of work for each process
MEET = 200  # guests of the folder in which the costs are measured


class Costs(NamedTuple):
    """Seconds that rank 0 takes."""

    look: float  # for one guest that is at work, every LOOK_EVERY
    order: float  # to give one order and take in what comes of it


def measured() -> Costs:
    """Both, on a folder of this disk."""
    tasks = Tasks({"N": [20], "zeta_T": [1e-3], "M_over_M0": [1.0], "V_over_V0": np.linspace(0.1, 10.0, 1_000_000)})
    job, batches = Job(tasks, choose("auto", 1e-3), True), Batches(np.arange(len(tasks)), np.full(len(tasks), 5e-3), 1)
    with tempfile.TemporaryDirectory() as name:
        found = Guests(Path(name, "t.h5"), job, batches, 1)
        folder = mailbox.folder_of(Path(name, "t.h5"))
        for _ in range(MEET):
            _arrive(folder)
        start, ids = time.perf_counter(), {}
        for one in found.wanting():
            ids[f"{one.name}.{one.given}"] = order = next_order(batches, np.inf)
            found.give(one, order.ids, order.predicted)
        given = time.perf_counter() - start
        start = time.perf_counter()
        for _ in range(5):
            assert not [*found.taken(), *found.lost(1.0), *found.wanting()]
        look = (time.perf_counter() - start) / 5
        for name_of, order in ids.items():
            rows = blank_of(tasks.columns(order.ids))
            rows["status"] = DONE
            seal(rows)
            mailbox.put(folder / f"{name_of}{ROWS}", rows)
        start = time.perf_counter()
        assert len([*found.taken()]) == len(ids)
        taken = time.perf_counter() - start
        found.close()
    return Costs(look / MEET, (given + taken - look) / len(ids))


def _arrive(folder: Path) -> None:
    """A guest of another node, which gives one sign of life and no more."""
    ours = replace(lease.new(), host="elsewhere")
    descriptor = os.open(folder / f"{ours.token}{GUEST}", os.O_RDWR | os.O_CREAT, 0o666)
    lease.write(descriptor, ours)
    os.close(descriptor)


def simulate(predicted: np.ndarray, real: np.ndarray, guests: int, costs: Costs) -> float:
    """The efficiency of a run of one process that computes and serves, and so many guests, there from the start."""
    batches, now, end = Batches(np.arange(len(predicted)), predicted, guests + 1), 0.0, 0.0
    own, orders = 0.0, [deque[float]() for _ in range(guests)]  # until when each computes, order by order
    while len(batches) or any(orders):
        while own <= now and len(ids := batches.take()):
            own += float(real[ids].sum())
        now += costs.look * guests
        for queue in orders:
            while queue and queue[0] <= now:
                end = max(end, queue.popleft())
            while len(queue) < served.AHEAD and len((order := next_order(batches, np.inf)).ids):
                now += costs.order
                begins = queue[-1] if queue else now + guest.LOOK_EVERY
                queue.append(begins + float(real[order.ids].sum()))
        now += served.LOOK_EVERY
    return float(real.sum()) / ((guests + 1) * max(now, own, end))


def work_of(spec: Path, target: float, seconds: float) -> np.ndarray:
    """Predicted seconds of tasks as in the spec, as many as are so many seconds of work together."""
    every = scale.costs(spec, target)
    times = seconds / float(every.sum())
    if times < 1.0:
        return every[np.random.default_rng(1).random(len(every)) < times]
    return np.tile(every, round(times))


def main() -> None:
    """Measure, simulate, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--guests", type=int, nargs="+", default=GUESTS)
    parser.add_argument("--seconds", type=float, nargs="+", default=SECONDS, help="of work for each process")
    parser.add_argument("--spec", type=Path, default=scale.FIGURE_8)
    parser.add_argument("--target", type=float, default=1e-3)
    parser.add_argument("--keep", action="store_true", help="for the documentation")
    args = parser.parse_args()
    costs, master = measured(), scale.measured()
    told = f"rank 0 takes {1e6 * costs.look:.0f} us to look after a guest, {1e3 * costs.order:.1f} ms for an order"
    print(told)
    lines = []
    for guests in args.guests:
        for seconds in args.seconds:
            predicted = work_of(args.spec, args.target, seconds * (guests + 1))
            real = scale.scattered(predicted)
            joined = simulate(predicted, real, guests, costs)
            job = scale.simulate(predicted, real, guests + 1, master).efficiency
            lines.append(
                {
                    "joining one process": f"{guests}",
                    "work for each": f"{seconds:g} s",
                    "tasks": f"{len(predicted)}",
                    "efficiency": f"{100 * joined:.1f} %",
                    "of one job of as many ranks": f"{100 * job:.1f} %",
                    "ratio": f"{100 * joined / job:.1f} %",
                }
            )
            print("; ".join(f"{name}: {value}" for name, value in lines[-1].items()), flush=True)
    if args.keep:
        keep("crowds", lines, f"simulated; {told}, measured")


if __name__ == "__main__":
    sys.exit(main())
