"""What the commands answer about random tables is right by the tables' own rows (`python -m tests.asked` asks more)."""

import pytest

from .program import program

pytestmark = pytest.mark.slow


def test_answers_about_random_tables_are_those_of_their_rows():
    said = program("tests.asked", "--seed", "25", "--cases", "3", "--each", "1")
    assert said == "3 tables, 0 wrong answers\n"
