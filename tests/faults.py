"""Breaks simulated nodes while they compute, and counts what is lost: `python -m tests.faults [--faults N] [--seed S]`.

Two nodes compute one table on a Gluster disk that a third machine serves (tests/nodes): as two ranks, with either
writer, or as a run on one of them and a `sweep join` on the other. At a random instant the cable of a node is cut, for
5, 20 or 120 seconds or for good, the node loses its power, or the server of the disk dies, for 8 or 55 seconds or for
good: the node that holds rank 0 and its launcher, or the other. The run must then end by itself, with every rank and
guest; after the repair the same sweep runs again, to the end. Most of that is waiting: `--at-once K` does it on K
separate clusters.

A row counts as reported done once a reader on a node has read it, sealed, from the table. What a run prints must add
up: done, failed and left are all tasks, or its exit status is not 0. Exit status 1 where a row was lost or torn, a run
hung, a total was wrong, or a resumed table differs from one that was left in peace. Needs root, namespaces and Gluster.
"""

import argparse
import contextlib
import json
import os
import signal
import sys
import threading
from collections import Counter, defaultdict
from queue import Empty, Queue

import numpy as np

from .measured import keep
from .nodes.cluster import Cluster, why_not
from .nodes.trial import FAULTS, PLACES, SPEC, WAYS, Fault, Trial, in_peace

BAD = ("lost", "torn", "hung", "wrong total", "different")
ENDS = ("went on", "ended 75", "ended 2", "died with its node", "ended else")
COUNTED = ("faults", *ENDS, "rows reported", *BAD)
Counts = dict[Fault, Counter[str]]


def table(counts: Counts) -> list[dict[str, str]]:
    """A line for each fault, way and place."""
    lines = []
    for (name, way, place), counted in sorted(counts.items(), key=lambda item: _order(item[0])):
        numbers = {each: str(counted[each]) for each in COUNTED}
        lines.append({"fault": name, "way": way, "hit": place} | numbers | {"longest": f"{counted['longest']} s"})
    return lines


def _order(fault: Fault) -> tuple[int, int, str]:
    return [*FAULTS].index(fault.name), WAYS.index(fault.way), fault.place


def short(counts: Counts) -> list[dict[str, str]]:
    """For the documentation: whichever node was hit, and in few columns."""
    together: Counts = defaultdict(Counter)
    for (name, way, _), counted in counts.items():
        both = together[Fault(name, way, "")]
        longest = max(both["longest"], counted["longest"])
        both.update(counted)
        both["longest"] = longest
    wanted = ["faults", *(end for end in ENDS if any(one[end] for one in together.values())), "rows reported"]
    lines = []
    for line in table(together):
        wrong = ", ".join(f"{line[each]} {each}" for each in BAD if line[each] != "0")
        told = {"fault": line["fault"].replace(" ", "\N{NO-BREAK SPACE}")} | {
            name: line[name] for name in ("way", *wanted)
        }
        lines.append(told | {"wrong": wrong or "0", "longest": line["longest"]})
    return lines


def drawn(faults: int, seed: int, only: str) -> "Queue[tuple[int, Fault]]":
    """The faults, in an order in which each comes about as often as any other."""
    rng, queue = np.random.default_rng(seed), Queue()
    every = [Fault(name, way, place) for name in FAULTS for way in WAYS for place in PLACES]
    every = [fault for fault in every if only in "; ".join(fault)]
    for i in range(faults):
        if i % len(every) == 0:
            rng.shuffle(every)  # type: ignore[arg-type]
        queue.put((i, Fault(*every[i % len(every)])))
    return queue


class Tally:
    """What came of all of them."""

    def __init__(self, seed: int) -> None:
        self.counts: dict[Fault, Counter[str]] = defaultdict(Counter)
        self.seed, self.bad, self.whole = seed, 0, in_peace()
        self._one = threading.Lock()

    def work(self, cluster: Cluster, queue: "Queue[tuple[int, Fault]]") -> None:
        """Break one cluster until all faults are done."""
        with contextlib.closing(cluster), contextlib.suppress(Empty):
            cluster.start(slurm=False)
            while True:
                number, fault = queue.get_nowait()
                (cluster.brick / "spec.toml").write_text(SPEC)
                trial = Trial(cluster, fault, self.whole, Counter())
                try:
                    trial.one(np.random.default_rng([self.seed, number]))
                except AssertionError as error:  # the run was not there to be hit
                    trial.count["wrong total"] += 1
                    trial.log = str(error)
                with self._one:
                    self.add(number, trial)

    def add(self, number: int, trial: Trial) -> None:
        """Count one more."""
        new, before = trial.count, self.counts[trial.fault]
        wrong = sum(new[name] for name in BAD)
        self.bad += wrong
        print(
            f"{number + 1}: {'; '.join(trial.fault)}: {dict(+new)}, {trial.seconds:.0f} s", file=sys.stderr, flush=True
        )
        if wrong or new["ended else"]:
            print(trial.log, file=sys.stderr, flush=True)
        before.update(new)
        before["longest"] = max(before["longest"], round(trial.seconds))


def main() -> int:
    """Print what was counted; the exit status."""
    parser = argparse.ArgumentParser(
        prog="tests.faults", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--faults", type=int, default=200, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--only", default="", metavar="TEXT", help="only faults in whose line this is")
    parser.add_argument("--at-once", type=int, default=1, metavar="K", help="so many clusters side by side")
    parser.add_argument("--keep", action="store_true", help="for the documentation")
    args = parser.parse_args()
    if why := why_not():
        print(why)
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # whoever ends this wants no machines left
    queue, tally = drawn(args.faults, args.seed, args.only), Tally(args.seed)
    clusters = [Cluster() for _ in range(args.at_once)]
    threads = [threading.Thread(target=tally.work, args=(cluster, queue), daemon=True) for cluster in clusters]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        for cluster in clusters:
            cluster.close()
        print(*(json.dumps(line) for line in table(tally.counts)), sep="\n")
    done = sum(counted["faults"] for counted in tally.counts.values())
    print(f"{done} faults, {tally.bad} wrong")
    if args.keep:
        keep(
            "faults",
            short(tally.counts),
            f"{done} random faults, {args.at_once} clusters at once on {os.cpu_count()} cores",
        )
    return int(tally.bad > 0 or done < args.faults)


if __name__ == "__main__":
    sys.exit(main())
