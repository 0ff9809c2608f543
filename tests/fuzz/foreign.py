"""HDF5 files that are no tables, but bear a table's names."""

from pathlib import Path

import h5py
import numpy as np

from sweep.schema import RESULTS, ROW, RUN, RUNS
from sweep.store import table
from sweep.store.structure import STRUCTURE

CREATION = (
    {"shape": (12,)},
    {"shape": ()},
    {"shape": (0,)},
    {"shape": (2, 6)},
    {"shape": (1 << 40,), "chunks": (1 << 10,)},  # of which nothing is stored
    {"shape": (12,), "maxshape": (None,), "chunks": (5,)},
    {"shape": (12,), "chunks": (12,), "compression": "gzip"},
    {"shape": (1 << 20,)},
)
TYPES = (ROW, RUN, "f8", "S5", np.dtype("<u4"), h5py.string_dtype(), h5py.ref_dtype, h5py.vlen_dtype("i4"))


def make(rng: np.random.Generator, path: Path) -> None:
    """A file in which each of our names may be anything; most often two are as they should be."""
    libver = str(rng.choice(["earliest", "latest"]))
    with h5py.File(path, "w", libver=libver, userblock_size=int(rng.choice([0, 512]))) as file:
        right = {RESULTS: ROW, RUNS: RUN, STRUCTURE: np.dtype("<u4")}
        for name, dtype in right.items():
            if rng.random() < 0.9:
                _item(rng, file, name, dtype)
        if rng.random() < 0.9:
            _format(rng, file)
        if rng.random() < 0.9:
            _provenance(rng, file)


def _item(rng: np.random.Generator, file: h5py.File, name: str, dtype: np.dtype) -> None:
    what = rng.random()
    if what < 0.8:
        chosen = dtype if rng.random() < 0.8 else TYPES[int(rng.integers(len(TYPES)))]
        file.create_dataset(name, dtype=chosen, **CREATION[int(rng.integers(len(CREATION)))])
    elif what < 0.84:
        file[name] = h5py.SoftLink(f"/{name}")
    elif what < 0.88:
        file[name] = h5py.ExternalLink("/dev/null" if rng.random() < 0.5 else "sound.h5", f"/{name}")
    elif what < 0.92:
        file.create_group(name)
    elif what < 0.96:
        file[name] = np.dtype(dtype)
    else:
        file.create_dataset(name, dtype=dtype, data=h5py.Empty(dtype))


def _format(rng: np.random.Generator, file: h5py.File) -> None:
    values = (np.bytes_(table.FORMAT),) * 4 + (table.FORMAT, 2, np.zeros(3), h5py.Empty("S5"), [table.FORMAT.encode()])
    file.attrs["format"] = values[int(rng.integers(len(values)))]


def _provenance(rng: np.random.Generator, file: h5py.File) -> None:
    if rng.random() < 0.2:
        file[table.PROVENANCE] = 3
        return
    group = file.create_group(table.PROVENANCE)
    for name in ("spec", "resolved", "kernel", "versions"):
        values = (np.bytes_(b"{}"), "{}", 5, np.zeros(4), np.bytes_(b"\xff"), h5py.Empty("f8"))
        group[name] = values[int(rng.integers(len(values)))]
    if rng.random() < 0.2:
        group["again"] = group
    if rng.random() < 0.1:
        group["gone"] = h5py.SoftLink("/nowhere")
