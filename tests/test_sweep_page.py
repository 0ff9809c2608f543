"""`sweep run --page` keeps a page as the table is; its failure costs no row."""

import errno
import os
import signal

import pytest

from sweep import page
from sweep.site.launch import without_launcher

pytestmark = pytest.mark.slow


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_run_ends_with_a_page_of_all_its_rows(sweep, small_spec, tmp_path, ranks):
    done = sweep("run", small_spec, "-o", "t.h5", "--page", "t.html", ranks=ranks)
    assert done.returncode == 0, done.stderr
    assert done.stderr.splitlines()[-1] == "sweep: page t.html"
    assert '"rows": 24' in (tmp_path / "t.html").read_text()


def test_a_page_that_may_not_be_written_is_refused_before_the_table_is_there(sweep, small_spec, tmp_path):
    (tmp_path / "notes.html").write_text("mine")
    done = sweep("run", small_spec, "-o", "t.h5", "--page", "notes.html")
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert "--page: notes.html is not as this program left it; move it, or give another\n" in done.stderr
    assert not (tmp_path / "t.h5").exists()


def test_what_rank_0_starts_does_not_take_part_in_the_run():
    kept = without_launcher({"PMI_RANK": "0", "OMPI_COMM_WORLD_RANK": "0", "HOME": "/h", "MPI4PY_RC_INITIALIZE": "0"})
    assert kept == {"HOME": "/h"}


@pytest.mark.parametrize("end", ["hurry", "_finish"])
def test_a_page_that_is_killed_is_waited_for(tmp_path, monkeypatch, end):
    """Else it would stay as a zombie as long as the run lasts; only who waits learns how it ended."""
    monkeypatch.setattr(page, "LAST_LIMIT", 0.0)
    made = page.Page(tmp_path / "p.html", tmp_path / "t.h5")
    made._start()
    child = made._running
    getattr(made, end)()
    assert child.returncode == -signal.SIGKILL


class _Pages:
    """Stands for the program that makes a page, in so many seconds, and for the clock."""

    def __init__(self, monkeypatch, capsys, takes=2.0, status=0, missing=False):
        self.now, self.begun, self._takes, self._missing = 0.0, [], takes, missing
        self.returncode, self.killed, self._status, self._capsys = None, 0, status, capsys
        monkeypatch.setattr(page.time, "monotonic", lambda: self.now)
        monkeypatch.setattr(page.subprocess, "Popen", self._begin)

    def _begin(self, *_args, **_kwargs):
        self.begun.append(self.now)
        self.returncode = None
        if self._missing:
            raise OSError(errno.ENOENT, os.strerror(errno.ENOENT))
        return self

    def poll(self):
        self.returncode = None if self.now < self.begun[-1] + self._takes else self._status
        return self.returncode

    def kill(self):
        self.returncode, self.killed = -signal.SIGKILL, self.killed + 1

    def communicate(self, timeout=None):
        self.returncode = self._status if self.returncode is None else self.returncode
        return "", "first words\nlast words\n"

    def run(self, made, seconds):
        while self.now < seconds:
            self.now += 0.125
            made.tick()

    def said(self):
        return self._capsys.readouterr().err


@pytest.mark.parametrize(("takes", "begun"), [(2.0, [5.0, 47.0, 89.0]), (0.125, [5.0 + 5.125 * k for k in range(19)])])
def test_a_page_is_made_a_twentieth_of_the_time_and_not_more_often_than_all_five_seconds(
    tmp_path, monkeypatch, capsys, takes, begun
):
    pages = _Pages(monkeypatch, capsys, takes)
    pages.run(page.Page(tmp_path / "p.html", tmp_path / "t.h5"), 100.0)
    assert pages.begun == begun
    assert pages.said() == ""


def test_a_page_that_cannot_be_made_is_told_and_tried_again(tmp_path, monkeypatch, capsys):
    pages = _Pages(monkeypatch, capsys, missing=True)
    pages.run(page.Page(tmp_path / "p.html", tmp_path / "t.h5"), 16.0)
    assert pages.begun == [5.0, 10.0, 15.0]
    assert pages.said() == 3 * f"sweep: page {tmp_path}/p.html: not made (No such file or directory)\n"


@pytest.mark.parametrize(("status", "told"), [(0, ""), (1, ": last words")])
def test_the_last_page_is_made_at_the_end_and_one_that_fails_says_why(tmp_path, monkeypatch, capsys, status, told):
    pages = _Pages(monkeypatch, capsys, status=status)
    with page.Page(tmp_path / "p.html", tmp_path / "t.h5") as made:
        pages.run(made, 6.0)
    assert pages.begun == [5.0, 6.0]
    assert pages.killed == 1, "the one that was under way shows less"
    assert pages.said() == f"sweep: page {tmp_path}/p.html{told}\n"


def test_nobody_waits_for_a_last_page_that_was_not_asked_for_or_when_the_run_ends_otherwise(
    tmp_path, monkeypatch, capsys
):
    pages = _Pages(monkeypatch, capsys)
    with page.Page(None, tmp_path / "t.h5") as made:
        pages.run(made, 10.0)
    with page.Page(tmp_path / "p.html", tmp_path / "t.h5") as made:
        made.hurry()
    with pytest.raises(KeyError), page.Page(tmp_path / "p.html", tmp_path / "t.h5"):
        raise KeyError
    assert (pages.begun, pages.said()) == ([], "")
