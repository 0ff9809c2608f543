"""Every number of the paper beside ours, with a verdict."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

import kernel
from analysis.convention import DRAWS, TOLERANCE, ratios
from analysis.errors import InputError
from analysis.figures.recipe import Source
from analysis.paper_numbers import POINTS, SAID, Point
from kernel.model import C2, C3, M0, V0, Array

AGREES, DIFFERS, ILL, OTHER = "agrees", "differs", "ill-conditioned", "agrees under another mass convention"
MASS_SCALE = 1 / 2.75  # of the other convention: M/M0 divided by this much less than the paper's axis says
GRID_STEP = 0.14  # between two impacts of figure 5, in the logarithm
CHAOTIC_SPREAD = 0.1  # a number whose ensemble spreads by more than this share is ill-conditioned


@dataclass(frozen=True)
class Ours:
    """Our number, its estimated relative error, and what to know about it."""

    value: float
    error: float = 0.0
    chaotic: bool = False
    note: str = ""
    scales_with_mass: bool = False  # a mass on the axis that the other convention stretches


def compare(source: Source) -> pd.DataFrame:
    """One row per number: key, where, what, paper, ours, error, verdict, note."""
    rows = [_point_row(point) for point in POINTS]
    for key, said in SAID.items():
        row = {"key": key, "where": said.where, "what": said.what, "paper": said.paper}
        try:
            ours = MEASURED[key](source)
        except InputError as error:
            rows.append(row | {"ours": np.nan, "error": np.nan, "verdict": "not computed", "note": str(error)})
            continue
        rows.append(
            row
            | {
                "ours": ours.value,
                "error": ours.error,
                "verdict": _verdict(said.paper, said.factor, ours),
                "note": ours.note,
            }
        )
    return pd.DataFrame(rows)


def _verdict(paper: float, factor: float, ours: Ours) -> str:
    allowed = np.log(factor) + ours.error + 1e-9
    if abs(np.log(ours.value / paper)) <= allowed:
        return AGREES
    if ours.scales_with_mass and abs(np.log(ours.value / (paper * MASS_SCALE))) <= allowed + GRID_STEP:
        return OTHER
    return ILL if ours.chaotic else DIFFERS


def _point_row(point: Point) -> dict[str, object]:
    """A ke_ratio with all its parameters: the value, what its ensemble spans, and the same at the other mass."""
    stated, other = ratios(point, "M_over_M0", np.array([1.0, MASS_SCALE]))
    result = kernel.ke_ratio(**point.task(), accuracy=1e-4)  # type: ignore[arg-type]
    where = f"M/M0 = {point.M_over_M0:g}, V/V0 = {point.V_over_V0:g}, N = {point.N}, zeta_T = {point.zeta_T:g}"
    note = f"tasks that the paper would print alike give {_span(stated)}; with M/M0 divided by {1 / MASS_SCALE:.2f}, {_span(other)}"
    verdict = point_verdict(point.paper, stated, other)
    what = f"ke_ratio at {where}"
    return {"key": point.key, "where": point.where, "what": what, "paper": point.paper, "ours": result.ke_ratio,
            "error": result.error, "verdict": verdict, "note": note}  # fmt: skip


def point_verdict(paper: float, stated: Array, other: Array) -> str:
    """A spread ensemble that holds the paper's number neither confirms nor refutes it."""
    if _holds(stated, paper):
        return ILL if np.ptp(stated) > CHAOTIC_SPREAD * np.median(stated) else AGREES
    return OTHER if _holds(other, paper) else DIFFERS


def _holds(found: Array, paper: float) -> bool:
    return bool(found.min() * (1 - TOLERANCE) <= paper <= found.max() * (1 + TOLERANCE))


def _span(found: Array) -> str:
    return f"{found.min():.3g} to {found.max():.3g} ({DRAWS} draws)"


def _stable_strains() -> tuple[float, float]:
    """Compression of the first inflection of the energy (f' = 0) and of the second stable state (f = 0)."""
    inflection = min(np.roots([3 * C3, -2 * C2, 1.0]).real)
    return float(inflection), float(max(np.roots([C3, -C2, 1.0]).real))


def _nominal_mass(_: Source) -> Ours:
    strain = 0.46  # the paper's own second stable state
    energy = strain**2 / 2 - C2 * strain**3 / 3 + C3 * strain**4 / 4
    return Ours(energy / V0**2, note="from the paper's strain of 0.46, which is not the zero of its force")


def _lowest(source: Source, zeta_T: float, N: int) -> pd.Series:  # type: ignore[type-arg]
    df = source.table("fig5")
    rows = df[(df["zeta_T"] == zeta_T) & (df["N"] == N)]
    if rows.empty:
        raise InputError(f"the table fig5 has no row at N = {N}, zeta_T = {zeta_T:g}")
    return rows.loc[rows["ke_ratio"].idxmin()]


def _panel(zeta_T: float, column: str) -> Callable[[Source], Ours]:
    def measured(source: Source) -> Ours:
        row = _lowest(source, zeta_T, 200)
        note = f"lowest of the panel: {row['ke_ratio']:.3g} at ({row['M_over_M0']:.3g}, {row['V_over_V0']:.4g})"
        error = min(float(row["error"]), 1.0) if column == "ke_ratio" else 0.0
        return Ours(
            float(row[column]),
            0.0 if np.isnan(error) or row["chaotic"] else error,
            bool(row["chaotic"]),
            note,
            column == "M_over_M0",
        )

    return measured


def _energy_of_best(zeta_T: float) -> Callable[[Source], Ours]:
    def measured(source: Source) -> Ours:
        df = source.table("fig5")
        row = df.loc[df.loc[df["zeta_T"] == zeta_T, "ke_ratio"].idxmin()]
        note = f"ke_ratio {row['ke_ratio']:.3g} at N = {row['N']}"
        return Ours(
            float(row["M_over_M0"] * M0 * (row["V_over_V0"] * V0) ** 2), chaotic=bool(row["chaotic"]), note=note
        )

    return measured


def _best8(column: str) -> Callable[[Source], Ours]:
    def measured(source: Source) -> Ours:
        df = source.table("fig8")
        row = df.loc[df["ke_ratio"].idxmin()]
        place = f"N = {row['N']}, zeta_T = {row['zeta_T']:.3g}, M/M0 = {row['M_over_M0']:.3g}, V/V0 = {row['V_over_V0']:.3g}"
        values = {
            "ke_ratio": row["ke_ratio"],
            "MV2": row["M_over_M0"] * row["V_over_V0"] ** 2,
            "mass": 100 * row["M_over_M0"] * M0,
            "speed": 100 * row["V_over_V0"] * V0,
        }
        return Ours(float(values[column]), chaotic=bool(row["chaotic"]), note=f"of {len(df)} impacts, at {place}")

    return measured


def _threshold(source: Source) -> Ours:
    df = source.table("fig4")
    losing = df[df["ke_ratio"] > 1.05]
    if losing.empty:
        raise InputError("no cell of the table fig4 has a ke_ratio above 1.05")
    return Ours(float((losing["N"] / losing["zeta_T"]).min()), note="least N/zeta_T with a ke_ratio above 1.05")


def _waves(source: Source) -> Ours:
    one = next(s for s in source.scenes("fig11") if s.scene.N == 50 and s.scene.law == "bistable")
    v = one["profile"]["v"][0]
    peaks = (v[1:-1] > v[:-2]) & (v[1:-1] >= v[2:]) & (v[1:-1] > 0.5 * v.max())
    return Ours(float(peaks.sum()), note="peaks above half of the highest at t/N = 0.5; by eye in the paper")


def _peak_time(source: Source) -> Ours:
    peak = source.scenes("fig7")[0]["peak_ke"]
    return Ours(float(peak["t"]), note="read off the picture in the paper")


def _forces(source: Source) -> Ours:
    tops = {(s.scene.law, s.scene.N): float(np.abs(s["viscous_force"]["force"]).max()) for s in source.scenes("fig9")}
    fine = tops.pop(("bistable", 200))
    return Ours(fine / max(tops.values()), note="highest over the ten times of the scene file")


def _undamped(source: Source) -> Ours:
    row = _lowest(source, 0.0, 200)
    return Ours(float(row["ke_ratio"]), chaotic=bool(row["chaotic"]), note="N = 200")


MEASURED: dict[str, Callable[[Source], Ours]] = {
    "c2": lambda _: Ours(C2),
    "c3": lambda _: Ours(C3),
    "eps0": lambda _: Ours(_stable_strains()[0]),
    "eps2": lambda _: Ours(_stable_strains()[1], note="the zero of the force beyond the barrier"),
    "M0": _nominal_mass,
    "waves50": _waves,
    "threshold4d": _threshold,
    "undamped5": _undamped,
    "min5h": _panel(4e-5, "ke_ratio"),
    "M5h": _panel(4e-5, "M_over_M0"),
    "V5h": _panel(4e-5, "V_over_V0"),
    "min5l": _panel(4e-4, "ke_ratio"),
    "M5l": _panel(4e-4, "M_over_M0"),
    "V5l": _panel(4e-4, "V_over_V0"),
    "t7a": _peak_time,
    "min8": _best8("ke_ratio"),
    "MV8": _best8("MV2"),
    "force9": _forces,
    "PiIE0": _energy_of_best(0.0),
    "PiIE1": _energy_of_best(4e-5),
    "PiIE2": _energy_of_best(4e-4),
    "mass": _best8("mass"),
    "speed": _best8("speed"),
}
