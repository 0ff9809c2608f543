"""From nothing to a map without root: the wheel with its MPI from the package index, in an environment of its own.

    python -m tests.newcomer [--keep]

As root the whole is done as the user `nobody`. What every step takes is wall time and processor time of its processes;
the index's answers are in neither the kernel's hands nor ours.
"""

import argparse
import os
import pwd
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from tests.measured import keep

ROOT = Path(__file__).parent.parent
INDEX_WAIT = 20.0  # seconds for the index's first answer
STEP_MAX = 900.0  # seconds of one step; far above what any takes
WHEEL = "python -m pip wheel -q --no-deps --no-build-isolation -w {folder} ."
# After the wheel is there: what a user types, in the folder of the new environment.
STEPS: Mapping[str, str] = {
    "a virtual environment": "python3 -m venv env",
    "`pip install --no-compile` of the wheel with its MPI": (
        "env/bin/python -m pip install -q --no-compile {pinned} {wheel}[mpi]"
    ),
    "the first `sweep run`, on two ranks, which compiles the kernel": (
        "env/bin/mpirun -n 2 env/bin/sweep run quick.toml -o quick.h5"
    ),
    "`analysis best`": "env/bin/analysis best quick.h5 -o quick.png",
    "the same `sweep run`, compiled": "env/bin/mpirun -n 2 env/bin/sweep run quick.toml -o again.h5",
}
TO_A_MAP = 4  # steps until there is a map


def index_problem() -> str:
    """Why pip can have nothing from its index; empty where it can."""
    ask = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--no-cache-dir", "mpich"]
    with tempfile.TemporaryDirectory() as folder:
        try:
            subprocess.run([*ask, "-d", folder], check=True, capture_output=True, timeout=INDEX_WAIT)
        except subprocess.SubprocessError as error:
            return f"pip cannot have mpich from its index: {type(error).__name__}"
    return ""


@contextmanager
def home() -> Iterator[Path]:
    """An empty folder that belongs to who is to work there: `nobody` where we are root."""
    folder = Path(tempfile.mkdtemp(prefix="newcomer-"))
    try:
        if os.getuid() == 0:
            nobody = pwd.getpwnam("nobody")
            os.chown(folder, nobody.pw_uid, nobody.pw_gid)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def work(folder: Path, pinned: bool) -> dict[str, tuple[float, float]]:
    """Do all steps in the folder; wall and processor seconds of each. CalledProcessError where one fails.

    `pinned`: the versions that the project is tested with, else the newest that the index has.
    """
    wheels, source = folder / "wheels", folder / "source"
    source.mkdir()  # a copy: a wheel is built from build/, which would stay in the checkout
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for package in ("kernel", "sweep", "analysis"):
        shutil.copytree(ROOT / package, source / package, ignore=shutil.ignore_patterns("__pycache__"))
    build = WHEEL.format(folder=wheels).split()
    subprocess.run([sys.executable, *build[1:]], cwd=source, check=True, capture_output=True, timeout=STEP_MAX)
    shutil.copy(ROOT / "jobs" / "quick.toml", folder)
    shutil.copy(ROOT / ".ci" / "constraints.txt", folder)
    (wheel,) = wheels.glob("*.whl")
    names = {"pinned": "-c constraints.txt" if pinned else "", "wheel": wheel}
    return {what: _timed(step.format(**names).split(), folder) for what, step in STEPS.items()}


def _timed(command: list[str], folder: Path) -> tuple[float, float]:
    who = {"user": "nobody", "group": "nogroup", "extra_groups": []} if os.getuid() == 0 else {}
    kept = ("PATH", "LANG", *(name for name in os.environ if name.startswith(("PIP_", "SSL_"))))
    environment = {name: os.environ[name] for name in kept if name in os.environ} | {"HOME": str(folder)}
    path = environment["PATH"].split(os.pathsep)  # without the environment that this test itself runs in
    environment["PATH"] = os.pathsep.join(place for place in path if not place.startswith(sys.prefix))
    start, before = time.monotonic(), _processor_seconds()
    subprocess.run(
        command, cwd=folder, env=environment, check=True, capture_output=True, text=True, timeout=STEP_MAX, **who
    )
    return time.monotonic() - start, _processor_seconds() - before


def _processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", action="store_true", help="for the documentation (tests.measured)")
    args = parser.parse_args()
    if problem := index_problem():
        sys.exit(problem)
    with home() as folder:
        took = work(folder, pinned=False)
    first = list(took.values())[:TO_A_MAP]
    took["from nothing to a map"] = (sum(wall for wall, _ in first), sum(cpu for _, cpu in first))
    for what, (wall, cpu) in took.items():
        print(f"{what:64} {wall:5.0f} s by the clock {cpu:5.0f} s of processors")
    if args.keep:
        heads = "seconds by the clock", "seconds of processors"
        rows = [
            {"step": what} | {head: f"{t:.0f}" for head, t in zip(heads, two, strict=True)}
            for what, two in took.items()
        ]
        keep("newcomer", rows, "two cores with nothing else to do; the clock counts the index's answers too")


if __name__ == "__main__":
    main()
