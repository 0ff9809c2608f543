"""
A cluster run
=============

What to look at before a large sweep, and which jobs it becomes.
"""

# %%
# A plan says how many tasks there are and how long they take, for this machine and any number of ranks.

import subprocess
import sys
import tempfile
from pathlib import Path

folder = Path(tempfile.mkdtemp())
(folder / "large.toml").write_text(
    """
name = "large"
[grid]
N         = { log = [5, 500], points = 60 }
zeta_T    = { log = [1e-5, 1], points = 50 }
M_over_M0 = { log = [0.1, 10], points = 12 }
V_over_V0 = { log = [0.1, 10], points = 12 }
[accuracy]
target = 1e-2
"""
)


def sweep(*words):
    """The command, and what it prints."""
    command = [sys.executable, "-P", "-m", "sweep", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    told = done.stdout.replace(str(Path(sys.prefix)), "/home/me/bistable/.venv").replace(str(folder), "/home/me/sweeps")
    print(f"$ sweep {' '.join(words)}\n{told}")


sweep("plan", "large.toml")

# %%
# The jobs: the plan's cost, spread over ranks, each job with a time limit. A job stops in time, is queued
# again, and goes on where it was; whatever happens to it, no row that was reported done is lost. Without
# ``--dry-run`` they are submitted.

sweep("submit", "large.toml", "-o", "large.h5", "--dry-run")

# %%
# The same as an array of jobs that never talk, and one that joins their tables:

sweep("submit", "large.toml", "-o", "large.h5", "--array", "3", "--dry-run")

# %%
# ``sweep status large.h5`` looks at a running sweep from anywhere, ``sweep doctor DIR`` at a folder and its
# file system, and ``sweep audit large.h5`` recomputes a sample far more tightly (:doc:`/clusters`).
