"""Below a picture there is room for all that its legend and its small print say."""

import pytest

from analysis.caption import below
from analysis.look import settings
from analysis.style import canvas

LONG = "what takes several lines of a narrow column, as an impact with its exponent and the interval of that does"


@pytest.mark.parametrize("long", [(0, 1, 2), (0,), (3, 4), (1, 3), ()])
@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a_legend_of_wrapped_labels_stays_between_the_axes_and_the_print(long, columns):
    """The columns of a legend are filled one after the other."""
    from matplotlib.lines import Line2D

    with settings():
        figure, axes = canvas(1, 1, 6.0, 6.0)
        axes[0, 0].set_xlabel("x")
        handles = [Line2D([], [], label=LONG if k in long else "short") for k in range(5)]
        below(figure, handles, ("ke_ratio",), columns=columns)
        figure.draw_without_rendering()
        legend = figure.legends[0].get_window_extent()
        assert figure.texts[0].get_window_extent().y1 <= legend.y0 + 1
        assert legend.y1 <= axes[0, 0].get_tightbbox().y0 + 1
