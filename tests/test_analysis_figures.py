"""Claims about the paper's figures, drawn from small tables and the shipped scene files."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import kernel
from analysis import InputError
from analysis.look import settings
from analysis.output import output, write
from analysis.paper import figures
from analysis.paper.draw_convention import convention_figure
from analysis.paper.figures import ALL, fig04, fig06, fig07, fig08, fig13, fig14
from analysis.paper.figures.fig10 import spectrum
from analysis.paper.figures.fig11 import foremost_peak
from analysis.paper.recipe import Source
from analysis.paper.scenes import Seen
from analysis.style import LABELS, OPEN
from analysis.table import IMPACT

from .drawn import frame, legend, stars, written
from .paper_source import JOBS, small_source

pytestmark = pytest.mark.slow
FROM_TABLES = ("1", "4", "5", "6", "8", "13", "14")  # the figures that are; the others are drawn from scenes


@pytest.fixture(scope="module")
def source():
    return small_source()


def test_the_fifteen_figures_are_those_of_the_paper():
    assert [recipe.number for recipe in ALL] == [*map(str, range(1, 15)), "A1"]


def test_every_file_of_a_figure_is_among_them():
    files = {path.stem for path in Path(figures.__file__).parent.glob("fig*.py")}
    assert files == {f"fig{name}" for name in figures.FILES}


@pytest.mark.parametrize("recipe", ALL, ids=lambda recipe: recipe.stem)
def test_a_figure_is_drawn_and_its_csv_holds_what_is_plotted(recipe, source, tmp_path):
    with settings():
        drawn = recipe.draw(source)
    write(output(tmp_path / f"{recipe.stem}.png", "paper"), drawn.figure, drawn.numbers)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"{recipe.stem}.paper.csv", f"{recipe.stem}.png"]
    back = pd.read_csv(tmp_path / f"{recipe.stem}.paper.csv")
    assert len(back) == len(drawn.numbers) > 0
    plotted = {float(y) for ax in drawn.figure.axes for line in ax.get_lines() for y in np.ravel(line.get_ydata())}
    for name in {"ke_ratio", "force", "total", "ke_bistable_N"} & set(back):
        if recipe.number in ("1", "6", "9", "12", "A1"):
            assert set(back[name].dropna()) & plotted


@pytest.mark.parametrize("recipe", [one for one in ALL if one.number in FROM_TABLES], ids=lambda recipe: recipe.stem)
def test_a_figure_without_its_table_says_which_is_missing(recipe, tmp_path):
    with pytest.raises(InputError, match=r"there is no table .*fig"):
        recipe.draw(Source(tmp_path, JOBS))


def test_maps_have_the_papers_axes_and_colours_about_1(source):
    by_number = {recipe.number: recipe for recipe in ALL}
    for number, limits in (("4", (0.1, 10)), ("5", (1e-2, 10)), ("8", (1e-3, 10))):
        ax = by_number[number].draw(source).figure.axes[0]
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
        assert ax.collections[0].get_clim() == limits
    field = by_number["2"].draw(source).figure.axes[0]
    assert field.collections[0].get_clim()[0] == 1e-4


def test_the_cell_of_a_site_reaches_half_way_to_its_neighbours(source):
    (recipe,) = [recipe for recipe in ALL if recipe.number == "2"]
    drawn = recipe.draw(source)
    borders = drawn.figure.axes[0].collections[0].get_coordinates()[0, :, 0]
    assert (borders[0], borders[-1]) == (0.5, drawn.numbers["N"].iloc[0] + 0.5)


@pytest.mark.parametrize("number", ["1", "4", "6", "13"])
def test_a_legend_tells_what_the_open_circles_are(source, number):
    (recipe,) = [recipe for recipe in ALL if recipe.number == number]
    assert OPEN in written(recipe.draw(source).figure)


FEW = ((5, 20, 80), (1e-4, 1e-2), (0.1, 1.0), (1.0, 10.0))


def only(**tables):
    return Source(Path("nowhere"), JOBS, _tables=tables)


def test_figure_4_has_curves_of_the_papers_chains_where_the_table_holds_them():
    df = frame(((5, 20, 50, 51, 100, 200, 500), (0.0, *fig04.ZETAS), (2.0,), (2.0,)))
    ax = fig04.RECIPES[0].draw(only(fig1=df, fig4=df)).figure.axes[2]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["5", "20", "50", "100", "200", "500", OPEN]


def test_figure_6_has_a_curve_of_every_impact_beside_the_power_laws(source):
    ratios, _ = fig06.RECIPES[0].draw(source).figure.axes
    impacts = {f"({M:g}, {V:g})" for M, V in fig06.COLOURS}
    assert {text.get_text() for text in ratios.get_legend().get_texts()} == {*impacts, OPEN}


def test_figure_7_tells_the_peak_of_its_first_panel(source):
    first = source.scenes("fig7")[0]
    assert (first.scene.N, first.scene.event.V_over_V0) == (20, 1.0)
    (note,) = fig07.RECIPES[0].draw(source).notes
    assert f"KE/TE = {float(first['peak_ke']['ke']):.3g} at t/N" in note


def test_figure_8_marks_the_lowest_that_is_not_chaotic_and_counts_what_chaos_has_won():
    df = frame(FEW)
    lowest = df.index[(df["N"] == 5) & (df["zeta_T"] == 1e-4) & (df["V_over_V0"] == 1)]
    df.loc[lowest, ["ke_ratio", "chaotic"]] = [1e-3, True]
    df.loc[(df["N"] == 20) & (df["zeta_T"] == 1e-2), "ke_ratio"] = 2e-3
    drawn = fig08.RECIPES[0].draw(only(fig8=df))
    assert [stars(ax) for ax in drawn.figure.axes[:3]] == [[(20.0, 1e-2)]] * 3
    assert [bar.get_ylabel() for bar in drawn.figure.axes[3:]] == [LABELS[name] for name in ("ke_ratio", *IMPACT)]
    assert drawn.notes == ("24 rows used, 2 of them chaotic (competing); 1 of 6 cells won by a chaotic row (hatched)",)


def test_figure_8_counts_no_chaos_where_nobody_looked():
    df = frame(FEW, chaotic=pd.NA, checked=False, error=np.nan)
    assert fig08.RECIPES[0].draw(only(fig8=df)).notes == ("24 rows used, not checked for chaos",)


def test_figure_14_says_of_what_is_left_out_that_it_is_not_used():
    wide = ((5, 8, 13, 20, 40, 80), (1e-5, 1e-4, 1e-3, 1e-2), (2.0,), (2.0,))
    df = frame(wide)
    df.loc[:1, "chaotic"] = True
    notes = fig14.RECIPES[0].draw(only(fig4=df, fig8=df)).notes
    assert [note.partition(";")[0] for note in notes] == ["(a) 22 of 24 cells", "(b) 22 of 24 cells"]
    assert all("left out: 0 failed, 2 chaotic, 0 without damping" in note for note in notes)


def test_the_dots_of_figure_13_are_drawn_in_an_order_that_hides_no_N():
    df = frame(((20, 50, 100, 200), (0.0, 4e-5), tuple(np.geomspace(0.1, 10, 9)), tuple(np.geomspace(0.1, 10, 9))))
    colours = [fig13.RECIPES[0].draw(only(fig5=df)).figure.axes[0].collections[0].get_edgecolors() for _ in range(2)]
    np.testing.assert_array_equal(*colours)
    changes = (np.diff(colours[0], axis=0) != 0).any(axis=1).mean()
    assert 0.6 < changes < 0.9  # of neighbours three in four differ by chance; drawn N by N, one in a hundred


def test_the_grey_band_of_the_conventions_is_in_the_legend():
    columns = {
        "family": ["a", "b", "c", "d", "e", "f"] * 2,
        "factor": [0.5] * 6 + [2.0] * 6,
        "key": "fig. 8",
        "paper": 0.1,
    }
    scanned = pd.DataFrame(columns).assign(low=0.08, middle=0.1, high=0.2)
    figure = convention_figure(scanned)
    assert "agreement within 10%" in legend(figure)
    (band,) = figure.axes[0].patches
    assert [band.get_y(), band.get_y() + band.get_height()] == pytest.approx([0.9, 1.1])
    assert "tasks that the paper would print alike" in written(figure)


def test_the_spectrum_of_a_travelling_wave_is_one_peak_at_its_frequency_and_wave_number():
    N, times = 64, 512
    scene = kernel.Scene(N, 1e-3, kernel.Impact(1, 1), observe={"viscous_force": {"times": times}})
    t = np.linspace(0, 2.25, times)
    k, omega = 2 * np.pi * 8 / N, 2 * np.pi * 30 / (times * (t[1] * N))
    force = np.cos(k * np.arange(N) - omega * t[:, None] * N)
    found = kernel.Simulation(
        "done", "rk45", 0, 0, {"viscous_force": {"t": t, "force": force, "link": np.arange(1, N + 1)}}
    )
    waves, frequencies, amplitude = spectrum(Seen(scene, found))
    row, column = np.unravel_index(amplitude.argmax(), amplitude.shape)
    assert frequencies[row] == pytest.approx(omega * N)
    assert waves[column] == pytest.approx(-k * N)  # drawn to the right, since it travels to the right


def test_the_foremost_peak_is_the_last_high_one():
    assert foremost_peak(np.array([0, 1.0, 0, 0, 0.9, 0, 0.1, 0])) == 4
