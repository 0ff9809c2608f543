"""Puts faults into a copy of the code, one by one, and runs the tests that run the line: do they notice?

    python -m tests.mutate [--faults 100] [--seed 1] [--rooms kernel sweep analysis] [--at-once 1] [-o faults.csv]
                           [--covered covered.jsonl]

A fault is one change of one line, drawn evenly over the files of a room: a number (another by a tenth, or by one), a
sign, a comparison, `and` for `or`, a statement left out. Texts, types, docstrings and matters of taste are left alone.
Which tests run the line, and how long they take, `python -m tests.covered` has found; quick ones that run much of the
file are asked first. Of a line that numba compiles nothing is known: all tests of the kernel are asked, first
those that compare bits or are named after the file. A fault in the kernel compiles it anew. Survivors are printed with
file and line: each is to be explained, or to get a test. Exit status 1 where fewer than NOTICED_LEAST of the faults are
noticed.

A run that was stopped goes on with the next fault: what the table holds already is not tried again (delete its line).
"""

import argparse
import ast
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import NamedTuple

from tests.covered import CHOSEN, HOME, ROOMS, TIME_LIMIT, copied, read

NOTICED_LEAST = 0.95
HANGS, NOT_NOTICED = "hangs", "not noticed"
LIMIT = 900  # seconds after which no further file of tests is asked: what it would notice is not noticed
SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
COMPARISONS = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
COMPARISONS |= {ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}
LOOKS = {"alpha", "capsize", "fontsize", "linewidth", "markersize", "mew", "ms", "pad", "s", "title_fontsize", "zorder"}
FORBIDS = ("dataclass", "zip")  # with keywords that forbid what no run does: nothing could notice another


class Fault(NamedTuple):
    """One change: in this file, of this line, what it is, the file's text with it, and the lines of its statement."""

    file: Path
    line: int
    what: str
    text: str
    statement: range


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
        what, line, within = _what(node), node.lineno, _statement(tree, node)  # type: ignore[attr-defined]
        if what.startswith("without"):
            _leave_out(tree, node)
        else:
            _change(node)
        fault = Fault(file.relative_to(HOME), line, what, ast.unparse(ast.fix_missing_locations(tree)), within)
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


def _statement(tree: ast.AST, node: ast.AST) -> range:
    """The lines of the innermost statement that holds this node, without the statements that this one holds."""
    holding = [
        some for some in ast.walk(tree) if isinstance(some, ast.stmt) and any(node is part for part in ast.walk(some))
    ]
    inner = holding[-1]
    body = getattr(inner, "body", None)
    return range(
        inner.lineno, max(inner.lineno + 1, body[0].lineno) if body else (inner.end_lineno or inner.lineno) + 1
    )


def tests_of(fault: Fault, found: dict[str, dict]) -> list[str]:
    """The files of tests that may notice it, in the order in which they are asked."""
    file, words = str(fault.file), set(fault.file.with_suffix("").parts[1:])
    ran = {test: set(found[test]["lines"].get(file, ())) for test in found}

    def likely(test: str) -> tuple[float, ...]:
        kin = "numerics" in test or words & set(test.split("_"))
        return (not kin if compiled else 0, found[test]["seconds"] / (1 + len(ran[test])))

    running = [test for test in found if ran[test].intersection(fault.statement)]
    compiled = fault.file.parts[0] == "kernel" and not running
    of_kernel = [test for test in found if test.startswith(("test_kernel", "test_known"))]
    return sorted(of_kernel if compiled else running, key=likely)


def noticed(fault: Fault, found: dict[str, dict]) -> str:
    """Which test noticed the fault, or nothing."""
    with tempfile.TemporaryDirectory() as folder:
        environment = copied(Path(folder), (fault.file.parts[0],))
        (Path(folder) / fault.file).write_text(fault.text)
        end = time.monotonic() + LIMIT
        try:
            failures = (_failed(test, environment) for test in tests_of(fault, found) if time.monotonic() < end)
            return next(filter(None, failures), "")
        finally:
            _end_all_with(f"PYTHONPATH={folder}")


def _end_all_with(variable: str) -> None:
    """End the processes with this in their environment: what a fault lets go on would take a core for ever."""
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if variable.encode() in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)


def _failed(test: str, environment: dict[str, str]) -> str:
    """Which test of this file failed first; HANGS where it takes longer than any does; nothing where all pass."""
    command = [sys.executable, "-P", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", CHOSEN]
    with tempfile.TemporaryFile("w+") as said:  # no pipe, which what a killed test has started would hold open
        try:
            command.append(f"tests/{test}.py")
            done = subprocess.run(command, cwd=HOME, env=environment, stdout=said, timeout=TIME_LIMIT)
        except subprocess.TimeoutExpired:
            return HANGS
        said.seek(0)
        if done.returncode not in (1, 2) and done.returncode >= 0:  # not failed, nor not loaded, nor crashed
            return ""
        names = re.findall(r"^(?:FAILED|ERROR) \S*?(\w+\.py\S*)", said.read(), re.MULTILINE)
        return names[-1] if names else f"exit status {done.returncode}"


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
    parser.add_argument(
        "--covered", type=Path, default=Path("covered.jsonl"), help="what python -m tests.covered wrote"
    )
    args = parser.parse_args()
    each = -(-args.faults // len(args.rooms))
    every = [fault for room in args.rooms for fault in faults(room, each, args.seed)]
    args.output.touch()
    found = {test: one for test, one in read(args.covered).items() if one["passes"]}  # others would notice anything
    told = dict(line.rsplit("\t", 1) for line in args.output.read_text().splitlines())
    left = [fault for fault in every if _named(fault) not in told]
    with args.output.open("a") as file, ThreadPoolExecutor(args.at_once) as pool:
        for k, (fault, by) in enumerate(
            zip(left, pool.map(partial(noticed, found=found), left), strict=True), len(every) - len(left) + 1
        ):
            told[_named(fault)] = by or NOT_NOTICED
            line = f"{_named(fault)}\t{told[_named(fault)]}"
            print(f"{k}/{len(every)}", line, flush=True)
            print(line, file=file, flush=True)
    seen = sum(told[_named(fault)] != NOT_NOTICED for fault in every)
    print(f"{seen} of {len(every)} noticed")
    return 0 if seen >= NOTICED_LEAST * len(every) else 1


if __name__ == "__main__":
    raise SystemExit(main())
