"""Twenty kills and eight damaged tables: nothing that was reported done is lost (`python -m tests.chaos` does more)."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.mpi
ROOT = Path(__file__).parent.parent


def test_twenty_kills_lose_nothing():
    command = [sys.executable, "-m", "tests.chaos", "--kills", "20", "--damages", "8", "--seed", "7"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0, done.stdout + done.stderr
