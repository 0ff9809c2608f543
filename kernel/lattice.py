"""Which chain: its springs, its contact, how long and at which site it is watched; else the paper's."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from kernel import along
from kernel.alike import EqualInKind
from kernel.hints import did_you_mean, meant_or_known, shown, unknown
from kernel.laws import CONTACTS, PAPER, SPRINGS, Hertz
from kernel.laws.foreign import problem_of_excess
from kernel.model import MIDDLE, Lattice
from kernel.problems import ProblemsError, lines_of
from kernel.task import MODEL_BOX, T_END_OVER_N, finite_numbers, is_finite, outside
from kernel.varied import DriverMotion, Varied, varied_of

FIXED, FREE = WALLS = ("fixed", "free")
REST_ERROR = 1e-9  # what rounding may leave of a law's stiffness at rest
LAWS: dict[str, Mapping[str, Any]] = {"spring": SPRINGS, "contact": CONTACTS}
# The methods of kernel.laws.Spring and kernel.laws.Contact.
FACE = ("excess", "energy_at", "stiffness_at", "steepest", "is_linear", "stiffens_in_tension", "stiffness_jumps")
PUSHING = (
    *("push", "energy_at", "stiffness_at", "period", "duration", "after", "overlap", "impulse"),
    *("at_unit_speed", "of_cells", "softened"),
)


@dataclass(frozen=True, eq=False)
class Model(EqualInKind):
    """The chain that a task's numbers are about.

    Parameters
    ----------
    spring : Bistable, Polynomial, PiecewiseLinear, PowerLaw, Toda, or another law with the face of kernel.laws.Spring
        Law of all links. The linear chain that it is compared with has the same stiffness at rest.
    contact : Hertz, or another law with the face of kernel.laws.Contact
        Law of impactor and first site.
    wall : str
        "fixed": the last link is tied to a wall; "free": the last site has no link behind it.
    t_end : float
        Duration of a run in cell transit times over N, 0.01 to 1000.
    site : float
        Where the watched site is, 1e-4 to 1: it has the number ceil(site N), counted from 1 at the struck end; 0.5 is
        the middle.
    mass : float, Graded, Disordered or (N,) numbers
        Of every site, over that of the paper's chain: 1e-3 to 1000. Where it or one of the next two is no number, or
        the wall is free, Dormand-Prince integrates: the fast methods are for uniform chains only.
    stiffness : float, Graded, Disordered or (N,) numbers
        Of every link, over that of the paper's chain: 1e-3 to 1000.
    damping : float, Graded, Disordered or (N,) numbers
        Of every damper, over that of the paper's chain: 0 to 1000.

    Raises
    ------
    ValueError
        Naming everything that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> model = kernel.Model(spring=kernel.Bistable(c2=4.0, c3=5.5), site=0.25)
    >>> model.numbers()["spring.c3"], model == model.with_numbers({"site": 0.25})
    (5.5, True)
    """

    spring: Any = PAPER
    contact: Any = Hertz()  # noqa: RUF009 (a named tuple)
    t_end: float = T_END_OVER_N
    site: float = MIDDLE
    mass: Any = 1.0
    stiffness: Any = 1.0
    damping: Any = 1.0
    wall: str = FIXED

    def __post_init__(self) -> None:
        for name in ("spring", "contact"):  # frozen: there is no other way
            object.__setattr__(self, name, _without_arrays(getattr(self, name)))
        problems = _of_law("spring", self.spring, FACE) + _of_law("contact", self.contact, PUSHING)
        for name, (low, high) in MODEL_BOX.items():
            value = getattr(self, name)
            problems += along.problems_of(name, value) if name in along.KINDS else outside(low, high, **{name: value})
        if not isinstance(self.wall, str) or self.wall not in WALLS:
            problems.append(unknown("wall", self.wall, WALLS))
        lengths = {
            name: len(x)
            for name in along.KINDS
            if isinstance(x := along.plain(getattr(self, name)), list) or _is_plain(x)
        }
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{name} {length}" for name, length in lengths.items())
            problems.append(f"{', '.join(lengths)}: must hold as many numbers, got {told}")
        if problems:
            raise ProblemsError(problems)
        for name in MODEL_BOX:
            object.__setattr__(self, name, along.as_kept(getattr(self, name)))
        for name in ("spring", "contact"):
            object.__setattr__(self, name, _as_floats(getattr(self, name)))

    @property
    def has_sound(self) -> bool:
        """Whether its links have a stiffness at rest, without which there is no linear chain to compare it with."""
        return bool(getattr(self.spring, "has_sound", lambda: True)())

    @property
    def is_uniform(self) -> bool:
        """Whether all sites and links are alike, and the chain ends at a wall: the fast methods serve no others."""
        return self.wall == FIXED and all(isinstance(getattr(self, name), float) for name in along.KINDS)

    @property
    def sites(self) -> int | None:
        """How many sites a chain must have, where a list says so."""
        return next((len(x) for name in along.KINDS if _is_plain(x := getattr(self, name))), None)

    def numbers(self) -> dict[str, float]:
        """Every number by its name, as "spring.c2", "contact.stiffness", "site", "spring.slopes.0", "mass.spread"."""
        found = dict[str, float]()
        for name in (*MODEL_BOX, "spring", "contact"):
            found |= _numbers_of(name, getattr(self, name))
        return found

    def with_numbers(self, numbers: Mapping[str, float]) -> "Model":
        """The model with these of its numbers changed; ValueError naming all that are none or break a rule."""
        if not isinstance(numbers, Mapping):
            raise ValueError(f"numbers: must be a mapping of names to numbers, got {shown(numbers)}")
        known = self.numbers()
        strange = [name for name in numbers if name not in known]
        told = {name: meant_or_known(str(name), known) for name in strange}
        problems = [f"{name}: the model has no such number{told[name]}, got {shown(numbers[name])}" for name in strange]
        changed = {name: _changed(name, getattr(self, name), numbers) for name in (*MODEL_BOX, "spring", "contact")}
        try:
            model = replace(self, **changed)
        except ValueError as error:
            problems += lines_of(error)
        if problems:
            raise ProblemsError(problems)
        return model

    def lattice(self, N: int | None = None, motion: DriverMotion | None = None) -> Lattice:
        """As the compiled code takes it; N, of which length, where the chain is not uniform; motion: of its driver."""
        contact = _compiled(self.contact)
        numbers: tuple[float, float, float, Varied | None]
        if self.is_uniform and motion is None:
            numbers = self.mass, self.stiffness, self.damping, None
        else:
            each = [along.values_along(getattr(self, name), int(N or 0), name) for name in along.KINDS]
            numbers = 1.0, 1.0, 1.0, varied_of(each[0], each[1], each[2], self.wall == FREE, motion)
        return Lattice(self.spring, contact, self.t_end, self.site, *numbers)

    def settings(self) -> dict[str, Any]:
        """As a spec's section [model] says it, with every number."""
        contact = {} if type(self.contact) is Hertz else {"law": _name("contact", self.contact)}
        plain = {field.name: _listed(getattr(self, field.name)) for field in fields(self) if field.name in MODEL_BOX}
        return {
            "spring": {"law": _name("spring", self.spring), **_listed(self.spring)},
            "contact": contact | _listed(self.contact),
            **plain,
            "wall": self.wall,
        }


def names_of_numbers(model: object) -> tuple[str, ...] | None:
    """The names of the numbers that a model has; None where `model` is no model."""
    return tuple(model.numbers()) if isinstance(model, Model) else None


def model_of(given: Mapping[str, Any]) -> Model:
    """The model of a spec's section [model], of which any setting may be missing.

    Raises ValueError naming everything that is wrong.
    """
    parts, problems = dict(given), list[str]()
    for part, laws in LAWS.items():
        value = given.get(part, {})
        if not isinstance(value, Mapping):
            problems.append(f"{part}: must be a table as {{ {EXAMPLES[part]} }}, got {shown(parts.pop(part))}")
            continue
        name = value.get("law", next(iter(laws)))
        if isinstance(name, str) and name in laws:
            problems += _set(parts, part, laws[name], {key: x for key, x in value.items() if key != "law"})
        else:
            problems.append(unknown(f"{part}.law", name, laws))
            del parts[part]
    for kind in along.KINDS:
        try:
            parts |= {kind: along.from_settings(kind, given[kind])} if kind in given else {}
        except ValueError as error:
            problems.append(str(error))
            del parts[kind]
    known = [field.name for field in fields(Model)]
    for name in [name for name in parts if name not in known]:
        problems.append(f"{name}: is not a known key{did_you_mean(name, known)}, got {shown(parts.pop(name))}")
    try:
        model = Model(**parts)
    except ValueError as error:
        problems += lines_of(error)
    if problems:
        raise ProblemsError(problems)
    return model


EXAMPLES = {"spring": 'law = "bistable", c2 = 4.0, c3 = 3.5', "contact": "stiffness = 8.86e6, exponent = 1.5"}


def _set(parts: dict[str, Any], part: str, kind: Any, numbers: Mapping[str, Any]) -> list[str]:
    """Put the law into `parts`, the paper's where its numbers have names that it does not know; these in words."""
    strange = [name for name in numbers if name not in kind._fields]
    made = {name: tuple(x) if isinstance(x, list) else x for name, x in numbers.items() if name not in strange}
    missing = [name for name in kind._fields if name not in made and name not in kind._field_defaults]
    if missing:
        del parts[part]
    else:
        parts[part] = kind(**made)
    return [f"{part}.{name}: is missing" for name in missing] + [
        f"{part}.{name}: is not a number of this law, which has {', '.join(kind._fields)}"
        f"{did_you_mean(name, kind._fields)}, got {shown(numbers[name])}"
        for name in strange
    ]


def check_comparable(model: object, N: object = None) -> None:
    """ValueError where it is no Model, has no linear chain to compare it with, or a list for another N, if one is."""
    if not isinstance(model, Model):
        raise ValueError(f"model: must be a kernel.Model, got {shown(model)}")
    if not model.has_sound:
        raise ValueError(
            f"model: spring: has no stiffness at rest, so that there is no linear chain to compare it with "
            f"(a scene can be simulated), got {shown(model.spring)}"
        )
    if is_finite(N) and model.sites not in (None, N):  # what is no number is refused elsewhere
        raise ValueError(f"model: holds lists of {model.sites} numbers, which a chain of N = {shown(N)} cannot have")


def _compiled(law: Any) -> Any:
    """The law that the compiled code knows in its place."""
    return law.compiled() if hasattr(law, "compiled") else law


def _name(part: str, law: Any) -> str:
    return next((name for name, kind in LAWS[part].items() if type(law) is kind), type(law).__name__)


def _without_arrays(law: Any) -> Any:
    """With lists for rows of an array, of pandas too."""
    return type(law)._make(map(along.plain, law)) if isinstance(law, tuple) and hasattr(law, "_make") else law


def _of_law(part: str, law: Any, methods: tuple[str, ...]) -> list[str]:
    lacks = [name for name in methods if not hasattr(_compiled(law), name)]
    if lacks or not isinstance(law, tuple):
        laws = ", ".join(f"kernel.{kind.__name__}" for kind in LAWS[part].values())
        own = f"; a law of your own: it lacks {', '.join(lacks)}" if 0 < len(lacks) < len(methods) else ""
        return [f"{part}: must be a law as {laws}, got {shown(law)}{own}"]
    if not _compiled(law):  # numba takes a named tuple without fields for no named tuple
        return [f"{part}: must be a law with at least one number, got {shown(law)}"]
    problems = [f"{part}.{line}" for line in getattr(law, "problems", list)()]
    problems = problems or [
        f"{part}.{name}: must be a number, got {shown(x)}" for name, x in _items(law) if not _holds_numbers(x)
    ]
    return problems if problems or part == "contact" else _at_rest(_as_floats(law))


def _holds_numbers(x: object) -> bool:
    return finite_numbers(x) is not None if isinstance(x, tuple | list) else is_finite(x)


def _at_rest(spring: Any) -> list[str]:
    """A law that is softer or stiffer at rest than the linear chain's must not be compared with it."""
    rest, wanted = float(spring.stiffness_at(0.0)), 1.0 if getattr(spring, "has_sound", lambda: True)() else 0.0
    if abs(rest - wanted) < REST_ERROR:
        return [line] if (line := problem_of_excess(spring)) else []
    return [f"spring: must have a stiffness of {wanted:g} at rest (in k_T L over strain), got {shown(rest)}"]


def _as_floats(law: Any) -> Any:
    """The law with floats for whole numbers and tuples for lists: what is compiled depends on the types."""
    return type(law)(*(tuple(map(float, x)) if isinstance(x, tuple | list) else float(x) for x in law))


def _is_plain(value: Any) -> bool:
    """Whether it is a tuple of numbers, no law."""
    return isinstance(value, tuple) and not hasattr(value, "_fields")


def _items(value: Any) -> list[tuple[str, Any]]:
    """The parts of a law, or of a tuple of numbers, with their names."""
    names = map(str, range(len(value))) if _is_plain(value) else value._fields
    return list(zip(names, value, strict=True))


def _numbers_of(name: str, value: Any) -> dict[str, float]:
    if not isinstance(value, tuple):
        return {name: value}
    return {key: x for part, inner in _items(value) for key, x in _numbers_of(f"{name}.{part}", inner).items()}


def _changed(name: str, value: Any, numbers: Mapping[str, float]) -> Any:
    """A law, a tuple of numbers or a number, with those of `numbers` that are its own."""
    if not isinstance(value, tuple):
        return numbers.get(name, value)
    parts = [_changed(f"{name}.{part}", inner, numbers) for part, inner in _items(value)]
    return tuple(parts) if _is_plain(value) else type(value)(*parts)


def _listed(value: Any) -> Any:
    """A value of the model in the types that TOML and JSON have."""
    if not isinstance(value, tuple):
        return value
    return [*value] if _is_plain(value) else {name: _listed(x) for name, x in _items(value)}


PAPER_MODEL = Model()
