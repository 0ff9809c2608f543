"""The command line (contract): `sweep COMMAND`, each in a file of `commands`; `python -m sweep` is the same."""

import argparse
import contextlib
import io
import os
from collections.abc import Sequence

from sweep import commands, grammar
from sweep.errors import ALL_DONE, EXIT_STATUS, InputError
from sweep.site import launch


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = grammar.program("sweep", description="Parameter sweeps of impact on bistable chains.", epilog=EXIT_STATUS)
    top.set_defaults(on_all_ranks=False)
    names = top.add_subparsers(required=True, metavar="COMMAND")
    for command in commands.ALL:
        command.add(names)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status."""
    grammar.open_streams()
    on_all_ranks = True  # as long as nobody knows the command

    def work() -> int:
        nonlocal on_all_ranks
        args = _parse(argv)
        on_all_ranks = args.on_all_ranks
        return _done(args)

    status = grammar.answer("sweep", work, (InputError,))
    if status == grammar.INTERRUPTED and on_all_ranks:
        launch.end_those_that_start(status)
    launch.part(status)
    return status


def _done(args: argparse.Namespace) -> int:
    """The exit status of a command; of those that need no other ranks the first alone looks, writes and tells."""
    if launch.stated_rank(os.environ) > 0 and not args.on_all_ranks:
        return ALL_DONE
    return int(args.command(args))


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """A usage error is printed once, by rank 0; every rank exits 2."""
    if launch.stated_rank(os.environ) == 0:
        return parser().parse_args(argv)
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        return parser().parse_args(argv)
