"""Puts faults into a copy of the code, one by one, and runs the tests of that room: do they notice?

    python -m tests.mutate [--faults 100] [--seed 1] [--rooms kernel sweep analysis] [--at-once 1] [-o faults.csv]

A fault is one change of one line, drawn evenly over the files of a room: a number (another by a tenth, or by one), a
sign, a comparison, `and` for `or`, a statement left out. Texts, types, docstrings and matters of taste are left alone.
The tests that import or start the file or are named after it are asked first, the other tests of the room where none of
these notices, until FAR_LIMIT, first those named after what imports the file; of both the quick ones before those that
start commands and ranks. A fault in the kernel compiles it anew. Survivors are printed with file and line: each is to
be explained, or to get a test. Exit status 1 where fewer than NOTICED_LEAST of the faults are noticed.

A run that was stopped goes on with the next fault: what the table holds already is not tried again (delete its line).
"""

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import NamedTuple

HOME = Path(__file__).parent.parent
ROOMS = ("kernel", "sweep", "analysis")
NOTICED_LEAST = 0.95
QUICK, REST = "not mpi and not slurm and not slow", "mpi or slow"
HANGS, NOT_NOTICED = "hangs", "not noticed"
TIME_LIMIT = 900  # seconds of the near tests, far above what they take; a fault that makes them hang is noticed
FAR_LIMIT = 300  # seconds of the others; what they would notice later is not noticed
SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
COMPARISONS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
COMPARISONS |= {ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}
LOOKS = {"alpha", "capsize", "fontsize", "linewidth", "markersize", "mew", "ms", "pad", "s", "title_fontsize", "zorder"}
FORBIDS = ("dataclass", "zip")  # with keywords that forbid what no run does: nothing could notice another


class Fault(NamedTuple):
    """One change: in this file, of this line, what it is, and the file's text with it."""

    file: Path
    line: int
    what: str
    text: str


def places(tree: ast.AST) -> Iterator[ast.AST]:
    """Nodes that can be changed, in order; nothing within annotations, docstrings and texts."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.arg | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.AnnAssign):
            continue
        if isinstance(node, ast.keyword) and isinstance(tree, ast.Call) and ast.unparse(tree.func) in FORBIDS:
            continue
        if isinstance(node, ast.FunctionDef):
            node.returns = None
        changeable = ast.BinOp | ast.Compare | ast.BoolOp | ast.Constant | ast.Assign | ast.AugAssign | ast.Expr
        if isinstance(node, changeable) and _what(node):
            yield node
        yield from places(node)


def _what(node: ast.AST) -> str:
    """What a fault at this node would be; nothing where there is none."""
    match node:
        case ast.Constant(value=bool()):
            return f"{not node.value} for {node.value}"
        case ast.Constant(value=int() | float()):
            return f"{_another(node.value)} for {node.value}"
        case ast.BinOp() if type(node.op) in SIGNS:
            return f"{SIGNS[type(node.op)].__name__} for {type(node.op).__name__}"
        case ast.Compare() if type(node.ops[0]) in COMPARISONS:
            return f"{COMPARISONS[type(node.ops[0])].__name__} for {type(node.ops[0]).__name__}"
        case ast.BoolOp():
            return "the other of and, or"
        case ast.AugAssign() | ast.Expr(value=ast.Call()):
            return f"without: {ast.unparse(node)}"
    return ""


def _another(number: float) -> float:
    return number + 1 if isinstance(number, int) else number * 1.1 if number else 0.1


def _change(node: ast.AST) -> None:
    match node:
        case ast.Constant(value=bool()):
            node.value = not node.value
        case ast.Constant():
            node.value = _another(node.value)  # type: ignore[arg-type]
        case ast.BinOp():
            node.op = SIGNS[type(node.op)]()
        case ast.Compare():
            node.ops[0] = COMPARISONS[type(node.ops[0])]()
        case ast.BoolOp():
            node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()


def faults(room: str, count: int, seed: int) -> list[Fault]:
    """So many faults of one room, the same for the same seed."""
    draw, found = random.Random(f"{room} {seed}"), list[Fault]()
    files = sorted((HOME / room).rglob("*.py"))
    trees = {file: tree for file in files if any(places(tree := ast.parse(file.read_text())))}
    while len(found) < count:
        file = draw.choice(sorted(trees))
        tree = deepcopy(trees[file])
        node = draw.choice(list(places(tree)))
        if _is_taste(tree, node):
            continue
        what, line = _what(node), node.lineno  # type: ignore[attr-defined]
        if what.startswith("without"):
            _leave_out(tree, node)
        else:
            _change(node)
        fault = Fault(file.relative_to(HOME), line, what, ast.unparse(ast.fix_missing_locations(tree)))
        found += [fault] if fault not in found else []
    return found


def _is_taste(tree: ast.AST, node: ast.AST) -> bool:
    """Whether it is a width or size of something drawn, or a seed: another is as good."""
    for parent in ast.walk(tree):
        if isinstance(parent, ast.keyword) and parent.value is node and parent.arg in LOOKS:
            return True
        if isinstance(parent, ast.Call) and node in parent.args and ast.unparse(parent.func).endswith("default_rng"):
            return True
    return False


def _leave_out(tree: ast.AST, node: ast.AST) -> None:
    for parent in ast.walk(tree):
        for name in ("body", "orelse", "finalbody"):
            body = getattr(parent, name, None)
            if isinstance(body, list) and node in body:
                body[body.index(node)] = ast.Pass()


def tests_of(fault: Fault) -> tuple[list[Path], list[Path]]:
    """Files of near tests, which import its file, call it, are named after it or compare what is kept, and the rest."""
    room, *names = fault.file.with_suffix("").parts
    package, words = re.escape(".".join((room, *names[:-1]))), {word.rstrip("s") for word in names}
    of_room = re.compile(rf"^(?:import|from) {room}\b", re.MULTILINE)
    imports = re.compile(rf"from {package}\.{names[-1]} import |from {package} import .*\b{names[-1]}\b")
    tree = ast.parse((HOME / fault.file).read_text())
    public = [node.name for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name[4:]]
    of_command = rf'(?:{room}|main)\(\[?"{names[-1]}"'
    calls = re.compile("|".join([of_command, *(rf"\b{name}\(" for name in public if name[0] != "_")]))
    users = {file.stem for file in (HOME / room).rglob("*.py") if imports.search(file.read_text())}

    def distance(file: Path) -> int:
        text, called = file.read_text(), set(file.stem.split("_"))
        if room == "kernel" and {"sweep", "analysis"} & called:  # which want it compiled
            return 6
        if room == "kernel" and "numerics" in called:  # compares bits of the paper's chain, and compiles that alone
            return 0
        if imports.search(text) or (names == ["__main__"] and f'"-m", "{room}"' in text):
            return 1
        if room == "analysis" and "assert_kept" in text:  # compares pictures, numbers and pages
            return 2
        if file.stem != "test_docs" and not {room, *names[:-1]} & called and not of_room.search(text):
            return 6
        if words & {word.rstrip("s") for word in called} or calls.search(text):
            return 2
        return 3 if users & called else 4 if names[-1] in text else 5

    files = sorted((HOME / "tests").glob("test_*.py"), key=lambda file: (distance(file), room not in file.stem, file))
    return [file for file in files if distance(file) < 3], [file for file in files if 3 <= distance(file) < 6]


def noticed(fault: Fault) -> str:
    """Which test noticed the fault, or nothing."""
    room, (near, far) = fault.file.parts[0], tests_of(fault)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        shutil.copytree(HOME / room, copy / room, ignore=shutil.ignore_patterns("__pycache__"))
        (copy / fault.file).write_text(fault.text)
        environment = os.environ | {"PYTHONPATH": folder, "HYPOTHESIS_STORAGE_DIRECTORY": f"{folder}/hypothesis"}
        if room == "kernel":
            environment["NUMBA_CACHE_DIR"] = f"{folder}/cache"
        try:
            by = _failed(near, environment, TIME_LIMIT)
            return by or _failed(far, environment, FAR_LIMIT).replace(HANGS, "")
        finally:
            _end_all_with(f"PYTHONPATH={folder}")


def _end_all_with(variable: str) -> None:
    """End the processes with this in their environment: what a fault lets go on would take a core for ever."""
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if variable.encode() in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)


def _failed(files: list[Path], environment: dict[str, str], limit: float) -> str:
    """The first of these tests that fails; HANGS after the limit; nothing where all pass."""
    end = time.monotonic() + limit
    for chosen in (QUICK, REST) if files else ():
        command = [sys.executable, "-P", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", chosen, *files]
        with tempfile.TemporaryFile("w+") as said:  # no pipe, which what a killed test has started would hold open
            try:
                done = subprocess.run(command, cwd=HOME, env=environment, stdout=said, timeout=end - time.monotonic())
            except subprocess.TimeoutExpired:
                return HANGS
            said.seek(0)
            if done.returncode in (1, 2) or done.returncode < 0:  # a test failed, could not be loaded, or crashed
                names = re.findall(r"^(?:FAILED|ERROR) \S*?(\w+\.py\S*)", said.read(), re.MULTILINE)
                return names[-1] if names else f"exit status {done.returncode}"
    return ""


def _named(fault: Fault) -> str:
    return f"{fault.file}:{fault.line}\t{fault.what}"


def main() -> int:
    """Count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", nargs="+", choices=ROOMS, default=ROOMS)
    parser.add_argument("--at-once", type=int, default=1, help="faults that are tried side by side")
    parser.add_argument("-o", "--output", type=Path, default=Path("faults.csv"))
    args = parser.parse_args()
    each = -(-args.faults // len(args.rooms))
    every = [fault for room in args.rooms for fault in faults(room, each, args.seed)]
    args.output.touch()
    told = dict(line.rsplit("\t", 1) for line in args.output.read_text().splitlines())
    left = [fault for fault in every if _named(fault) not in told]
    with args.output.open("a") as file, ThreadPoolExecutor(args.at_once) as pool:
        for k, (fault, by) in enumerate(zip(left, pool.map(noticed, left), strict=True), len(every) - len(left) + 1):
            told[_named(fault)] = by or NOT_NOTICED
            line = f"{_named(fault)}\t{told[_named(fault)]}"
            print(f"{k}/{len(every)}", line, flush=True)
            print(line, file=file, flush=True)
    seen = sum(told[_named(fault)] != NOT_NOTICED for fault in every)
    print(f"{seen} of {len(every)} noticed")
    return 0 if seen >= NOTICED_LEAST * len(every) else 1


if __name__ == "__main__":
    raise SystemExit(main())
