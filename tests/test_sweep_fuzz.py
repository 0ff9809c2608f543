"""Some hundred malformed specs and damaged tables end in words, not in tracebacks (`tests.fuzz` does more)."""

import pytest

from .program import program

pytestmark = pytest.mark.slow


def test_malformed_specs_and_damaged_tables_are_refused_in_words():
    said = program("tests.fuzz", "--cases", "400", "--seed", "7", "--tables", "0.3")
    assert said.splitlines()[-1].split()[:2] == ["all", "400"], said
