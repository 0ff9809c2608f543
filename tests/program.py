"""Runs a program of the tests, such as tests.fuzz, on the installed package."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
TIME_LIMIT = 1200  # seconds; far above what any of them takes
# The checkout comes last: what is tested is the installed package.
START = "import runpy, sys; sys.path.append('.'); runpy.run_module({!r}, run_name='__main__', alter_sys=True)"


def program(name: str, *arguments: str) -> str:
    """What `python -m name arguments` prints; AssertionError with it where the exit status is not 0."""
    command = [sys.executable, "-P", "-c", START.format(name), *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=TIME_LIMIT)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
