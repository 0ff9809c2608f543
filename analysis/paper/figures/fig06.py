"""Figure 6: the transition in N, and how it moves with the damping."""

import pandas as pd

from analysis import style
from analysis.draw_transition import curve, exponent, finish
from analysis.notes import chaos_text
from analysis.paper.numbers import EXPONENTS
from analysis.paper.recipe import Drawn, Recipe, Source
from analysis.plane import chosen
from analysis.power_law import power_laws
from analysis.table import IMPACT
from analysis.transition import DEFINITIONS, transition

# The paper's green, red, magenta and grey, and one that it does not have.
COLOURS: dict[tuple[float, float], str] = {
    (2, 1): "#009E73",
    (2, 2): "#D55E00",
    (2, 4): "#CC79A7",
    (0.5, 4): "#0072B2",
    (0.1, 10): "0.45",
}
CAPTION = (
    "(a) Ratio of the peak kinetic energies at the middle against N at zeta_T = 4e-4 for several impacts (M/M0, "
    "V/V0); open circles are chaotic. All but the slowest impact fall sharply from above 1 to far below it at "
    "their N_transition. (b) N_transition, the steepest fall of log ke_ratio against log N (bars: the N "
    "it lies between), against zeta_T, with power laws zeta_T^-b through those up to 1e-2, and 95 % intervals of b."
)


def draw(source: Source) -> Drawn:
    """(a) from the table fig6, (b) from fig6b."""
    df, grid = source.table("fig6"), source.table("fig6b")
    figure, axes = style.canvas(1, 2, 8.6, 3.6)
    for (M, V), colour in COLOURS.items():
        rows = chosen(df, dict(zip(IMPACT, (M, V), strict=True)))
        style.curve(axes[0, 0], rows, "N", "ke_ratio", colour, f"({M:g}, {V:g})")
    style.against_one(axes[0, 0], "$N$")
    handles = [*axes[0, 0].get_legend_handles_labels()[0], style.open_circle()]
    axes[0, 0].legend(
        handles=handles, title="$(M/M_0, V/V_0)$", fontsize=7, title_fontsize=8, frameon=False, loc="lower left"
    )
    lines = {key: transition(chosen(grid, dict(zip(IMPACT, key, strict=True)))) for key in EXPONENTS}
    for (M, V), found in lines.items():
        curve(axes[0, 1], found, f"({M:g}, {V:g})", COLOURS[M, V], paper=EXPONENTS[M, V])
    finish(axes[0, 1])
    axes[0, 1].legend(fontsize=7, frameon=False)
    style.letter(axes)
    found = pd.concat(lines.values())
    numbers = pd.concat([df.assign(panel="a"), found.assign(panel="b")])
    lost = f"(b) {(found['why_not'] != '').sum()} of {len(found)} dampings have no transition"
    return Drawn(figure, numbers, (chaos_text(df, "open circles"), lost, *_sensitivity(found)))


def _sensitivity(found: pd.DataFrame) -> list[str]:
    """The exponents by every definition of the transition."""
    return [
        f"b({M:g}, {V:g}): "
        + ", ".join(
            f"{exponent(law['b'])} by the {DEFINITIONS[law['definition']].words}" for law in laws.to_dict("records")
        )
        for (M, V), laws in power_laws(found).groupby(IMPACT)
    ]


RECIPES = (Recipe("6", "transition in N and its power law", CAPTION, draw),)
