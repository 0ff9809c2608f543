"""A map shows every number at its place and with its size, what is not known as not known, and says what it shows."""

import colorsys
import itertools
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from analysis.best import best, competing
from analysis.caption import MEANINGS
from analysis.draw import best_maps, plane_map
from analysis.look import Look
from analysis.notes import Notes, of_best, of_plane
from analysis.plane import plane
from analysis.ruler import ruler
from analysis.ticks import ticks
from sweep.errors import InputError

from .drawn import FOUR, colour_of, crowded, frame, hatched, legend, mesh, stars, written

GRID = ((5, 10, 40, 200), (0.0, 1e-4, 1e-3, 1e-2), (2.0,), (2.0,))


def drawn_plane(df, over=("N", "zeta_T"), at=None, **look):
    cells = plane(df, over, at)
    return plane_map(cells, over, of_plane(df, cells, over, at), Look(**look))


def drawn_best(df, **look):
    used = competing(df)
    cells = best(used, chaotic_too=True)
    impacts = {name: np.unique(used[name].to_numpy()) for name in ("M_over_M0", "V_over_V0")}
    return best_maps(cells, impacts, of_best(df, used, cells), Look(**look))


def test_the_colours_turn_at_1_and_values_above_it_differ():
    ax = drawn_plane(frame(GRID)).axes[0]
    assert mesh(ax).norm(1.0) == pytest.approx(0.5)
    below, above, far = (colour_of(ax, value) for value in (0.2, 2.0, 8.0))
    assert below[2] > below[0]  # blue
    assert above[0] > above[2]  # red
    assert np.abs(above - far).max() > 0.2


def test_no_colour_of_the_scale_is_a_grey():
    ax = drawn_plane(frame(GRID)).axes[0]
    saturation = [colorsys.rgb_to_hsv(*colour_of(ax, value)[:3])[1] for value in np.geomspace(0.05, 10, 101)]
    assert min(saturation) > 0.04


def test_cells_lie_at_their_values_and_zero_damping_apart():
    df = frame(((10, 32, 56, 91, 170, 1000), GRID[1], (2.0,), (2.0,)))
    ax = drawn_plane(df).axes[0]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    borders = mesh(ax).get_coordinates()
    np.testing.assert_allclose(borders[0, 1:-1, 0] ** 2, np.array([10, 32, 56, 91, 170]) * [32, 56, 91, 170, 1000])
    gap = mesh(ax).get_array()[1]
    assert np.ma.getmaskarray(gap).all()
    assert "0" in [text.get_text() for text in ax.get_yticklabels()]


def test_a_single_chaotic_cell_is_hatched_in_black_and_white_and_outlined_and_counted():
    df = frame(GRID)
    df.loc[5, "chaotic"] = True
    figure = drawn_plane(df)
    assert hatched(figure.axes[0]) == {(1.0, 1.0, 1.0, 1.0): 1, (0.0, 0.0, 0.0, 1.0): 1}
    from matplotlib.collections import LineCollection

    outlines = [one for one in figure.axes[0].collections if isinstance(one, LineCollection)]
    assert [len(one.get_segments()) for one in outlines] == [4, 4]
    assert "1 of 16 cells, chaotic: sensitive to their inputs" in legend(figure)


def test_best_says_how_many_rows_were_left_out_and_how_many_cells_have_none_else():
    df = frame((GRID[0], GRID[1], (1.0, 2.0), (2.0,)))
    df.loc[(df["N"] == 5) & (df["zeta_T"] == 0), "chaotic"] = True
    df.loc[(df["N"] == 10) & (df["M_over_M0"] == 1), "chaotic"] = True
    figure = drawn_best(df)
    assert "1 cell with chaotic rows only" in legend(figure)
    assert "6 of 32 rows are chaotic (sensitive to their inputs) and 4 of these left out." in written(figure)
    df.loc[(df["N"] == 5) & (df["zeta_T"] == 0), "chaotic"] = False
    assert "4 of 32 rows are chaotic (sensitive to their inputs) and left out." in written(drawn_best(df))


def test_a_table_that_was_not_checked_says_so_beside_the_scale_and_tells_of_no_chaos():
    df = frame(GRID, chaotic=pd.NA, checked=False, error=np.nan)
    for figure in (drawn_plane(df), drawn_best(df)):
        assert any(ax.get_ylabel() == "not checked for chaos" for ax in figure.findobj(type(figure.axes[0])))
        assert not any("chaotic" in text for text in legend(figure))
        assert any("error not estimated, not checked for chaos" in text for text in legend(figure))


def test_cells_without_a_number_say_whether_they_failed_or_are_to_come():
    df = frame(GRID)
    df.loc[[0, 1], ["status", "ke_ratio"]] = ["pending", np.nan]
    df.loc[2, ["status", "ke_ratio"]] = ["not_finite", np.nan]
    df.loc[3, "ke_ratio"] = np.nan
    told = legend(drawn_plane(df))
    assert {"not computed: 2 cells", "failed: 1 cell", "no number: 1 cell"} <= set(told)


@given(st.sets(st.integers(0, 15), min_size=1, max_size=15), st.sampled_from(["pending", "unasked", "torn"]))
@example({12, 13, 14, 15}, "unasked")  # all of N = 200
@settings(max_examples=10)
def test_the_grid_is_the_sweeps_whatever_has_been_computed_of_it(missing, status):
    df = frame(GRID)
    df.loc[list(missing), ["status", "ke_ratio"]] = [status, np.nan]
    for figure in (drawn_plane(df), drawn_best(df)):
        assert f"not computed: {len(missing)} cell{'s' * (len(missing) > 1)}" in legend(figure)
        assert mesh(figure.axes[0]).get_array().shape == (5, 4)  # with the gap


def test_the_lowest_is_marked_where_it_is_and_told_with_its_error():
    df = frame(GRID)
    df.loc[(df["N"] == 200) & (df["zeta_T"] == 1e-3), "ke_ratio"] = 0.01
    df.loc[(df["N"] == 10) & (df["zeta_T"] == 1e-3), ["ke_ratio", "chaotic"]] = [0.001, True]
    for figure in (drawn_plane(df), drawn_best(df)):
        assert stars(figure.axes[0]) == [(200.0, 1e-3)]
        assert any(text.startswith("lowest: 0.01 at $N$ = 200") for text in legend(figure))
        assert any("estimated error 0.0001 relative" in text for text in legend(figure))


def test_best_draws_no_panel_of_an_impact_that_does_not_vary_and_tells_it_in_the_title():
    def titles(figure):
        return [ax.get_title(loc="left") for ax in figure.axes if ax.get_title(loc="left")]

    assert titles(drawn_best(frame(GRID))) == ["lowest KE ratio over all impacts\n$M/M_0$ = 2, $V/V_0$ = 2"]
    masses = titles(drawn_best(frame((GRID[0], GRID[1], (1.0, 2.0), (2.0,)))))
    assert [title.partition("\n")[0] for title in masses] == [
        "(a) lowest KE ratio over all impacts",
        "(b) its impactor mass $M/M_0$",
    ]
    assert masses[0].endswith("$V/V_0$ = 2")


def test_every_symbol_of_a_map_is_defined_below_it():
    text = written(drawn_plane(frame(GRID)))
    for name in ("ke_ratio", *FOUR):
        head = MEANINGS[name].partition(":")[0] + ":"
        assert head in text
    assert "over that in the same chain made linear" in text


SHAPES = [(1, 1), (1, 7), (7, 1), (2, 2), (6, 3), (8, 3), (3, 20), (20, 3)]


@pytest.mark.slow
@pytest.mark.parametrize("impacts", [1, 3])
@pytest.mark.parametrize(("across", "up"), SHAPES)
def test_no_text_of_a_map_of_any_shape_is_cut_off_or_runs_into_another(across, up, impacts):
    impact = tuple(0.5 * 2.0 ** np.arange(impacts))
    df = frame((5 + 3 * np.arange(across), 1e-4 * 1.6 ** np.arange(up), impact, impact))
    df = df.assign(ke_ratio=np.geomspace(0.04, 3, len(df)))
    df.loc[0, "chaotic"] = True
    for figure in (drawn_plane(df, at={"M_over_M0": 0.5, "V_over_V0": 0.5}), drawn_best(df)):
        assert crowded(figure) == []
        for ax in figure.axes:
            box = ax.get_window_extent()
            assert min(box.width, box.height) > 1.5 * figure.dpi
            assert {ax.get_xlabel(), figure.axes[0].get_ylabel()} == {
                "number of unit cells $N$",
                r"bulk damping ratio $\zeta_T$",
            }


@pytest.mark.parametrize("impacts", [1, 3])
def test_long_small_print_leaves_a_map_its_size(impacts):
    impact = tuple(0.5 * 2.0 ** np.arange(impacts))
    df = frame(((5, 10, 20), (1e-4, 1e-3, 1e-2), impact, impact))
    sides = []
    for words in ("", "what else there is to say of it. " * 30):
        cells = best(competing(df), chaotic_too=True)
        impacts_of = {name: np.unique(df[name].to_numpy()) for name in ("M_over_M0", "V_over_V0")}
        figure = best_maps(cells, impacts_of, replace(of_best(df, df, cells), said=words))
        assert crowded(figure) == []
        sides.append(figure.axes[0].get_window_extent().height / figure.dpi)
    assert sides[0] == pytest.approx(sides[1], abs=0.02)


def test_a_title_that_is_longer_than_its_map_is_wide_takes_two_lines():
    df = frame(((5, 10), (1e-4, 1e-3), (1.0, 2.0), (1.0, 2.0)))
    cells, notes = best(df), of_best(df, df, best(df))
    long = replace(notes, of=replace(notes.of, title="KE ratio (the worst within 10 % of mass and 20 % of speed)"))
    assert crowded(best_maps(cells, {"M_over_M0": np.array([1, 2.0]), "V_over_V0": np.array([1, 2.0])}, long)) == []


def test_the_star_of_a_corner_cell_is_whole_and_dots_are_seen_on_small_cells_and_large():
    sizes = []
    for count in (4, 25, 100):
        df = frame((5 + np.arange(count), 1e-4 * 1.1 ** np.arange(count), (2.0,), (2.0,)))
        df = df.assign(inferred=np.arange(len(df)) % 7 > 0)
        figure = plane_map(df, ("N", "zeta_T"), of_plane(df, df, ("N", "zeta_T")))
        star, dots = (
            next(one for one in figure.axes[0].get_lines() if one.get_marker() == marker) for marker in ("*", "o")
        )
        assert not star.get_clip_on()
        sizes.append(dots.get_markersize() / 72 * Look().dpi)
        assert dots.get_markersize() / 72 < figure.axes[0].get_window_extent().width / figure.dpi / count
    assert min(sizes) > 4  # pixels
    assert sizes[0] > sizes[2]


@pytest.mark.parametrize("grid", [GRID, ((200,), (4e-4,), (2.0,), (2.0,)), ((5, 10, 20), (0.0,), (2.0,), (2.0,))])
def test_nothing_reaches_beyond_the_picture(grid):
    df = frame(grid)
    df.loc[0, "chaotic"] = True
    for figure in (drawn_plane(df), drawn_best(df)):
        figure.draw_without_rendering()
        inside = figure.bbox.padded(2)
        for text in figure.texts + [text for one in figure.legends for text in one.get_texts()]:
            box = text.get_window_extent()
            assert inside.x0 <= box.x0 <= box.x1 <= inside.x1, text.get_text()
            assert inside.y0 <= box.y0 <= box.y1 <= inside.y1, text.get_text()


def test_titles_of_narrow_maps_do_not_run_into_each_other():
    figure = drawn_best(frame(((60, 100), (0.0, 4e-5), (1.0, 2.0), (1.0, 2.0))))
    figure.draw_without_rendering()
    boxes = [ax._left_title.get_window_extent() for ax in figure.axes if ax.get_title(loc="left")]
    assert len(boxes) == 3
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


def test_a_map_has_as_many_numbers_as_its_side_has_room_for_once_it_is_laid_out():
    N = np.geomspace(5, 500, 8).astype(int)
    ax = drawn_plane(frame((tuple(N), tuple(np.geomspace(1e-5, 1e-2, 3)), (2.0,), (2.0,)))).axes[0]
    side = ax.get_window_extent().width / ax.figure.dpi
    assert [text.get_text() for text in ax.get_xticklabels()] == list(ticks(ruler(N), side, across=True).labels)


def test_limits_colours_size_and_title_are_as_asked():
    figure = drawn_plane(frame(GRID), limits=(0.1, 1.0), cmap="cividis", size=(5.0, 6.0), title="Mine")
    assert tuple(figure.get_size_inches()) == (5.0, 6.0)
    assert figure.get_suptitle() == "Mine"
    assert mesh(figure.axes[0]).get_clim() == (0.1, 1.0)
    from matplotlib import colormaps

    np.testing.assert_allclose(colour_of(figure.axes[0], 0.1), colormaps["cividis"](0.0), atol=0.01)


def test_a_size_in_which_the_titles_of_panels_are_cut_or_meet_is_refused():
    cells = best(frame(((5, 20), (1e-4, 1e-2), (1.0, 2.0), (1.0, 2.0))))
    others = {name: np.array([1.0, 2.0]) for name in ("M_over_M0", "V_over_V0")}
    with pytest.raises(InputError, match=r"^--size: 4 x 3.5 inches are too small for this picture$"):
        best_maps(cells, others, Notes(), Look(size=(4, 3.5)))
    assert crowded(best_maps(cells, others, Notes(), Look(size=(9, 3.5)))) == []


def test_numbers_beside_a_colour_bar_are_plain():
    ratio = np.geomspace(20.175, 60, 16)
    figure = drawn_plane(frame(GRID).assign(ke_ratio=ratio))
    bar = figure.axes[0].child_axes[0]
    labels = [text.get_text() for text in bar.get_yticklabels(which="both")]
    assert labels
    assert all(set(text) <= set("0123456789.") for text in labels)


def test_a_value_beyond_all_floats_is_no_number():
    with pytest.raises(InputError, match=r"^at: must hold numbers, got M_over_M0 = 10+"):
        plane(frame(((5, 20), (1e-4, 1e-2), (1.0,), (1.0,))), at={"M_over_M0": 10**400})
