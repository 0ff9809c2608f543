"""Write a picture and its numbers, each whole or not at all, and never over a file that this program did not write.

The numbers of quick.png, drawn by `best`, go to quick.best.csv: no other command writes a file of that name. The
picture's metadata hold a mark and the checksum of its numbers, by which both are known as ours when the command runs
again. quick.svg serves to know quick.best.csv too. A picture that replaces another keeps the checksums of the other
commands' numbers. A file that is not ours, or numbers that were edited since, are replaced only with --force; so are
numbers whose picture is gone, since they may have been edited.
"""

import hashlib
import re
from dataclasses import dataclass
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from analysis.look import MARK, PLAIN, Look, save
from sweep.errors import InputError
from sweep.files import folder_problem, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".pdf", ".svg")
_MARK_PATTERN = re.compile(rb"%b, numbers ([0-9a-f]{64}(?: [0-9a-f]{64})*)" % MARK.encode())
_END_BYTES = 1 << 20  # bytes at either end of a picture in which its metadata are looked for


@dataclass(frozen=True)
class Output:
    """A picture and, beside it under the same stem and the command's name, the CSV of what it shows."""

    picture: Path
    csv: Path


def output(picture: str | Path, command: str, table: str | Path | None = None, force: bool = False) -> Output:
    """Check the output before anything is computed; InputError says what is wrong with it.

    Without `force` it is wrong to replace files that we did not write, or that were changed since.
    """
    path = Path(picture)
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: a picture ends in {', '.join(FORMATS)}")
    if problem := folder_problem(path):
        raise InputError(f"-o: {problem}")
    out = Output(path, path.with_name(f"{path.stem}.{command}.csv"))
    for target in (out.picture, out.csv):
        if target.is_dir():
            raise InputError(f"{target} is a directory, it cannot be written")
        if table is not None and target.exists() and Path(table).exists() and target.samefile(table):
            raise InputError(f"{target} is the table itself and would be overwritten")
    foreign = [str(target) for target in _foreign(out)]
    if foreign and not force:
        are = "is not" if len(foreign) == 1 else "are not"
        raise InputError(f"{' and '.join(foreign)} {are} as this program left it; --force replaces it")
    return out


def write(out: Output, figure: "Figure", numbers: pd.DataFrame, look: Look = PLAIN) -> None:
    """Write both files, each whole or not at all; what fails before the first is in place leaves both as they were."""
    try:
        with replacing(out.csv) as csv, replacing(out.picture) as picture:
            named = numbers.index.name is not None  # as `task`; mere line numbers are left out
            numbers.to_csv(csv, index=named)  # floats in shortest form that reads back exactly
            mark = f"{MARK}, numbers {' '.join([_checksum(csv), *_carried_over(out)])}"
            save(figure, picture, out.picture.suffix[1:].lower(), look.dpi, mark)
    except OSError as error:
        raise InputError(f"cannot write {out.picture} and {out.csv.name}: {error.strerror or error}") from None


def _foreign(out: Output) -> list[Path]:
    """Those of the two files that exist and are not as we left them."""
    foreign = [out.picture] if out.picture.exists() and not _marks(out.picture) else []
    known = set().union(*(_marks(out.picture.with_suffix(suffix)) for suffix in (out.picture.suffix, *FORMATS)))
    if out.csv.exists() and _checksum(out.csv) not in known:
        foreign.append(out.csv)
    return foreign


def _carried_over(out: Output) -> list[str]:
    """Checksums of other commands' unchanged numbers, from the picture that is about to be replaced."""
    known = _marks(out.picture)
    others = out.picture.parent.glob(f"{escape(out.picture.stem)}.*.csv") if known else []
    return sorted({_checksum(csv) for csv in others if csv != out.csv and csv.is_file()} & known)


def _marks(picture: Path) -> set[str]:
    """The checksums of numbers that a picture of ours holds; empty of any other file, or where there is none."""
    if not picture.is_file():
        return set()
    with picture.open("rb") as file:
        start = file.read(_END_BYTES)
        file.seek(max(picture.stat().st_size - _END_BYTES, 0))
        found = _MARK_PATTERN.search(start) or _MARK_PATTERN.search(file.read())
    return set(found[1].decode().split()) if found else set()


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
