"""Pictures of transitions and collapses hide no row, define what they name, and stay readable on large tables."""

import itertools
import warnings

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_hex

from analysis.collapse import NUMBERS, collapse, with_numbers
from analysis.draw_collapse import collapse_figure, under
from analysis.draw_level import level_figure
from analysis.draw_transition import LEGEND_MAX, exponent, transition_figure
from analysis.level import crossings
from analysis.look import COLOURS, MARKERS, Look
from analysis.power_law import power_laws
from analysis.transition import transition

from .drawn import assert_nested, crowded, frame, legend, written

N = np.unique(np.geomspace(5, 500, 24).astype(int))
ZETAS = (1e-4, 3e-4, 1e-3, 3e-3)


def falling(impacts, error=1e-3, chaotic=0):
    """Transitions at 0.7 zeta_T^-0.5, the same for every impact: their markers coincide."""
    parts = []
    for M, V in impacts:
        df = frame((N, ZETAS, (M,), (V,)), error=error)
        middle = 0.7 * df["zeta_T"] ** -0.5
        parts.append(df.assign(ke_ratio=0.1 + 2 / (1 + (df["N"] / middle) ** 8)))
    df = pd.concat(parts, ignore_index=True)
    df.loc[: chaotic - 1, "chaotic"] = True
    return df


def random_rows(n=400, undamped=0):
    rng = np.random.default_rng(2)
    df = pd.DataFrame(
        {
            "N": np.sort(rng.integers(5, 500, n)),
            "zeta_T": 10 ** rng.uniform(-5, -1, n),
            "M_over_M0": 10 ** rng.uniform(-1, 1, n),
            "V_over_V0": 10 ** rng.uniform(-1, 1, n),
        }
    )
    df.loc[: undamped - 1, "zeta_T"] = 0.0
    ratio = 0.05 * with_numbers(df)["Pi_IE"] ** -0.4 * 10 ** rng.uniform(0, 1, n)
    return df.assign(ke_ratio=ratio, chaotic=False, checked=True, error=1e-3, status="done")


def markers(figure):
    """x of every marker with an error bar, by container."""
    return [container.lines[0].get_xdata() for container in figure.axes[0].containers]


def test_markers_of_impacts_with_the_same_transitions_do_not_hide_each_other():
    figure = transition_figure(transition(falling([(2, 2), (2, 4), (1, 2)])))
    places = np.array(markers(figure))
    assert places.shape == (3, len(ZETAS))
    assert all((column == ZETAS).all() for column in places)  # a reader reads their own zeta_T off the axis
    assert_nested(figure.axes[0])
    assert "Marks within each other" in written(figure)


def test_a_fit_is_drawn_through_the_transitions_that_it_is_fitted_to():
    figure = transition_figure(transition(falling([(2, 2), (2, 4), (1, 2), (1, 4)])))
    laws = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "--" and len(line.get_xdata())]
    assert len(laws) == 4
    for law, container in zip(laws, figure.axes[0].containers, strict=True):
        x, y = np.log(container.lines[0].get_xydata().astype(float)).T
        off = np.interp(x, *np.log(law.get_xydata()).T) - y
        assert abs(off).max() < 0.1  # of the scatter on this grid of N; a shift of 20 % in zeta_T alone makes 0.1
        assert {x[0], x[-1]} == set(np.log(law.get_xdata()))


def test_the_markers_of_many_impacts_stay_within_a_quarter_of_the_way_to_the_next_zeta_T():
    figure = transition_figure(transition(falling([(M, 2.0) for M in np.linspace(1, 2, LEGEND_MAX + 3)])))
    logs = np.log(np.array(markers(figure), float) / ZETAS)
    assert abs(logs).max() < 0.25 * np.diff(np.log(ZETAS)).min()
    grey = [line.get_xdata()[0] for line in figure.axes[0].get_lines() if line.get_color() == "0.85"]
    assert grey == list(ZETAS)
    assert r"stand side by side about it (grey lines)" in written(figure)


def test_a_picture_without_a_transition_says_so_and_has_the_axes_of_its_table():
    df = frame((N, ZETAS, (2.0,), (2.0,))).assign(ke_ratio=0.5)
    figure = transition_figure(transition(df), within=(5, 500))
    ax = figure.axes[0]
    assert [text.get_text() for text in ax.texts] == ["No transition: never above 1 on 4 lines."]
    assert ax.get_xlim() == pytest.approx((ZETAS[0], ZETAS[-1]), rel=0.3)
    assert ax.get_ylim() == pytest.approx((5, 500), rel=0.3)
    assert ax.get_xlim()[0] < ZETAS[0] < ZETAS[-1] < ax.get_xlim()[1]
    assert "Bars:" not in written(figure)
    assert crowded(figure) == []


def test_lines_without_a_transition_are_counted_below_the_others():
    df = pd.concat([falling([(2, 2)]), frame((N, ZETAS, (1.0,), (2.0,))).assign(ke_ratio=0.5)])
    figure = transition_figure(transition(df.reset_index(drop=True)))
    assert "No transition: never above 1 on 4 lines." in written(figure)
    assert not figure.axes[0].texts


@pytest.mark.parametrize("drawn", [0, 1, LEGEND_MAX + 1])
def test_transitions_at_zeta_T_0_are_counted_and_not_drawn(drawn):
    """Of so many impacts that have one at another zeta_T, and of one that has none."""
    found = transition(falling([(M, 2.0) for M in np.linspace(1, 2, drawn + 1)]))
    first = found["zeta_T"] == ZETAS[0]
    none = ~first & (found["M_over_M0"] == found["M_over_M0"].max())
    found.loc[none, ["N_transition", "N_low", "N_high", "why_not"]] = [np.nan] * 3 + ["never above 1"]
    figure = transition_figure(found.assign(zeta_T=found["zeta_T"].where(~first, 0.0)), within=(5, 500))
    assert len(markers(figure)) == drawn
    are = "transitions at $\\zeta_T$ = 0 are" if drawn else "transition at $\\zeta_T$ = 0 is"
    assert f"No transition: never above 1 on 3 lines. {drawn + 1} {are} not drawn." in written(figure)


@pytest.mark.parametrize("zetas", [(1e-3,), (1e-3, 1.2e-3), (2e-4, 1e-3, 5e-3)])
def test_a_short_axis_of_zeta_T_is_labelled_with_its_values_alone(zetas):
    found = transition(falling([(M, 2.0) for M in np.linspace(1, 2, LEGEND_MAX + 3)]))
    rows = found[found["zeta_T"].isin(ZETAS[: len(zetas)])]
    figure = transition_figure(rows.assign(zeta_T=rows["zeta_T"].map(dict(zip(ZETAS, zetas, strict=False)))))
    axis = figure.axes[0].xaxis
    assert (axis.get_majorticklocs().tolist(), axis.get_minorticklocs().tolist()) == (list(zetas), [])
    assert crowded(figure) == []


def test_what_is_dashed_is_explained_where_something_is():
    found = transition(falling([(2, 2), (1, 2)]))
    assert "Legend: $(M/M_0, V/V_0)$. Dashed: $A" in written(transition_figure(found))
    few = written(transition_figure(found[found["zeta_T"].isin(ZETAS[:3])]))
    assert "Legend: $(M/M_0, V/V_0)$." in few
    assert "Dashed" not in few


@pytest.mark.parametrize("zeta_T", [0.1, 1e-4])
def test_a_picture_without_a_transition_at_one_zeta_T_is_labelled_with_it_alone(zeta_T):
    found = transition(falling([(2, 10)]).assign(ke_ratio=0.5))
    figure = transition_figure(found[:1].assign(zeta_T=zeta_T), Look(size=(4, 3.5)), within=(5, 500))
    axis = figure.axes[0].xaxis
    assert (axis.get_majorticklocs().tolist(), axis.get_minorticklocs().tolist()) == ([zeta_T], [])
    assert crowded(figure) == []


@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 12, 16, 20])
def test_markers_of_many_impacts_do_not_touch(count):
    figure = transition_figure(transition(falling([(M, 2.0) for M in np.linspace(1, 2, count)])))
    figure.draw_without_rendering()
    ax = figure.axes[0]
    drawn = [container.lines[0] for container in ax.containers]
    points = [ax.transData.transform(one.get_xydata())[0, 0] * 72 / figure.dpi for one in drawn]
    assert np.diff(points).min() > max(one.get_markersize() for one in drawn)


def test_markers_of_many_impacts_are_as_large_as_the_legends_where_there_is_room():
    """Few of them lie at one N, and those at others do not stand in their way."""
    impacts = [(M, V) for M in (0.5, 1.0, 2.0) for V in np.geomspace(1, 10, 8)]
    found = transition(falling(impacts)).assign(N_low=lambda rows: rows["N_low"] * rows["V_over_V0"])
    found = found.assign(N_transition=found["N_transition"] * found["V_over_V0"] * found["M_over_M0"] ** 0.1)
    found = found.assign(N_high=found["N_transition"] * 1.1)
    figure = transition_figure(found)
    figure.draw_without_rendering()
    ax = figure.axes[0]
    drawn = [container.lines[0] for container in ax.containers]
    assert len(drawn) == len(impacts)
    (size,) = {one.get_markersize() for one in drawn}
    assert size >= 4
    places = np.concatenate([ax.transData.transform(one.get_xydata()) for one in drawn]) * 72 / figure.dpi
    apart = np.abs(places[:, None] - places).max(axis=2) + 1e9 * np.eye(len(places))
    assert apart.min() > size


def test_the_law_is_drawn_as_far_as_it_is_fitted_and_the_picture_says_how_far():
    found = transition(falling([(2, 2)]))
    beyond = found.iloc[-1:].assign(zeta_T=[0.1])
    figure = transition_figure(pd.concat([found, beyond]))
    (dashed,) = [line for line in figure.axes[0].get_lines() if line.get_linestyle() == "--" and len(line.get_xdata())]
    np.testing.assert_allclose(dashed.get_xdata(), [ZETAS[0], ZETAS[-1]])
    assert r"through the transitions up to $\zeta_T$ = 0.01" in written(figure)


def test_the_mass_is_explained_where_it_is_shown():
    for masses, shown in ((len(MARKERS), True), (len(MARKERS) + 1, False)):
        figure = transition_figure(transition(falling([(M, 2.0) for M in np.linspace(1, 2, masses)])))
        assert ("$M/M_0$" in written(figure)) is shown


@pytest.mark.parametrize(("masses", "speeds"), [(LEGEND_MAX, 1), (1, LEGEND_MAX + 1), (4, 4), (len(MARKERS), 3)])
def test_no_two_impacts_share_both_colour_and_marker(masses, speeds):
    impacts = list(itertools.product(np.linspace(1, 2, masses), np.linspace(1, 2, speeds)))
    figure = transition_figure(transition(falling(impacts)))
    drawn = [container.lines[0] for container in figure.axes[0].containers]
    assert len({(to_hex(one.get_color()), one.get_marker()) for one in drawn}) == masses * speeds
    if len(impacts) <= LEGEND_MAX:
        assert [one.get_color() for one in drawn] == list(COLOURS)


@pytest.mark.slow
def test_many_impacts_are_told_by_a_scale_and_no_warning_is_given():
    impacts = [(M, V) for M in np.geomspace(0.1, 10, 12) for V in np.geomspace(1, 10, 12)]
    found = transition(falling(impacts))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = transition_figure(found)
    assert len(markers(figure)) == 144
    assert len(legend(figure)) <= 8
    assert figure.axes[1].get_ylabel() == "$V/V_0$"
    assert max(figure.get_size_inches()) < 8
    box = figure.axes[0].get_position()
    assert box.width * box.height > 0.4


def test_transitions_from_which_several_chaotic_rows_were_left_out_have_a_power_law():
    found = transition(falling([(2, 2)], chaotic=5))
    assert found["chaotic"].max() > 1
    assert len(power_laws(found)) == 3
    assert any("$b$ = 0.5" in text for text in legend(transition_figure(found)))


def test_every_symbol_of_the_transition_is_defined():
    text = written(transition_figure(transition(falling([(2, 2)]))))
    assert r"$N_\mathrm{transition}$: where the KE ratio falls most steeply" in text
    assert r"$A\,\zeta_T^{-b}$ by weighted least squares" in text
    assert "KE ratio: largest kinetic energy" in text


def test_transitions_of_unchecked_rows_say_so():
    df = falling([(2, 2)])
    assert "checked for chaos" not in written(transition_figure(transition(df)))
    df.loc[:2, "checked"] = False
    assert "3 not checked for chaos." in written(transition_figure(transition(df)))
    none = df.assign(chaotic=pd.NA, checked=False)
    assert "Not checked for chaos." in written(transition_figure(transition(none)))


@pytest.mark.parametrize(("b", "text"), [(-0.0001, "0.000"), (0.0, "0.000"), (-0.0006, "-0.001"), (0.5, "0.500")])
def test_a_zero_has_no_sign(b, text):
    assert exponent(b) == text


def test_dots_are_drawn_in_an_order_that_hides_no_colour_and_is_always_the_same():
    found = collapse(random_rows(), "Pi_IE")
    drawn = [collapse_figure(found, "N").axes[0].collections[0].get_offsets() for _ in range(2)]
    np.testing.assert_array_equal(*drawn)
    order = pd.Series(found.rows["N"].to_numpy(), index=found.rows["ke_ratio"].to_numpy()).loc[drawn[0][:, 1]]
    assert abs(np.corrcoef(order, np.arange(len(order)))[0, 1]) < 0.2
    assert len(order) == 400


def test_rows_without_damping_are_dots_too_where_damping_is_the_colour():
    found = collapse(random_rows(undamped=50), "Pi_IE")
    figure = collapse_figure(found, "zeta_T")
    assert len(figure.axes[0].collections[0].get_offsets()) == 400
    assert r"$\zeta_T$ = 0" in legend(figure)


def test_what_lies_under_the_power_law_is_counted():
    found = collapse(random_rows(2000), "Pi_IE")
    front = found.front
    x, y = found.rows["Pi_IE"].to_numpy(), found.rows["ke_ratio"].to_numpy()
    there = (x >= min(front.start, front.end)) & (x <= max(front.start, front.end))
    lower = there & (y < front.A * x**front.s)
    assert lower.any()
    assert under(found, front).startswith(f"{lower.sum()} of the {there.sum()} rows that it spans lie below, by up to")
    assert any(under(found, front) in text for text in legend(collapse_figure(found, "N")))


def test_a_cloud_without_a_falling_edge_has_no_line_and_says_so():
    found = collapse(random_rows().assign(ke_ratio=0.5), "Pi_IE")
    figure = collapse_figure(found, "N")
    assert legend(figure) == []
    assert "No falling lower edge." in written(figure)


def test_the_dimensionless_numbers_are_names_and_no_subtractions():
    assert all("-" not in text for text in [number.axis for number in NUMBERS.values()])
    text = written(collapse_figure(collapse(random_rows(), "Pi_IV"), "N"))
    assert r"$\Pi_\mathrm{IV}$: momentum of the impact over the viscous one" in text
    assert "Scatter about the running median" in text


def test_only_symbols_that_stand_on_the_picture_are_explained():
    text = written(collapse_figure(collapse(random_rows(), "Pi_IE"), "M_over_M0"))
    assert "impactor mass over nominal" in text
    assert "number of unit cells" not in text
    assert "bulk damping ratio" not in text
    text = written(collapse_figure(collapse(random_rows(), "Pi_IV"), "V_over_V0"))
    assert "bulk damping ratio" in text
    assert "number of unit cells" not in text


def test_a_collapse_of_unchecked_rows_says_so_and_counts_no_chaos():
    df = random_rows().assign(chaotic=pd.NA, checked=False, error=np.nan)
    text = written(collapse_figure(collapse(df, "Pi_IE"), "N"))
    assert "Not checked for chaos." in text
    assert "0 chaotic" not in text


@pytest.mark.parametrize("limits", [(2.0, 300.0), (0.02, 300.0), (20.0, 30.0)])
def test_an_axis_is_labelled_along_all_of_the_limits_that_were_asked_for(limits):
    df, look = falling([(2, 10)]), Look(limits=limits)
    near = df[df["N"].between(20, 60)]  # whose own range is too short for decades
    pictures = (
        transition_figure(transition(df), look),
        collapse_figure(collapse(near), "N", look),
        level_figure(crossings(near, 1.0), "N", "zeta_T", [], look=look),
    )
    for figure in pictures:
        ax = figure.axes[0]
        assert ax.get_ylim() == limits
        seen = [tick for tick in ax.yaxis.get_majorticklocs() if limits[0] <= tick <= limits[1]]
        places = np.log10([limits[0], *seen, limits[1]])
        assert np.diff(places).max() <= 1.0
        assert 2 <= len(seen) <= 8


def test_a_single_value_of_the_colour_has_no_scale_but_is_named():
    df = random_rows()
    assert len(collapse_figure(collapse(df), "N").axes) == 2
    figure = collapse_figure(collapse(df.assign(zeta_T=1e-2)), "zeta_T")
    assert len(figure.axes) == 1
    assert legend(figure)[0] == r"$\zeta_T$ = 0.01"
    masses = [(M, 2.0) for M in np.geomspace(0.5, 4, LEGEND_MAX + 1)]
    figure = transition_figure(transition(falling(masses)))
    assert len(figure.axes) == 1
    assert legend(figure)[-1] == "$V/V_0$ = 2"
