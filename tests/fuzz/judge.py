"""One command, in this process, and whether it kept the rules: what every case is judged by."""

import contextlib
import io
import os
import traceback
import zlib
from pathlib import Path

from sweep import cli

REFUSED, ACCEPTED, TRACEBACK, STATUS = "refused", "accepted", "tracebacks", "wrong status"
MESSAGE, FILES, WRONG = "bad messages", "files", "wrong rows"
LINE_MAX = 6000  # characters: a path may be thousands
Told = tuple[str, str]  # one of the above, and what to say about it


def contents(folder: Path) -> dict[str, tuple[int, int]]:
    """Every file below the folder, with what would tell a change."""
    found = {}
    for path in sorted(folder.rglob("*")):
        data = path.read_bytes() if path.is_file() else b""
        found[str(path.relative_to(folder))] = len(data), zlib.crc32(data)
    return found


def tried(error: BaseException) -> Told:
    """A refusal, if it is one; anything else should not have come up."""
    from sweep.errors import InputError

    if isinstance(error, InputError):
        return REFUSED, ""
    return TRACEBACK, "".join(traceback.format_exception(error)[-3:])


def judged(argv: list[str], folder: Path, statuses: set[int], writes: bool = False) -> Told:
    """Run the command in `folder`; refused or accepted, or the rule that was broken.

    `writes`: a command that succeeds may change files; one that is refused never does.
    """
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", errors=how) for how in ("strict", "backslashreplace"))
    before = contents(folder)
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = cli.main(argv)
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else -1
    except BaseException as error:
        return TRACEBACK, f"{argv}\n" + "".join(traceback.format_exception(error)[-3:])
    said, complained = _written(out), _written(err)
    told = f"{argv}: exit status {status}, {complained[:600]!r}, {said[:100]!r}"
    if status not in statuses:
        return STATUS, told
    after = contents(folder)
    if any(name.endswith((".partial", ".lock")) for name in after) or (
        after != before and not (writes and status != 2)
    ):
        return FILES, f"{told}; {set(after.items()) ^ set(before.items())}"
    if not _speaks_well(status, said, complained):
        return MESSAGE, told
    return (REFUSED if status == 2 else ACCEPTED), ""


def _written(text: io.TextIOWrapper) -> str:
    text.seek(0)
    return text.read()


def _speaks_well(status: int, out: str, err: str) -> bool:
    """Refusals are lines that begin with the program's name; nothing else ever comes on stderr."""
    lines = err.split("\n")[:-1]
    if lines and lines[0].startswith("usage: "):
        return status == 2 and "sweep" in lines[-1]
    ours = all(line.startswith("sweep: ") and line.isprintable() and len(line) < LINE_MAX for line in lines)
    return ours and (status != 2 or (bool(lines) and out == ""))
