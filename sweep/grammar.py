"""What the command lines `sweep` and `analysis` share: hints, version, completion, and how a command ends."""

import argparse
import errno
import io
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

from kernel.hints import did_you_mean
from kernel.version import __version__
from sweep.errors import BAD_INPUT, of_system
from sweep.log import drop, settle_stderr

# The exit statuses that a shell gives to a program that SIGPIPE (13) or SIGINT (2) ended: 128 and its number.
CLOSED_PIPE, INTERRUPTED = 141, 130
PATHS = ("TABLE", "PICTURE", "PAGE", "FILE", "DIR")  # the metavar of every argument that names a file or folder
NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
SHELLS = ("bash", "zsh", "tcsh")
REFUSED_BY = "SWEEP_REFUSED_BY"  # environment variable: stands before each problem, for who must tell it from the log


class _Commands(argparse._SubParsersAction):  # type: ignore[type-arg]
    def add_parser(self, name: str, **kwargs: Any) -> Any:
        """The help of a command begins with what the list of commands says of it."""
        told: dict[str, Any] = {"description": kwargs.get("help"), **kwargs}
        return super().add_parser(name, **told)


class Parser(argparse.ArgumentParser):
    """A grammar without abbreviations. A mistyped command, choice or option is answered with what may be meant.

    A command that sets the default `tells_wrong` gets `wrong` values in words, to tell them beside its other problems.
    """

    _given: Sequence[str] = ()
    _wrong: Sequence[str] = ()  # values of options, in words: told together

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{"allow_abbrev": False} | kwargs)
        self.register("action", "parsers", _Commands)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As in argparse, except that a subcommand reports its own unknown options."""
        self._given, self._wrong = sys.argv[1:] if args is None else list(args), list[str]()
        known, unknown = super().parse_known_args(args, namespace)
        if unknown or (self._wrong and not self.get_default("tells_wrong")):
            self.error("there is no such option or argument: " + " ".join(unknown) if unknown else "")
        known.wrong = [line.removeprefix("argument ") for line in self._wrong] or getattr(known, "wrong", [])
        return known, unknown

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        try:
            return super()._get_value(action, arg_string)
        except argparse.ArgumentError as error:
            self._tell_later(action, error)
            return None

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            hint = did_you_mean(str(value), map(str, action.choices or ()))
            self._tell_later(action, argparse.ArgumentError(action, error.message + hint))

    def _tell_later(self, action: argparse.Action, error: argparse.ArgumentError) -> None:
        """Unless something would be done at once with the value."""
        if not isinstance(action, argparse._StoreAction | argparse._AppendAction):
            raise error from None
        self._wrong = (*self._wrong, str(error))

    def error(self, message: str) -> NoReturn:
        """Print the usage and one line, with what each unknown option may mean; exit status 2."""
        words = (word.partition("=")[0] for word in self._given if word.startswith("--"))
        unknown = dict.fromkeys(word for word in words if word not in (*self._option_string_actions, "--"))
        hints = [f"; {word}{hint}" for word in unknown if (hint := did_you_mean(word, self._option_string_actions))]
        told = "; ".join(filter(None, (*self._wrong, message)))
        super().error(printable("".join([told, *hints])))


class _PrintCompletion(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *args: Any) -> None:
        import shtab  # loaded only for those who ask for a completion

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


def open_streams() -> None:
    """Make stdin, stdout and stderr ready for a command, before it opens any file.

    One that whoever started it has closed leads nowhere: else a table would get its number, and what is told with it.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)  # the lowest number that is free, which is this one
            os.set_inheritable(nowhere, True)
            setattr(sys, name, os.fdopen(nowhere, mode, errors="backslashreplace"))
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a path need not be text


def answer(name: str, work: Callable[[], int], refused: tuple[type[Exception], ...]) -> int:
    """Do the work of a command line, named `name`; the exit status that `work` gives, or 2, 130 or 141.

    2: `work` raised one of the exceptions `refused`, whose `problems` (or text) go to stderr, one line each; or the
    system refused a file.
    130: a Ctrl-C ended it. 141: nobody reads any more what is printed.
    """
    try:
        try:
            return work()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        drop(sys.stdout)
        return CLOSED_PIPE
    except refused as error:
        problems = getattr(error, "problems", (str(error),))
        refuse(name, problems)
        return BAD_INPUT
    except OSError as error:
        if not (problem := of_system(error)):
            if error.errno not in NO_ROOM:
                raise
            drop(sys.stdout)
            problem = f"what there is to tell cannot be written: {error.strerror}"
        refuse(name, [problem])
        return BAD_INPUT
    except KeyboardInterrupt:
        sys.stderr.write(f"{name}: interrupted\n")
        return INTERRUPTED
    finally:
        settle_stderr()


def refuse(name: str, problems: Iterable[str]) -> None:
    """Tell what the user can mend, one line each."""
    by = os.environ.get(REFUSED_BY, name)
    with suppress(OSError):  # a full disk under the log does not change how it ends
        sys.stderr.write("".join(f"{by}: {printable(problem)}\n" for problem in problems))


def printable(text: str) -> str:
    """On one line, whatever a key or a path holds."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
