"""What the user wrote: a TOML file, validated as a whole, every problem reported at once."""

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

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

from kernel.hints import did_you_mean
from kernel.method import MAX_STEPS, Integrator, choose
from kernel.task import broken_rule, is_number_of_model
from sweep.errors import InputError
from sweep.files import kind_of_data
from sweep.plan.asked import Adaptive, Sought
from sweep.plan.axis import axis_values
from sweep.plan.model import (
    check_axes,
    combinations,
    is_papers,
    model_of,
    occurring,
    settings_of,
    split_axes,
    values_of,
)
from sweep.plan.own import sha256
from sweep.plan.points import Points, read_points
from sweep.plan.problems import Section, SpecError, cut, meant, problem_lines
from sweep.plan.search import Extent, Search
from sweep.plan.tasks import Listed, Tasks, inputs, keys_of
from sweep.schema import layout_of

TASKS_MAX = 1_000_000_000  # of a table of 160 GB: a typing error, rather than a wish
NAME_MAX = 80  # characters of a sweep's name
NO_NUMBERS = ("name", "output.flush_every")  # keys that change no row
PEAK_KE, KE = "peak_ke", "ke"  # two names of the quantity that every table has


def _keep_rule(name: str, value: object) -> object:
    if broken := broken_rule(name, value):
        raise ValueError(broken.removeprefix(f"{name}: "))
    return value


def _rule(name: str) -> BeforeValidator:
    """The kernel's own rule for a value."""
    return BeforeValidator(partial(_keep_rule, name))


def _axis(name: str) -> BeforeValidator:
    return BeforeValidator(partial(axis_values, name))


class Grid(Section):
    """The four axes; a task is one combination, the last axis varying fastest."""

    N: Annotated[tuple[int, ...], _axis("N")]
    zeta_T: Annotated[tuple[float, ...], _axis("zeta_T")]
    M_over_M0: Annotated[tuple[float, ...], _axis("M_over_M0")]
    V_over_V0: Annotated[tuple[float, ...], _axis("V_over_V0")]


class Accuracy(Section):
    """How good the numbers must be, and by which method."""

    target: Annotated[float, _rule("accuracy")] = 1e-3  # wanted relative error of ke_ratio
    method: Literal["auto", "rk45"] = "auto"  # what suits each task, or Dormand and Prince's method for all
    rtol: Annotated[float, _rule("rtol")] | None = None  # with method = "rk45" only
    atol: Annotated[float, _rule("atol")] | None = None  # the same
    max_steps: Annotated[int, _rule("max_steps")] = MAX_STEPS  # of one run; a task that needs more is a failed row
    # Estimate the error of every row, and see whether it is chaotic: on average twice the time at a target of 1e-3,
    # less at tighter ones, nearly three times at looser ones, for which it keeps the steps short.
    certify: bool = True

    @model_validator(mode="after")
    def _goes_together(self) -> "Accuracy":
        self.integrator()
        return self

    def integrator(self) -> Integrator:
        """The kernel's integrator for these settings."""
        return choose(self.method, self.target, self.rtol, self.atol, self.max_steps, certify=self.certify)


def _known_quantities(value: object) -> object:
    if value in ([PEAK_KE], [KE]):
        return [PEAK_KE]
    from kernel.quantities import QUANTITIES  # and with it numba, which most plans do without

    known = (PEAK_KE, KE, *QUANTITIES)
    rule = f"must be a list of distinct quantities out of: {', '.join(known)}"
    if not isinstance(value, list) or not value or len(set(map(str, value))) < len(value):
        raise ValueError(f"{rule}; got {value!r}")
    if others := [name for name in value if name not in known]:
        hints = (f"{name!r}{did_you_mean(str(name), known)}" for name in others)
        raise ValueError(f"{rule}; got {', '.join(hints)}")
    return [PEAK_KE, *sorted(name for name in value if name not in (PEAK_KE, KE))]


class Output(Section):
    """What every row holds, and how often the table goes to the disk."""

    # Every table has what ke, or peak_ke, stands for: ke_bistable, ke_linear, their ratio, times. Of another quantity q
    # it has q of the chain, q_linear of the same made linear, q_ratio and q_error.
    observe: Annotated[list[str], BeforeValidator(_known_quantities)] = Field(default_factory=lambda: [PEAK_KE])
    # Seconds between two writings to the disk.
    flush_every: Annotated[float, Field(ge=0.1, le=86400, allow_inf_nan=False)] = 30.0

    def quantities(self) -> tuple[str, ...]:
        """What is asked for beside the kinetic energy."""
        return tuple(name for name in self.observe if name != PEAK_KE)


def _possible_model(given: dict[str, Any]) -> dict[str, Any]:
    """A section [model] as it is, which a model can be made of: judged beside the other sections, not after them."""
    model_of(given)
    return given


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
    def _has_one_chain(self, info: ValidationInfo) -> "Spec":
        self._points = info.context
        if self.grid is None and self._points is None:
            return self  # what is missing is said elsewhere
        given, varied = self.model or {}, self.varied()
        if self._points is None:
            together, where, N = combinations(self.axes), "grid", self._all_axes()["N"]
        else:
            together = occurring(self._points, self.points or {}, varied)
            where, N = "points", self._points["N"].tolist()
        model = check_axes(given, varied, together, where, N) if given or varied else None
        self._model = None if model is None or (not varied and is_papers(model)) else model
        settings = None if self._model is None else settings_of(self._model, varied)
        object.__setattr__(self, "model", settings)  # every number spelled out
        return self

    @model_validator(mode="after")
    def _fits_a_table(self) -> "Spec":
        if self.search is not None and self.adaptive is not None:
            raise ValueError("adaptive: must not stand beside a section [search], which can do the same")
        certified = self.accuracy.certify
        if self.asked and (lines := self.asked.problems(self._all_axes(), self.layout(), certified)):
            raise SpecError(lines)
        if (self.grid is not None or self._points is not None) and self.tasks > TASKS_MAX:
            raise ValueError(f"grid has {self.tasks} tasks, at most {TASKS_MAX} fit one table")
        return self

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
        return (self.grid.model_dump() if self.grid else {}) | self.axes

    def varied(self) -> tuple[str, ...]:
        """The numbers of the model that differ from task to task."""
        return tuple(name for name in (self._points or self.axes) if is_number_of_model(name))

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
        """The keys in which a table's resolved spec asks for other numbers than this one (`NO_NUMBERS` do not)."""
        ours, theirs = flat(self._given()), flat(resolved)
        return sorted(
            key for key in ours.keys() | theirs.keys() if key not in NO_NUMBERS and ours.get(key) != theirs.get(key)
        )


def flat(spec: dict[str, Any]) -> dict[str, Any]:
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
        raise InputError(f"{path}: is {f'{kind}, not a spec' if kind else 'not a text file in UTF-8'}") from None
    return parse_spec(text, str(path), path.parent), text


def parse_spec(text: str, source: str, folder: Path = Path()) -> Spec:
    """The validated spec; `source` names the text in messages, `folder` is where files lie that it names."""
    try:
        document = tomllib.loads(text)
        _check_whole_numbers(document)
    except ValueError as error:  # TOMLDecodeError is one
        raise InputError(f"{source}: is not TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{source}: is nested too deeply") from None
    document, points, problems = _prepared(document, folder)
    try:
        spec = Spec.model_validate(document, context=points)
    except ValidationError as error:
        problems += (line for e in error.errors() for line in problem_lines(e, _keys()))
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
            document["search"] = search | {"sha256": sha256(folder / search["file"])}
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            problems.append(f"search.file: {search['file']} cannot be read: {why}")
    return document, points, problems


def _keys() -> dict[str, list[str]]:
    """Of every section; those at the top under ""."""
    sections: dict[str, type[Section]] = {"grid": Grid, "search": Sought, "adaptive": Adaptive}
    sections |= {"accuracy": Accuracy, "output": Output}
    return {"": [name for name in Spec.model_fields if name != "axes"]} | {
        name: list(section.model_fields) for name, section in sections.items()
    }


def _check_whole_numbers(value: Any) -> None:
    """TOML's own rule, which tomllib leaves to its users."""
    if isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            _check_whole_numbers(item)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError(f"a whole number must fit 64 bits, got {hex(value)[:20]}...")
