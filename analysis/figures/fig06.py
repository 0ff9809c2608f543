"""Figure 6: the transition in N, and how it moves with the damping."""

from analysis.figures import style
from analysis.figures.recipe import Drawn, Recipe, Source, pick

IMPACTS = ((2, 1), (2, 2), (2, 4), (0.5, 4), (0.1, 10))
IMPACT_COLOURS = ("#009E73", "#D55E00", "#CC79A7", "#0072B2", "0.45")  # the paper's green, red, magenta, -, grey
CAPTION = (
    "(a) Ratio of the peak kinetic energies at the middle against N at zeta_T = 4e-4 for several impacts (M/M0, "
    "V/V0); open circles are chaotic. All but the slowest impact fall sharply from above 1 to far below it at "
    "their N_transition."
)


def draw(source: Source) -> Drawn:
    """(a) from the table fig6."""
    df = source.table("fig6")
    figure, axes = style.canvas(1, 1, 4.6, 3.6)
    ax = axes[0, 0]
    for colour, (M, V) in zip(IMPACT_COLOURS, IMPACTS, strict=True):
        rows = pick(df, M_over_M0=M, V_over_V0=V)
        style.curve(ax, rows, "N", "ke_ratio", colour, f"({M:g}, {V:g})")
    ax.axhline(1, color="0.6", linewidth=0.6, zorder=0)
    ax.set(xscale="log", yscale="log", xlabel="$N$", ylabel="KE ratio")
    ax.legend(title="$(M/M_0, V/V_0)$", fontsize=8, frameon=False)
    return Drawn(figure, df, (style.chaotic_note(df, "open circles"),))


RECIPE = Recipe("6", "transition in N and its power law", CAPTION, draw, tables=("fig6",))
