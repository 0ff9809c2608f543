"""Figure 7: why a slow impact has no transition."""

from analysis.paper.figures.fields import fields
from analysis.paper.recipe import Drawn, Recipe, Source

CAPTION = (
    "Kinetic energy of every site over the initial total energy in the bistable chain at zeta_T = 4e-4, colours "
    "cut at 1e-4: above (M/M0, V/V0) = (2, 1), below (2, 2); left N = 20, right N = 200. At (2, 1) the leading "
    "pulse stops in the coarse chain already, for want of energy; at (2, 2) it crosses the coarse chain and dies "
    "in the fine one."
)


def draw(source: Source) -> Drawn:
    """Slow impact above, fast one below."""
    seen = source.scenes("fig7")
    titles = [f"$V/V_0$ = {one.scene.event.V_over_V0:g}, $N$ = {one.scene.N}" for one in seen]  # type: ignore[union-attr]
    drawn = fields(seen, titles, columns=2)
    peak = seen[0]["peak_ke"]
    note = f"peak at the middle site of panel (a): KE/TE = {float(peak['ke']):.3g} at t/N = {float(peak['t']):.2f}"
    return Drawn(drawn.figure, drawn.numbers, (note,))


RECIPES = (Recipe("7", "space-time maps of a slow and a fast impact", CAPTION, draw),)
