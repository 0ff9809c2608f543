"""What the command lines `sweep` and `analysis` share: hints, version, completion, and how a command ends."""

import argparse
import errno
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from kernel.hints import did_you_mean
from kernel.version import __version__
from sweep.errors import BAD_INPUT
from sweep.log import drop_stdout

CLOSED_PIPE = 141  # what a shell tells of a program that SIGPIPE ended: 128 + 13
PATHS = ("TABLE", "PICTURE", "PAGE", "FILE", "DIR")  # what an argument is called that names a file
NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
SHELLS = ("bash", "zsh", "tcsh")


class Parser(argparse.ArgumentParser):
    """A grammar that takes no abbreviations and answers a mistyped command, choice or option with what is near it."""

    _given: Sequence[str] = ()

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{"allow_abbrev": False} | kwargs)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse has it, but that a subcommand answers for its own options."""
        self._given = sys.argv[1:] if args is None else list(args)
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error("there is no such option or argument: " + " ".join(unknown))
        return known, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            hint = did_you_mean(str(value), map(str, action.choices or ()))
            raise argparse.ArgumentError(action, error.message + hint) from None

    def error(self, message: str) -> NoReturn:
        """Usage and one line, with what each unknown option may have meant; exit status 2."""
        words = (word.partition("=")[0] for word in self._given if word.startswith("--"))
        unknown = dict.fromkeys(word for word in words if word not in (*self._option_string_actions, "--"))
        hints = [f"; {word}{hint}" for word in unknown if (hint := did_you_mean(word, self._option_string_actions))]
        super().error(printable("".join([message, *hints])))


class _PrintCompletion(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *args: Any) -> None:
        import shtab  # which nobody needs who does not ask for this

        _complete_files(parser, shtab.FILE)
        print(shtab.complete(parser, shell=args[1]))
        parser.exit(0)


def _complete_files(parser: argparse.ArgumentParser, how: Any) -> None:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _complete_files(command, how)
        elif action.type is Path or action.metavar in PATHS:
            action.complete = how  # type: ignore[attr-defined] # where shtab looks for it


def program(name: str, **kwargs: Any) -> Parser:
    """The grammar of a whole command line, with what every one has; `kwargs` as argparse.ArgumentParser takes them."""
    top = Parser(prog=name, **kwargs)
    top.add_argument("--version", action="version", version=f"{name} {__version__} (bistable-sweep)")
    top.add_argument(
        "--print-completion",
        action=_PrintCompletion,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print the completion for {', '.join(SHELLS)}",
    )
    return top


def answer(name: str, work: Callable[[], int], refused: tuple[type[Exception], ...]) -> int:
    """Do the work of a command line; its exit status.

    Parameters
    ----------
    name : of the program, before every line on stderr.
    work : parses, does, prints; gives the exit status.
    refused : what bad input raises; its `problems`, or else its text, go to stderr, one line each: status 2.

    Returns
    -------
    What `work` gave, 2, or 141 where nobody reads what is printed any more.
    """
    try:
        try:
            return work()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        drop_stdout()
        return CLOSED_PIPE
    except refused as error:
        problems = getattr(error, "problems", (str(error),))
        sys.stderr.write("".join(f"{name}: {printable(problem)}\n" for problem in problems))
        return BAD_INPUT
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        drop_stdout()
        sys.stderr.write(f"{name}: what there is to tell cannot be written: {error.strerror}\n")
        return BAD_INPUT


def printable(text: str) -> str:
    """On one line, whatever a key or a path holds."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
