"""Claims about the paper's figures, drawn from small tables and the shipped scene files."""

import numpy as np
import pandas as pd
import pytest

import kernel
from analysis import InputError
from analysis.draw_convention import convention_figure
from analysis.figures import ALL, Source
from analysis.figures.fig10 import spectrum
from analysis.figures.fig11 import foremost_peak
from analysis.look import settings
from analysis.output import output, write
from analysis.scenes import Seen
from analysis.style import OPEN

from .drawn import legend, written
from .paper_source import JOBS, small_source


@pytest.fixture(scope="module")
def source():
    return small_source()


def test_the_fifteen_figures_are_those_of_the_paper():
    assert [recipe.number for recipe in ALL] == [*map(str, range(1, 15)), "A1"]


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


@pytest.mark.parametrize("recipe", [recipe for recipe in ALL if recipe.tables], ids=lambda recipe: recipe.stem)
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


@pytest.mark.parametrize("number", ["1", "4", "6", "13"])
def test_a_legend_tells_what_the_open_circles_are(source, number):
    (recipe,) = [recipe for recipe in ALL if recipe.number == number]
    assert OPEN in written(recipe.draw(source).figure)


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
    assert "tasks that the paper would print alike" in written(figure)


def test_the_spectrum_of_a_travelling_wave_is_one_peak_at_its_frequency_and_wave_number():
    N, times = 64, 512
    scene = kernel.Scene(N, 1e-3, kernel.Impact(1, 1), observe={"viscous_force": {"times": times}})
    t = np.linspace(0, 2.25, times)
    k, omega = 2 * np.pi * 8 / N, 2 * np.pi * 30 / (times * (t[1] * N))
    force = np.cos(k * np.arange(N) - omega * t[:, None] * N)
    found = kernel.Simulation("done", 0, 0, {"viscous_force": {"t": t, "force": force, "link": np.arange(1, N + 1)}})
    waves, frequencies, amplitude = spectrum(Seen(scene, found))
    row, column = np.unravel_index(amplitude.argmax(), amplitude.shape)
    assert frequencies[row] == pytest.approx(omega * N)
    assert waves[column] == pytest.approx(-k * N)  # drawn to the right, since it travels to the right


def test_the_foremost_peak_is_the_last_high_one():
    assert foremost_peak(np.array([0, 1.0, 0, 0, 0.9, 0, 0.1, 0])) == 4
