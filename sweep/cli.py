"""The command line (contract): `sweep plan | run | status | show | audit`; `python -m sweep` is the same."""

import argparse
import contextlib
import io
import json
import os
import platform
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from sweep import launch, writers
from sweep.errors import InputError
from sweep.run import BAD_INPUT, SOME_FAILED, Options, run

EPILOG = "exit status: 0 all rows done; 1 some rows failed; 2 bad input or environment; 75 stopped early, run again"
AUDIT_EPILOG = "exit status: 0 the table keeps its promise; 1 it breaks it; 2 bad input"


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = argparse.ArgumentParser(
        prog="sweep", description="Parameter sweeps of impact on bistable chains.", epilog=EPILOG, allow_abbrev=False
    )
    commands = top.add_subparsers(dest="command", required=True)
    plan = commands.add_parser("plan", help="tasks, predicted cost, table size; runs nothing")
    plan.add_argument("spec", type=Path)
    plan.add_argument("--json", action="store_true")
    run_ = commands.add_parser("run", help="run or resume a sweep, under mpirun or alone", epilog=EPILOG)
    run_.add_argument("spec", type=Path)
    run_.add_argument("-o", "--output", type=Path, required=True, metavar="TABLE", help="created, or resumed")
    run_.add_argument("--writer", choices=writers.NAMES, default="auto", help="who writes rows (default: auto)")
    run_.add_argument("--keep-rows", action="store_true", help="resume although the kernel has changed since")
    for name, text in (("status", "done, failed, left, rate, ETA"), ("show", "where a table comes from")):
        command = commands.add_parser(name, help=f"{text}; also while it is being written")
        command.add_argument("table", type=Path)
        command.add_argument("--json", action="store_true")
    audit = commands.add_parser("audit", help="recompute a sample much more tightly", epilog=AUDIT_EPILOG)
    audit.add_argument("table", type=Path)
    audit.add_argument("--fraction", type=float, default=0.01, metavar="F", help="of the done rows (default: 0.01)")
    audit.add_argument("--json", action="store_true")
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status."""
    args = _parse(argv)
    try:
        return {"run": _run, "audit": _audit}.get(args.command, _report)(args)
    except InputError as error:
        sys.stderr.write("".join(f"sweep: {_printable(problem)}\n" for problem in error.problems))
        return BAD_INPUT


def _printable(text: str) -> str:
    """On one line, whatever a key or a path holds."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """A usage error is told once, by rank 0; every rank exits 2."""
    if launch.rank_told(os.environ) == 0:
        return parser().parse_args(argv)
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        return parser().parse_args(argv)


def _run(args: argparse.Namespace) -> int:
    comm = launch.communicator()
    options = Options(args.spec, args.output, args.writer, args.keep_rows)
    try:
        return run(comm, options)
    except InputError:
        raise
    except Exception:
        if comm is None:
            raise
        # The other ranks would wait for this one for ever.
        sys.stderr.write(f"sweep: rank {comm.rank} on {platform.node()}\n{traceback.format_exc()}")
        sys.stderr.flush()
        comm.Abort(1)
        raise


def _report(args: argparse.Namespace) -> int:
    from sweep import report  # pydantic, which the workers of a run do without

    told = {"plan": report.plan, "status": report.status, "show": report.show}[args.command]
    answer = told(args.spec if args.command == "plan" else args.table)
    print(json.dumps(answer, indent=1) if args.json else report.as_text(answer))
    return 0


def _audit(args: argparse.Namespace) -> int:
    from sweep import audit, audit_text

    answer = audit.audit(args.table, args.fraction)
    print(json.dumps(answer, indent=1) if args.json else audit_text.as_text(answer))
    return 0 if answer["kept"] else SOME_FAILED
