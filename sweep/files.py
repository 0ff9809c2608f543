"""Of a file that is no table: what it is instead. Of one to be written: which names it may not have, and how."""

import codecs
import errno
import os
import re
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

HDF5 = "an HDF5 file"
SPEC = "a spec (TOML)"
BEGINNINGS = {
    b"\x89HDF\r\n\x1a\n": HDF5,
    b"\x89PNG": "a PNG picture",
    b"%PDF": "a PDF file",
    b"PAR1": "a Parquet file",
    b"PK\x03\x04": "a zip archive",
    b"\x1f\x8b": "a gzip file",
    b"\x93NUMPY": "a numpy file",
    b"SQLite format 3": "an SQLite file",
}
MARK = "bistable-sweep analysis"  # in every picture and page that we wrote, by which it is known as ours
HEAD_BYTES = 1 << 16  # of a file, from which its kind is guessed
# Names that end so belong to files of other kinds.
OTHER_ENDINGS = (
    *(".csv", ".tsv", ".parquet", ".nc", ".json", ".txt", ".xlsx", ".npy", ".npz", ".pkl", ".zip", ".gz"),
    *(".png", ".pdf", ".svg", ".jpg", ".jpeg", ".html"),
    *(".toml", ".sbatch", ".pbs", ".lsf", ".sh", ".py", ".log", ".md"),
)


def kind_of(path: Path) -> str | None:
    """What a file is by its beginning (`kind_of_data`). Raises OSError where it cannot be read."""
    with path.open("rb") as file:
        return kind_of_data(file.read(HEAD_BYTES))


def kind_of_data(data: bytes) -> str | None:
    """ "a CSV file" for example; None where the beginning shows nothing, as that of a damaged file."""
    head = data[:HEAD_BYTES]
    if not head:
        return "an empty file"
    known = next((kind for beginning, kind in BEGINNINGS.items() if head.startswith(beginning)), None)
    return known or _kind_of_text(head)


def _kind_of_text(head: bytes) -> str | None:
    try:
        text = codecs.getincrementaldecoder("utf-8-sig")().decode(head)  # its end may be half a letter
    except UnicodeDecodeError:
        return None
    if not all(c.isprintable() or c.isspace() for c in text):
        return None
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    first = lines[0] if lines else ""
    if any(re.match(r"\[(grid|points)\]", line) for line in lines):
        return SPEC
    if first.startswith(("<?xml", "<svg", "<!DOCTYPE", "<html")):
        return "an SVG, XML or HTML file"
    even = len(lines) < 3 or lines[1].count(",") == first.count(",")  # a last line may be cut off
    return "a CSV file" if "," in first and even and not first.startswith(("[", "{")) else "a text file"


def no_file(path: Path) -> str:
    """What is there that is no file: of a pipe whoever opens it may wait for ever; else empty. May raise OSError."""
    if path.is_file() or not path.exists():
        return ""
    return "directory" if path.is_dir() else "device or pipe"


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A new file that takes the place of `path` when the block ends well, and vanishes when it does not."""
    # Of this block alone: another one may be writing the same file. Not tempfile, whose files are for their owner only.
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        yield partial
        partial.replace(path)
    finally:
        with suppress(OSError):  # where nothing can be written nothing can be removed
            partial.unlink(missing_ok=True)


def as_text(path: Path) -> str:
    """A path in a text that says where something comes from: what is not UTF-8 in a name is escaped."""
    return os.fsencode(path).decode(errors="backslashreplace")


def wrong_ending(path: Path) -> str:
    """A message where a table's name ends as those of another format do; else empty."""
    if path.suffix.lower() not in OTHER_ENDINGS:
        return ""
    return (
        f"{path}: a table is an HDF5 file, its name may not end with {path.suffix} as those of other formats do; "
        f"give {path.with_suffix('.h5')}"
    )


def folder_problem(path: Path) -> str:
    """A message where the folder of a file is not there, or nothing can be written in it; else empty."""
    try:
        if not path.parent.is_dir():
            return f"there is no directory {str(path.parent)!r} to write {path.name!r} in"
        path.exists()
    except OSError as error:  # of a name that is too long
        return f"{str(path)!r} cannot be written: {error.strerror}"
    if os.access(path.parent, os.W_OK | os.X_OK):
        return ""
    why = f": {os.strerror(errno.EROFS)}" if os.statvfs(path.parent).f_flag & os.ST_RDONLY else ""
    return f"the directory {str(path.parent)!r} is not writable{why}"


def page_problem(
    path: Path, force: bool = False, pictures: Path | None = None, remedy: str = "--force replaces it"
) -> str:
    """A message where no page can be written to `path`, or (unless `force`) only over what is none of ours.

    `pictures` is the folder that its pictures go to, if it has any: a file of that name is in the way. remedy: what to
    do about a file that is none of ours.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        return f"{path}: a page ends in .html"
    if problem := folder_problem(path):
        return problem
    if pictures is not None and (path.is_dir() or (pictures.exists() and not pictures.is_dir())):
        return f"{path} or the folder {pictures} for its pictures is in the way"
    if kind := no_file(path):
        return f"{path} is a {kind}, it cannot be written"
    if force or not path.exists():
        return ""
    with path.open("rb") as file:
        ours = MARK.encode() in file.read(HEAD_BYTES)
    return "" if ours else f"{path} is not as this program left it; {remedy}"
