"""A folder with tables, what is known of each, and whether that is so."""

import json
import re
import shutil
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sweep.schema import DONE, RESULTS, SCREENED, UNASKED, content_columns, inputs_of, is_ended
from sweep.store import table
from sweep.tell import report
from tests.histories.commands import Command, Told
from tests.histories.specs import Asked

Rows = dict[bytes, bytes]  # the inputs of a task to what is known of it


class Violation(AssertionError):  # noqa: N818 # what the program looks for
    """What a table or a command promises, and does not keep."""


@dataclass(frozen=True)
class Content:
    """What two runs of one spec have in common."""

    rows: Rows  # that have ended
    columns: dict[str, bytes]
    screened: bytes
    failed: int
    left: int  # rows that are neither computed nor unasked


def content(path: Path) -> Content:
    """Read it without what counts for the user."""
    with table.reading(path) as file:
        rows = file[RESULTS][()]
        screened = file[SCREENED][()].tobytes() if SCREENED in file else b""
    ended, names = is_ended(rows), content_columns(rows.dtype)
    keys, values = (np.ascontiguousarray(rows[list(some)]) for some in (inputs_of(rows.dtype), names))
    packed = [each.astype([(name, each.dtype[name]) for name in each.dtype.names]) for each in (keys, values)]
    found = {packed[0][i].tobytes(): packed[1][i].tobytes() for i in np.flatnonzero(ended)}
    failed = int(np.count_nonzero(ended & (rows["status"] != DONE)))
    left = int(np.count_nonzero(~ended & (rows["status"] != UNASKED)))
    return Content(found, {name: rows[name].tobytes() for name in names}, screened, failed, left)


@dataclass
class Known:
    """What must be so of one table."""

    asked: Asked
    shard: str = ""
    sources: set[str] = field(default_factory=set)  # texts of the specs whose rows it may hold
    rows: Rows = field(default_factory=dict)  # that were seen done
    taken: bool = False  # whether rows were taken from elsewhere that its own spec may not ask for, or asks otherwise
    resumable: bool = True


class World:
    """One history's folder."""

    def __init__(self, folder: Path, rng: np.random.Generator) -> None:
        self.folder, self.rng, self.log = folder / "here", rng, list[str]()
        self._scratch, self._peace = folder / "scratch", folder / "peace"
        for each in (self.folder, self._scratch, self._peace):
            each.mkdir()
        self.tables = dict[str, Known]()
        self._truths = dict[str, Content]()
        self._begun = time.monotonic()
        self.life = 1.0  # seconds of the last run that was left in peace

    def spec(self, name: str, asked: Asked) -> str:
        """Write a spec; its name."""
        (self.folder / name).write_text(asked.text)
        return name

    def truth(self, asked: str) -> Content:
        """Of an undisturbed run of this spec on one rank."""
        if asked not in self._truths:
            shutil.rmtree(self._peace)
            self._peace.mkdir()
            (self._peace / "s.toml").write_text(asked)
            told = Command(self._peace, self._scratch, ["run", "s.toml", "-o", "t.h5"]).wait()
            self.must(told.status in (0, 1), f"in peace: {told}")
            self._truths[asked] = content(self._peace / "t.h5")
            self.must(told.status == (self._truths[asked].failed > 0), f"in peace: {told}")
        return self._truths[asked]

    def must(self, holds: object, what: str) -> None:
        """A promise."""
        if not holds:
            raise Violation(what)

    def start(self, *arguments: str, ranks: int = 1) -> Command:
        """A command that goes on."""
        command = Command(self.folder, self._scratch, list(arguments), ranks)
        self.log.append(command.line)
        return command

    def run(self, *arguments: str, ranks: int = 1) -> Told:
        """A command that is left in peace."""
        told = self.ended(self.start(*arguments, ranks=ranks))
        self.must(told.status in (0, 1, 2, 75), f"exit status {told.status}\n{told.err}")
        return told

    def ended(self, command: Command) -> Told:
        """How a command has ended, which tells no traceback."""
        told = command.wait()
        self.log[-1] += f"  -> {told.status}  {told.out.strip()[:150]}  {time.monotonic() - self._begun:.1f} s"
        self.must("Traceback" not in told.err, f"{command.line}: {told.err}")
        return told

    def tells(self, name: str, told: Told) -> None:
        """What a run in peace has said of its table is so, and so is its exit status."""
        if told.status == 2:
            return
        found = re.search(r"(\d+) done, (\d+) failed, (\d+) left", told.out)
        self.must(found, f"says nothing: {told}")
        assert found
        done, failed, left = map(int, found.groups())
        untried = re.search(r"(\d+) of the rows left failed in an earlier run", told.err)
        again = int(untried[1]) if untried else 0  # for the table they have failed
        status = report.status(self.folder / name)
        known = tuple(int(status[each]) for each in ("done", "failed", "left"))
        self.must((done, failed + again, left - again) == known, f"{name}: says {found[0]}, status tells {known}")
        expected = 75 if left else 1 if failed else 0
        if "more than --max-fails" in told.err:
            expected = 1
        self.must(told.status == expected, f"{name}: exit status {told.status} of {found[0]}")
        self.no_traces(name)

    def no_traces(self, name: str = "") -> None:
        """Nothing lies beside a table, or anywhere, that only a run needs."""
        left = [str(each.relative_to(self.folder)) for each in self.folder.rglob(f".{name}*")]
        left += [str(each.relative_to(self.folder)) for each in self.folder.rglob("*-journal")] if not name else []
        self.must(not left, f"left behind: {left}")

    def look(self) -> None:
        """Every table holds what it held, nothing but what it may hold, and its status is true."""
        for name, known in self.tables.items():
            path = self.folder / name
            if path.exists():
                self._look(name, known, content(path), report.status(path))

    def _look(self, name: str, known: Known, found: Content, status: dict[str, object]) -> None:
        lost = [key for key in known.rows if key not in found.rows]
        self.must(not lost, f"{name}: {len(lost)} rows that were done are lost")
        changed = [key for key, row in known.rows.items() if found.rows[key] != row]
        self.must(not changed, f"{name}: {len(changed)} rows that were done have changed")
        known.rows = found.rows
        truths = [self.truth(text).rows for text in known.sources | {known.asked.text}]
        wrong = [key for key, row in found.rows.items() if not any(each.get(key) == row for each in truths)]
        if known.taken and known.asked.is_search:  # other rows may lead a search elsewhere
            wrong = [key for key in wrong if any(key in each for each in truths)]
        self.must(not wrong, f"{name}: {len(wrong)} of {len(found.rows)} rows are not those of a run in peace")
        done = len(found.rows) - found.failed
        told = status["done"], status["failed"]
        self.must(told == (done, found.failed), f"{name}: status tells {told}, has {done}, {found.failed}")
        if not known.asked.is_search:
            self.must(status["left"] == found.left, f"{name}: status tells {status['left']} left, {found.left} are")
        self.must(status["running"] is False, f"{name}: status tells that it runs: {json.dumps(status)}")

    def finish(self, name: str) -> None:
        """Complete a table; it then has the bits of one that was left in peace."""
        known = self.tables[name]
        more = ["--shard", known.shard] if known.shard else []
        told = self.run("run", self.spec("f.toml", known.asked), "-o", name, *more)
        self.must(told.status in (0, 1), f"{name}: cannot be finished: {told.err}")
        self.tells(name, told)
        self.look()
        found, truth = content(self.folder / name), self.truth(known.asked.text)
        self.must(told.status == (found.failed > 0), f"{name}: exit status {told.status}")
        self.must(report.status(self.folder / name)["left"] == 0, f"{name}: something is left")
        if known.shard:
            return
        if known.taken:
            lacks = truth.rows.keys() - found.rows.keys() if not known.asked.is_search else set()
            self.must(not lacks, f"{name}: lacks {len(lacks)} rows")
            return
        differ = [each for each, bits in truth.columns.items() if found.columns[each] != bits]
        self.must(not differ, f"{name}: differs from a run in peace in {differ}")
        self.must(found.screened == truth.screened, f"{name}: what was screened differs from a run in peace")


def was_stopped(told: Told, ranks: int) -> bool:
    """Whether a run that got SIGTERM may end so: before it says that it begins the signal may kill it.

    The status of mpirun tells little (docs/limits.md).
    """
    if told.status in (0, 1, 75):
        return True
    begun, ended = " left; " in told.err, " left" in told.out
    killed = (-signal.SIGTERM, signal.SIGTERM, 128 + signal.SIGTERM) if ranks > 1 else (-signal.SIGTERM,)
    return told.status in killed and (ended or not begun)
