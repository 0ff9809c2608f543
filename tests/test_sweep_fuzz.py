"""Some hundred malformed specs and damaged tables end in words, not in tracebacks (`tests.fuzz` does more)."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
# The checkout comes last: what is tested is the installed package.
START = "import runpy, sys; sys.path.append('.'); runpy.run_module('tests.fuzz', run_name='__main__', alter_sys=True)"


def test_malformed_specs_and_damaged_tables_are_refused_in_words():
    command = [sys.executable, "-P", "-c", START, "--cases", "400", "--seed", "7", "--tables", "0.3"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1].split()[:2] == ["all", "400"], done.stdout
