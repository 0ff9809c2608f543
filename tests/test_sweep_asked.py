"""What the commands answer about random tables is right by the tables' own rows (`python -m tests.asked` asks more)."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
# The checkout comes last: what is tested is the installed package.
START = "import runpy, sys; sys.path.append('.'); runpy.run_module('tests.asked', run_name='__main__', alter_sys=True)"


def test_answers_about_random_tables_are_those_of_their_rows():
    command = [sys.executable, "-P", "-c", START, "--seed", "25", "--cases", "3", "--each", "1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == "3 tables, 0 wrong answers\n"
