"""What may happen to tables."""

import csv
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from sweep.schema import DONE, RESULTS
from sweep.store import table
from sweep.store.export import columns_of
from sweep.store.shelf import Shelf
from sweep.store.structure import seal_structure
from tests.histories.commands import Command, Told
from tests.histories.specs import Asked
from tests.histories.world import Known, World, was_stopped

WRITERS = ("auto", "mpio", "gather") if h5py.get_config().mpi else ("auto", "gather")
VICTIMS = ("worker", "master", "launcher", "all")


class Steps:
    """The steps of one history about one spec."""

    def __init__(self, world: World, asked: Asked, most: int = 3) -> None:
        """`most`: ranks of any run."""
        self.world, self.asked, self.rng = world, asked, world.rng
        self.run, self.folder, self._most = world.run, world.folder, most
        world.tables["t.h5"] = Known(asked)
        self._has_finer = False  # whether the store has rows that are finer than asked for
        self._others = {"finer": asked.scaled(10), "looser": asked.scaled(0.1)}
        self._others |= {} if asked.kind == "points" else {"beside": asked.beside(self.rng)}

    def one(self) -> None:
        """Any step, then a look at everything."""
        steps: list[Callable[[], None]] = [self.go_on] * 4 + [self.damage, self.other, self.reuse, self.join]
        steps += [self.shards, self.shards, self.export, self.change, self.kernel, self.merge]
        steps[int(self.rng.integers(len(steps)))]()
        self.world.look()

    def _chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def _ranks(self) -> int:
        return min(self._most, int(self.rng.choice([1, 1, 1, 1, 2, 3])))

    def _any_table(self) -> str | None:
        there = [name for name in self.world.tables if (self.folder / name).exists()]
        return str(self.rng.choice(there)) if there else None

    def go_on(self) -> None:
        """Begin or resume the table."""
        self.disturbed("t.h5")

    def disturbed(self, name: str, *more: str) -> None:
        """A run which may be killed, stopped, or have little time."""
        known, ranks = self.world.tables[name], self._ranks()
        line = ["run", self.world.spec("s.toml", known.asked), "-o", name, *more]
        line += ["--shard", known.shard] if known.shard else []
        line += ["--writer", str(self.rng.choice(WRITERS))] if ranks > 1 else []
        line += ["--until", f"{self.rng.uniform(0.3, 2):.1f}s"] if self._chance(0.15) else []
        line += ["--max-fails", str(self.rng.integers(4))] if self._chance(0.15) else []
        if self._chance(0.15):
            line.append("--retry-failed")
        line += self._stored(known) if self._chance(0.2) else []
        if self._chance(0.4):
            self.world.tells(name, self.run(*line, ranks=ranks))
            return
        command = self.world.start(*line, ranks=ranks)
        time.sleep(float(self.rng.uniform(0, (2.5 if ranks > 1 else 0.0) + self.world.life)))
        self._hit(command)

    def _stored(self, known: Known) -> list[str]:
        """The option for a run that shares the store. A grid takes what is finer, too."""
        finer = self._others["finer"]
        self._has_finer |= known.asked == finer
        if self._has_finer or known.asked == self._others["looser"]:
            known.sources |= {self.asked.text, finer.text}
            known.taken |= not known.asked.is_search
        return ["--store", "store"]

    def _hit(self, command: Command) -> Told:
        if self._chance(0.6):
            victim = VICTIMS[int(self.rng.integers(len(VICTIMS)))]
            self.world.log[-1] += f"  kill {victim}"
            command.kill(victim, self.rng)
            return self.world.ended(command)
        self.world.log[-1] += "  SIGTERM"
        command.stop()
        told = self.world.ended(command)
        self.world.must(was_stopped(told, command.ranks), f"{command.line}: exit status {told}")
        return told

    def other(self) -> None:
        """A run of another spec."""
        name = str(self.rng.choice(sorted(self._others)))
        self.world.tables.setdefault(f"{name}.h5", Known(self._others[name]))
        line = ["run", self.world.spec("o.toml", self._others[name]), "-o", f"{name}.h5"]
        line += self._stored(self.world.tables[f"{name}.h5"]) if self._chance(0.5 if name != "finer" else 0.2) else []
        self.world.tells(f"{name}.h5", self.run(*line, ranks=self._ranks()))

    def reuse(self) -> None:
        """A table that takes rows over, or the table itself."""
        if (old := self._any_table()) is None:
            return
        name = "t.h5" if self._chance(0.5) else "u.h5"
        if old == name:
            return
        known = self.world.tables.setdefault(name, Known(self.asked))
        its = self.world.tables[old]
        serves = its.asked != self._others["looser"]
        before = self._bytes(name)
        line = ["run", self.world.spec("s.toml", known.asked), "-o", name, "--reuse", old]
        if serves:
            known.sources |= its.sources | {its.asked.text}
            known.taken |= its.taken or its.asked.text != known.asked.text
        told = self.run(*line, ranks=self._ranks())
        self.world.must((told.status == 2) == (not serves), f"--reuse {old}: {told}")
        if not serves:
            self.world.must(self._bytes(name) == before, f"{name}: a refused run has changed it")
        self.world.tells(name, told)

    def _bytes(self, name: str) -> bytes:
        path = self.folder / name
        return path.read_bytes() if path.exists() else b""

    def change(self) -> None:
        """Another spec with the table: refused."""
        if not (self.folder / "t.h5").exists():
            return
        before = self._bytes("t.h5")
        other = self._others[str(self.rng.choice(sorted(self._others)))]
        told = self.run("run", self.world.spec("o.toml", other), "-o", "t.h5", ranks=self._ranks())
        self.world.must(told.status == 2 and "holds another sweep" in told.err, f"another spec: {told}")
        self.world.must(self._bytes("t.h5") == before, "a refused run has changed the table")
        self.world.no_traces("t.h5")

    def shards(self) -> None:
        """Shares of the sweep, complete or not, in any order, and a table of them."""
        if self.asked.is_search:
            told = self.run("run", self.world.spec("s.toml", self.asked), "-o", "p.h5", "--shard", "1/2")
            self.world.must(told.status == 2 and not (self.folder / "p.h5").exists(), f"a shard of a search: {told}")
            return
        count = 3
        for index in self.rng.permutation(count)[: int(self.rng.integers(1, count + 1))] + 1:
            name = f"p{index}.h5"
            self.world.tables.setdefault(name, Known(self.asked, f"{index}/{count}"))
            self.disturbed(name)
        self.merge()

    def merge(self) -> None:
        """Join what there is of this spec."""
        names = [f"p{index}.h5" for index in (1, 2, 3)] + ["t.h5", "m.h5", "u.h5"]
        there = [name for name in names if (self.folder / name).exists()]
        if not there or self.asked.is_search:
            return
        some = [str(each) for each in self.rng.permutation(there)[: int(self.rng.integers(1, len(there) + 1))]]
        whole = self.asked.kind != "points"
        new = self.world.tables.setdefault("m.h5", Known(self.asked, resumable=whole))
        old = replace(new, sources=set(new.sources))
        for name in some:
            its = self.world.tables[name]
            new.sources |= its.sources
            new.taken |= its.taken
        line = ["merge", *some, "-o", "m.h5"]
        if self._chance(0.3):
            command = self.world.start(*line)
            time.sleep(float(self.rng.uniform(0, 0.3)))
            command.kill("all", self.rng)
            self.world.ended(command)
            if (self.folder / "m.h5").exists():  # else nothing removes what is left
                return
        told = self.run(*line)
        if told.status == 2:
            self.world.must("disagree" in told.err and new.taken, f"merge: {told}")
            self.world.tables["m.h5"] = old
            return
        self._merged(told)

    def _merged(self, told: Told) -> None:
        found = dict(line.split(None, 1) for line in told.out.splitlines() if len(line.split(None, 1)) == 2)
        failed, left = int(found["failed"]), int(found["left"])
        expected = 75 if left else 1 if failed else 0
        self.world.must(told.status == expected, f"merge: exit status {told.status} of {told.out}")
        self.world.no_traces("m.h5")

    def export(self) -> None:
        """Rows as text, read again."""
        if (name := self._any_table()) is None:
            return
        everything = self._chance(0.5)
        told = self.run("export", name, "-o", "e.csv", "--force", *(["--all"] if everything else []))
        self.world.must(told.status == 0, f"export: {told}")
        with table.reading(self.folder / name) as file:
            rows = file[RESULTS][()]
        if not everything:
            rows = rows[rows["status"] == DONE]
        with (self.folder / "e.csv").open() as text:
            lines = list(csv.DictReader(text))
        self.world.must(len(lines) == len(rows), f"export {name}: {len(lines)} lines, {len(rows)} rows")
        for column in columns_of(rows.dtype):
            if rows.dtype[column].kind == "f":
                read = np.array([float(line[column]) for line in lines])
                same = (read == rows[column]) | (np.isnan(read) & np.isnan(rows[column]))
                self.world.must(same.all(), f"export {name}: {column} differs")

    def damage(self) -> None:
        """Bits of a copy flip, or its end is lost; the same sweep finds it."""
        if not (self.folder / "t.h5").exists():
            return
        known = self.world.tables["t.h5"]
        copy = replace(known, rows={}, sources=set(known.sources))
        self.world.tables.pop("d.h5", None)
        for old in ("d.h5", "d.h5.damaged"):
            (self.folder / old).unlink(missing_ok=True)
        raw = bytearray(self._bytes("t.h5"))
        truncated = self._chance(0.3)
        if truncated:
            raw = raw[: int(self.rng.integers(len(raw)))]
        else:
            for place in self.rng.integers(len(raw), size=int(self.rng.choice([1, 3, 30]))):
                raw[place] ^= 1 << int(self.rng.integers(8))
        (self.folder / "d.h5").write_bytes(raw)
        self.world.log.append(f"d.h5 is t.h5, {'truncated' if truncated else 'with bits flipped'}")
        line = ["run", self.world.spec("s.toml", self.asked), "-o", "d.h5"]
        told = self.run(*line, ranks=self._ranks())
        if told.status == 2:
            told = self.run(*line, "--repair", ranks=self._ranks())
            if told.status == 2 and "no trace of this sweep" in told.err:
                return
            (self.folder / "d.h5.damaged").unlink(missing_ok=True)
        self.world.must(told.status in (0, 1), f"damaged: {told}")
        self.world.tables["d.h5"] = copy
        self.world.tells("d.h5", told)
        self.world.finish("d.h5")
        del self.world.tables["d.h5"]

    def join(self) -> None:
        """Processes that join the run, and leave it."""
        if self.asked.is_search or (self.folder / "j.h5").exists():
            return
        self.world.tables["j.h5"] = Known(self.asked)
        line = ["run", self.world.spec("s.toml", self.asked), "-o", "j.h5"]
        line += self._stored(self.world.tables["j.h5"]) if self._chance(0.3) else []
        run = self.world.start(*line, ranks=self._ranks())
        while run.goes_on() and not (self.folder / ".j.h5.join" / "run").exists():
            time.sleep(0.005)
        guest = self.world.start("join", "j.h5", ranks=min(self._most, int(self.rng.choice([1, 1, 2]))))
        if self._chance(0.5):
            time.sleep(float(self.rng.uniform(0, 1)))
            self._hit(guest if self._chance(0.6) else run)
        told = [self.world.ended(each) for each in (run, guest)]
        for each in told:
            self.world.must(each.status in (0, 1, 2, 75, -9, -15, 9, 15, 137, 143), f"join: {each}")

    def kernel(self) -> None:
        """Another kernel has computed the table: refused, kept, or begun again."""
        path = self.folder / "t.h5"
        if not path.exists():
            return
        with h5py.File(path, "r") as file:
            known = bytes(file[table.PROVENANCE]["kernel"][()])
        self._tell_kernel(path, bytes(known[::-1]))
        before = self._bytes("t.h5")
        line = ["run", self.world.spec("s.toml", self.asked), "-o", "t.h5"]
        told = self.run(*line)
        self.world.must(told.status == 2 and self._bytes("t.h5") == before, f"another kernel: {told}")
        how = "--keep-rows" if self._chance(0.5) else "--recompute"
        if how == "--recompute":
            mine = self.world.tables["t.h5"]
            self.world.tables["t.h5"] = Known(mine.asked)
        told = self.run(*line, how, ranks=self._ranks())
        self.world.must(told.status in (0, 1), f"{how}: {told}")
        self.world.tells("t.h5", told)
        if how == "--keep-rows":
            self._tell_kernel(path, known)

    @staticmethod
    def _tell_kernel(path: Path, kernel: bytes) -> None:
        with h5py.File(path, "r+", locking=False) as file:
            group = file[table.PROVENANCE]
            group["kernel"][...] = np.bytes_(kernel)
            runs = file["runs"][()]
            runs["kernel"][runs["kernel"] != b""] = kernel[:16]
            file["runs"][...] = runs
        seal_structure(path)

    def end(self) -> None:
        """Complete every table, then nothing else is there."""
        for name, known in list(self.world.tables.items()):
            if known.resumable and (name != "m.h5" or (self.folder / name).exists()):
                self.world.finish(name)
                if name == "t.h5":
                    again = self.run("run", self.world.spec("f.toml", known.asked), "-o", name)
                    self.world.must(" 0 left; " in again.err, f"{name}: is computed again: {again}")
        if (self.folder / "m.h5").exists():  # of a merge that was killed
            self.run("merge", "m.h5", "-o", "m.h5")
        if (self.folder / "store").exists():
            Shelf(self.folder / "store").close()  # which undoes what a killed run had begun
        self.world.no_traces()
