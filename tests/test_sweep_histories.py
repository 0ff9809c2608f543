"""Two short random histories of tables end as a run in peace does (`python -m tests.histories` does more)."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
# The checkout comes last: what is tested is the installed package.
START = (
    "import runpy, sys; sys.path.append('.'); runpy.run_module('tests.histories', run_name='__main__', alter_sys=True)"
)


def test_random_histories_end_in_the_tables_of_runs_in_peace():
    command = [sys.executable, "-P", "-c", START, "--seed", "1000", "--steps", "4", "--histories", "2", "--ranks", "1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout == "2 histories of 4 steps, 0 wrong\n"
