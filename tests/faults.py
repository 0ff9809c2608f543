"""Breaks simulated nodes while they compute, and counts what is lost: `python -m tests.faults [--faults N] [--seed S]`.

Two nodes write one table on a Gluster disk that a third machine serves (tests/nodes). At a random instant the cable of
a node is cut, for 5, 20 or 120 seconds or for good, the node loses its power, or the server of the disk dies, for 8 or
55 seconds or for good: the node that holds rank 0 and its launcher, or the other; with either writer. The run must then
end by itself, with every rank; after the repair the same sweep runs again, to the end.

A row counts as reported done once a reader on a node has read it, sealed, from the table. What a run prints must add
up: done, failed and left are all tasks, or its exit status is not 0. Exit status 1 where a row was lost or torn, a run
hung, a total was wrong, or a resumed table differs from one that was left in peace. Needs root, namespaces and Gluster.
"""

import argparse
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sweep.errors import InputError
from sweep.serve.pulse import SILENCE_MAX

from .chaos import content, finished_rows
from .conftest import BIN, clean_environment
from .nodes.cluster import Cluster, why_not
from .nodes.machines import Machine

LOOK = """
import json, sys
from pathlib import Path
import numpy as np
from sweep.store import table
with table.reading(Path(sys.argv[1])) as file:
    ids, sums = np.flatnonzero(table.finished(file)), file["results"]["checksum"]
print(json.dumps({str(i): int(sums[i]) for i in ids}))
"""
SPEC = """
name = "faults"
[grid]
N         = { linear = [60, 160], points = 41 }
zeta_T    = [1e-4, 1e-3]
M_over_M0 = [0.5, 2]
V_over_V0 = { linear = [0.3, 3], points = 6 }
[accuracy]
method = "rk45"
rtol = 1e-6
"""
TASKS = 41 * 2 * 2 * 6
FOR_GOOD = float("inf")  # seconds, of what is never repaired while the run goes on
FAULTS = {
    **{
        f"cut {name}": ("cut", seconds)
        for name, seconds in (("5 s", 5), ("20 s", 20), ("2 min", 120), ("for good", FOR_GOOD))
    },
    "node off": ("off", FOR_GOOD),
    **{f"disk gone {name}": ("brick", seconds) for name, seconds in (("8 s", 8), ("55 s", 55), ("for good", FOR_GOOD))},
}
WRITERS, PLACES = ("gather", "mpio"), ("other", "rank 0")  # which node is hit
START, PEACE = 120.0, 150.0  # seconds for the first rows, and for a run of a table
# Seconds after a fault by which every process has ended, unless the run goes on: the silence, then an abort, and the
# 42 s after which Gluster lets go of processes that wait for it; and as many as a busy machine may take.
END = SILENCE_MAX + 5.0 + 42.0 + 30.0
COUNTED = (
    "faults",
    "went on",
    "ended 75",
    "ended 2",
    "ended else",
    "rows reported",
    "lost",
    "torn",
    "hung",
    "wrong total",
    "different",
)


class Fault(NamedTuple):
    """One of what is drawn."""

    name: str
    writer: str
    place: str


class Trial:
    """One table, from its creation over one fault to its end."""

    def __init__(self, cluster: Cluster, fault: Fault, whole: bytes, count: Counter[str]) -> None:
        self.cluster, self.fault, self.whole, self.count = cluster, fault, whole, count
        self.victim = cluster.node2
        self.first = cluster.node2 if fault.place == "rank 0" else cluster.node1
        self.path, self.seen = cluster.work / "t.h5", {}
        self.log, self.seconds = "", 0.0

    def start(self) -> "subprocess.Popen[str]":
        """The run, launched on the node of rank 0."""
        second = next(node for node in (self.cluster.node1, self.cluster.node2) if node is not self.first)
        launch = [BIN / "mpirun", "-launcher", "ssh", "-launcher-exec", self.cluster.ssh, "-n", "2", "-hosts"]
        run = [BIN / "sweep", "run", self.cluster.work / "spec.toml", "-o", self.path, "--writer", self.fault.writer]
        pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "env": clean_environment()}
        return self.first.start(*launch, f"{self.first.name},{second.name}", *run, **pipe)

    def look(self, node: Machine) -> dict[str, int] | None:
        """What a reader on a node is told is done; None where the disk does not answer."""
        with contextlib.suppress(subprocess.TimeoutExpired, ValueError):
            said = node.on(BIN / "python", "-c", LOOK, self.path, timeout=60.0, env=clean_environment()).stdout
            return dict(json.loads(said))
        return None

    def ranks(self) -> list[str]:
        """What still runs, on the nodes that are on."""
        nodes = [node for node in (self.cluster.node1, self.cluster.node2) if node.is_on]
        return [f"{node.name}: {pid}" for node in nodes for pid in node.on("pgrep", "-f", "sweep run").stdout.split()]

    def one(self, rng: np.random.Generator) -> None:
        """Start, break, wait, repair, resume; count."""
        for file in self.cluster.brick.glob("*t.h5*"):
            file.unlink()
        process, hurt = self.start(), 0.0
        if not self.wait_for_rows(process, int(rng.integers(20, TASKS // 2))):
            self.log = self.end(process)
            raise AssertionError(f"the run ended before it was hit:\n{self.log}")
        self.remember(self.look(self.first if rng.random() < 0.5 else self.cluster.node1))
        hurt = time.monotonic()
        repaired = self.inflict()
        while (left := process.poll() is None or self.ranks()) and time.monotonic() < hurt + self.limit():
            if not repaired and time.monotonic() > hurt + FAULTS[self.fault.name][1]:
                repaired = self.repair()
            time.sleep(0.5)
        self.seconds = time.monotonic() - hurt
        self.count["hung"] += bool(left)
        if not repaired:
            self.repair()
        self.log = self.end(process)
        self.judge_end(process.returncode)
        self.resume()

    def limit(self) -> float:
        """Seconds after the fault by which all has ended: a run that goes on may compute to its end."""
        lasts = FAULTS[self.fault.name][1]
        return (0.0 if lasts == FOR_GOOD else lasts) + max(END, PEACE if lasts <= 20 else 0.0)

    def wait_for_rows(self, process: "subprocess.Popen[str]", wanted: int) -> bool:
        """Whether so many rows came before the run's end."""
        until = time.monotonic() + START
        while process.poll() is None and time.monotonic() < until:
            with contextlib.suppress(InputError, OSError):
                if len(finished_rows(self.cluster.brick / "t.h5")) >= wanted:
                    return True
            time.sleep(0.2)
        return False

    def remember(self, seen: dict[str, int] | None) -> None:
        self.seen |= seen or {}

    def inflict(self) -> bool:
        """Break it; whether nothing is to be repaired while the run goes on."""
        kind, lasts = FAULTS[self.fault.name]
        {"cut": self.victim.cut, "off": self.victim.power_off, "brick": self.cluster.kill_brick}[kind]()
        return False if lasts < FOR_GOOD else kind == "never"

    def repair(self) -> bool:
        """Put it back as it was."""
        kind, _ = FAULTS[self.fault.name]
        if kind == "cut":
            self.victim.mend()
        elif kind == "brick":
            self.cluster.revive_brick()
        else:
            self.victim.boot()
            self.cluster.bring_up(self.victim)
        return True

    def end(self, process: "subprocess.Popen[str]") -> str:
        """Kill what is left; what the run has said."""
        for node in (self.cluster.node1, self.cluster.node2):
            if node.is_on:
                node.on("pkill", "-KILL", "-f", "hydra|mpiexec|sweep run")
        with contextlib.suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)
        return process.communicate(timeout=60)[0]

    def judge_end(self, status: int) -> None:
        """How the broken run ended, and whether its total was right."""
        kind = {0: "went on", 75: "ended 75", 2: "ended 2"}.get(status, "ended else")
        self.count.update({"faults": 1, kind: 1, "wrong total": status == 0 and not self.adds_up(self.log)})

    @staticmethod
    def adds_up(log: str) -> bool:
        told = re.search(r"^(\d+) done, (\d+) failed, (\d+) left;", log, re.MULTILINE)
        return told is not None and sum(map(int, told.groups())) == TASKS

    def resume(self) -> None:
        """Nothing that was reported is gone; the same command completes the table, with the same bits."""
        after = None
        for _ in range(6):  # the disk comes back by itself
            if (after := self.look(self.cluster.node1)) is not None:
                break
        after = after or {}
        self.count.update({"rows reported": len(self.seen), "lost": len(self.seen.keys() - after.keys())})
        self.count["torn"] += sum(after.get(i, row) != row for i, row in self.seen.items())
        process = self.start()
        try:
            log, status = process.communicate(timeout=PEACE)[0], process.returncode
        except subprocess.TimeoutExpired:
            self.count["hung"] += 1
            log, status = self.end(process), -1
        whole = status == 0 and self.adds_up(log)
        self.count["wrong total"] += status == 0 and not whole
        self.count["different"] += not whole or content(self.cluster.brick / "t.h5") != self.whole
        if not whole:
            self.log += f"\n--- resumed: {status}\n{log}"


def in_peace() -> bytes:
    """The bits of a table that was left in peace, on one machine."""
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "spec.toml").write_text(SPEC)
        command = [BIN / "mpirun", "-n", "2", BIN / "sweep", "run", "spec.toml", "-o", "t.h5"]
        subprocess.run(command, cwd=name, env=clean_environment(), check=True, capture_output=True, timeout=PEACE)
        return content(Path(name) / "t.h5")


def table(counts: dict[Fault, Counter[str]]) -> str:
    """For people, and the documentation."""
    lines = ["| fault | writer | hit | " + " | ".join((*COUNTED, "longest")) + " |", "|---" * (len(COUNTED) + 4) + "|"]
    for (name, writer, place), counted in sorted(counts.items(), key=lambda item: [*FAULTS].index(item[0].name)):
        cells = (str(counted[each]) for each in COUNTED)
        lines.append(f"| {name} | {writer} | {place} | {' | '.join(cells)} | {counted['longest']} s |")
    return "\n".join(lines)


def main() -> int:
    """Print what was counted; the exit status."""
    parser = argparse.ArgumentParser(
        prog="tests.faults", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--faults", type=int, default=200, metavar="N")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--only", default="", metavar="TEXT", help="only faults whose name has this in it")
    args = parser.parse_args()
    if why := why_not():
        print(why)
        return 2
    rng, counts, whole = np.random.default_rng(args.seed), defaultdict(Counter), in_peace()
    names = [name for name in FAULTS if args.only in name]
    every = [Fault(name, writer, place) for name in names for writer in WRITERS for place in PLACES]
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # whoever ends this wants no machines left
    cluster, bad = Cluster(), 0
    try:
        cluster.start(slurm=False)
        for i in range(args.faults):
            if i % len(every) == 0:
                rng.shuffle(every)  # type: ignore[arg-type]
            fault = Fault(*every[i % len(every)])
            (cluster.brick / "spec.toml").write_text(SPEC)
            before = counts[fault].copy()
            trial = Trial(cluster, fault, whole, counts[fault])
            trial.one(rng)
            counts[fault]["longest"] = max(counts[fault]["longest"], round(trial.seconds))
            new = counts[fault] - before
            wrong = sum(new[name] for name in ("lost", "torn", "hung", "wrong total", "different"))
            bad += wrong
            print(f"{i + 1}: {'; '.join(fault)}: {dict(new)}", file=sys.stderr, flush=True)
            if wrong or new["ended else"]:
                print(trial.log, file=sys.stderr, flush=True)
    finally:
        cluster.stop()
        print(table(counts))
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
