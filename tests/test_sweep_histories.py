"""Two short random histories of tables end as a run in peace does (`python -m tests.histories` does more)."""

import pytest

from .program import program

pytestmark = pytest.mark.slow


def test_random_histories_end_in_the_tables_of_runs_in_peace():
    said = program("tests.histories", "--seed", "1000", "--steps", "4", "--histories", "2", "--ranks", "1")
    assert said == "2 histories of 4 steps, 0 wrong\n"
