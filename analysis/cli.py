"""The command line: `analysis COMMAND ... -o PICTURE`, each command in a file of `commands`."""

import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from sweep.errors import InputError
from sweep.grammar import Parser, answer, open_streams, program

# Each is a file of analysis.commands; the help has them in this order.
COMMANDS = (
    *("best", "map", "points", "transition", "level", "collapse", "findings"),
    *("page", "view", "tradeoff", "atlas", "paper", "outlook", "convention"),
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; 0 if picture and CSV were written, 2 for bad input (one line per problem on stderr)."""
    open_streams()

    def work() -> int:
        args = parser().parse_args(_before_at(sys.argv[1:] if argv is None else argv))
        print("\n".join(args.command(args)))
        return 0

    return answer("analysis", work, (InputError, OSError))


def _before_at(words: Sequence[str]) -> list[str]:
    """The words, but a file before the `--at` that would take it for one more NAME=VALUE."""
    found, place = list[str](), -1
    for word in words:
        if word.startswith("-"):
            place = len(found) if word == "--at" else -1
        if place >= 0 and Path(word).suffix and Path(word).is_file():
            found.insert(place, word)
            place += 1
        else:
            found.append(word)
    return found


def parser() -> Parser:
    """The command line's grammar."""
    top = program("analysis", description="Maps, fits and findings from a table of results.")
    names = top.add_subparsers(required=True, metavar="COMMAND", dest="name")
    for name in COMMANDS:
        import_module(f"analysis.commands.{name}").add(names)
    return top
