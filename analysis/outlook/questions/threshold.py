"""Question a: how b and the prefactor of N_transition depend on the law."""

import numpy as np
import pandas as pd

from analysis import style
from analysis.look import COLOURS
from analysis.outlook.draw_laws import Shown, against, planes
from analysis.outlook.laws import BISTABLE, CANDIDATES, FAMILIES, LAW, OF_IMPACT, SHAPE, STRAIN_MAX, possible
from analysis.outlook.part import Grid, Part, Picture, Question, interval
from analysis.outlook.predict import RULE as PREDICT_RULE
from analysis.outlook.predict import judged
from analysis.outlook.questions.told import best_of, candidates_grid
from analysis.outlook.thresholds import KNOWN, MIDDLE_ZETA_T, alike, known, thresholds
from analysis.paper.recipe import Source
from analysis.power_law import MIN_TRANSITIONS
from sweep.errors import InputError

EXPONENT = Shown("b", "b_low", "b_high", "exponent $b$")
LEVEL = Shown(
    "N_middle",
    "N_middle_low",
    "N_middle_high",
    rf"$N_\mathrm{{transition}}$ at $\zeta_T$ = {MIDDLE_ZETA_T:g}",
    log=True,
)
ALL_CANDIDATES = CANDIDATES | OF_IMPACT
MOST = [0.05, 0.95]  # nine of ten laws lie between these shares of them
HOLDS = 0.5  # the exponent of a diffusion, over whose length sqrt(t) viscosity smooths a wave


def part(source: Source) -> Part:
    """From the table threshold."""
    table = source.table("threshold")
    every = thresholds(table)
    found = possible(every)
    sure = known(found)
    if sure.empty:
        raise InputError(f"no law of the table threshold has a b known to {KNOWN:g}")
    judged_b, judged_N = (judged(sure, of, ALL_CANDIDATES) for of in ("b", "log_N_middle"))
    speeds = sorted(every["V_over_V0"].unique())
    pictures = [
        Picture(
            "a-plane",
            planes(found.assign(known=found.index.isin(sure.index)), (EXPONENT, LEVEL), speeds),
            every,
            CAPTIONS[0],
            "b and N_transition over c2 and c3",
        ),
        *_predicting(sure, judged_b, judged_N),
    ]
    tables = [
        _families(found),
        candidates_grid("Which number of the law predicts the exponent b", judged_b, "off by (b)"),
        candidates_grid("Which predicts N_transition in the middle", judged_N, "off by (log N)"),
    ]
    lost = len(every) - len(found)
    missing = [
        f"{len(every[LAW].drop_duplicates())} laws at {len(speeds)} speeds; {lost} of {len(every)} left out, whose "
        f"second state lies at a strain of {STRAIN_MAX:g} or more; {len(found) - len(sure)} have no b, or none known "
        f"to {KNOWN:g}",
        f"{found['rows'].sum()} rows used; {found['chaotic'].sum()} chaotic and left out; one mass, M/M0 = 2",
    ]
    return Part([*_answer(found, sure, judged_b, judged_N), _similar(table)], pictures, tables, missing)


def _answer(found: pd.DataFrame, sure: pd.DataFrame, of_b: pd.DataFrame, of_N: pd.DataFrame) -> list[str]:
    middle, ends = sure["b"].median(), np.quantile(sure["b"], MOST)
    holds = int(((sure["b_low"] <= HOLDS) & (sure["b_high"] >= HOLDS)).sum())
    N_ends = np.quantile(sure["N_middle"], MOST)
    other = found[found[SHAPE] < BISTABLE]
    steep = int((other["transitions"] >= MIN_TRANSITIONS).sum())
    first = (
        f"Where b is known it hardly depends on the law: its median is {middle:.3f}, nine in ten lie from "
        f"{ends[0]:.2f} to {ends[1]:.2f}, and {holds} of {len(sure)} intervals hold {HOLDS:g}."
    )
    return [
        f"{first} {best_of(of_b, 'b')}",
        f"The prefactor does depend: N_transition at zeta_T = {MIDDLE_ZETA_T:g} is {N_ends[0]:.0f} to {N_ends[1]:.0f}. "
        f"{best_of(of_N, 'it')}",
        f"The threshold does not need a second stable state: of {len(other)} laws and speeds without one {steep} have "
        f"{MIN_TRANSITIONS} transitions or more. They soften under compression and stiffen again.",
    ]


def _similar(table: pd.DataFrame) -> str:
    pairs = alike(table)
    if pairs.empty:
        return "No two laws of one shape meet at one V c2, so that their likeness is not shown."
    off = pd.Series(np.abs(np.log(pairs["ke_ratio"] / pairs["ke_ratio_other"])))
    return (
        f"Laws of one shape at the same V c2 are one law in other units: over {len(pairs)} pairs of rows their "
        f"ke_ratio differ by {100 * off.median():.2g} % at the median, {100 * off.quantile(0.95):.2g} % or less in 95 "
        "of 100. So two numbers, c2^2/c3 and V over a strain of the law, are all that b and the prefactor can depend "
        "on here."
    )


def _families(found: pd.DataFrame) -> Grid:
    rows = []
    for name in FAMILIES:
        some = found[found["family"] == name]
        sure = known(some)
        b, N = ([*np.quantile(sure[one], [0.5, 0, 1])] if len(sure) else [np.nan] * 3 for one in ("b", "N_middle"))
        with_one = f"{some['transitions'].sum()} of {some['lines'].sum()}"
        rows.append([name, str(len(some)), with_one, str(len(sure)), interval(*b), interval(*N)])
    columns = ("law", "laws x speeds", "lines with a transition", "b known", "b: median (range)", "N: median (range)")
    return Grid("By the shape of the law", columns, rows)


def _predicting(sure: pd.DataFrame, of_b: pd.DataFrame, of_N: pd.DataFrame) -> list[Picture]:
    if of_b.empty or of_N.empty:
        return []
    figure, axes = style.canvas(1, 2, 8.4, 3.6)
    for ax, one, judged_ in zip(axes[0], (EXPONENT, LEVEL), (of_b, of_N), strict=True):
        name = judged_["name"][0]
        against(ax, sure, name, one, (COLOURS[2], COLOURS[1], COLOURS[3]), "V_over_V0")
        ax.set_xlabel(name)
    axes[0, 0].axhline(HOLDS, color="0.6", linewidth=0.6, zorder=0)
    style.letter(axes)
    style.legend(figure, axes)
    return [Picture("a-predict", figure, sure, CAPTIONS[1], "b and N_transition against the best predictor")]


CAPTIONS = (
    "Exponent b (above) and N_transition at zeta_T = 4e-4 (below) over the plane of c2 and c3, for three impact speeds "
    "at M/M0 = 2. Coloured squares: laws whose b is known well enough to be compared; laws whose second state lies at "
    "a strain of 1 or more are not drawn (white). Lines: where laws change in kind.",
    "(a) b and (b) N_transition at zeta_T = 4e-4, each against the number that explains the most of it (the tables "
    "below say what it is), of the laws whose b is known; bars are 95 % intervals. The line in (a) is b = 1/2.",
)
QUESTION = Question(
    "a",
    "The threshold and the law",
    "How do the exponent b and the prefactor of N_transition ~ zeta_T^-b depend on the law of the springs? Does one "
    "dimensionless number of the law predict them?",
    (
        "N_transition and its power law as in `analysis transition`: the steepest fall of log ke_ratio against log N, "
        f"weighted least squares, from four zeta_T on; b counts as known where its 95 % interval is {2 * KNOWN:g} wide "
        f"or narrower; the prefactor is told as N_transition at zeta_T = {MIDDLE_ZETA_T:g}",
        PREDICT_RULE,
    ),
    ("threshold",),
    ("a-plane", "a-predict"),
    part,
)
