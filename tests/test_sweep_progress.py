"""What a run says of how far it is: early, then seldom, and never that it ends when nobody knows."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest

from sweep.log import Bar
from sweep.plan.batches import Batches
from sweep.serve import progress
from sweep.serve.master import Count
from sweep.serve.worker import Usage
from sweep.store.runs import new_run


class _Kept:
    """Stands for the table's list of runs."""

    def __init__(self):
        self.written = []

    def log(self, slot, run):
        self.written.append(progress.time.monotonic())


@pytest.fixture
def follow(monkeypatch, capsys):
    """follow(more, seconds): the seconds at which lines came, the lines, and the seconds at which the table's list of
    runs was brought up to date, of a run that is a third done."""

    def run(more: bool, seconds: float, finished: float = 20.0, left: float = 40.0):
        clock, at = [1000.0], []
        monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
        monkeypatch.setattr(progress, "say", lambda line: (at.append(clock[0] - 1000.0), print(line)))
        count = Count(done=8, failed=2, added=6 * more, finished=finished, real=finished)
        ids = np.arange(20)
        batches = Batches(ids, np.full(20, left / 20), 1)
        kept = _Kept()
        told = progress.Progress(kept, 0, batches, count, new_run(30, "gather", "0"), more)
        while clock[0] < 1000.0 + seconds:
            clock[0] += 0.5
            told.tick()
        return at, capsys.readouterr().out.splitlines(), [second - 1000.0 for second in kept.written]

    return run


def test_the_first_line_comes_after_two_seconds_and_later_ones_ever_more_seldom_down_to_every_thirty(follow):
    at, lines, _ = follow(False, 130)
    assert at == [2.0, 6.0, 14.0, 30.0, 60.0, 90.0, 120.0]
    assert lines[0] == "10 of 30 tasks, 2 failed, 2 s, about 40 s left"


def test_an_adaptive_sweep_says_of_what_its_time_left_is(follow):
    _, lines, _ = follow(True, 3)
    assert lines == ["10 of 36 tasks known so far, 2 failed, 2 s, about 40 s left for these, more may follow"]


def test_what_takes_less_than_a_second_is_not_told_as_nothing(follow):
    _, lines, _ = follow(False, 3, left=0.2)
    assert lines[0].endswith("about 1 s left")


def test_what_a_status_shows_is_a_second_old_at_most_and_true_from_the_first_look(follow):
    _, _, kept = follow(False, 5)
    assert kept == [0.5, 1.5, 2.5, 3.5, 4.5]


@pytest.mark.parametrize("step", [-3600.0, 300.0])
def test_a_clock_that_is_set_during_a_run_does_not_change_how_long_it_took(monkeypatch, step):
    clock, wrong = [1000.0], [2e9]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(progress.time, "time", lambda: clock[0] + wrong[0])
    run = new_run(30, "gather", "0")
    told = progress.Progress(_Kept(), 0, Batches(np.arange(20), np.ones(20), 1), Count(), run)
    for _ in range(100):
        clock[0] += 1.0
        told.tick()
    wrong[0] += step
    clock[0] += 1.0
    told.tick()
    assert run["updated"][0] - run["start"][0] == pytest.approx(101.0)
    assert run["updated"][0] == clock[0] + wrong[0]


class _Terminal(io.StringIO):
    def isatty(self):
        return True

    def shown(self):
        return [text.strip() for text in re.split(r"[\r\n]", self.getvalue()) if text.strip()]


def test_on_a_terminal_a_bar_stands_in_place_of_lines(follow, monkeypatch):
    monkeypatch.setattr("sys.stderr", terminal := _Terminal())
    _, lines, _ = follow(True, 60)
    assert lines == []
    assert re.fullmatch(
        r"28%\|.*\| 10/36 tasks, 00:00, 2 failed, about 40 s left for these, more may follow", terminal.shown()[-1]
    )


def test_a_long_command_shows_on_a_terminal_one_bar_after_the_other_and_elsewhere_nothing(monkeypatch):
    for stream, bars in (
        (_Terminal(), ["looking 0", "looking 1", "looking 4", "writing 0", "writing 2"]),
        (io.StringIO(), []),
    ):
        monkeypatch.setattr("sys.stderr", stream)
        with Bar() as bar:
            for what, done in (("looking", 1), ("looking", 4), ("writing", 2)):
                bar(what, done, 4)
        assert re.findall(r"(\w+ \d) of 4 \|", stream.getvalue()) == bars
        assert "\n" not in stream.getvalue()  # all in one line, which is empty in the end
        assert stream.getvalue().endswith("\r" if bars else "")


def test_in_the_end_it_is_told_how_the_ranks_were_used():
    ranks = [Usage(busy=8.0, waited=0.125, waited_cpu=0.03125), Usage(busy=6.0, waited=0.375, waited_cpu=0.0625)]
    many = progress.Efficiency(ranks, 10.0, 1.0, 7.0, 0.125)
    assert str(many) == (
        "ranks busy 70.0% (80% 60%), waited 0.50 s at 18.8% of a core; tail 1.00 s; serving took 0.12 s; "
        "computing took 14.0 s, predicted 7.0 s"
    )
    assert "ranks busy 70.0% (80% 60% 80% 60% 80% 60% 80% 60%), " in str(replace(many, ranks=4 * ranks))
    assert "ranks busy 71.1% (least 60%), " in str(replace(many, ranks=[*4 * ranks, ranks[0]]))
    assert str(progress.Efficiency([Usage()], 0.0, 0.0, 0.0, 0.0)).startswith(
        "ranks busy 0.0% (0%), waited 0.00 s at 0.0% of a core; "
    )
