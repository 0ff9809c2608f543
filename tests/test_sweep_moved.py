"""A table that is deleted, moved or replaced beneath its run: the run stops, and says where the rows are."""

import errno
import itertools
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from sweep.errors import InputError
from sweep.plan.tasks import Tasks
from sweep.schema import RUN, RUNS
from sweep.store import moved, structure, table
from sweep.store.moved import Moved
from sweep.store.runs import new_run
from sweep.store.writers import Gather, Waiting

from .test_sweep_table_foreign import AXES
from .waiting import WAIT, wait_for, wait_for_rows


class Run:
    """What a run does with its table: it writes its row, and looks at the name, every second of a clock of its own."""

    def __init__(self, path, monkeypatch):
        self.clock, self.path = itertools.count(1000.0), path
        self._now = next(self.clock)
        monkeypatch.setattr(moved.time, "monotonic", lambda: self._now)
        table.create(path, Tasks(AXES), {})
        with table.reading(path) as file:
            at = structure.place(file[RUNS])[0]
        self.writer, self.row = Gather(path, 1e9), new_run(1, "gather", "0")
        self.moved = Moved(path, at, Waiting())
        self.go_on(1)

    def go_on(self, seconds):
        """How long it took to find it; None where it was not found so soon."""
        for passed in range(seconds):
            self._now = next(self.clock)
            self.row["updated"] = self._now
            self.writer.log(0, self.row)
            self.moved.look()
            if self.moved.is_so:
                return passed
        return None

    def end(self):
        self.writer.close()
        self.moved.refuse()


@pytest.fixture
def run(tmp_path, monkeypatch):
    return Run(tmp_path / "t.h5", monkeypatch)


def last_update(path):
    with table.reading(path) as file:
        return float(table.runs(file)["updated"][0])


def delete(path):
    path.unlink()


def move(path):
    path.rename(path.with_name("elsewhere.h5"))


def restore(path):
    """As an editor does, rsync, or whoever takes a backup back."""
    shutil.copyfile(path, path.with_name("copy"))
    path.with_name("copy").rename(path)


def put_a_folder_there(path):
    path.unlink()
    path.mkdir()


SAVED = "what it held is saved as {0}.saved: rename this to {0}, and run again"
FATES = {
    delete: ("was deleted while", SAVED, "t.h5.saved"),
    move: (
        "was moved to {1}elsewhere.h5 while",
        "give it its name again, or -o {1}elsewhere.h5, and run",
        "elsewhere.h5",
    ),
    restore: ("was replaced by another file while", SAVED, "t.h5.saved"),
    put_a_folder_there: ("was replaced by another file while", SAVED, "t.h5.saved"),
}


@pytest.mark.parametrize("harm", FATES)
def test_a_run_whose_table_has_lost_its_name_knows_at_the_second_look_and_keeps_its_rows(run, tmp_path, harm):
    assert run.go_on(60) is None
    harm(run.path)
    assert moved.LOOK_EVERY - 1 <= run.go_on(60) <= 2 * moved.LOOK_EVERY
    said, way, kept = FATES[harm]
    with pytest.raises(InputError) as refused:
        run.end()
    (line,) = refused.value.problems
    assert line.startswith(f"{run.path}: {said.format(run.path, f'{tmp_path}/')} this run wrote it; ")
    assert way.format(run.path, f"{tmp_path}/") in line
    assert last_update(tmp_path / kept) == run.row["updated"]


@pytest.mark.parametrize("harm", FATES)
def test_what_happens_just_before_the_end_is_told_too(run, harm):
    harm(run.path)
    with pytest.raises(InputError, match="while this run wrote it"):
        run.end()


def test_a_table_that_is_left_alone_or_comes_back_soon_ends_no_run(run):
    elsewhere = run.path.with_name("elsewhere.h5")
    for _ in range(5):
        run.path.rename(elsewhere)
        assert run.go_on(int(moved.LOOK_EVERY)) is None
        elsewhere.rename(run.path)
        assert run.go_on(int(moved.LOOK_EVERY)) is None
    run.end()


def test_a_disk_that_does_not_answer_or_gives_the_file_another_number_ends_no_run(run, monkeypatch):
    def gone(*_args, **_named):
        raise OSError(errno.ENOTCONN, os.strerror(errno.ENOTCONN))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "stat", gone)
        assert run.go_on(600) is None
    with monkeypatch.context() as patch:
        patch.setattr(os.path, "samestat", lambda *_: False)
        assert run.go_on(600) is None
    run.end()


def test_on_a_network_a_table_must_be_missing_for_a_minute(tmp_path, monkeypatch):
    monkeypatch.setattr(moved.disk, "is_shared", lambda _: True)
    run = Run(tmp_path / "t.h5", monkeypatch)
    run.path.rename(tmp_path / "elsewhere.h5")
    assert moved.SHARED_FOR <= run.go_on(600) + 1 <= moved.SHARED_FOR + 2 * moved.LOOK_EVERY
    with pytest.raises(InputError, match=r"elsewhere\.h5"):
        run.end()


def test_earlier_savings_are_left_alone_and_a_folder_that_is_gone_is_told(run, tmp_path):
    for name in ("t.h5.saved", "t.h5.saved1"):
        (tmp_path / name).write_text("another")
    run.path.unlink()
    with pytest.raises(InputError, match=r"saved as .*t\.h5\.saved2: "):
        run.end()
    assert (tmp_path / "t.h5.saved1").read_text() == "another"


def test_rows_that_cannot_be_saved_are_told_to_be_lost(run, tmp_path, monkeypatch):
    def full(*_args):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(shutil, "copyfileobj", full)
    run.path.unlink()
    with pytest.raises(InputError, match=r"its rows are lost \(.*saved: cannot be written: No space left on device\)"):
        run.end()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.mpi
@pytest.mark.parametrize(("ranks", "writer"), [(1, "gather"), (2, "gather"), (2, "mpio")])
@pytest.mark.parametrize("harm", [delete, move])
def test_a_run_stops_with_2_soon_after_its_table_has_lost_its_name(start, slow_spec, tmp_path, ranks, writer, harm):
    slow_spec.write_text(slow_spec.read_text().replace("1e-7", "1e-12"))  # a minute or more
    path = tmp_path / "t.h5"
    process = start("run", slow_spec, "-o", "t.h5", "--writer", writer, ranks=ranks)
    wait_for_rows(path, process)
    guest = start("join", "t.h5")
    wait_for(lambda: any(path.with_name(".t.h5.join").glob("*.order")) or guest.poll() is not None)
    harm(path)
    out, err = process.communicate(timeout=WAIT)
    assert process.returncode == 2, out + err
    said, _, kept = FATES[harm]
    assert err.count(f"sweep: t.h5: {said.format('', '')} this run wrote it; ") == 1
    assert "cannot be read" not in err
    assert "Traceback" not in err
    with table.reading(tmp_path / kept) as file:
        done, _, left = table.counts(file)
        run = table.runs(file)[-1]
    assert done > 0
    assert left > 0
    assert run["ended"]
    assert run["left"] == left
    _, wrong = guest.communicate(timeout=WAIT)
    assert guest.returncode == 2, wrong


def test_the_row_of_a_run_is_where_the_look_expects_it(run):
    with run.path.open("rb") as file:
        row = np.frombuffer(os.pread(file.fileno(), RUN.itemsize, run.moved._run_at), RUN)
    assert row["updated"] == run.row["updated"]
    run.end()
