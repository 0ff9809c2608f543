"""`sweep run --page` keeps a page as the table is; its failure costs no row."""

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
