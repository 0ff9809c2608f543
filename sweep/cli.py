"""The command line (contract): `sweep COMMAND`, each in a file of `commands`; `python -m sweep` is the same."""

import argparse
import contextlib
import io
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

from sweep import commands
from sweep.errors import InputError
from sweep.run import BAD_INPUT, EXIT_STATUS
from sweep.site import launch


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        super().error(_printable(message))


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = _Parser(
        prog="sweep",
        description="Parameter sweeps of impact on bistable chains.",
        epilog=EXIT_STATUS,
        allow_abbrev=False,
    )
    names = top.add_subparsers(required=True, metavar="COMMAND")
    for command in commands.ALL:
        command.add(names)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a path need not be text
    args = _parse(argv)
    try:
        return int(args.command(args))
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
