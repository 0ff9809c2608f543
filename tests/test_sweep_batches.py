"""Work goes out once each, longest first, in batches whose predicted time and size stay within their limits."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sweep.plan.batches import BATCH_MAX, BATCH_SHARE, SECONDS_MAX, SECONDS_MIN, SECONDS_MIN_PER_RANK, Batches

SECONDS = st.lists(st.floats(1e-6, 30.0), max_size=600).map(np.array)
RANKS = st.integers(1, 64) | st.just(5000)


def limit_of(left: float, ranks: int) -> float:
    """Predicted seconds of a batch."""
    return min(SECONDS_MAX, max(SECONDS_MIN, SECONDS_MIN_PER_RANK * ranks, BATCH_SHARE * left / ranks))


def all_batches(seconds: np.ndarray, ranks: int) -> list[np.ndarray]:
    """Task numbers are 10, 11, ...: a number must not be taken for a position."""
    batches, taken = Batches(np.arange(len(seconds)) + 10, seconds.astype(float), ranks), []
    while len(batch := batches.take()):
        taken.append(batch)
    assert len(batches) == 0
    assert batches.seconds_left == 0
    return taken


@given(SECONDS, RANKS)
def test_every_task_goes_out_exactly_once(seconds, ranks):
    taken = all_batches(seconds, ranks)
    assert sorted(np.concatenate([[], *taken]).tolist()) == [k + 10 for k in range(len(seconds))]


@given(SECONDS, RANKS)
def test_the_longest_go_out_first_and_equal_ones_by_number(seconds, ranks):
    order = np.concatenate([[], *all_batches(seconds, ranks)]).astype(int).tolist()
    assert order == sorted(order, key=lambda k: (-seconds[k - 10], k))


@given(SECONDS, RANKS)
def test_a_batch_of_several_tasks_stays_within_its_limits(seconds, ranks):
    left = seconds.sum()
    for batch in all_batches(seconds, ranks):
        predicted = seconds[batch - 10].sum()
        limit = limit_of(left, ranks)
        assert len(batch) <= BATCH_MAX
        assert len(batch) == 1 or predicted <= limit * (1 + 1e-9) + 1e-9
        left -= predicted


def test_the_numbers_of_a_batch_fit_a_message_that_mpi_sends_without_waiting():
    assert Batches(np.arange(9999), np.full(9999, 1e-9), 1).take().nbytes <= 4096


@given(SECONDS, RANKS)
def test_no_batch_is_smaller_than_it_must_be(seconds, ranks):
    """Small batches cost messages: each takes all tasks that fit its limit."""
    taken, left = all_batches(seconds, ranks), seconds.sum()
    for batch, following in itertools.pairwise(taken):
        limit = limit_of(left, ranks)
        one_more = seconds[batch - 10].sum() + seconds[following[0] - 10]
        assert len(batch) == BATCH_MAX or one_more > limit * (1 - 1e-9) - 1e-9
        left -= seconds[batch - 10].sum()


@given(SECONDS, RANKS, st.randoms(use_true_random=False))
def test_the_order_does_not_depend_on_how_the_tasks_were_listed(seconds, ranks, random):
    positions = list(range(len(seconds)))
    random.shuffle(positions)
    shuffled = Batches(np.array(positions, int) + 10, seconds[positions].astype(float), ranks)
    for batch in all_batches(seconds, ranks):
        assert set(shuffled.take().tolist()) == set(batch.tolist())


@given(SECONDS, RANKS)
def test_seconds_left_falls_by_what_is_taken(seconds, ranks):
    batches = Batches(np.arange(len(seconds)), seconds.astype(float), ranks)
    while len(batches):
        before = batches.seconds_left
        taken = seconds[batches.take()].sum()
        assert abs(before - taken - batches.seconds_left) <= 1e-9 * (1 + before)


@given(SECONDS, RANKS, st.lists(st.floats(0.0, 40.0), min_size=1), st.integers(0, 600))
def test_nothing_that_does_not_fit_goes_out_and_everything_that_fits_does(seconds, ranks, time_left, known):
    """The time left falls, as a clock's does; tasks that are not known at first come when a batch is out."""
    ids, seconds = np.arange(len(seconds)), seconds.astype(float)
    batches = Batches(ids[:known], seconds[:known], ranks)
    taken = [batches.take(max(time_left))]
    batches.add(ids[known:], seconds[known:])
    skipped = batches.skipped
    for fits in sorted(time_left, reverse=True):
        before = len(batches)
        batch = batches.take(fits)
        assert abs(seconds[batch].sum() - batches.taken) < 1e-9 * (1 + seconds.sum())
        assert seconds[batch].sum() <= fits + 1e-9 * (1 + seconds.sum())
        assert before == len(batches) + len(batch) + batches.skipped - skipped
        skipped = batches.skipped
        taken.append(batch)
    while len(batch := batches.take(min(time_left))):
        taken.append(batch)
    done = set(np.concatenate([[], *taken]).astype(int).tolist())
    assert done >= set(np.flatnonzero(seconds <= min(time_left)).tolist())
    assert len(done) + batches.skipped == len(seconds)


@given(SECONDS, RANKS)
def test_the_longest_that_is_left_is_known(seconds, ranks):
    """On however many ranks, work ends no sooner: what a run says at its start."""
    batches, left = Batches(np.arange(len(seconds)), seconds.astype(float), ranks), dict(enumerate(seconds.tolist()))
    while left:
        assert batches.longest == max(left.values())
        for k in batches.take():
            del left[k]
    assert batches.longest == 0
