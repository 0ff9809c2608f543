"""What can be read off the machine without trying: processor, compiled kernel, disk, SLURM."""

import os
import shutil
import subprocess
from pathlib import Path

from sweep.machine import cache_folder, processor_name
from sweep.schema import ROW

GOOD, LIMIT, BAD = "good", "limit", "bad"
NETWORK = ("nfs", "lustre", "gpfs", "beegfs", "ceph", "cifs", "smb", "panfs", "fuse.", "9p")
ENOUGH = 1e9  # bytes
PARTITIONS = ["sinfo", "--noheader", "--format=%R %a"]  # which it must ask the controller for
ANSWER_WITHIN = 20.0  # seconds; sinfo itself tries for ten


def processor() -> tuple[str, str]:
    """Which one, and how many sites it takes at once."""
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    width = next((n for name, n in (("avx512f", 8), ("avx2", 4), ("sse2", 2)) if name in flags), 1)
    cores = len(os.sched_getaffinity(0))
    return (GOOD if width >= 4 else LIMIT), f"{processor_name()}, {cores} cores for this process, vectors of {width}"


def cache() -> tuple[str, str]:
    """Whether the kernel is compiled, and where it is kept."""
    folder = cache_folder()
    compiled = sum(1 for _ in folder.rglob("*.nbc")) if folder.is_dir() else 0
    parent = next(path for path in (folder, *folder.absolute().parents) if path.is_dir())
    if not os.access(parent, os.W_OK):
        return LIMIT, f"the compiled kernel cannot be kept in {folder}: every start compiles; set NUMBA_CACHE_DIR"
    if not compiled:
        return LIMIT, f"not compiled yet: the first run takes a minute longer, then finds it in {folder}"
    return GOOD, f"compiled code in {folder}"


def disk(place: Path) -> tuple[str, str]:
    """Room and kind of file system."""
    free, kind = shutil.disk_usage(place).free, _kind(place)
    told = f"{kind}, {free / 1e9:.3g} GB free, {free / ROW.itemsize / 1e6:.3g} million rows"
    if kind.startswith(NETWORK):
        return LIMIT, f"{told}; a network file system: not tested, prefer --writer gather"
    return (GOOD if free > ENOUGH else LIMIT), told


def _kind(place: Path) -> str:
    mounts = (line.split() for line in Path("/proc/mounts").read_text().splitlines())
    real = place.resolve()
    holding = [(len(Path(at).parts), kind) for _, at, kind, *_ in mounts if real.is_relative_to(at)]
    return max(holding, default=(0, "unknown file system"))[1]


def slurm() -> tuple[str, str]:
    """Whether jobs can be submitted from here, by the controller's own word."""
    names = ("sbatch", "squeue", "scontrol", "scancel", "sinfo")
    if missing := [name for name in names if shutil.which(name) is None]:
        return LIMIT, f"no {', '.join(missing)}: jobs cannot be submitted from here"
    try:
        answer = subprocess.run(PARTITIONS, capture_output=True, text=True, check=False, timeout=ANSWER_WITHIN)
    except subprocess.TimeoutExpired:
        return LIMIT, f"its controller does not answer within {ANSWER_WITHIN:g} s: jobs cannot be submitted now"
    except OSError as error:
        return LIMIT, f"sinfo cannot be run ({error.strerror}): jobs cannot be submitted from here"
    if answer.returncode:
        why = (answer.stderr.strip().splitlines() or [f"exit status {answer.returncode}, without a reason"])[-1]
        return LIMIT, f"its controller cannot be reached, jobs cannot be submitted now: {why}"
    up = sorted({name for name, state in map(str.split, answer.stdout.splitlines()) if state == "up"})
    if not up:
        return LIMIT, "its controller answers, but no partition is up: jobs would wait"
    return GOOD, f"jobs can be submitted from here (sweep submit), to {', '.join(up)}"
