"""Which change of one constant would explain the most of the paper's ke_ratio at once.

The paper names four values of ke_ratio with all their parameters. Each family below multiplies one constant by a
factor; the equations as stated are the factor 1. A factor explains a value of the paper that lies, to within
TOLERANCE, between those of the tasks that the paper would print alike.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import kernel
from analysis.paper.numbers import POINTS, Point
from kernel.model import Array, Chain
from kernel.task import PARAMETERS

MULTIPLES = np.geomspace(0.25, 4.0, 41)  # by which a convention may differ: half, twice, squares, in steps of 7 %
TOLERANCE = 0.1  # relative: the paper rounds axes and values, and integrates less tightly
DRAWS = 8  # tasks that the paper would print alike: where they disagree, the number is ill-conditioned

TASK_FAMILIES = {"impactor mass": "M_over_M0", "impact speed": "V_over_V0", "damping": "zeta_T"}
CHAIN_FAMILIES = {"cubic coefficient c3": "c3", "quadratic coefficient c2": "c2", "contact stiffness": "K"}
_SCENE_MULTIPLES = MULTIPLES[::4]  # fewer, as scenes are slower than tasks


@dataclass(frozen=True)
class _Altered(kernel.Scene):
    """A scene in which one constant of the chain is multiplied by a factor; the linear chain has no c2 and c3."""

    change: tuple[str, float] = ("K", 1.0)

    @property
    def chain(self) -> Chain:
        chain, (name, factor) = super().chain, self.change
        return chain._replace(spring=_times(chain.spring, name, factor), contact=_times(chain.contact, name, factor))


def _times(law: Any, name: str, factor: float) -> Any:
    """The law, its number of this name, where it has one, times the factor; a linear spring's stay zero."""
    return law._replace(**{name: getattr(law, name) * factor}) if name in law._fields else law


def scan(points: tuple[Point, ...] = POINTS, factors: Array = MULTIPLES) -> pd.DataFrame:
    """One row per family, factor and number of the paper: family, factor, key, paper, low, middle, high, explained."""
    rows = [row for name in TASK_FAMILIES for point in points for row in _task_rows(name, point, factors)]
    return pd.DataFrame(rows + [row for name in CHAIN_FAMILIES for point in points for row in _chain_rows(name, point)])


def ratios(point: Point, name: str, factors: Array) -> Array:
    """ke_ratio (factors, DRAWS) of the point's ensemble with parameter `name` times each factor."""
    tasks = np.repeat(point.ensemble(DRAWS)[None], len(factors), axis=0)
    tasks[:, :, PARAMETERS.index(name)] *= factors[:, None]
    found = kernel.ke_ratios(tasks.reshape(-1, 4), 1e-3, certify=False)["ke_ratio"]
    return np.asarray(found.reshape(len(factors), DRAWS))


def _task_rows(family: str, point: Point, factors: Array) -> list[dict[str, object]]:
    found = ratios(point, TASK_FAMILIES[family], factors)
    return [_row(family, float(factor), point, some) for factor, some in zip(factors, found, strict=True)]


def _chain_rows(family: str, point: Point) -> list[dict[str, object]]:
    changes = [(CHAIN_FAMILIES[family], float(factor)) for factor in _SCENE_MULTIPLES]
    return [_row(family, change[1], point, np.array([_scene_ratio(point, change)])) for change in changes]


def _scene_ratio(point: Point, change: tuple[str, float]) -> float:
    peaks = []
    for law in ("bistable", "linear"):
        impact = kernel.Impact(point.M_over_M0, point.V_over_V0)
        scene = _Altered(point.N, point.zeta_T, impact, law, change=change)
        peaks.append(float(kernel.simulate(scene, 1e-4)["peak_ke"]["ke"]))
    return peaks[0] / peaks[1]


def _row(family: str, factor: float, point: Point, found: Array) -> dict[str, object]:
    low, high = float(found.min()), float(found.max())
    explained = low * (1 - TOLERANCE) <= point.paper <= high * (1 + TOLERANCE)
    values = {"low": low, "middle": float(np.median(found)), "high": high, "explained": explained}
    return {"family": family, "factor": factor, "key": point.key, "paper": point.paper, **values}


def summary(scanned: pd.DataFrame) -> pd.DataFrame:
    """One row per family and one for the equations as stated, best first.

    `factor` explains the most numbers (of equals, the one with the least `misfit`, the mean factor by which
    the numbers are off); `explained` names them; `range` is the span of neighbouring factors that explain as many.
    """
    rows = [_best(name, group) for name, group in scanned.groupby("family", sort=False)]
    stated = scanned[np.isclose(scanned["factor"], 1) & (scanned["family"] == "impactor mass")]
    rows.append(_summed("as stated", 1.0, stated) | {"range": "1"})
    table = pd.DataFrame(rows)
    return table.sort_values(["count", "misfit"], ascending=[False, True], ignore_index=True)


def _best(name: object, group: pd.DataFrame) -> dict[str, object]:
    found = pd.DataFrame([_summed(str(name), float(f), rows) for f, rows in group.groupby("factor")])  # type: ignore[arg-type]
    most = found[found["count"] == found["count"].max()]
    best = most.loc[most["misfit"].idxmin()]
    span = f"{most['factor'].min():.3g} .. {most['factor'].max():.3g}"
    return {str(column): value for column, value in best.items()} | {"range": span}


def _summed(name: str, factor: float, rows: pd.DataFrame) -> dict[str, object]:
    off = np.abs(np.log(rows["middle"] / rows["paper"]))
    explained = rows.loc[rows["explained"], "key"]
    told = {"count": len(explained), "explained": ", ".join(explained), "misfit": float(np.exp(off.mean()))}
    return {"family": name, "factor": factor} | told


# What somebody might have multiplied the impactor's mass by.
NAMED = {
    "1 (as stated)": 1.0,
    "1/2 (the factor of the energy)": 0.5,
    "1/e": np.exp(-1),
    "1/2.75": 1 / 2.75,
    "1/3": 1 / 3,
    "1/pi": 1 / np.pi,
    "0.26 (V0)": 0.26,
    "1/4 (half of V0, squared)": 0.25,
}


def named(points: tuple[Point, ...] = POINTS) -> pd.DataFrame:
    """One row per named factor of the mass: its name and, by number of the paper, ours over the paper's."""
    factors = np.array(list(NAMED.values()))
    found = {point.key: ratios(point, "M_over_M0", factors) / point.paper for point in points}
    rows = [
        {key: f"{some[k].min():.2f} .. {some[k].max():.2f}" for key, some in found.items()} for k in range(len(NAMED))
    ]
    return pd.DataFrame({"name": list(NAMED), "ratios": rows})
