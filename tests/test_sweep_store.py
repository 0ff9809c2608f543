"""What one sweep has computed no other computes again: rows are kept in a folder, and taken by what they are."""

import contextlib
import json
import os
import signal
import sqlite3
from pathlib import Path

import h5py
import numpy as np
import pytest

import analysis
from sweep.errors import InputError
from sweep.schema import ROW
from sweep.store import shelf
from sweep.store.blocks import INDEX
from sweep.store.known import _Keeper, serving
from sweep.store.shelf import FILE, Shelf

from .conftest import SLOW, SMALL, clean_environment
from .waiting import wait_for_rows

MORE = SMALL.replace("[5, 8, 13]", "[3, 5, 8, 13]")
SEARCH = """
name = "cells"
[grid]
N         = [8, 30]
zeta_T    = [2e-5, 0.1]
M_over_M0 = { log = [0.1, 10], points = 5 }
V_over_V0 = { log = [0.1, 10], points = 6 }
[search]
find = "lowest"
over = ["M_over_M0", "V_over_V0"]
"""
LEVEL = SEARCH[: SEARCH.index("[search]")] + '[search]\nfind = "level"\nalong = "V_over_V0"\nlevel = 0.8\nuntil = 0.1\n'


@pytest.fixture
def run(sweep, tmp_path):
    """run(spec, table, ...): how many rows were taken from the store `rows`, and how many it left to compute."""

    def run(text: str, table: str, *options: object, ranks: int = 1) -> tuple[int, int]:
        (tmp_path / f"{table}.toml").write_text(text)
        answer = sweep("run", f"{table}.toml", "-o", f"{table}.h5", "--store", "rows", *options, ranks=ranks)
        assert answer.returncode == 0, answer.stderr
        said = answer.stderr.splitlines()
        taken = next(line for line in said if "rows taken from the store rows" in line)
        return int(taken.split()[1]), int(
            next(line for line in said if " left; " in line).split(" left; ")[0].split()[-1]
        )

    return run


def told(sweep, name) -> list[dict]:
    return json.loads(sweep("show", name, "--json").stdout)["reused"]


def stored(folder: Path) -> int:
    with sqlite3.connect(folder / FILE) as file:
        return file.execute("SELECT coalesce(sum(length(entries)), 0) FROM blocks").fetchone()[0] // INDEX.itemsize


def test_a_repeated_and_a_contained_sweep_compute_nothing_and_their_bits_are_the_same(sweep, run, tmp_path, physics):
    assert run(MORE, "first") == (0, 32)
    assert run(MORE, "again") == (32, 0)
    assert run(SMALL, "part") == (24, 0)
    assert physics(tmp_path / "again.h5") == physics(tmp_path / "first.h5")
    sweep("run", "part.toml", "-o", "fresh.h5")
    assert physics(tmp_path / "part.h5") == physics(tmp_path / "fresh.h5")
    (entry,) = told(sweep, "part.h5")
    assert (entry["rows"], entry["accuracy"]) == (24, "auto at target 0.01, certified")
    assert entry["table"].startswith(f"store {tmp_path / 'rows'}: ")
    assert entry["table"].endswith(str(tmp_path / "first.h5"))
    assert told(sweep, "first.h5") == []
    assert sum(analysis.table.reused(tmp_path / "part.h5").values()) == 24
    assert run(SMALL, "part") == (0, 0)  # resumed: it has them


@pytest.mark.mpi
def test_a_larger_sweep_computes_what_is_new_on_any_number_of_ranks(sweep, run, tmp_path, physics):
    assert run(SMALL, "small", ranks=2) == (0, 24)
    assert run(MORE, "more", ranks=3) == (24, 8)
    assert run(MORE, "again") == (32, 0)
    sweep("run", "more.toml", "-o", "fresh.h5")
    assert physics(tmp_path / "again.h5") == physics(tmp_path / "more.h5") == physics(tmp_path / "fresh.h5")
    assert sorted(entry["rows"] for entry in told(sweep, "again.h5")) == [8, 24]


@pytest.mark.mpi
@pytest.mark.parametrize("text", [SEARCH, LEVEL])
def test_a_repeated_search_computes_and_screens_nothing(run, tmp_path, physics, text):
    taken, _ = run(text, "first", ranks=2)
    assert taken == 0
    taken, left = run(text, "again")
    assert (taken > 0, left) == (True, 0)
    assert physics(tmp_path / "again.h5") == physics(tmp_path / "first.h5")
    with h5py.File(tmp_path / "first.h5") as one, h5py.File(tmp_path / "again.h5") as other:
        assert [name for name in one if "screened" in name] == [name for name in other if "screened" in name]
        for name in {"screened"} & set(one):
            assert one[name][()].tobytes() == other[name][()].tobytes()


def test_the_environment_names_the_store_as_well(sweep, small_spec, tmp_path):
    env = clean_environment() | {"SWEEP_STORE": str(tmp_path / "rows")}
    assert "0 rows taken from the store" in sweep("run", small_spec, "-o", "a.h5", env=env).stderr
    assert "24 rows taken from the store" in sweep("run", small_spec, "-o", "b.h5", env=env).stderr
    assert "store" not in sweep("run", small_spec, "-o", "c.h5", env=env | {"SWEEP_STORE": ""}).stderr


def test_tighter_rows_answer_a_looser_request_and_never_the_reverse(sweep, run, tmp_path):
    assert run(SMALL.replace("1e-2", "1e-4"), "tight") == (0, 24)
    assert run(SMALL.replace("1e-2", "1e-3"), "fair") == (24, 0)
    assert run(SMALL.replace("1e-2", "1e-5"), "tighter") == (0, 24)
    assert run(SMALL + "certify = false\n", "unchecked") == (24, 0)
    (entry,) = told(sweep, "unchecked.h5")
    assert entry["accuracy"] == "auto at target 0.0001, certified"  # the nearest of those that serve
    fair, tight = (analysis.load(tmp_path / f"{name}.h5") for name in ("fair", "tight"))
    np.testing.assert_array_equal(fair["ke_ratio"], tight["ke_ratio"])


def test_rows_of_its_own_accuracy_come_first(run, tmp_path, physics):
    run(SMALL.replace("1e-2", "1e-4"), "tight")
    run(SMALL, "loose", "--recompute")
    assert run(MORE, "both") == (24, 8)


def test_a_search_takes_no_rows_of_another_accuracy(sweep, run, tmp_path, physics):
    run(LEVEL + "[accuracy]\ntarget = 1e-5\n", "tight")
    taken, _ = run(LEVEL, "search")
    assert taken == 0


@pytest.mark.parametrize(
    "other",
    [
        SMALL + 'method = "rk45"\n',
        SMALL + '[output]\nobserve = ["peak_ke", "wall_force"]\n',
        SMALL + "[model]\nt_end = 2.5\n",
        SMALL.replace("1e-3]", "2e-3]").replace("[0.0,", "[5e-4,"),
    ],
)
def test_rows_of_another_method_layout_model_or_task_are_not_taken(run, other):
    run(SMALL, "ours")
    assert run(other, "other") == (0, 24)
    assert run(other, "again") == (24, 0)


def test_a_killed_run_leaves_its_rows_to_others(sweep, run, start, tmp_path):
    (tmp_path / "slow.toml").write_text(SLOW)
    process = start("run", "slow.toml", "-o", "killed.h5", "--store", "rows")
    wait_for_rows(tmp_path / "killed.h5", process, 200)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait(60)
    before = stored(tmp_path / "rows")
    assert before > 0
    taken, left = run(SLOW, "next")
    assert (taken, taken + left) == (before, 492)


def damage(folder: Path, part: str, change) -> None:
    """Change this part of the only block that there is."""
    with sqlite3.connect(folder / FILE) as file:
        ((first, known),) = file.execute(f"SELECT first, {part} FROM blocks WHERE length(entries) > 0")
        file.execute(f"UPDATE blocks SET {part} = ? WHERE first = ?", [change(known), first])


def flipped(known: bytes, *places: int) -> bytes:
    return bytes(byte ^ (i in places) for i, byte in enumerate(known))


SIZE = ROW.itemsize


@pytest.mark.parametrize(
    ("part", "change", "lost"),
    [
        ("rows", lambda rows: flipped(rows, 3 * SIZE + 40, 11 * SIZE), 2),
        ("rows", lambda rows: rows[: 5 * SIZE] + rows[4 * SIZE : 5 * SIZE] + rows[6 * SIZE :], 1),  # of another task
        ("rows", lambda rows: rows[:-1], 24),
        ("rows", lambda _: 7, 24),
        ("entries", lambda index: flipped(index, 30), 24),
        ("entries", lambda index: index[:-1], 24),
    ],
)
def test_what_is_damaged_is_found_computed_again_and_mended(run, tmp_path, physics, part, change, lost):
    run(SMALL, "first")
    damage(tmp_path / "rows", part, change)
    assert run(SMALL, "again") == (24 - lost, lost)
    assert physics(tmp_path / "again.h5") == physics(tmp_path / "first.h5")
    assert run(SMALL, "third") == (24, 0)


def page_of(data: bytes, name: str) -> slice:
    """Where the root of a table, or of a table's own index, lies in a store's file."""
    with contextlib.closing(sqlite3.connect(":memory:")) as file:
        file.deserialize(data)
        (page,) = file.execute("SELECT rootpage FROM sqlite_schema WHERE name = ?", [name]).fetchone()
    return slice((page - 1) * shelf.PAGE, page * shelf.PAGE)


@pytest.mark.parametrize("part", ["blocks", "kinds", "sqlite_autoindex_kinds_1", "the end"])
def test_a_file_that_sqlite_finds_damaged_ends_no_sweep(sweep, run, tmp_path, physics, part):
    """It is found as rows are looked for, as the store is opened, as it learns of this sweep, as it is opened."""
    run(SMALL, "first")
    data = bytearray((tmp_path / "rows" / FILE).read_bytes())
    data[slice(shelf.PAGE + 1, None) if part == "the end" else page_of(data, part)] = (
        b"" if part == "the end" else b"\xff" * shelf.PAGE
    )
    (tmp_path / "rows" / FILE).write_bytes(data)
    answer = sweep("run", "first.toml", "-o", "again.h5", "--store", "rows")
    assert answer.returncode == 0
    assert (
        answer.stderr.count("database disk image is malformed; what it has is computed, and nothing more is kept") == 1
    )
    assert physics(tmp_path / "again.h5") == physics(tmp_path / "first.h5")


def test_two_runs_at_once_keep_all_their_rows(start, run, tmp_path):
    (tmp_path / "a.toml").write_text(SLOW)
    (tmp_path / "b.toml").write_text(SLOW.replace("[0.5, 2]", "[0.5, 2, 4]"))
    for process in [start("run", f"{name}.toml", "-o", f"{name}.h5", "--store", "rows") for name in "ab"]:
        process.communicate(timeout=240)
        assert process.returncode == 0
    assert stored(tmp_path / "rows") == 738
    assert run(SLOW.replace("[0.5, 2]", "[0.5, 2, 4]"), "c") == (738, 0)


def test_a_folder_that_holds_no_store_is_refused_in_one_line_and_nothing_is_written(sweep, small_spec, tmp_path):
    (tmp_path / "file").write_text("no folder")
    for name, text in (("text", b"hello, this is no database" * 40), ("other", None), ("older", None)):
        (tmp_path / name).mkdir()
        if text is not None:
            (tmp_path / name / FILE).write_bytes(text)
    with sqlite3.connect(tmp_path / "other" / FILE) as file:
        file.execute("CREATE TABLE of_somebody_else (x)")
    with sqlite3.connect(tmp_path / "older" / FILE) as file:  # one record for each row
        file.execute("CREATE TABLE rows (key INTEGER PRIMARY KEY, row BLOB)")
        file.execute(f"PRAGMA application_id = {shelf.OURS}")
        file.execute("PRAGMA user_version = 1")
    for folder, problem in (
        ("file", "must be a folder, or the name of a new one (File exists)"),
        ("none/rows", "must be a folder, or the name of a new one (No such file or directory)"),
        ("text", f"{FILE} cannot be used: file is not a database"),
        ("other", f"{FILE} is no store of this version of bistable-sweep"),
        ("older", f"{FILE} is no store of this version of bistable-sweep"),
    ):
        answer = sweep("run", small_spec, "-o", "t.h5", "--store", folder)
        assert (answer.returncode, answer.stderr) == (2, f"sweep: --store {folder}: {problem}\n")
    assert not list(tmp_path.glob("*.h5"))


def test_a_disk_whose_nodes_do_not_see_each_others_writes_is_refused(tmp_path, monkeypatch):
    for kind, good in (("ext4", True), ("nfs4", True), ("lustre", True), ("fuse.glusterfs", False), ("cifs", False)):
        monkeypatch.setattr(shelf.disk, "kind_of", lambda _, kind=kind: kind)
        if good:
            Shelf(tmp_path).close()
        else:
            with pytest.raises(InputError, match=f"lies on {kind}, where a node may not see what another has written"):
                Shelf(tmp_path)


@pytest.mark.parametrize("before", ["user_version", "sqlite_schema", "journal_mode", "page_size"])
def test_a_store_that_another_run_begins_meanwhile_is_opened(tmp_path, monkeypatch, before):
    connect = sqlite3.connect

    class Interleaved:
        """A connection; the other run comes just before one of its steps, and waits for no lock."""

        def __init__(self, *given, **named):
            self._file, self._met = connect(*given, **named), False

        def __getattr__(self, name):
            return getattr(self._file, name)

        def execute(self, line, *given):
            if before in line and not self._met:
                self._met = True
                with monkeypatch.context() as patch, contextlib.suppress(InputError):
                    patch.setattr(shelf.sqlite3, "connect", connect)
                    patch.setattr(shelf, "BUSY_MAX", 0.0)
                    Shelf(tmp_path).close()
            return self._file.execute(line, *given)

    monkeypatch.setattr(shelf.sqlite3, "connect", Interleaved)
    ours = Shelf(tmp_path)
    assert ours._file._met
    assert ours.kind("one") == 1
    ours.close()
    monkeypatch.undo()
    again = Shelf(tmp_path)
    assert again.kinds() == {1: "one"}
    again.close()


def test_it_never_keeps_a_write_ahead_log(tmp_path):
    Shelf(tmp_path).close()
    with sqlite3.connect(tmp_path / FILE) as file:
        file.execute("PRAGMA journal_mode = WAL")
    Shelf(tmp_path).close()
    with sqlite3.connect(tmp_path / FILE) as file:
        assert file.execute("PRAGMA journal_mode").fetchone() == ("delete",)


def test_the_nearest_of_what_serves_comes_first():
    def what(target, **other):
        return {"model": None, "accuracy": {"target": target} | other}

    kinds = {1: what(1e-5), 2: what(1e-3), 3: what(1e-2), 4: what(1e-4), 5: what(1e-4, certify=False)}
    texts = {kind: json.dumps(each) for kind, each in kinds.items()} | {6: json.dumps(what(1e-4) | {"model": {}})}
    texts[7] = json.dumps({"model": None, "accuracy": "screened"})
    assert list(serving(what(1e-3), texts)) == [4, 1]
    assert list(serving(what(1e-3, certify=False), texts)) == [2, 4, 5, 1]


def test_where_the_store_cannot_be_written_rows_for_it_do_not_pile_up(tmp_path, capsys):
    (tmp_path / "file").write_text("no folder")
    keeper = _Keeper(tmp_path / "file", "here")
    keeper._thread.join(10)
    keeper.take(0, np.zeros(1))
    assert keeper._rows == []
    keeper.close()
    assert "not kept for other sweeps" in capsys.readouterr().err
