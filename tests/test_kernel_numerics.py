"""The number of the kernel's bits is raised where bits change, and only there: a store hands out what has the same."""

import json
import subprocess
import sys

import pytest

from kernel import numerics

from . import bits

KNOWN = json.loads(bits.DIGESTS.read_text())
HERE = numerics.processor_kind()


@pytest.fixture(scope="module")
def digest():
    if not any(HERE in digests for digests in KNOWN.values()):
        pytest.skip(f"no digest of {HERE} is kept: python -m tests.bits --digest")
    return bits.digest()


def test_bits_are_those_that_this_number_stands_for(digest):
    """If this fails, bits have changed: if that is meant, raise NUMERICS, then python -m tests.bits --digest."""
    assert KNOWN[str(numerics.NUMERICS)][HERE] == digest


def test_the_number_was_raised_only_where_bits_changed(digest):
    earlier = [
        digests[HERE] for number, digests in KNOWN.items() if int(number) < numerics.NUMERICS and HERE in digests
    ]
    assert digest not in earlier
    assert max(map(int, KNOWN)) == numerics.NUMERICS


def test_what_a_machine_says_of_its_bits_is_the_same_in_another_process():
    said = "from kernel.numerics import numerics; print(numerics())"
    answer = subprocess.run([sys.executable, "-P", "-c", said], capture_output=True, text=True, timeout=240, check=True)
    assert answer.stdout.strip() == numerics.numerics()
    assert answer.stdout.startswith(f"{numerics.NUMERICS} {HERE} ")


def test_a_change_of_the_last_bit_of_one_number_is_told(monkeypatch):
    before = numerics.digest([numerics.choose(accuracy=1e-2)])
    results = numerics.results_of

    def moved(*asked, **how):
        rows = results(*asked, **how)
        rows["ke_ratio"].view("i8")[-1] += 1
        return rows

    monkeypatch.setattr(numerics, "results_of", moved)
    assert numerics.digest([numerics.choose(accuracy=1e-2)]) != before
