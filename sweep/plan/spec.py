"""What the user wrote: a TOML file, validated as a whole, every problem reported at once."""

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from kernel.task import is_number_of_model
from sweep.errors import InputError
from sweep.files import HDF5, kind_of_data
from sweep.plan.asked import Adaptive, Sought
from sweep.plan.model import (
    check_axes,
    combinations,
    is_papers,
    model_of,
    occurring,
    settings_of,
    sound_values,
    split_axes,
    values_of,
)
from sweep.plan.own import sha256
from sweep.plan.points import Points, read_points
from sweep.plan.problems import SpecError, cut, line_of, meant, problem_lines
from sweep.plan.search import Extent, Search
from sweep.plan.section import Reading, Section
from sweep.plan.sections import Accuracy, Grid, Output
from sweep.plan.tasks import Listed, Tasks, inputs, keys_of
from sweep.schema import layout_of

TASKS_MAX = 1_000_000_000  # of a table of 160 GB: a typing error, rather than a wish
NAME_MAX = 80  # characters of a sweep's name
OF_A_TABLE = "; of a table, `sweep export TABLE -o FOLDER --crate` writes its spec, to FOLDER/spec.toml"
NO_NUMBERS = ("name", "output.flush_every")  # keys that change no row


def _possible_model(given: dict[str, Any]) -> dict[str, Any]:
    """A section [model] as it is, which a model can be made of: judged beside the other sections, not after them."""
    model_of(given)
    return given


SECTIONS: dict[str, type[Section]] = {
    **{"grid": Grid, "search": Sought, "adaptive": Adaptive},
    **{"accuracy": Accuracy, "output": Output},
}


class Spec(Section):
    """One sweep."""

    name: Annotated[str, Field(min_length=1, max_length=NAME_MAX)]  # of the sweep, told with its table
    grid: Grid | None = None  # it, or
    points: dict[str, Any] | None = None  # of sweep.plan.points: where they come from
    axes: Annotated[dict[str, Any], BeforeValidator(values_of)] = Field(
        default_factory=dict
    )  # numbers of the model that the grid varies
    model: Annotated[dict[str, Any], AfterValidator(_possible_model)] | None = None  # None: the paper's
    search: Sought | None = None
    adaptive: Adaptive | None = None
    accuracy: Accuracy = Accuracy()
    output: Output = Output()

    _points: Points | None = PrivateAttr(None)
    _model: Any = PrivateAttr(None)

    @model_validator(mode="after")
    def _goes_together(self, info: ValidationInfo) -> "Spec":
        self._points = info.context.points if isinstance(info.context, Reading) else None
        model, problems = self._chain()
        there = self.grid is not None or self._points is not None
        if problems := [*problems, *self._wrong_search()] or self._too_large(self.tasks if there else 0):
            raise SpecError(problems)
        varied = self.varied()
        self._model = None if model is None or (not varied and is_papers(model)) else model
        settings = None if self._model is None else settings_of(self._model, varied)
        object.__setattr__(self, "model", settings)  # every number spelled out
        return self

    @classmethod
    def problems_of_sound(cls, document: dict[str, Any], reading: Reading) -> list[str]:
        """What is wrong between the sound keys of a spec that was refused: all that needs none of the others."""
        part = cls.sound_part(document, reading)
        for name, section in SECTIONS.items():
            if isinstance(given := document.get(name), Mapping):
                object.__setattr__(part, name, section.sound_part(given, reading))
        if "axes" in part._unsound:
            object.__setattr__(part, "axes", sound_values(document["axes"])[0])
        part._points = reading.points
        axes = part._all_axes()
        tasks = math.prod(map(len, axes.values())) if len(axes) == len(part._names()) else 0
        return [*part.accuracy.problems(), *part._chain()[1], *part._wrong_search(), *part._too_large(tasks)]

    def _chain(self) -> tuple[Any, list[str]]:
        """The model, None where nothing is said of it; and what is wrong with it, as far as its axes are known."""
        given, varied = self.model or {}, self.varied()
        if "model" in self._unsound or not (given or varied) or (self._points is None and not self._names()):
            return None, []  # what is missing is said elsewhere
        if self._points is None:
            together = () if "axes" in self._unsound else combinations(self.axes)
            where, N = "grid", self._all_axes().get("N", ())
        else:
            together = occurring(self._points, self.points or {}, varied)
            where, N = "points", self._points["N"].tolist()
        try:
            return check_axes(given, varied, together, where, N), []
        except SpecError as error:
            return None, [*error.lines]

    def _wrong_search(self) -> list[str]:
        problems = list[str]()
        if self.search is not None and self.adaptive is not None:
            problems.append("adaptive: must not stand beside a section [search], which can do the same")
        if self.asked:
            certified = self.accuracy.certify
            problems += self.asked.problems(self._names(), self._all_axes(), self.layout(), certified)
        return problems

    @staticmethod
    def _too_large(tasks: int) -> list[str]:
        return [f"grid has {tasks} tasks, at most {TASKS_MAX} fit one table"] if tasks > TASKS_MAX else []

    @property
    def tasks(self) -> int:
        """How many rows the table has: one for each task that is or may be computed."""
        tasks = self.task_list()
        return len(tasks) if isinstance(tasks, Listed) else math.prod(map(len, tasks.axes.values()))

    @property
    def asked(self) -> Adaptive | Sought | None:
        """What the sweep is to find, where it is not to compute the whole grid."""
        return self.search if self.search is not None else self.adaptive

    def _all_axes(self) -> dict[str, Sequence[Any]]:
        axes = (self.grid.model_dump() if self.grid else {}) | self.axes
        return {name: values for name, values in axes.items() if values is not None}

    def _names(self) -> tuple[str, ...]:
        """Of all axes of the grid, sound or not."""
        grid = self.grid is not None or "grid" in self._unsound
        return (*Grid.model_fields, *self._unsound.get("axes", self.axes)) if grid else ()

    def varied(self) -> tuple[str, ...]:
        """The numbers of the model that differ from task to task."""
        return tuple(name for name in (self._points or self._names()) if is_number_of_model(name))

    def layout(self) -> "np.dtype[Any]":
        """Of the table's rows."""
        return layout_of(self.output.quantities(), self.varied())

    def kernel_model(self) -> Any:
        """The kernel.Model of all tasks, but for the numbers that they vary; None: the paper's."""
        return self._model

    def task_list(self) -> Tasks | Listed:
        """Every task that has a row, numbered as in the table."""
        if self._points is not None:
            return Listed(keys_of(self._points), inputs(self._points))
        return self.asked.every(self._all_axes()) if self.asked else Tasks(self._all_axes())

    def extent(self) -> Extent:
        """How much is computed."""
        return self.asked.extent(self._all_axes()) if self.asked else Extent(self.tasks, self.tasks)

    def new_search(self) -> Search | None:
        """The search that steers the sweep, with nothing learnt; None where all tasks are computed."""
        return self.asked.search(self._all_axes()) if self.asked else None

    def sampler(self, folder: Path) -> Path | None:
        """The file that steers its search, if it is the user's own; `folder`: where the spec lies."""
        return folder / self.search.file if self.search is not None and self.search.file is not None else None

    def resolved(self) -> str:
        """The spec with every default and every axis value spelled out, as JSON; exact, so it can be compared."""
        return json.dumps(self._given(), indent=1)

    def _given(self) -> dict[str, Any]:
        given = {name: part for name, part in self.model_dump(mode="json").items() if part is not None}
        axes = given.pop("axes")
        if axes:
            given["grid"] |= axes
        return given

    def identity_texts(self) -> list[str]:
        """The parts of `resolved` that say what a row is: how good, of which quantities, of which chain.

        `sweep run --repair` looks for them in a damaged table: without them its rows may be another sweep's.
        """
        texts = [json.dumps({"accuracy": self.accuracy.model_dump(mode="json")}, indent=1)[2:-2]]
        if self.output.quantities():
            text = json.dumps({"output": {"observe": self.output.observe}}, indent=1)
            texts.append(text[text.index('"observe"') : text.index("]") + 1])
        return texts if self.model is None else [*texts, json.dumps({"model": self.model}, indent=1)[2:-2]]

    def differences(self, resolved: dict[str, Any]) -> list[str]:
        """The keys in which a table's resolved spec asks for other numbers than this one."""
        return [*differing(self._given(), resolved)]


def differing(one: dict[str, Any], other: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    """What two resolved specs have where they ask for other numbers (`NO_NUMBERS` do not), by key."""
    ours, theirs = _flat(one), _flat(other)
    both = {key: (ours.get(key), theirs.get(key)) for key in sorted({*ours, *theirs}.difference(NO_NUMBERS))}
    return {key: (a, b) for key, (a, b) in both.items() if a != b}


def _flat(spec: dict[str, Any]) -> dict[str, Any]:
    """{"grid": {"N": x}} as {"grid.N": x}."""
    sections = {key: value for key, value in spec.items() if isinstance(value, dict)}
    plain = {key: value for key, value in spec.items() if key not in sections}
    return plain | {f"{name}.{key}": value for name, section in sections.items() for key, value in section.items()}


def read_axes(grid: Any) -> dict[str, Sequence[Any]]:
    """All axes of a table's resolved grid; ValueError where it is none."""
    if not isinstance(grid, Mapping):
        raise ValueError("is no grid")
    plain, axes = split_axes(grid)
    return Grid.model_validate(plain).model_dump() | values_of(axes)


def read_spec(path: Path) -> tuple[Spec, str]:
    """The validated spec and its text as given; InputError naming every problem. A pipe can be read only once."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        kind = kind_of_data(error.object)
        hint = OF_A_TABLE if kind == HDF5 else ""
        raise InputError(f"{path}: is {f'{kind}, not a spec{hint}' if kind else 'not a text file in UTF-8'}") from None
    return parse_spec(text, str(path), path.parent), text


def parse_spec(text: str, source: str, folder: Path = Path()) -> Spec:
    """The validated spec; `source` names the text in messages, `folder` is where files lie that it names."""
    try:
        document = tomllib.loads(text)
        _check_whole_numbers(document)
    except ValueError as error:  # TOMLDecodeError is one
        raise InputError(f"{source}: is not TOML: {error}{line_of(str(error), text)}") from None
    except RecursionError:
        raise InputError(f"{source}: is nested too deeply") from None
    document, points, problems = _prepared(document, folder)
    reading = Reading(points, {})
    try:
        spec = Spec.model_validate(document, context=reading)
    except ValidationError as error:
        alone = (line for e in error.errors() for line in problem_lines(e, _keys()))
        problems += dict.fromkeys([*alone, *Spec.problems_of_sound(document, reading)])
    if problems:
        raise InputError(*(f"{source}: {cut(line)}" for line in problems))
    return spec


def _prepared(document: dict[str, Any], folder: Path) -> tuple[dict[str, Any], Points | None, list[str]]:
    """The document with the axes of the model beside the grid, its points where it has them, and what is wrong."""
    document, points, problems = dict(document), None, list[str]()
    if "axes" in document:
        problems.append(f"axes: is not a known key{meant(['axes'], _keys())}, got {document.pop('axes')!r}")
    if "points" in document:
        try:
            points, document["points"] = read_points(document["points"], folder)
        except SpecError as error:
            problems += error.lines
            del document["points"]
        if "grid" in document:
            problems.append("points: must not stand beside a section [grid]")
    elif "grid" not in document:
        problems.append("grid: is missing")
    if isinstance(document.get("grid"), dict):
        document["grid"], document["axes"] = split_axes(document["grid"])
    search = document.get("search")
    if isinstance(search, dict) and search.get("find") == "own" and isinstance(search.get("file"), str):
        try:
            found = sha256(folder / search["file"])
            document["search"] = search | {"sha256": found}
            if search.get("sha256", found) != found:
                problems.append(f"search.sha256: must be that of {search['file']}, {found}, got {search['sha256']!r}")
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            problems.append(f"search.file: {search['file']} cannot be read: {why}")
    return document, points, problems


def _keys() -> dict[str, list[str]]:
    """Of every section; those at the top under ""."""
    return {"": [name for name in Spec.model_fields if name != "axes"]} | {
        name: list(section.model_fields) for name, section in SECTIONS.items()
    }


def _check_whole_numbers(value: Any, key: str = "") -> None:
    """TOML's own rule, which tomllib leaves to its users."""
    if isinstance(value, dict):
        for name, item in value.items():
            _check_whole_numbers(item, f"{key}.{name}".lstrip("."))
    elif isinstance(value, list):
        for item in value:
            _check_whole_numbers(item, key)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError(f"{key}: a whole number must fit 64 bits, got {hex(value)[:20]}...")
