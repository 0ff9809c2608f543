"""Tasks that form no grid: a list of a file, or a sample of a box. A spec's section [points]."""

import csv
import hashlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.columns import out_of_box
from kernel.hints import did_you_mean, shown, unknown
from kernel.task import BOX, PARAMETERS, SEED, breaking, is_finite, is_input, is_number_of_model, is_whole
from sweep.errors import some_of
from sweep.files import no_file
from sweep.plan.axis import broken_rules, rounded, takes_whole
from sweep.plan.problems import SpecError
from sweep.plan.tasks import inputs, keys_of

SAMPLES = ("sobol", "latin", "random")
POINTS_MAX = 10_000_000  # all are held in memory
OTHER_SIGNS = (";", "\t", "|", " ")  # that may stand between columns where commas should
RANGE = "must be a number or a range { log = [a, b] } or { linear = [a, b] }"
Points = dict[str, NDArray[Any]]


def read_points(section: Mapping[str, Any], folder: Path) -> tuple[Points, dict[str, Any]]:
    """The inputs of all points, and what a table says of where they come from; SpecError naming all that is wrong."""
    if not isinstance(section, Mapping):
        raise SpecError([f"points: must be a section [points], got {shown(section)}"])
    if ("file" in section) == ("sample" in section):
        raise SpecError([f"points: must have either a file or a sample, got {', '.join(section) or 'nothing'}"])
    if "file" not in section:
        points = _sampled(section)
        told: dict[str, Any] = dict(section)
    else:
        problems = [f"points.{key}: is not a known key beside points.file" for key in section if key != "file"]
        try:
            points, told = _from_file(section["file"], folder), {"file": section["file"]}
        except SpecError as error:
            problems += error.lines
        if problems:
            raise SpecError(problems)
    points = {name: points[name] for name in inputs(points)}
    points["N"] = np.rint(points["N"]).astype(np.int64)
    keys = np.unique(keys_of(points))
    return points, told | {"distinct": len(keys), "sha256": hashlib.sha256(keys.tobytes()).hexdigest()[:16]}


def _from_file(name: Any, folder: Path) -> Points:
    if not isinstance(name, str):
        raise SpecError([f"points.file: must be the name of a file, got {shown(name)}"])
    try:
        if kind := no_file(folder / name):  # a pipe would be waited for, and some devices never end
            raise SpecError([f"points.file: {name} is a {kind}, not a file of points"])
        with (folder / name).open(newline="", encoding="utf-8-sig") as text:
            reader = csv.reader(text)
            header = next(reader, [])
            rows = [(reader.line_num, row) for row in reader if row]
    except SpecError:
        raise
    except (OSError, ValueError, csv.Error) as error:  # ValueError: no text, or no name of a file
        raise SpecError([f"points.file: {name} cannot be read: {getattr(error, 'strerror', None) or error}"]) from None
    names = [word.strip() for word in header]
    if len(names) == 1 and (sign := next((sign for sign in OTHER_SIGNS if sign in names[0]), "")):
        raise SpecError([f"points.file: {name} must have commas between columns, got {sign!r} in {shown(names[0])}"])
    problems = _wrong_names("points.file", names)
    if len(set(names)) < len(names):
        problems.append(f"points.file: {name} has a column twice: {', '.join(names)}")
    table, read = np.zeros((len(rows), len(names))), np.ones((len(rows), len(names)), np.bool_)
    for k, (line, row) in enumerate(rows):
        try:
            table[k] = np.array([float(word) for word in row]).reshape(len(names))
        except ValueError:
            rule = f"must hold {len(names)} numbers with commas between them"
            problems.append(f"points.file: {name}, line {line}: {rule}, got {shown(row)}")
            numbers = [_number(word) for word in row] if len(row) == len(names) else [None] * len(names)
            read[k] = [number is not None for number in numbers]
            table[k] = [number or 0.0 for number in numbers]
    if not 1 <= len(rows) <= POINTS_MAX:
        problems.append(f"points.file: {name} must hold 1 to {POINTS_MAX} points, got {len(rows)}")
    for key, column, known in zip(names, table.T, read.T, strict=True):
        where = np.flatnonzero(_breaks_rule(key, column) & known)
        if len(where):
            (rule,) = broken_rules(key, column[where[:1]].tolist())
            more = f" and {len(where) - 1} more" if len(where) > 1 else ""
            problems.append(f"points.{key}: {rule} in {name}, line {rows[where[0]][0]}{more}")
    if problems:
        raise SpecError(some_of(problems, "points.file: and {} more problems"))
    return dict(zip(names, table.T, strict=True))


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _sampled(section: Mapping[str, Any]) -> Points:
    kind, n, seed = section["sample"], section.get("n"), section.get("seed", 0)
    problems = [] if kind in SAMPLES else [unknown("points.sample", kind, SAMPLES)]
    if not (is_whole(n) and 1 <= n <= POINTS_MAX):  # type: ignore[operator]
        problems.append(f"points.n: must be a whole number from 1 to {POINTS_MAX}, got {shown(n)}")
    problems += breaking(SEED, **{"points.seed": seed})
    axes = {key: value for key, value in section.items() if key not in ("sample", "n", "seed")}
    problems += _wrong_names("points", axes)
    for name, value in axes.items():
        if is_input(name):  # of others no rule is known
            problems += [f"points.{name}: {line}" for line in _wrong_range(value) or _wrong_ends(name, value)]
    if problems:
        raise SpecError(problems)
    varied = [name for name, value in axes.items() if isinstance(value, Mapping)]
    unit = _unit(str(kind), int(n or 0), int(seed), len(varied))
    points = {name: np.full(int(n or 0), float(value)) for name, value in axes.items() if name not in varied}
    for k, name in enumerate(varied):
        points[name] = _stretched(name, axes[name], unit[:, k])
    return points


def _unit(kind: str, n: int, seed: int, dimensions: int) -> NDArray[np.float64]:
    """(n, dimensions) numbers from 0 to 1."""
    from scipy.stats import qmc  # only rank 0 asks

    if not dimensions or kind == "random":
        return np.random.default_rng(seed).random((n, dimensions))
    if kind == "latin":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=seed).random(n))
    return np.asarray(qmc.Sobol(dimensions, rng=seed).random_base2(math.ceil(math.log2(n)))[:n])


def _stretched(name: str, value: Mapping[str, Any], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Along the range, to 12 digits as those of a grid: all machines must get the same points."""
    ((spacing, (a, b)),) = value.items()
    if takes_whole(name):  # so that both ends have their share
        a, b = a - 0.5, b + 0.5
    along = a ** (1 - x) * b**x if spacing == "log" else a * (1 - x) + b * x
    found = np.array([rounded(value) for value in along])
    return np.clip(np.rint(found), math.ceil(a), math.floor(b)) if takes_whole(name) else found


def _wrong_names(where: str, names: Any) -> list[str]:
    known = [*PARAMETERS, "spring.c2"]
    strange = [name for name in names if not is_input(name)]
    lines = [f"{where}: {shown(name)} is no input of a task{did_you_mean(str(name), known)}" for name in strange]
    return lines + [f"{where}: lacks {name}" for name in PARAMETERS if name not in names]


def _wrong_range(value: Any) -> list[str]:
    if is_finite(value):
        return []
    if not isinstance(value, Mapping) or len(value) != 1 or not set(value) <= {"log", "linear"}:
        return [f"{RANGE}, got {shown(value)}"]
    ((spacing, ends),) = value.items()
    if not (isinstance(ends, list) and len(ends) == 2 and all(map(is_finite, ends)) and ends[0] < ends[1]):
        return [f"{spacing} must be two ascending finite numbers [a, b], got {shown(ends)}"]
    return [f"log needs both ends above 0, got {shown(ends)}"] if spacing == "log" and ends[0] <= 0 else []


def _wrong_ends(name: str, value: Any) -> list[str]:
    """Which rule of a task's input a number or the ends of a range break: those that it takes of it (`_stretched`)."""
    if not isinstance(value, Mapping):
        return broken_rules(name, [value])
    ((a, b),) = value.values()
    taken = {a: math.ceil(a - 0.5), b: math.floor(b + 0.5)} if takes_whole(name) else {a: a, b: b}
    return broken_rules(name, [end for end, number in taken.items() if broken_rules(name, [number])])


def _breaks_rule(name: str, column: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which values break the rule of this input of a task."""
    if name in BOX:
        return out_of_box(name, column)
    if is_number_of_model(name):  # its own rules come later, of numbers that are some
        return ~np.isfinite(column)
    return np.zeros(len(column), np.bool_)  # no input
