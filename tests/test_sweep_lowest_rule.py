"""What a search for the lowest asks for, on made-up landscapes: it follows from values alone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sweep.plan.lowest import Lowest, around
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, blank

# Made-up landscapes: what is asked for follows from values alone.

AXES = {"N": [5, 6], "zeta_T": [0.1], "M_over_M0": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "V_over_V0": [1.0, 2.0, 3.0, 4.0]}
EACH_MADE = 24  # candidates of a made-up cell
OVER = ["M_over_M0", "V_over_V0"]


def played(rng, values, screened, chaotic, kinds=(1, np.max, 1), known=(), tried=None, of="ke_ratio"):
    """Every order of a search whose results arrive in random order and portions; `known`: computed before it began."""
    seen = np.concatenate([values, screened, values if tried is None else tried])
    near, reduce, first = kinds
    axes = AXES if near == 1 else {**AXES, **{name: around(AXES[name], 0.01) for name in OVER}}
    search = Lowest(Tasks(axes), OVER, of, near, reduce, first)
    rows, n = blank(len(values)), len(values)
    rows["status"], rows[of], rows["chaotic"], rows["checked"] = DONE, values, chaotic, True
    search.tell(np.array(known, np.int64), rows[list(known)])
    given, waiting = [], search.ask().tolist()
    while waiting:
        given += [order for order in waiting if order not in given]
        rng.shuffle(waiting)
        part = np.array([waiting.pop() for _ in range(rng.integers(1, len(waiting) + 1))])
        search.tell_seen(part[part >= n], seen[part[part >= n]])
        search.tell(part[part < n], rows[part[part < n]])
        new = search.ask().tolist()
        assert not {*new} & {*given}
        waiting += new
    return sorted(given)


@given(st.integers(0, 2**32 - 1), st.sampled_from([(1, np.max, 1), (3, np.max, 1), (3, np.median, 9)]))
def test_what_is_asked_for_depends_on_no_order_and_on_nothing_known_besides(seed, kinds):
    rng = np.random.default_rng(seed)
    n = 2 * EACH_MADE * kinds[0] ** 2
    values = rng.lognormal(size=n)
    screened, tried = (values * rng.lognormal(sigma=most * rng.random(), size=n) for most in (0.3, 0.1))
    chaotic = rng.random(n) < rng.choice([0, 0.2, 1.0])
    once = played(rng, values, screened, chaotic, kinds, tried=tried)
    assert played(rng, values, screened, chaotic, kinds, tried=tried) == once
    known = np.flatnonzero(rng.random(n) < 0.3)
    assert played(rng, values, screened, chaotic, kinds, known, tried) == sorted(set(once) - set(known.tolist()))


@given(st.integers(0, 2**32 - 1))
def test_screening_that_is_right_or_wrong_alike_everywhere_misses_nothing(seed):
    rng, n = np.random.default_rng(seed), 2 * EACH_MADE
    values, off = rng.lognormal(size=n), rng.random()
    screened = values * np.exp(rng.choice([-off, off], size=n))  # each is as far off as the others
    chaotic = rng.random(n) < 0.2
    asked = played(rng, values, screened, chaotic, of="t_peak_linear")  # which is screened by whole runs
    assert missed(values, chaotic, asked) == 0


@given(st.integers(0, 2**32 - 1))
def test_screening_that_ends_early_and_is_never_too_high_misses_nothing(seed):
    rng, n = np.random.default_rng(seed), 2 * EACH_MADE
    values = rng.lognormal(size=n)
    screened = values * np.exp(-rng.exponential(3.0 * rng.random(), size=n))
    chaotic = rng.random(n) < 0.2
    assert missed(values, chaotic, played(rng, values, screened, chaotic)) == 0


def missed(values, chaotic, asked) -> int:
    """In how many of the two cells the lowest of the calm tasks was not computed."""
    best = np.where(chaotic, np.inf, values).reshape(2, EACH_MADE).argmin(axis=1) + EACH_MADE * np.arange(2)
    return len({*best[~chaotic[best]].tolist()} - {*asked})


def test_a_cell_of_chaotic_tasks_alone_is_computed_as_a_whole_and_of_a_calm_one_the_lowest():
    rng, n = np.random.default_rng(0), 2 * EACH_MADE
    values = rng.lognormal(size=n)
    asked = np.array(played(rng, values, values, np.arange(n) < EACH_MADE))
    assert asked[asked < n].tolist() == [*range(EACH_MADE), EACH_MADE + values[EACH_MADE:].argmin()]
    tried = asked[asked >= 2 * n] - 2 * n
    assert EACH_MADE <= len(tried) <= EACH_MADE + 8 + 4


def test_what_could_not_be_screened_is_tried_and_what_could_not_be_tried_is_computed():
    rng, n = np.random.default_rng(0), 2 * EACH_MADE
    values, calm = np.linspace(1, 2, n), np.zeros(n, bool)
    failed = np.where(np.arange(n) == 19, np.nan, values)
    asked = played(rng, values, failed, calm)
    assert 2 * n + 19 in asked
    assert 19 not in asked
    assert 19 in played(rng, values, failed, calm, tried=failed)


def test_what_lies_beside_the_lowest_is_tried_although_it_was_screened_high():
    rng, n = np.random.default_rng(0), 2 * EACH_MADE
    values, calm = 2 + rng.random(n), np.zeros(n, bool)
    values[[13, 14]] = 1.5, 1.0
    screened = np.where(np.arange(n) == 14, 30.0, values)
    asked = played(rng, values, screened, calm)
    assert {2 * n + k for k in (9, 12, 14, 17)} <= {*asked}
    assert 14 in asked
