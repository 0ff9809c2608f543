"""One table over one fault: started on two simulated nodes, hit at a random instant, mended, resumed (tests.faults)."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sweep.errors import InputError
from sweep.serve.pulse import DISK_MAX, SILENCE_MAX
from sweep.store.mailbox import GUEST, folder_of, names

from ..chaos import content, finished_rows
from ..conftest import BIN, clean_environment
from .cluster import Cluster, until
from .machines import Machine

LOOK = """
import json, sys
from pathlib import Path
import numpy as np
from sweep.store import table
sys.stdin.readline()
with table.reading(Path(sys.argv[1])) as file:
    ids, sums = np.flatnonzero(table.finished(file)), file["results"]["checksum"]
print(json.dumps({str(i): int(sums[i]) for i in ids}))
"""
SPEC = """
name = "faults"
[grid]
N         = { linear = [60, 200], points = 41 }
zeta_T    = [1e-4, 1e-3]
M_over_M0 = [0.5, 2]
V_over_V0 = { linear = [0.3, 3], points = 6 }
[accuracy]
method = "rk45"
rtol = 1e-6
"""
TASKS = 41 * 2 * 2 * 6
PIPE: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
FOR_GOOD = float("inf")  # seconds, of what is never repaired while the run goes on
FAULTS = {
    **{
        f"cut {name}": ("cut", seconds)
        for name, seconds in (("5 s", 5), ("20 s", 20), ("2 min", 120), ("for good", FOR_GOOD))
    },
    "node off": ("off", FOR_GOOD),
    **{f"disk gone {name}": ("brick", seconds) for name, seconds in (("8 s", 8), ("55 s", 55), ("for good", FOR_GOOD))},
}
JOIN = "join"
WAYS, PLACES = ("gather", "mpio", JOIN), ("other", "rank 0")  # how both nodes compute; which of them is hit
START, PEACE = 120.0, 150.0  # seconds for the first rows, and for a run of a table
# Seconds after a fault by which every process has ended, unless the run goes on: the silence, then an abort, and the
# 42 s after which Gluster lets go of processes that wait for it; and as many as a busy machine may take.
END = SILENCE_MAX + 5.0 + 42.0 + 30.0


class Fault(NamedTuple):
    """One of what is drawn."""

    name: str
    way: str
    place: str


class Trial:
    """One table, from its creation over one fault to its end."""

    def __init__(self, cluster: Cluster, fault: Fault, whole: bytes, count: Counter[str]) -> None:
        self.cluster, self.fault, self.whole, self.count = cluster, fault, whole, count
        self.victim = cluster.node2
        self.first = cluster.node2 if fault.place == "rank 0" else cluster.node1
        self.second = cluster.node1 if fault.place == "rank 0" else cluster.node2
        self.path, self.seen = cluster.work / "t.h5", dict[str, int]()
        self.guest: subprocess.Popen[str] | None = None
        self.log, self.seconds = "", 0.0

    def start(self) -> "subprocess.Popen[str]":
        """The run, launched on the node of rank 0."""
        run = [BIN / "sweep", "run", self.cluster.work / "spec.toml", "-o", self.path]
        if self.fault.way == JOIN:
            return self.first.start(*run, **PIPE, env=clean_environment())
        launch = [BIN / "mpirun", "-launcher", "ssh", "-launcher-exec", self.cluster.ssh, "-n", "2", "-hosts"]
        hosts = f"{self.first.name},{self.second.name}"
        return self.first.start(*launch, hosts, *run, "--writer", self.fault.way, **PIPE, env=clean_environment())

    def has_joined(self) -> bool:
        """Whether the other node computes too; where it is to join, it is told to, once."""
        if self.fault.way != JOIN:
            return True
        if self.guest is None:
            self.guest = self.second.start(BIN / "sweep", "join", self.path, **PIPE, env=clean_environment())
        return bool(names(folder_of(self.cluster.brick / "t.h5"), GUEST))

    def reader(self, node: Machine) -> "subprocess.Popen[str]":
        """Somebody on a node who will look into the table when told to, at once."""
        both = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        return node.start(BIN / "python", "-c", LOOK, self.path, **both, env=clean_environment())

    @staticmethod
    def look(reader: "subprocess.Popen[str]") -> dict[str, int] | None:
        """What it sees is done; None where the disk does not answer."""
        with contextlib.suppress(subprocess.TimeoutExpired, ValueError):
            return dict(json.loads(reader.communicate("now\n", timeout=60.0)[0]))
        reader.kill()
        return None

    def ranks(self) -> list[str]:
        """What still runs, on the nodes that are on."""
        nodes = [node for node in (self.cluster.node1, self.cluster.node2) if node.is_on]
        return [
            f"{node.name}: {pid}" for node in nodes for pid in node.on("pgrep", "-f", "sweep (run|join)").stdout.split()
        ]

    def one(self, rng: np.random.Generator) -> None:
        """Start, break, wait, repair, resume; count."""
        for left in self.cluster.brick.glob("*t.h5*"):
            shutil.rmtree(left) if left.is_dir() else left.unlink()
        process, reader = self.start(), self.reader(self.first if rng.random() < 0.5 else self.cluster.node1)
        if not self.wait_for_rows(process, int(rng.integers(20, TASKS // 2))):
            self.log = self.end(process)
            raise AssertionError(f"the run ended before it was hit:\n{self.log}")
        self.seen = self.look(reader) or {}
        hurt = time.monotonic()
        self.inflict()
        repaired = False
        while (left := process.poll() is None or self.ranks()) and time.monotonic() < hurt + self.limit():
            if not repaired and time.monotonic() > hurt + FAULTS[self.fault.name][1]:
                repaired = self.repair()
            time.sleep(0.5)
        self.seconds = time.monotonic() - hurt
        if left:
            self.count["hung"] += 1
            self.log = f"left: mpirun {process.poll()}, {self.ranks()}\n"
        if not repaired:
            self.repair()
        self.log += self.end(process)
        self.judge_end(process.returncode)
        self.resume()

    def limit(self) -> float:
        """Seconds after the fault by which all has ended: a run that goes on may compute to its end."""
        kind, lasts = FAULTS[self.fault.name]
        patience = DISK_MAX if kind == "brick" else 0.0  # what one write may take
        return (0.0 if lasts == FOR_GOOD else lasts) + max(END, PEACE if lasts <= 20 else 0.0) + patience

    def wait_for_rows(self, process: "subprocess.Popen[str]", wanted: int) -> bool:
        """Whether so many rows came before the run's end."""
        until = time.monotonic() + START
        while process.poll() is None and time.monotonic() < until:
            with contextlib.suppress(InputError, OSError):
                rows = len(finished_rows(self.cluster.brick / "t.h5"))
                if rows and self.has_joined() and rows >= wanted:
                    return True
            time.sleep(0.2)
        return False

    def inflict(self) -> None:
        """Break it."""
        kind, _ = FAULTS[self.fault.name]
        {"cut": self.victim.cut, "off": self.victim.power_off, "brick": self.cluster.kill_brick}[kind]()

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
                node.on("pkill", "-KILL", "-f", "hydra|mpiexec|sweep (run|join)")
        with contextlib.suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)
        log = process.communicate(timeout=60)[0]
        return log if self.guest is None else f"{log}\n--- the guest:\n{self.guest.communicate(timeout=60)[0]}"

    def judge_end(self, status: int) -> None:
        """How the broken run ended, and whether its total was right."""
        kind = {0: "went on", 75: "ended 75", 2: "ended 2"}.get(status, "ended else")
        if FAULTS[self.fault.name][0] == "off" and self.first is self.victim:
            kind = "died with its node"
        if self.guest is not None and self.guest.returncode in (1, -signal.SIGABRT, -signal.SIGSEGV):
            kind = "ended else"
        self.count.update({"faults": 1, kind: 1, "wrong total": status == 0 and not self.adds_up(self.log)})

    @staticmethod
    def adds_up(log: str) -> bool:
        told = re.search(r"^(\d+) done, (\d+) failed, (\d+) left;", log, re.MULTILINE)
        return told is not None and sum(map(int, told.groups())) == TASKS

    def resume(self) -> None:
        """Nothing that was reported is gone; the same command completes the table, with the same bits."""
        for node in (self.first, self.second):  # the disk comes back by itself
            until(lambda node=node: node.on("stat", self.cluster.work / "spec.toml").returncode == 0, "the disk")
        after = self.look(self.reader(self.cluster.node1)) or {}
        self.count.update({"rows reported": len(self.seen), "lost": len(self.seen.keys() - after.keys())})
        self.count["torn"] += sum(after.get(i, row) != row for i, row in self.seen.items())
        process, self.guest = self.start(), None
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
