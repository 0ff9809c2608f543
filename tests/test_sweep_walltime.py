"""Until when a run may go on, from every way of saying it; what does not fit is left for the next run."""

import time
from datetime import datetime

import pytest

from sweep.conduct import run
from sweep.prepare import Options
from sweep.serve.master import Count
from sweep.serve.stops import TIME_FACTOR, Stops
from sweep.site import walltime
from sweep.site.walltime import MARGIN, deadline
from sweep.tell import report

from .conftest import problems_of

NOON = datetime(2030, 5, 17, 12, 0).timestamp()


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("90m", 5400),
        ("1h30m", 5400),
        ("1:30:00", 5400),
        ("2-00:00:10", 172810),
        ("0.5h", 1800),
        ("12:30", 1800),
        ("11:30", 23.5 * 3600),
        ("2030-05-17T13:00", 3600),
        ("2030-05-18", 12 * 3600),
    ],
)
def test_a_time_can_be_said_in_many_ways(text, seconds):
    assert deadline(text, {}, NOON) == NOON + seconds


@pytest.mark.parametrize(
    "text",
    [
        "",
        "soon",
        "90",
        "-5m",
        "0m",
        "1:2",
        "25:00",
        "2020-05-17T11:00",
        "1e999-1",
        "9" * 5000 + "-00:00:00",
        "9" * 5000 + "d",
    ],
)
def test_a_bad_time_is_told_in_one_line_and_nothing_is_written(text, tmp_path, small_spec):
    (problem,) = problems_of(run, None, Options(small_spec, tmp_path / "t.h5", until=text))
    assert problem.startswith("--until: must ")
    assert list(tmp_path.iterdir()) == [small_spec]


def test_slurm_is_believed_unless_the_user_says_otherwise():
    slurm = {"SLURM_JOB_ID": "7", "SLURM_JOB_END_TIME": str(int(NOON) + 7200)}
    assert deadline(None, slurm, NOON) == NOON + 7200 - MARGIN
    assert deadline("1h", slurm, NOON) == NOON + 3600
    assert deadline("none", slurm, NOON) is None
    assert deadline(None, {}, NOON) is None


def test_squeue_is_asked_where_slurm_does_not_tell(tmp_path, monkeypatch):
    squeue = tmp_path / "squeue"
    for answer, expected in (("2030-05-17T14:00:00", NOON + 7200 - MARGIN), ("NONE", None)):
        squeue.write_text(f'#!/bin/sh\ntest "$*" = "-h -j 7 -o %e" && echo {answer}\n')
        squeue.chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
        assert deadline(None, {"SLURM_JOB_ID": "7"}, NOON) == expected


def test_what_fits_shrinks_with_the_clock_and_with_a_run_slower_than_predicted(monkeypatch):
    monkeypatch.setattr(time, "time", lambda: NOON)
    stops = Stops(lambda: False, NOON + 80.0)
    assert stops.fits(Count()) == pytest.approx(80.0 / TIME_FACTOR)
    assert stops.fits(Count(finished=1.0, real=2.0)) == pytest.approx(40.0 / TIME_FACTOR)
    assert stops.fits(Count(finished=2.0, real=1.0)) == pytest.approx(80.0 / TIME_FACTOR)
    monkeypatch.setattr(time, "time", lambda: NOON + 81.0)
    assert stops.fits(Count()) == 0.0


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [1, 3])
def test_a_task_that_does_not_fit_is_left_and_the_others_are_computed(sweep, tmp_path, small_spec, ranks):
    """Tasks of 10 000 sites as tightly would take a minute each; the 24 small ones are computed at once."""
    text = small_spec.read_text().replace("[5, 8, 13]", "[5, 8, 13, 10_000]")
    text = text.replace("[0.0, 1e-3]", "[0.0, 1e-6]").replace("target = 1e-2", 'method = "rk45"\nrtol = 1e-12')
    small_spec.write_text(text)
    answer = sweep("run", small_spec, "-o", "t.h5", "--until", "20s", ranks=ranks)
    assert answer.returncode == 75
    assert answer.stdout.startswith("24 done, 0 failed, 8 left; ")
    assert "sweep: stopped early: what is left does not fit before the end of the allotted time\n" in answer.stderr
    assert report.status(tmp_path / "t.h5")["running"] is False
    assert [each["rows"] for each in report.show(tmp_path / "t.h5")["runs"]] == [24]
    assert walltime.as_text(time.time())[:10] in answer.stderr
