"""Whether the structure of a table is intact, by a checksum over everything in the file that no run changes.

A damaged address would send finished rows to the wrong place; a damaged text would describe another sweep.
"""

import os
import zlib
from pathlib import Path

import h5py
import numpy as np

from sweep.schema import LAYOUTS, RESULTS, RUNS, SCREENED

PROVENANCE = "provenance"  # the group of texts that tell where a table comes from
STRUCTURE = "structure"  # the dataset that holds the checksum; one whole number

CHANGING = (RESULTS, RUNS, SCREENED)  # the datasets that runs write
# Offset and size in bytes, in the superblock (version 0), of the flags of a file open for writing; nobody reads them.
CONSISTENCY_FLAGS = (20, 4)


def seal_structure(path: Path) -> None:
    """Write the checksum of a file that has just been created, with all its datasets allocated; nobody else has it."""
    with h5py.File(path, "r", locking=False) as file:
        checksum = _checksum(file)
    with h5py.File(path, "r+", locking=False) as file:
        file[STRUCTURE][...] = checksum


def structure_is_whole(file: h5py.File) -> bool:
    """Whether nothing but rows and the list of runs has changed since the creation."""
    stored, found = file[STRUCTURE][0], _checksum(file)
    return found is not None and bool(stored == found)


def _checksum(file: h5py.File) -> np.uint32 | None:
    """The checksum of the file as it is; None where its datasets do not lie one after the other."""
    crc, position = 0, 0
    raw = file.id.get_vfd_handle()  # that HDF5 has open: under the name another table may be by now
    end = os.fstat(raw).st_size
    changing = [CONSISTENCY_FLAGS, *(place(file[name]) for name in (*CHANGING, STRUCTURE) if name in file)]
    for offset, size in (*sorted(changing), (end, 0)):
        if not position <= offset <= offset + size <= end:
            return None
        crc = zlib.crc32(os.pread(raw, offset - position, position), crc)
        position = offset + size
    return np.uint32(crc)


def has_our_name(file: h5py.File) -> bool:
    """Whether it says that it is a table of a version whose rows can be read."""
    return str(file.attrs.get("format")) in {str(np.bytes_(name)) for name in LAYOUTS}


def lost(file: h5py.File) -> str:
    """What a file that says that it is our table has lost, as one that was cut off while a run wrote it; or nothing."""
    kinds = {PROVENANCE: h5py.Group} | dict.fromkeys((RESULTS, RUNS, STRUCTURE), h5py.Dataset)
    kinds |= {SCREENED: h5py.Dataset} if SCREENED in file else {}
    missing = (name for name, kind in kinds.items() if not isinstance(file.get(name), kind))
    return next(missing, "") if has_our_name(file) else ""


def place(dataset: h5py.Dataset) -> tuple[int, int]:
    """Offset and length of its data in the file, bytes; it is contiguous."""
    return int(dataset.id.get_offset() or 0), int(dataset.size * dataset.dtype.itemsize)
