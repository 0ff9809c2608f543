"""Which file of tests runs which lines of the code, and how long it takes; and the lines that none runs.

    python -m tests.covered [--at-once 2] [-o covered.jsonl]

Each file of tests is run alone under coverage.py, with the commands and ranks that it starts, on a copy of the code
that it compiles once: some forty minutes on two cores. Compiled functions run unseen, and so does what is killed.
A run that was stopped goes on with the next file of tests. Needs coverage.py (python -m pip install coverage), which is
no part of the environment: where it is there, numba loads it at every start of every rank.
"""

import argparse
import ast
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

HOME = Path(__file__).parent.parent
ROOMS = ("kernel", "sweep", "analysis")
CHOSEN = "not slurm and not nodes"  # the others simulate machines, two of which would be in each other's way
TIME_LIMIT = 1200  # seconds, far above what any file of tests takes
SETTINGS = """
[run]
parallel = true
patch = subprocess, _exit
source = {folder}
data_file = {folder}/{name}/lines
disable_warnings = no-data-collected, module-not-measured, module-not-imported, couldnt-parse
"""


def copied(folder: Path, rooms: Sequence[str] = ROOMS) -> dict[str, str]:
    """The environment in which tests see the copy of these rooms that is now in this folder."""
    for room in rooms:
        shutil.copytree(HOME / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
    own = {"PYTHONPATH": str(folder), "HYPOTHESIS_STORAGE_DIRECTORY": f"{folder}/hypothesis"}
    return os.environ | own | ({"NUMBA_CACHE_DIR": f"{folder}/cache"} if "kernel" in rooms else {})


def covered(test: Path, folder: Path, environment: dict[str, str]) -> dict[str, Any]:
    """What one file of tests runs: its name, whether it passes, its seconds, and the lines of each file of the code."""
    from coverage import CoverageData
    from coverage.exceptions import CoverageException

    (folder / test.stem).mkdir()
    settings = folder / f"{test.stem}.ini"
    settings.write_text(SETTINGS.format(folder=folder, name=test.stem))
    command = [sys.executable, "-P", "-m", "coverage", "run", f"--rcfile={settings}", "-m", "pytest", "-q"]
    begun = time.monotonic()
    command += ["-p", "no:cacheprovider", "-m", CHOSEN, str(test)]
    done = subprocess.run(command, cwd=HOME, env=environment, capture_output=True, timeout=TIME_LIMIT)
    seconds, lines = round(time.monotonic() - begun, 1), dict[str, set[int]]()
    for file in (folder / test.stem).iterdir():
        data = CoverageData(str(file))
        with suppress(CoverageException):  # torn where a test lets no file grow
            data.read()
            for code in data.measured_files():
                lines.setdefault(str(Path(code).relative_to(folder)), set()).update(data.lines(code) or ())
    ran = {code: sorted(lines[code]) for code in lines}
    return {"test": test.stem, "passes": done.returncode == 0, "seconds": seconds, "lines": ran}


def read(table: Path) -> dict[str, dict[str, Any]]:
    """What was found of each file of tests, by its name."""
    lines = table.read_text().splitlines() if table.exists() else []
    return {found["test"]: found for found in map(json.loads, lines)}


def statements(code: Path) -> Iterator[int]:
    """The lines of the statements in this file's functions, but for docstrings and what numba compiles."""
    for function in ast.walk(ast.parse(code.read_text())):
        if isinstance(function, ast.FunctionDef) and not function.decorator_list:
            for node in function.body[ast.get_docstring(function) is not None :]:
                yield from (inner.lineno for inner in ast.walk(node) if isinstance(inner, ast.stmt))


def main() -> int:
    """Run what is not in the table, and print the lines that no test runs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--at-once", type=int, default=2, help="files of tests that run side by side")
    parser.add_argument("-o", "--output", type=Path, default=Path("covered.jsonl"))
    args = parser.parse_args()
    left = [test for test in sorted((HOME / "tests").glob("test_*.py")) if test.stem not in read(args.output)]
    with TemporaryDirectory() as folder, args.output.open("a") as file, ThreadPoolExecutor(args.at_once) as pool:
        environment = copied(Path(folder))
        for done in as_completed([pool.submit(covered, test, Path(folder), environment) for test in left]):
            found = done.result()
            how = "" if found["passes"] else "fails, or was left out"
            print(found["test"], found["seconds"], "s", how, file=sys.stderr, flush=True)
            print(json.dumps(found), file=file, flush=True)
    every = read(args.output).values()
    for code in sorted(code for room in ROOMS for code in (HOME / room).rglob("*.py")):
        name = str(code.relative_to(HOME))
        ran = {line for found in every for line in found["lines"].get(name, ())}
        if missed := sorted(set(statements(code)) - ran):
            print(name, *missed)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
