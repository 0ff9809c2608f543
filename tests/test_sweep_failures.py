"""A task that fails is a row with a status; the sweep goes on, exits 1, and does not try it again."""

import errno
import os
from types import SimpleNamespace

import numpy as np
import pytest

from sweep import cli
from sweep.conduct import run
from sweep.plan import batches
from sweep.prepare import Options
from sweep.schema import ROW, RUN_COLUMNS
from sweep.serve import worker
from sweep.serve.stops import Stops

from .conftest import rows_of

NOT_DONE = 13  # the N whose tasks fail: 8 of the 24


@pytest.fixture
def results(tmp_path):
    def read() -> np.ndarray:
        return rows_of(tmp_path / "t.h5")

    return read


@pytest.fixture
def asked(monkeypatch) -> list[int]:
    """Every N that the kernel was asked for; a task with N = NOT_DONE raises."""
    real, seen = worker.results_of, []

    def kernel(columns, *rest, **more):
        seen.extend(columns["N"])
        if NOT_DONE in columns["N"]:
            raise ZeroDivisionError("made up")
        return real(columns, *rest, **more)

    monkeypatch.setattr(worker, "results_of", kernel)
    return seen


def test_a_kernel_that_raises_costs_one_row_and_is_told(small_spec, tmp_path, asked, results, capsys):
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    rows = results()
    failed = rows["N"] == NOT_DONE
    assert set(rows["status"][failed]) == {b"error"}
    assert np.isnan(rows["ke_ratio"][failed]).all()
    assert set(rows["status"][~failed]) == {b"done"}
    assert np.isfinite(rows["ke_ratio"][~failed]).all()
    told = capsys.readouterr()
    assert told.out.startswith("16 done, 8 failed, 0 left; ")
    assert told.err.count("ZeroDivisionError: made up") == 8
    assert "sweep: 8 rows failed, error: the kernel raised an exception, which the run printed\n" in told.err
    # To who runs the program from Python a line that begins so is a run that has crashed.
    assert not any(line.startswith("Traceback") for line in told.err.splitlines())


def test_a_kernel_that_raises_while_the_log_is_full_ends_no_run(small_spec, tmp_path, asked, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("sys.stderr", SimpleNamespace(write=full, flush=full, isatty=bool))
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1


def test_the_other_rows_are_those_of_a_sweep_without_failures(small_spec, tmp_path, monkeypatch, results):
    assert run(None, Options(small_spec, tmp_path / "whole.h5")) == 0
    whole = rows_of(tmp_path / "whole.h5")
    real = worker.results_of

    def spend(columns, *rest, **more):
        results = real(columns, *rest, **more)
        spent = columns["N"] == NOT_DONE
        results["status"][spent], results["ke_ratio"][spent] = "step_budget", np.nan
        return results

    monkeypatch.setattr(worker, "results_of", spend)
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    rows = results()
    kept = rows["N"] != NOT_DONE
    assert set(rows["status"][~kept]) == {b"step_budget"}
    for name in set(ROW.names) - set(RUN_COLUMNS):
        assert rows[name][kept].tobytes() == whole[name][kept].tobytes()


def test_a_failed_task_is_not_repeated(small_spec, tmp_path, asked, results):
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    before = results().tobytes()
    asked.clear()
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    assert asked == []
    assert results().tobytes() == before


def test_failed_rows_are_computed_again_when_asked_for_and_only_those(
    small_spec, tmp_path, asked, monkeypatch, results
):
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    before = results()
    monkeypatch.setitem(globals(), "NOT_DONE", -1)
    asked.clear()
    assert run(None, Options(small_spec, tmp_path / "t.h5", retry_failed=True)) == 0
    assert set(asked) == {13}
    done = before["status"] == b"done"
    assert results()[done].tobytes() == before[done].tobytes()
    assert set(results()["status"]) == {b"done"}


def test_stopped_before_all_failed_rows_were_tried_again_it_says_so(small_spec, tmp_path, asked, monkeypatch, capsys):
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    monkeypatch.setattr(Stops, "fits", lambda *_: 0.0)
    assert run(None, Options(small_spec, tmp_path / "t.h5", retry_failed=True)) == 75
    told = capsys.readouterr()
    assert "\n16 done, 0 failed, 8 left; " in told.out
    assert "8 of the rows left failed in an earlier run and were not tried again" in told.err


def test_of_failed_rows_only_those_that_were_tried_again_have_failed_again(
    small_spec, tmp_path, asked, monkeypatch, capsys
):
    monkeypatch.setattr(batches, "BATCH_MAX", 1)
    assert run(None, Options(small_spec, tmp_path / "t.h5")) == 1
    monkeypatch.setattr(Stops, "fits", lambda _, count: 0.0 if count.failed else np.inf)
    assert run(None, Options(small_spec, tmp_path / "t.h5", retry_failed=True)) == 75
    told = capsys.readouterr()
    assert "\n16 done, 1 failed, 7 left; " in told.out
    assert "7 of the rows left failed in an earlier run and were not tried again" in told.err


@pytest.mark.parametrize(("accepted", "status"), [(0, 1), (8, 1)])
def test_a_run_stops_after_more_failures_than_accepted(
    small_spec, tmp_path, asked, monkeypatch, accepted, status, capsys
):
    monkeypatch.setattr(batches, "BATCH_MAX", 1)
    assert run(None, Options(small_spec, tmp_path / "t.h5", max_fails=accepted)) == status
    told = capsys.readouterr()
    if accepted:
        assert told.out.startswith("16 done, 8 failed, 0 left; ")
    else:
        assert " 1 failed, " in told.out
        assert " 0 left; " not in told.out
        assert "sweep: stopped early: 1 rows failed, more than --max-fails 0\n" in told.err


@pytest.mark.parametrize("text", ["-1", "many", "1.5", ""])
def test_a_bad_number_of_failures_is_a_usage_error(small_spec, text, capsys):
    assert cli.main(["run", str(small_spec), "-o", "t.h5", f"--max-fails={text}"]) == 2
    assert capsys.readouterr().err == f"sweep: --max-fails: must be a whole number, 0 or more, got {text!r}\n"


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_task_beyond_its_step_budget_fails_as_a_row_on_every_rank(sweep, small_spec, ranks, results):
    small_spec.write_text(small_spec.read_text() + "method = 'rk45'\nmax_steps = 500\n")
    answer = sweep("run", small_spec, "-o", "t.h5", ranks=ranks)
    assert answer.returncode == 1
    rows = results()
    spent = rows["status"] == b"step_budget"
    assert 0 < spent.sum() < 24
    assert answer.stdout.startswith(f"{24 - spent.sum()} done, {spent.sum()} failed, 0 left; ")
    assert f"{spent.sum()} rows failed, step_budget: the step budget was spent before" in answer.stderr
    assert np.isnan(rows["ke_ratio"][spent]).all()
    assert sweep("run", small_spec, "-o", "t.h5", ranks=ranks).returncode == 1
