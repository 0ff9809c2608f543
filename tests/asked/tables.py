"""Small random specs, and what may have become of their tables."""

import os
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd

from sweep import cli
from tests.asked.told import Told, must, tell
from tests.histories.specs import Asked

INPUTS = ("N", "zeta_T", "M_over_M0", "V_over_V0")
VALUES = {
    "N": [5, 6, 8, 11, 15, 20, 28, 40, 60],
    "zeta_T": [0.0, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 0.1],
    "M_over_M0": [0.1, 0.3, 0.5, 1.0, 2.0],
    "V_over_V0": [0.1, 0.3, 1.0, 2.0, 3.16, 5.0, 10.0],
}
ENDS = {"N": (5, 60), "zeta_T": (1e-4, 1e-1), "M_over_M0": (0.2, 2.0), "V_over_V0": (0.3, 10.0)}
ACCURACIES: tuple[dict[str, object], ...] = (
    {"target": 1e-2},
    {"target": 1e-3},
    {"target": 1e-3},
    {"target": 1e-3, "certify": False},
    {"method": "rk45", "rtol": 1e-4, "atol": 1e-7},
    {"target": 1e-2, "max_steps": 600},  # many rows fail
    {"target": 1e-2, "max_steps": 60},  # nearly all do
    {"target": 1e-8},  # some do not converge
)
BISTABLE = 'spring = { law = "bistable", c3 = 6.0 }\nsite = 0.4\n'
# A section [model], with an axis of it: as a grid and as [points] have it.
MODELS: tuple[tuple[str, dict[str, str], dict[str, str]], ...] = (
    *[("", {}, {})] * 6,
    (BISTABLE, {"spring.c2": "[4.5, 5.0]"}, {"spring.c2": "{ linear = [4.5, 5.0] }"}),
    (BISTABLE, {"spring.c2": "[4.5]"}, {"spring.c2": "4.5"}),
    ("mass = { spread = 0.2 }\n", {"mass.seed": "[0, 1]"}, {"mass.seed": "1"}),  # integrated by rk45 alone
)
QUANTITIES = ("ke", "wall_force", "flipped")  # of a flipped link there is no ratio
TASKS_MAX = 400
KINDS = ("grid", "grid", "grid", "points", "lowest", "level", "map", "adaptive")
FATES = ("whole", "whole", "whole", "stopped", "resumed", "shard", "merged", "torn")


@dataclass(frozen=True)
class Table:
    """A table, and what is known of it without this program's readers."""

    path: Path
    asked: Asked
    rows: pd.DataFrame  # of /results, with the status "torn" where a checksum fails
    fate: str = "whole"
    search: dict[str, Any] = field(default_factory=dict)
    screened: int = 0

    @property
    def is_csv(self) -> bool:
        """Whether it is an exported one, which tells no spec."""
        return self.path.suffix == ".csv"

    @property
    def inputs(self) -> list[str]:
        """The columns that say which task a row is."""
        return [*INPUTS, *(name for name in self.rows if "." in name)]

    @property
    def done(self) -> pd.DataFrame:
        """The rows that count."""
        return self.rows[self.rows["status"] == "done"]


def read(path: Path) -> pd.DataFrame:
    """The rows of a table's file."""
    with h5py.File(path, "r", locking=False) as file:
        rows = file["results"][()]
    frame = pd.DataFrame({name: rows[name] for name in rows.dtype.names})
    for name in ("method", "status"):
        frame[name] = [value.decode() for value in rows[name]]
    raw, size = rows.tobytes(), rows.dtype.itemsize
    sealed = [zlib.crc32(raw[k * size : (k + 1) * size - 4]) == rows["checksum"][k] for k in range(len(rows))]
    frame.loc[~np.array(sealed) & ~frame["status"].isin(["pending", "unasked"]), "status"] = "torn"
    frame["chaotic"] &= frame["checked"] & ~frame["status"].isin(["pending", "unasked", "torn"])
    return frame.rename_axis("task")


def drawn(rng: np.random.Generator, folder: Path) -> Table:
    """A random table in this folder."""
    asked, search = _spec(rng)
    fate = str(rng.choice(FATES))
    alone = asked.points.get("n") == "1" or all("[" not in each for each in asked.axes.values())
    if (asked.is_search and fate in ("shard", "merged", "torn")) or (alone and fate in ("shard", "merged")):
        fate = "whole"
    (folder / "s.toml").write_text(asked.text)
    path = folder / "t.h5"
    told = _made(rng, folder, fate)
    for each in told:
        must(each.status in (0, 1, 75) and "Traceback" not in each.err, f"{each.line}: {each}")
    if fate == "torn":
        _tear(rng, path)
    with h5py.File(path, "r", locking=False) as file:
        seen = file["screened"][()] if "screened" in file else np.empty(0, [("checksum", "u4")])
    screened = int(np.count_nonzero(seen["checksum"][: len(seen) // 2]))
    return Table(path, asked, read(path), fate, search, screened)


def _made(rng: np.random.Generator, folder: Path, fate: str) -> list[Told]:
    def run(*more: str, table: str = "t.h5", stop: int | None = None) -> Told:
        return tell(lambda: _run(["run", "s.toml", "-o", table, *more], stop), folder, f"sweep run {table} {more}")

    if fate in ("stopped", "resumed"):
        told = [run(stop=int(rng.choice([0, 1, 5, 20, 60])))]
        return told if fate == "stopped" else [*told, run()]
    if fate == "shard":
        return [run("--shard", f"{rng.integers(1, 3)}/2")]
    if fate == "merged":
        parts = [run("--shard", f"{k}/2", table=f"{k}.h5") for k in (1, 2)]
        return [*parts, tell(lambda: cli.main(["merge", "1.h5", "2.h5", "-o", "t.h5"]), folder, "sweep merge")]
    return [run()]


def _run(arguments: list[str], stop: int | None) -> int:
    """In a process of its own: a run that hands out nothing more once so many rows have ended."""
    from sweep.plan import batches
    from sweep.serve.stops import Stops

    if stop is not None:
        batches.BATCH_MAX = 3
        Stops.fits = lambda _, count: 0.0 if count.done + count.failed >= stop else np.inf  # type: ignore[method-assign]
    return cli.main(arguments)


def _tear(rng: np.random.Generator, path: Path) -> None:
    """One bit of some rows flips."""
    with h5py.File(path, "r", locking=False) as file:
        data = file["results"]
        start, size, rows = data.id.get_offset(), data.dtype.itemsize, len(data)
        offset = data.dtype.fields["ke_ratio"][1]
    assert start is not None
    with path.open("r+b") as raw:
        for row in rng.choice(rows, size=min(rows, 3), replace=False):
            raw.seek(start + int(row) * size + offset)
            byte = raw.read(1)[0]
            raw.seek(-1, os.SEEK_CUR)
            raw.write(bytes([byte ^ 1]))


def _spec(rng: np.random.Generator) -> tuple[Asked, dict[str, Any]]:
    kind, (model, axis, span) = str(rng.choice(KINDS)), MODELS[int(rng.integers(len(MODELS)))]
    accuracy, observed = ACCURACIES[int(rng.integers(len(ACCURACIES)))], rng.random() < 0.3
    search = _search(rng, kind)
    if search and observed and rng.random() < 0.5:
        search["of"] = "wall_force_ratio"
    if kind == "lowest":
        accuracy = {name: value for name, value in accuracy.items() if name != "certify"}
    points = {"sample": f'"{rng.choice(["sobol", "random"])}"', "n": str(rng.choice([1, 3, 30, 100]))}
    points = points if kind == "points" else {}
    axes = {**_ranges(rng), **span} if points else {**_axes(rng, kind, search), **axis}
    observe = str(list(QUANTITIES)).replace("'", '"') if observed else ""
    return Asked(kind, axes, accuracy, _section(kind, search), model, observe, points), search


def _ranges(rng: np.random.Generator) -> dict[str, str]:
    found = {}
    for name, (low, high) in ENDS.items():
        spacing = "log" if rng.random() < 0.6 else "linear"
        found[name] = _one(rng, name) if rng.random() < 0.4 else f"{{ {spacing} = [{low}, {high}] }}"
    if not any("{" in each for each in found.values()):  # else the points would all be one
        found["V_over_V0"] = "{ log = [0.3, 10.0] }"
    return found


def _one(rng: np.random.Generator, name: str) -> str:
    return repr(VALUES[name][int(rng.integers(len(VALUES[name])))])


def _axes(rng: np.random.Generator, kind: str, search: dict[str, Any]) -> dict[str, str]:
    """One value, some in a list of any order, or a range."""
    along = [*search.get("over", []), search.get("along", "N" if kind == "adaptive" else "")]
    found, tasks = dict[str, str](), 1
    for name in [str(each) for each in rng.permutation(INPUTS)]:
        least = 3 if name in along else 1
        count = max(least, int(rng.choice([1, 1, 2, 3, 5, 9])))
        count = max(least, min(count, TASKS_MAX // tasks, len(VALUES[name])))
        tasks *= count
        some = rng.choice(len(VALUES[name]), count, replace=False)
        some = np.sort(some) if name in along or rng.random() < 0.6 else some
        low, high = ENDS[name]
        if count == 1:
            found[name] = _one(rng, name)
        elif rng.random() < 0.4:
            spacing = "log" if rng.random() < 0.5 else "linear"
            found[name] = f"{{ {spacing} = [{low}, {high}], points = {count} }}"
        else:
            found[name] = repr([VALUES[name][int(k)] for k in some])
    return {name: found[name] for name in INPUTS}


def _search(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """The section [search], as a dict."""
    along = str(rng.choice(INPUTS))
    if kind == "level":
        level, which = float(rng.choice([0.3, 1.0])), str(rng.choice(["first", "last"]))
        return {"find": "level", "along": along, "level": level, "until": 0.1, "crossing": which}
    over = [str(each) for each in rng.choice(INPUTS, 2, replace=False)]
    if kind == "map":
        return {"find": "map", "over": over, "error": 0.1, "screen": bool(rng.random() < 0.5)}
    if kind == "lowest":
        robust = {"robust": 0.02, "by": str(rng.choice(["worst", "median"]))} if rng.random() < 0.4 else {}
        over = ["M_over_M0", "V_over_V0"][int(rng.integers(2)) :] if robust else over
        return {"find": "lowest", "over": over, **robust}
    return {}


def _section(kind: str, search: dict[str, Any]) -> str:
    if kind == "adaptive":
        return "[adaptive]\nuntil = 0.1\n"
    text = "".join(f"{key} = {_toml(value)}\n" for key, value in search.items())
    return f"[search]\n{text}" if search else ""


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value).replace("'", '"')


def exported(path: Path) -> pd.DataFrame:
    """The rows of a .csv, .parquet or .nc as other programs read them, what is not known as nan or None."""
    if path.suffix == ".csv":
        return pd.read_csv(path, float_precision="round_trip", keep_default_na=False, na_values=["nan", ""])
    if path.suffix == ".parquet":
        return pd.read_parquet(path, dtype_backend="numpy_nullable")
    import xarray

    with xarray.open_dataset(path, engine="h5netcdf") as data:
        frame = data.load().to_dataframe().reset_index()
    return frame.sort_values("task").reset_index(drop=True)
