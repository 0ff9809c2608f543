"""What a run says of how far it is: early, then seldom, and never that it ends when nobody knows."""

import numpy as np
import pytest

from sweep.plan.batches import Batches
from sweep.serve import progress
from sweep.serve.master import Count
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
        count = Count(done=10, finished=finished, real=finished)
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
    assert lines[0] == "10 of 30 tasks, 0 failed, 2 s, about 40 s left"


def test_an_adaptive_sweep_says_of_what_its_time_left_is(follow):
    _, lines, _ = follow(True, 3)
    assert lines == ["10 of 30 tasks known so far, 0 failed, 2 s, about 40 s left for these, more may follow"]


def test_what_takes_less_than_a_second_is_not_told_as_nothing(follow):
    _, lines, _ = follow(False, 3, left=0.2)
    assert lines[0].endswith("about 1 s left")


def test_what_a_status_shows_is_a_second_old_at_most_and_true_from_the_first_look(follow):
    _, _, kept = follow(False, 5)
    assert kept == [0.5, 1.5, 2.5, 3.5, 4.5]
