"""Figure 8: the best of the best."""

from analysis import style
from analysis.best import best
from analysis.figures.recipe import Drawn, Recipe, Source

LOW = 1e-3
OVER = ("N", "zeta_T")
CAPTION = (
    "(a) The lowest ratio of the peak kinetic energies over all impacts, for every N and zeta_T; (b) the impactor "
    "mass and (c) the impact speed that gave it. As in the paper, chaotic rows compete; cells whose best row is "
    "chaotic are hatched, their value is one draw of many."
)


def draw(source: Source) -> Drawn:
    """From the table fig8, chaotic rows competing as the paper had them."""
    cells = best(source.table("fig8"), chaotic_too=True)
    figure, axes = style.canvas(1, 3, 10.5, 3.3, sharey=True)
    figure.set_layout_engine("constrained", wspace=0.08)  # each panel's colour bar nearer to it than to the next
    names = {"ke_ratio": (LOW, 1, "viridis"), "M_over_M0": (0.1, 10, "cividis"), "V_over_V0": (0.1, 10, "cividis")}
    for ax, (name, (low, high, cmap)) in zip(axes[0], names.items(), strict=True):
        mesh = style.heat(ax, cells, OVER, name, low, high, cmap)
        style.bar(figure, mesh, ax, style.LABELS[name], "max" if name == "ke_ratio" else "neither")
    for ax in axes[0, 1:]:
        ax.set_ylabel("")
    style.letter(axes, ("lowest KE ratio", "its impactor mass", "its impact speed"))
    return Drawn(figure, cells, (_note(source, len(cells), int(cells["chaotic"].sum())),))


def _note(source: Source, cells: int, chaotic: int) -> str:
    return f"{len(source.table('fig8'))} rows used for {cells} cells, {chaotic} of them won by a chaotic row (hatched)"


RECIPE = Recipe("8", "best of the best: lowest ke_ratio and its impact", CAPTION, draw, tables=("fig8",))
