"""Question b: how the best impact's ke_ratio against Pi_IV depends on the law."""

from typing import Any

import numpy as np
import pandas as pd

from analysis import style
from analysis.collapse import scatter
from analysis.colours import log_bar, shades
from analysis.look import COLOURS
from analysis.outlook.draw_laws import Shown, against
from analysis.outlook.laws import C2, CANDIDATES, FAMILIES, LAW, SHAPE, STRAIN_MAX, possible
from analysis.outlook.optima import RULE, falls, optima
from analysis.outlook.part import Grid, Part, Picture, Question, interval
from analysis.outlook.predict import RULE as PREDICT_RULE
from analysis.outlook.predict import judged
from analysis.outlook.questions.told import best_of, candidates_grid
from analysis.paper.recipe import Source
from analysis.table import checked
from sweep.errors import InputError

EXPONENT = Shown("s", "s_low", "s_high", "exponent $s$")
LEVEL = Shown("at_middle", "at_middle_low", "at_middle_high", r"KE ratio in the middle", log=True)


def part(source: Source) -> Part:
    """From the table optimum, a search for the lowest."""
    table = source.table("optimum")
    # What a search looked at without certifying it is no result.
    found = optima(table[checked(table)] if checked(table).any() else table)
    laws = possible(falls(found))
    points = found.merge(laws[[*LAW, SHAPE]], on=LAW)
    if laws["s"].notna().sum() == 0:
        raise InputError("no law of the table optimum has enough optima for a fit")
    by_s, by_level = (judged(laws, of, CANDIDATES) for of in ("s", "log_at_middle"))
    kept = points[points["branch"]]
    tables = [
        _families(laws),
        candidates_grid("Which number of the law predicts the exponent s", by_s, "off by (s)"),
        candidates_grid("Which predicts the KE ratio in the middle", by_level, "off by (log)"),
    ]
    missing = [
        f"{found[LAW].drop_duplicates().shape[0]} laws, of which {len(laws)} have a second state at a strain below "
        f"{STRAIN_MAX:g} or none; N = {', '.join(map(str, sorted(table['N'].unique())))}",
        f"{kept['edge'].sum()} of {len(kept)} optima of the fits lie at the end of the impacts looked at: a better one "
        "may lie beyond",
    ]
    return Part(_answer(points, laws, by_s, by_level), [_picture(points, laws)], tables, missing)


def _answer(points: pd.DataFrame, laws: pd.DataFrame, by_s: pd.DataFrame, by_level: pd.DataFrame) -> list[str]:
    two = laws[laws["family"].isin(FAMILIES[2:]) & laws["s"].notna()]
    plain, scaled = (_within_shapes(points[points["branch"]], name) for name in ("Pi_IV", "scaled"))
    middle = float(laws["middle"].iloc[0])
    return [
        "Yes: past the threshold the lowest ke_ratio falls as (Pi_IV c2)^-s, and both s and the prefactor follow the "
        f"shape of the law. {best_of(by_s, 's')} {best_of(by_level, f'the ke_ratio at Pi_IV c2 = {middle:.3g}')}"
        if len(by_s) and by_s["verdict"][0] == "predicts"
        else f"{best_of(by_s, 's')} {best_of(by_level, f'the ke_ratio at Pi_IV c2 = {middle:.3g}')}",
        f"Of the bistable laws s is {interval(*_spread(two['s']))} (median and range over {len(two)} laws).",
        f"Among laws of one shape ke_ratio scatters by {plain:.2f} decades against Pi_IV and by {scaled:.2f} against "
        "Pi_IV c2.",
    ]


def _within_shapes(known: pd.DataFrame, name: str) -> float:
    """Scatter of ke_ratio about its running median, in decades: of laws of one shape, the median over shapes."""
    shapes = known.groupby(known[SHAPE].round(6))
    of = [
        scatter(np.log10(rows[name].to_numpy(float)), np.log10(rows["ke_ratio"].to_numpy(float)))
        for _, rows in shapes
        if len(rows[C2].unique()) > 1
    ]
    return float(np.median(of)) if of else np.nan


def _spread(values: "pd.Series[float]") -> tuple[float, float, float]:
    return float(values.median()), float(values.min()), float(values.max())


def _families(laws: pd.DataFrame) -> Grid:
    rows = []
    for name in FAMILIES:
        some = laws[(laws["family"] == name) & laws["s"].notna()]
        width = (some["s_high"] - some["s_low"]).median()
        told = ["–"] * 3 if some.empty else [interval(*_spread(some[one])) for one in ("s", "at_middle", "lowest")]
        rows.append([name, str(len(some)), *told, "–" if some.empty else f"{width:.2f}"])
    columns = ("law", "laws", "s: median (range)", "KE ratio in the middle", "lowest KE ratio")
    return Grid("By the shape of the law", (*columns, "width of the interval of s"), rows)


def _picture(points: pd.DataFrame, laws: pd.DataFrame) -> Picture:
    figure, axes = style.canvas(2, 2, 8.6, 6.6)
    scale = shades(laws[SHAPE])
    across = {"Pi_IV": r"$\Pi_\mathrm{IV}$", "scaled": r"$\Pi_\mathrm{IV}\,c_2$"}
    for ax, (name, text) in zip(axes[0], across.items(), strict=True):
        for _, rows in points.groupby(LAW):
            _law(ax, rows.sort_values(name), name, scale.to_rgba(rows[SHAPE].to_numpy(float)[:1])[0])
        style.against_one(ax, text)
    log_bar(figure, scale, "$c_2^2/c_3$", ax=list(axes[0]))
    for ax, one in zip(axes[1], (EXPONENT, LEVEL), strict=True):
        against(ax, laws, SHAPE, one, (COLOURS[2],))
        ax.set_xlabel("shape of the law, $c_2^2/c_3$")
        ax.axvline(4, color="0.6", linewidth=0.6, zorder=0)
    _fit_limits(axes[1, 0], laws["s"])
    style.letter(axes)
    return Picture("b-optimum", figure, points, CAPTION, "The lowest KE ratio against Pi_IV, and its fit by law")


def _law(ax: Any, rows: pd.DataFrame, name: str, colour: Any) -> None:
    fit, rest = rows[rows["branch"]], rows[~rows["branch"]]
    ax.plot(fit[name], fit["ke_ratio"], "o-", color=colour, markersize=2.5, linewidth=0.7)
    ax.plot(rest[name], rest["ke_ratio"], "o", color=colour, markersize=2.5, mfc="white", mew=0.6)


def _fit_limits(ax: Any, values: "pd.Series[float]") -> None:
    """Limits that hold all values: intervals of few points may be far wider."""
    room = 0.5 * (values.max() - values.min()) + 0.1
    ax.set_ylim(max(values.min() - room, 0), values.max() + room)


CAPTION = (
    "The lowest ke_ratio of all impacts and chains, one dot per law and zeta_T, against (a) Pi_IV and (b) Pi_IV c2; "
    "lines join those that are fitted, open circles are those before the threshold or hardly below 1; coloured by the "
    "shape of the law. (c) Exponent s and (d) KE ratio in the middle of the range, by shape, with 95 % intervals (some "
    "of (c) reach beyond the panel); the thin line is where a second stable state begins."
)
QUESTION = Question(
    "b",
    "The optimum and the law",
    "How does the lowest ke_ratio that any impact gets depend on Pi_IV = M V / (2 zeta_T) for another law? Does one "
    "dimensionless number of the law predict it?",
    (RULE, PREDICT_RULE),
    ("optimum",),
    ("b-optimum",),
    part,
)
