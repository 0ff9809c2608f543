"""How many rows a second rank 0 takes in for a search along lines, and the tasks that it chooses; computes nothing.

python -m tests.intake [--lines 2000] [--ranks 128]

All that rank 0 does with a row is in it, but the messages and the disk: the search, the cost model, the batches.
The rows are made up: ke_ratio falls through 1 somewhere on every line, with a ripple, and every twentieth is chaotic.
Seconds are of this process's own core.
"""

import argparse
import hashlib
import time
from unittest.mock import patch

import numpy as np

from kernel.method import choose
from sweep.conduct import _work as predicted
from sweep.plan.asked import Adaptive, Sought
from sweep.plan.batches import Batches
from sweep.plan.search import Search
from sweep.schema import DONE, blank
from sweep.serve import master
from sweep.serve.intake import Intake
from sweep.serve.messages import Report
from sweep.serve.worker import Job

# fmt: off
SEARCHES = {
    "adaptive, level": Adaptive(find="level"),
    "adaptive, log_slope": Adaptive(find="log_slope"),
    "level, first": Sought(find="level", along="N", level=0.7, until=0.002),
    "level, last": Sought(find="level", along="N", level=0.7, until=0.002, crossing="last"),
}
# fmt: on
START = {"N": [5, 10, 20, 40, 80, 160, 320], "M_over_M0": [1.0, 2.0], "V_over_V0": [1.0, 2.0]}
RIPPLE, CHAOTIC = 1.0, 0.05  # of the logarithm; share of the rows


def made_up(search: Search, rng: np.random.Generator) -> np.ndarray:
    """A row for every task."""
    tasks = search.tasks
    rows, columns = blank(len(tasks)), tasks.columns(np.arange(len(tasks)))
    line = columns["zeta_T"] * 1e4 + columns["M_over_M0"] + columns["V_over_V0"]
    fall = np.log(columns["N"] / (20 + 100 * np.modf(line)[0])) + RIPPLE * np.sin(0.3 * columns["N"] + line)
    rows["ke_ratio"], rows["status"] = np.exp(-fall), DONE
    rows["chaotic"] = rng.random(len(rows)) < CHAOTIC
    return rows


class Crowd:
    """In place of the workers and their messages: each has its rows as soon as it is asked for them."""

    def __init__(self, rows: np.ndarray, ranks: int) -> None:
        self.rows_of_all, self.size, self.asked = rows, ranks, np.zeros(len(rows), np.bool_)
        self._sent, self._given = list[Report](), dict[int, np.ndarray]()

    def send_work(self, comm: object, worker: int, ids: np.ndarray) -> None:
        if len(ids):
            self.asked[ids], self._given[worker] = True, ids
            self._sent.append(Report(worker, len(ids), 0, 1))

    def next(self) -> Report | None:
        """One report for each worker, then none until all had their turn: as they come where the master is busy."""
        self._turn = getattr(self, "_turn", 0) + 1
        if self._turn > self.size or not self._sent:
            self._turn = 0
            return None
        return self._sent.pop(0)

    def rows(self, report: Report) -> np.ndarray:
        return self.rows_of_all[self._given[report.worker]]

    def close(self) -> None:
        pass


class Nowhere:
    """In place of the table."""

    def write(self, ids: np.ndarray, rows: np.ndarray) -> None:
        pass


def taken_in(section: Adaptive | Sought, axes: dict[str, list[float]], ranks: int) -> tuple[float, np.ndarray]:
    """Seconds of this core for a whole search, and which tasks it chose."""
    search = section.search(axes)
    job = Job(search.tasks, choose(), True, True)
    crowd, writer = Crowd(made_up(search, np.random.default_rng(1)), ranks), Nowhere()
    intake = Intake(job, search, writer)

    def more(orders: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        new = intake.rows(orders, rows)
        return new, predicted(job, new)

    start = time.thread_time()
    first = search.ask()
    batches = Batches(first, predicted(job, first), ranks)
    with patch.multiple(master, Reports=lambda *_: crowd, send_work=crowd.send_work):
        master.Master(crowd, batches, None, writer.write, True, more=more).run(lambda: None)
    return time.thread_time() - start, crowd.asked


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lines", type=int, default=2000)
    parser.add_argument("--ranks", type=int, default=128, help="that report")
    args = parser.parse_args()
    axes = {**START, "zeta_T": np.geomspace(1e-5, 1e-2, args.lines // 4).tolist()}
    for name, section in SEARCHES.items():
        seconds, asked = taken_in(section, axes, args.ranks)
        chosen = hashlib.sha256(asked.tobytes()).hexdigest()[:12]
        print(f"{name:20} {asked.sum():7} rows, {asked.sum() / seconds:9.0f} a second of a core; chosen {chosen}")


if __name__ == "__main__":
    main()
