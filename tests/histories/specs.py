"""Small specs of every kind, and others beside them whose rows they could take over, or not."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

RANGE = "{{ {spacing} = [{low}, {high}], points = {points} }}"
ACCURACIES: tuple[dict[str, object], ...] = (
    {"target": 1e-2},
    {"target": 1e-3},
    {"target": 1e-4},
    {"target": 1e-3, "certify": False},
    {"method": "rk45", "rtol": 1e-6},
    {"target": 1e-2, "max_steps": 1500},  # some rows fail
    {"method": "rk45", "rtol": 1e-5, "max_steps": 700},
)
MODEL = 'spring = { law = "bistable", c3 = 6.0 }\nsite = 0.4\n'
SEARCHES = {
    "adaptive": ("[adaptive]\n", '[adaptive]\nfind = "log_slope"\nuntil = 0.1\n'),
    "level": (
        '[search]\nfind = "level"\nalong = "N"\nlevel = 0.3\nuntil = 0.05\n',
        '[search]\nfind = "level"\nalong = "V_over_V0"\nlevel = 0.5\ncrossing = "last"\n',
    ),
    "map": (
        '[search]\nfind = "map"\nover = ["N", "zeta_T"]\nerror = 0.1\n',
        '[search]\nfind = "map"\nover = ["M_over_M0", "V_over_V0"]\nerror = 0.05\nscreen = false\n',
    ),
    "lowest": (
        '[search]\nfind = "lowest"\nover = ["M_over_M0", "V_over_V0"]\n',
        '[search]\nfind = "lowest"\nover = ["V_over_V0"]\nrobust = 0.02\n',
    ),
}
KINDS = ("grid", "grid", "points", *SEARCHES)


@dataclass(frozen=True)
class Asked:
    """A spec in parts."""

    kind: str
    axes: Mapping[str, str]
    accuracy: Mapping[str, object]
    search: str = ""
    model: str = ""
    observe: str = ""
    points: Mapping[str, str] = field(default_factory=dict)

    @property
    def is_search(self) -> bool:
        """Whether it computes only what it needs."""
        return bool(self.search)

    @property
    def text(self) -> str:
        """The spec as a file."""
        inputs = "".join(f'"{name}" = {value}\n' for name, value in {**self.points, **self.axes}.items())
        accuracy = "".join(f"{name} = {_toml(value)}\n" for name, value in self.accuracy.items())
        model = f"[model]\n{self.model}" if self.model else ""
        output = f"[output]\nobserve = {self.observe}\n" if self.observe else ""
        where = "[points]" if self.points else "[grid]"
        return f'name = "h"\n{model}{where}\n{inputs}[accuracy]\n{accuracy}{output}{self.search}'

    def but(self, **accuracy: object) -> "Asked":
        """The same at another accuracy."""
        return replace(self, accuracy={**self.accuracy, **accuracy})

    def scaled(self, factor: float) -> "Asked":
        """The same, so many times as accurate."""
        name = "rtol" if "rtol" in self.accuracy else "target"
        return self.but(**{name: float(f"{float(str(self.accuracy[name])) / factor:.3g}")})

    def beside(self, rng: np.random.Generator) -> "Asked":
        """A grid at the same accuracy which has some of the same tasks."""
        axes = dict(self.axes)
        axes["zeta_T"] = str([1e-4, 3e-4, float(rng.choice([1e-3, 2e-3]))])
        return replace(self, kind="grid", axes=axes, search="", points={})


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


def drawn(rng: np.random.Generator, only: str = "") -> Asked:
    """A spec of some hundred tasks, which take some tenths of a second."""
    kind = only or str(rng.choice(KINDS))
    accuracy = ACCURACIES[int(rng.integers(len(ACCURACIES)))]
    if kind == "lowest" or rng.random() < 0.5:
        accuracy = {name: value for name, value in accuracy.items() if name != "certify"}
    search = SEARCHES[kind][int(rng.integers(2))] if kind in SEARCHES else ""
    axes = _points(rng) if kind == "points" else _axes(rng, kind, search)
    points = {"sample": f'"{rng.choice(["sobol", "latin", "random"])}"', "n": str(int(rng.integers(100, 400)))}
    asked = Asked(kind, axes, accuracy, search, points=points if kind == "points" else {})
    if rng.random() < 0.25:
        asked = replace(asked, model=MODEL, axes={**axes, "spring.c2": "4.5" if points and kind == "points" else C2})
    return replace(asked, observe='["ke", "wall_force"]') if asked.model and rng.random() < 0.5 else asked


C2 = "[4.5, 5.0]"


def _points(rng: np.random.Generator) -> dict[str, str]:
    return {
        "N": "{ linear = [5, 120] }",
        "zeta_T": "{ log = [1e-4, 1e-2] }",
        "M_over_M0": str(float(rng.choice([0.5, 2.0]))),
        "V_over_V0": "{ log = [0.3, 5] }",
    }


def _axes(rng: np.random.Generator, kind: str, search: str) -> dict[str, str]:
    """Few values, and more on the axes along which something is looked for."""

    def span(name: str, spacing: str, low: float, high: float, few: int, many: int) -> str:
        points = many if f'"{name}"' in search else few
        return RANGE.format(spacing=spacing, low=low, high=high, points=points)

    axes = {
        "N": span("N", "log", 6, 120, 5, 12),
        "zeta_T": span("zeta_T", "log", 1e-4, 1e-2, 3, 12),
        "M_over_M0": span("M_over_M0", "log", 0.3, 3, 2, 8),
        "V_over_V0": span("V_over_V0", "log", 0.3, 5, 12, 12),
    }
    if kind == "grid":  # values that other grids have too
        axes["zeta_T"] = str([float(each) for each in rng.choice([0.0, 1e-4, 3e-4, 1e-3, 1e-2], 3, replace=False)])
    return axes
