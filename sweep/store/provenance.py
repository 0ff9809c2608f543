"""Where a table comes from: everything needed to make it again, as text."""

import json
import platform
import subprocess
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py

from kernel.version import source_hash
from sweep.machine import processor_name

GIT_WITHIN = 10.0  # seconds in which git tells a revision; a folder far away may be slower, and is not waited for
DOCUMENTS = ("versions", "resolved", "merged")  # texts that are JSON


def collect(spec_text: str, resolved: str, folder: Path, mpi: str) -> dict[str, str]:
    """Texts by name. `folder`: where the spec lies, whose git revision is kept; `mpi`: names the MPI library."""
    versions = {name: metadata.version(name) for name in ("bistable-sweep", "numpy", "numba", "h5py", "mpi4py")}
    versions |= {"python": platform.python_version(), "HDF5": h5py.version.hdf5_version, "MPI": mpi}
    return {
        "spec": spec_text,
        "resolved": resolved,
        "kernel": source_hash(),
        "versions": json.dumps(versions),
        "host": platform.node(),
        "processor": processor_name(),
        "git": _git_revision(folder),
    }


def read(known: Mapping[str, str]) -> dict[str, Any]:
    """What `collect` gave, where texts that are JSON are decoded; a damaged one stays a text."""
    return dict(known) | {name: _document(known[name]) for name in DOCUMENTS if name in known}


def _document(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _git_revision(folder: Path) -> str:
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        told = subprocess.run(command, capture_output=True, check=True, timeout=GIT_WITHIN).stdout
    except (OSError, subprocess.SubprocessError):
        return "not in a git checkout"
    return told.decode(errors="replace").strip()
