"""Where a picture and its numbers go, and how they get there whole."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from analysis.draw import save
from analysis.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".pdf", ".svg")


@dataclass(frozen=True)
class Output:
    """A picture and, beside it under the same stem, the CSV of what it shows."""

    picture: Path
    csv: Path


def output(picture: str | Path, table: str | Path | None = None) -> Output:
    """Check the output before anything is computed; InputError says what is wrong with it."""
    path = Path(picture)
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: a picture ends in {', '.join(FORMATS)}")
    if not path.parent.is_dir():
        raise InputError(f"there is no directory {path.parent} to write {path.name} in")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(f"the directory {path.parent} is not writable")
    out = Output(path, path.with_suffix(".csv"))
    for target in (out.picture, out.csv):
        if target.is_dir():
            raise InputError(f"{target} is a directory, it cannot be written")
        if table is not None and target.exists() and Path(table).exists() and target.samefile(table):
            raise InputError(f"{target} is the table itself and would be overwritten")
    return out


def write(out: Output, figure: "Figure", numbers: pd.DataFrame) -> None:
    """Write both files; either both are new and whole, or both are as they were."""
    try:
        with replacing(out.csv) as csv, replacing(out.picture) as picture:
            numbers.to_csv(csv)  # floats in shortest form that reads back exactly
            save(figure, picture, out.picture.suffix[1:].lower())
    except OSError as error:
        raise InputError(f"cannot write {out.picture} and {out.csv.name}: {error.strerror}") from None


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file that takes the place of `path` when the block ends well, and vanishes when it does not."""
    # Not tempfile: its files are for their owner only, and a result is for the group too.
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
