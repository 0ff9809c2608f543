"""The command line: `python -m analysis COMMAND ... -o PICTURE`, each command in a file of `commands`."""

import argparse
import sys
from collections.abc import Sequence

from analysis import commands
from analysis.errors import InputError


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; 0 if picture and CSV were written, 2 for bad input (one line on stderr)."""
    args = _parser().parse_args(argv)
    try:
        lines = args.command(args)
    except (InputError, OSError) as error:
        print(f"analysis: {error}", file=sys.stderr)
        return 2
    print("\n".join(lines))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="analysis", description="Maps from a table of results.")
    names = parser.add_subparsers(required=True, metavar="COMMAND")
    for command in commands.ALL:
        command.add(names)
    return parser
