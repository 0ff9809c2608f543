"""What the user wrote: a TOML file, validated as a whole, every problem reported at once."""

import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from kernel.hints import did_you_mean, unknown
from kernel.method import MAX_STEPS, Integrator, choose
from kernel.task import broken_rule
from sweep.errors import InputError
from sweep.files import kind_of_data
from sweep.plan.adaptive import Search, every_task, most_asked
from sweep.plan.axis import axis_values
from sweep.plan.fall import START_MIN, Rule
from sweep.plan.tasks import Tasks

TASKS_MAX = 1_000_000_000  # of a table of 160 GB: a typing error, rather than a wish
NAME_MAX = 80  # characters of a sweep's name
LINE_MAX = 300  # characters of one problem: a value may be a list of thousands
NO_NUMBERS = ("name", "output.flush_every")  # keys that change no row
PEAK_KE = "peak_ke"  # the quantity that every table has


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def _keep_rule(name: str, value: object) -> object:
    if broken := broken_rule(name, value):
        raise ValueError(broken.removeprefix(f"{name}: "))
    return value


def _rule(name: str) -> BeforeValidator:
    """The kernel's own rule for a value."""
    return BeforeValidator(partial(_keep_rule, name))


def _axis(name: str) -> BeforeValidator:
    return BeforeValidator(partial(axis_values, name))


class Grid(_Section):
    """The four axes; a task is one combination, the last axis varying fastest."""

    N: Annotated[tuple[int, ...], _axis("N")]
    zeta_T: Annotated[tuple[float, ...], _axis("zeta_T")]
    M_over_M0: Annotated[tuple[float, ...], _axis("M_over_M0")]
    V_over_V0: Annotated[tuple[float, ...], _axis("V_over_V0")]


class Accuracy(_Section):
    """How good the numbers must be, and by which method."""

    target: Annotated[float, _rule("accuracy")] = 1e-3  # wanted relative error of ke_ratio
    method: Literal["auto", "rk45"] = "auto"
    rtol: Annotated[float, _rule("rtol")] | None = None  # with method = "rk45" only
    atol: Annotated[float, _rule("atol")] | None = None
    max_steps: Annotated[int, _rule("max_steps")] = MAX_STEPS  # of one run; a task that needs more is a failed row
    # Estimate the error of every row, and see whether it is chaotic: twice the time on average at 1e-3, more at looser
    # targets, for which it keeps the steps short.
    certify: bool = True

    @model_validator(mode="after")
    def _goes_together(self) -> "Accuracy":
        self.integrator()
        return self

    def integrator(self) -> Integrator:
        """The kernel's integrator for these settings."""
        return choose(self.method, self.target, self.rtol, self.atol, self.max_steps, certify=self.certify)


class Adaptive(_Section):
    """Compute only what the search for N_transition asks for, starting from the N of the grid on every line."""

    find: Literal["level", "log_slope"] = "level"
    until: Annotated[float, Field(ge=1e-3, le=0.5, allow_inf_nan=False)] = 0.02  # relative width of a bracket
    most: Annotated[int, Field(ge=1, le=10_000)] = 50  # N added to one line

    def rule(self) -> Rule:
        """These settings, as the search takes them."""
        return Rule(self.find, self.until, self.most)


def _known_quantities(value: object) -> object:
    if value == [PEAK_KE]:
        return value
    from kernel.quantities import QUANTITIES  # and with it numba, which most plans do without

    known = (PEAK_KE, *QUANTITIES)
    rule = f"must be a list of distinct quantities out of: {', '.join(known)}"
    if not isinstance(value, list) or not value or len(set(map(str, value))) < len(value):
        raise ValueError(f"{rule}; got {value!r}")
    if others := [name for name in value if name not in known]:
        hints = (f"{name!r}{did_you_mean(str(name), known)}" for name in others)
        raise ValueError(f"{rule}; got {', '.join(hints)}")
    return [PEAK_KE, *sorted(name for name in value if name != PEAK_KE)]


class Output(_Section):
    """What every row holds, and how often the table goes to the disk."""

    # Every table has what peak_ke stands for: ke_bistable, ke_linear, their ratio and times. Of another quantity q
    # (kernel.quantities) it has q of the bistable chain, q_linear, q_ratio and q_error.
    observe: Annotated[list[str], BeforeValidator(_known_quantities)] = [PEAK_KE]
    # Seconds between two writings to the disk (store.writers.Flusher).
    flush_every: Annotated[float, Field(ge=0.1, le=86400, allow_inf_nan=False)] = 30.0

    def quantities(self) -> tuple[str, ...]:
        """What is asked for beside the kinetic energy."""
        return tuple(name for name in self.observe if name != PEAK_KE)


class Spec(_Section):
    """One sweep."""

    name: Annotated[str, Field(min_length=1, max_length=NAME_MAX)]
    grid: Grid
    adaptive: Adaptive | None = None
    accuracy: Accuracy = Accuracy()
    output: Output = Output()

    @model_validator(mode="after")
    def _fits_a_table(self) -> "Spec":
        if self.adaptive is not None and len(self.grid.N) < START_MIN:
            raise ValueError(
                f"grid.N: an adaptive sweep starts from at least {START_MIN} values, got {list(self.grid.N)}"
            )
        if self.tasks > TASKS_MAX:
            raise ValueError(f"grid has {self.tasks} tasks, at most {TASKS_MAX} fit one table")
        return self

    @property
    def tasks(self) -> int:
        """How many rows the table has: one for each task that is or may be computed."""
        return math.prod(map(len, self.task_list().axes.values()))  # may be too many for a table

    @property
    def first(self) -> int:
        """How many tasks are computed in any case: all, or those with which an adaptive sweep starts."""
        return self.lines * len(self.grid.N)

    @property
    def at_most(self) -> int:
        """How many tasks may be computed."""
        if not self.adaptive:
            return self.tasks
        return most_asked((self.tasks // self.lines, self.lines), len(self.grid.N), self.adaptive.rule())

    @property
    def lines(self) -> int:
        """How many combinations of impact and zeta_T there are."""
        return len(self.grid.zeta_T) * len(self.grid.M_over_M0) * len(self.grid.V_over_V0)

    def task_list(self) -> Tasks:
        """Every task that has a row, numbered as in the table."""
        return every_task(self.grid.model_dump(), self.adaptive.until if self.adaptive else None)

    def search(self) -> Search | None:
        """The search of an adaptive sweep; None of another."""
        return Search(self.grid.model_dump(), self.adaptive.rule()) if self.adaptive else None

    def resolved(self) -> str:
        """The spec with every default and every axis value spelled out, as JSON; exact, so it can be compared."""
        return json.dumps(self._given(), indent=1)

    def _given(self) -> dict[str, Any]:
        return {name: part for name, part in self.model_dump(mode="json").items() if part is not None}

    def accuracy_text(self) -> str:
        """The part of `resolved` that says how good the numbers are."""
        return json.dumps({"accuracy": self.accuracy.model_dump(mode="json")}, indent=1)[2:-2]

    def observe_text(self) -> str:
        """The part of `resolved` that says which quantities a row holds."""
        text = json.dumps({"output": {"observe": self.output.observe}}, indent=1)
        return text[text.index('"observe"') : text.index("]") + 1]

    def differences(self, resolved: dict[str, Any]) -> list[str]:
        """The keys in which a table's resolved spec asks for other numbers than this one (`NO_NUMBERS` do not)."""
        ours, theirs = _flat(self._given()), _flat(resolved)
        return sorted(
            key for key in ours.keys() | theirs.keys() if key not in NO_NUMBERS and ours.get(key) != theirs.get(key)
        )


def _flat(spec: dict[str, Any]) -> dict[str, Any]:
    """{"grid": {"N": x}} as {"grid.N": x}."""
    sections = {key: value for key, value in spec.items() if isinstance(value, dict)}
    plain = {key: value for key, value in spec.items() if key not in sections}
    return plain | {f"{name}.{key}": value for name, section in sections.items() for key, value in section.items()}


def read_spec(path: Path) -> tuple[Spec, str]:
    """The validated spec and its text as given; InputError naming every problem. A pipe can be read only once."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        kind = kind_of_data(error.object)
        raise InputError(f"{path}: is {f'{kind}, not a spec' if kind else 'not a text file in UTF-8'}") from None
    return parse_spec(text, str(path)), text


def parse_spec(text: str, source: str) -> Spec:
    """The validated spec; `source` names the text in messages."""
    try:
        document = tomllib.loads(text)
        _check_whole_numbers(document)
        return Spec.model_validate(document)
    except ValidationError as error:
        raise InputError(*(f"{source}: {problem_line(e, _keys())}" for e in error.errors())) from None
    except ValueError as error:  # TOMLDecodeError is one
        raise InputError(f"{source}: is not TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{source}: is nested too deeply") from None


def _keys() -> dict[str, list[str]]:
    """Of every section; those at the top under ""."""
    sections: dict[str, type[_Section]] = {"grid": Grid, "adaptive": Adaptive, "accuracy": Accuracy, "output": Output}
    return {"": list(Spec.model_fields)} | {name: list(section.model_fields) for name, section in sections.items()}


def _check_whole_numbers(value: Any) -> None:
    """TOML's own rule, which tomllib leaves to its users."""
    if isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            _check_whole_numbers(item)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError(f"a whole number must fit 64 bits, got {hex(value)[:20]}...")


def problem_line(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    """`key: rule, got value`, cut off at LINE_MAX characters; `error`: one of pydantic's, `keys`: of `_keys`."""
    text = _text(error, keys)
    return text if len(text) <= LINE_MAX else f"{text[:LINE_MAX]}..."


def _text(error: Mapping[str, Any], keys: Mapping[str, Sequence[str]]) -> str:
    place, got = [str(part) for part in error["loc"]], error["input"]
    key = ".".join(place)
    match error["type"]:
        case "missing":
            return f"{key}: is missing"
        case "model_type":
            return f"{key}: must be a section [{key}], got {got!r}"
        case "extra_forbidden":
            return f"{key}: is not a known key{_meant(place, keys)}, got {got!r}"
        case "literal_error":
            return unknown(key, got, re.findall(r"'([^']*)'", error["ctx"]["expected"]))
        case "value_error":
            return f"{key}: {error['ctx']['error']}" if key else str(error["ctx"]["error"])
    rule = re.sub(r"^\w+ should", "must", error["msg"]).removesuffix(" after validation, not 0")
    return f"{key}: {rule}, got {got!r}"


def _meant(place: Sequence[str], keys: Mapping[str, Sequence[str]]) -> str:
    """Another key of the same section, or the section where this one belongs."""
    section, word = place[0] if len(place) > 1 else "", place[-1]
    if near := did_you_mean(word, keys.get(section, ())):
        return near
    home = next((name for name, known in keys.items() if word in known), None)
    return "" if home is None else f" (it belongs {f'into [{home}]' if home else 'before all sections'})"
