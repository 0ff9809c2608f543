"""Tables as bad disks, interrupted copies and other programs leave them."""

import contextlib
import io
import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from sweep import cli
from sweep.schema import PARAMETERS, PENDING, RESULTS, ROW, RUN, RUN_COLUMNS, RUNS, is_sealed, seal
from sweep.store import table
from sweep.store.structure import seal_structure
from tests.fuzz.children import Case
from tests.fuzz.judge import ACCEPTED, WRONG, Told, judged
from tests.fuzz.specs import GOOD

CONTENT = [name for name in ROW.names or () if name not in RUN_COLUMNS]
OTHER = GOOD.replace("[0, 1e-3]", "[1e-2]").replace("[5, 8]", "[5, 9]")


@dataclass(frozen=True)
class Truth:
    """Sound tables, and the rows that no other table may contradict."""

    tables: dict[str, bytes]
    rows: dict[bytes, bytes]  # parameters to content


def content(rows: np.ndarray) -> dict[bytes, bytes]:
    """Of finished rows: what must not depend on what happened, by the task's parameters."""
    kept = rows[(rows["status"] != PENDING) & is_sealed(rows)]
    return {
        b"".join(row[name].tobytes() for name in PARAMETERS): b"".join(row[name].tobytes() for name in CONTENT)
        for row in kept
    }


@contextmanager
def sound() -> Iterator[Truth]:
    """A complete table, one half done, a shard, and one that is no grid; made in a folder that goes away."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            for spec, text in (("good", GOOD), ("other", OTHER)):
                (folder / f"{spec}.toml").write_text(text)
                assert cli.main(["run", f"{folder}/{spec}.toml", "-o", f"{folder}/{spec}.h5"]) == 0
            assert cli.main(["run", f"{folder}/good.toml", "--shard", "1/2", "-o", f"{folder}/shard.h5"]) == 0
            assert cli.main(["merge", f"{folder}/good.h5", f"{folder}/other.h5", "-o", f"{folder}/list.h5"]) == 0
        (folder / "half.h5").write_bytes((folder / "good.h5").read_bytes())
        with h5py.File(folder / "half.h5", "r+") as file:
            rows = file[RESULTS][()]
            rows["status"][::2] = PENDING
            file[RESULTS][...] = rows
        with h5py.File(folder / "list.h5") as file:
            known = content(file[RESULTS][()])
        yield Truth({path.stem: path.read_bytes() for path in folder.glob("*.h5")}, known)


def flipped(rng: np.random.Generator, path: Path) -> None:
    """Bits, most often where the structure is."""
    raw = bytearray(path.read_bytes())
    for _ in range(int(rng.choice([1, 1, 2, 20, 500]))):
        raw[_place(rng, len(raw))] ^= 1 << int(rng.integers(8))
    path.write_bytes(raw)


def _place(rng: np.random.Generator, size: int) -> int:
    return int(rng.choice([rng.integers(size), rng.integers(min(size, 8192)), max(0, size - 1 - rng.integers(4096))]))


def truncated(rng: np.random.Generator, path: Path) -> None:
    raw = path.read_bytes()
    path.write_bytes(raw[: _place(rng, len(raw))])


def overwritten(rng: np.random.Generator, path: Path) -> None:
    """Blocks of zeros, of noise, or of another part of the file."""
    raw = bytearray(path.read_bytes())
    for _ in range(int(rng.integers(1, 4))):
        at, size, source = _place(rng, len(raw)), int(2 ** rng.integers(1, 17)), _place(rng, len(raw))
        block = (bytes(size), rng.bytes(size), bytes(raw[source : source + size]))[int(rng.integers(3))]
        block = block[: len(raw) - at]
        raw[at : at + len(block)] = block
    path.write_bytes(raw)


def lengthened(rng: np.random.Generator, path: Path) -> None:
    """Something at the end, in front, or in the middle."""
    raw, more = path.read_bytes(), rng.bytes(int(2 ** rng.integers(0, 14)))
    at = int(rng.choice([0, len(raw), _place(rng, len(raw))]))
    path.write_bytes(raw[:at] + more + raw[at:])


def foreign(rng: np.random.Generator, path: Path) -> None:
    """HDF5 of another structure that bears our names."""
    from tests.fuzz import foreign as makers

    path.unlink()
    makers.make(rng, path)


TEXTS = ("", "{", "[]", "{}", "null", "1e999", "NaN", "[[[[", '"x"', '{"grid": 1}', '{"grid": {"N": [5]}}', "\0", "é")
TEXTS += ("[1]" * 50,)


def told_otherwise(rng: np.random.Generator, path: Path) -> None:
    """Other texts in the provenance, under a checksum that holds: another program's, or an older version's."""
    with h5py.File(path, "r+") as file:
        known = file[table.PROVENANCE]
        name = str(rng.choice([*known, "shard", "merged", "resolved"]))
        old = bytes(known[name][()]).decode() if name in known else "{}"
        new: object = str(rng.choice([*TEXTS, old[: int(rng.integers(1 + len(old)))], _other_json(rng, old)]))
        kind = int(rng.integers(8))
        if name in known:
            del known[name]
        if kind == 0:
            new = int(rng.integers(9))
        elif kind == 1:
            new = np.bytes_(rng.bytes(20))
        if kind == 2:
            known.create_group(name)
        elif kind != 3:
            known[name] = np.bytes_(new.encode()) if isinstance(new, str) else new
    seal_structure(path)


def _other_json(rng: np.random.Generator, old: str) -> str:
    """One value of the document is another."""
    try:
        document = json.loads(old)
    except ValueError:
        return old
    place = document
    while isinstance(place, dict) and place:
        key = str(rng.choice(list(place)))
        if rng.random() < 0.4 or not isinstance(place[key], dict):
            values = (None, [], {}, "x", -1, 1e400, float("nan"), [None], [[]], True, 10**30, ["a"], [1.5], {"N": 1})
            place[key] = values[int(rng.integers(len(values)))]
            break
        place = place[key]
    return json.dumps(document)


def other_runs(rng: np.random.Generator, path: Path) -> None:
    """Noise in the list of runs, which changes while a run lives and so has no checksum."""
    with h5py.File(path, "r+") as file:
        log = file[RUNS][()]
        for _ in range(int(rng.integers(1, 4))):
            row, name = int(rng.integers(4)), str(rng.choice(RUN.names))
            numbers = (np.nan, np.inf, -1.0, 1e300, 0.0, -(2.0**63), 2.0**62)
            kind = RUN[name].kind
            log[name][row] = rng.bytes(16) if kind == "S" else _as(RUN[name], numbers[int(rng.integers(len(numbers)))])
            if rng.random() < 0.2:
                log[row] = np.frombuffer(rng.bytes(RUN.itemsize), RUN)[0]
        file[RUNS][...] = log


def _as(dtype: np.dtype, number: float) -> np.generic:
    with np.errstate(all="ignore"):
        return np.array(number).astype(dtype)[()]


def forged(rng: np.random.Generator, path: Path) -> None:
    """Rows of nonsense whose checksums hold."""
    with h5py.File(path, "r+") as file:
        rows = file[RESULTS][()]
        for _ in range(int(rng.integers(1, 4))):
            row, name = int(rng.integers(len(rows))), str(rng.choice(ROW.names))
            numbers = (np.nan, np.inf, -1.0, 0.0, 1e300, 1e9, 5e-324)
            kind = ROW[name].kind
            rows[name][row] = rng.bytes(16) if kind == "S" else _as(ROW[name], numbers[int(rng.integers(len(numbers)))])
        seal(rows)
        file[RESULTS][...] = rows


DAMAGES: dict[str, Callable[[np.random.Generator, Path], None]] = {
    "table: bits flipped": flipped,
    "table: truncated": truncated,
    "table: overwritten": overwritten,
    "table: lengthened": lengthened,
    "table: foreign HDF5": foreign,
    "table: provenance": told_otherwise,
    "table: list of runs": other_runs,
    "table: forged rows": forged,
}
SAYS, ENDS = {0, 2}, {0, 1, 2, 75}
READERS: tuple[tuple[set[int], str], ...] = (
    (SAYS, "status t.h5"),
    (SAYS, "status t.h5 --json"),
    (SAYS, "show t.h5"),
    (SAYS, "show t.h5 --json"),
    (SAYS, "export t.h5 -o e.csv"),
    (SAYS, "export t.h5 -o e.parquet --all"),
    (ENDS, "merge t.h5 sound.h5 -o m.h5"),
    (ENDS, "merge sound.h5 -o t.h5"),
)
WRITERS: tuple[tuple[set[int], str], ...] = (
    (ENDS, "run spec.toml -o t.h5"),
    (ENDS, "run spec.toml -o t.h5 --repair"),
    (ENDS, "run spec.toml -o t.h5 --recompute"),
    (ENDS, "run spec.toml -o t.h5 --keep-rows --retry-failed"),
    (ENDS, "run spec.toml -o m.h5 --reuse t.h5"),
    ({0, 1, 2}, "audit t.h5"),
)
WRITERS_SHARE = 0.2  # of the cases: they compute


def kinds(truth: Truth) -> dict[str, Case]:
    """A case per kind of damage: a sound table, damaged, given to one of the commands that take tables."""
    return {kind: _case(truth, damage) for kind, damage in DAMAGES.items()}


def _case(truth: Truth, damage: Callable[[np.random.Generator, Path], None]) -> Case:
    def case(rng: np.random.Generator, folder: Path) -> Told:
        names = sorted(truth.tables)
        (folder / "spec.toml").write_text(GOOD)
        (folder / "sound.h5").write_bytes(truth.tables["good"])
        (folder / "t.h5").write_bytes(truth.tables[names[int(rng.integers(len(names)))]])
        damage(rng, folder / "t.h5")
        commands = WRITERS if rng.random() < WRITERS_SHARE else READERS
        statuses, command = commands[int(rng.integers(len(commands)))]
        writes = not command.startswith(("status", "show", "audit"))
        outcome, why = judged(command.split(), folder, statuses, writes)
        if outcome == ACCEPTED and damage not in (forged, told_otherwise) and (wrong := _wrong(truth, folder)):
            return WRONG, f"{command}: {wrong}"
        return outcome, why

    return case


def _wrong(truth: Truth, folder: Path) -> str:
    """What the tables of the folder hold that is not so."""
    for path in folder.glob("?.h5"):
        with contextlib.suppress(Exception), table.reading(path) as file:
            told = content(file[RESULTS][()])
            differ = [key for key, row in told.items() if truth.rows.get(key) != row]
            if differ:
                return f"{len(differ)} rows of {path.name} differ"
    return ""
