"""Claims about the open questions: each rule on made-up tables whose answer is known, and the page."""

import math

import numpy as np
import pandas as pd
import pytest

import kernel
from analysis import InputError
from analysis.outlook.disorder import losses, survival
from analysis.outlook.draws import share_of
from analysis.outlook.laws import C2, C3, FAMILIES, family, possible, with_numbers
from analysis.outlook.merits import MERITS, held, in_place, misled
from analysis.outlook.optima import falls, optima
from analysis.outlook.part import interval
from analysis.outlook.predict import judged
from analysis.outlook.questions.lattice import answer
from analysis.outlook.thresholds import alike, known, thresholds

from .outlook_source import (
    LAWS,
    with_disorder,
    with_merits,
    with_optimum,
    with_threshold,
)


def test_the_exponent_and_the_prefactor_of_a_made_up_table_are_found_within_their_intervals():
    found = thresholds(with_threshold(b=0.4, laws=[(5.0, 6.0), (5.0, 5.0)], speeds=[2.0]))
    assert len(found) == len(known(found)) == 2
    assert (found["b_low"] < 0.4).all()
    assert (found["b_high"] > 0.4).all()
    assert found["b"].to_numpy() == pytest.approx([0.4, 0.4], abs=0.03)
    assert found["N_middle"].to_numpy() == pytest.approx([50, 50], rel=0.05)
    assert ((found["N_middle_low"] < found["N_middle"]) & (found["N_middle"] < found["N_middle_high"])).all()
    assert (found["N_middle_high"] < 1.1 * found["N_middle_low"]).all()  # the table is without noise


def test_chaotic_rows_are_left_out_of_the_threshold_and_counted():
    table = with_threshold(laws=[(5.0, 6.0)], speeds=[2.0])
    wild = table.index[::7]
    table.loc[wild, "ke_ratio"] = 100.0
    table.loc[wild, "chaotic"] = True
    (found,) = thresholds(table).to_dict("records")
    assert found["chaotic"] == len(wild)
    assert found["b"] == pytest.approx(0.5, abs=0.02)


def test_a_law_with_a_transition_at_some_zeta_t_has_its_exponent_from_these_and_says_why_not_at_others():
    table = with_threshold(laws=[(5.0, 6.0)], speeds=[2.0])
    low = table["zeta_T"] <= sorted(table["zeta_T"].unique())[1]
    (found,) = thresholds(table.assign(ke_ratio=table["ke_ratio"].mask(low, 0.5))).to_dict("records")
    assert (found["lines"], found["transitions"], found["why_not"]) == (6, 4, "never above 1")
    assert found["rows"] == len(table)
    assert found["b"] == pytest.approx(0.5, abs=0.05)


def test_a_law_without_a_transition_has_no_exponent_and_says_why():
    table = with_threshold(laws=[(5.0, 6.0)], speeds=[2.0])
    (found,) = thresholds(table.assign(ke_ratio=0.5)).to_dict("records")
    assert np.isnan(found["b"])
    assert found["why_not"] == "never above 1"


def test_the_numbers_of_a_law_are_those_of_its_spring():
    spring = kernel.Bistable(5.0, 5.0)
    (found,) = with_numbers(pd.DataFrame({C2: [5.0], C3: [5.0]})).to_dict("records")
    assert found["barrier"] == pytest.approx(spring.energy_at(spring.barrier()))
    second = -found["snap strain"]
    assert second + spring.excess(second) == pytest.approx(0, abs=1e-12)
    assert found["depth"] == pytest.approx(found["barrier"] - spring.energy_at(second))
    pushes = [-(e + spring.excess(e)) for e in np.linspace(spring.barrier(), 0, 2001)]
    assert found["push"] == pytest.approx(max(pushes), rel=1e-5)


def test_a_law_without_a_second_state_has_no_barrier_and_stays_and_one_that_turns_inside_out_goes():
    laws = with_numbers(pd.DataFrame({C2: [4.0, 5.0, 7.0], C3: [6.0, 6.0, 4.0]}))
    assert laws["barrier"].isna().tolist() == [True, False, False]
    assert possible(laws)[C2].tolist() == [4.0, 5.0]
    assert [family(shape) for shape in (2.0, 3.5, 4.2, 5.0)] == list(FAMILIES)


def test_laws_of_one_shape_do_the_same_at_the_same_speed_over_strain():
    kept = []
    for q in (1.0, 1.15):
        model = kernel.Model(kernel.Bistable(5.0 * q, 6.0 * q**2))
        found = kernel.ke_ratio(12, 4e-3, 2.0, 2.0 / q, accuracy=1e-4, model=model)
        law = {C2: 5.0 * q, C3: 6.0 * q**2, "N": 12, "zeta_T": 4e-3, "M_over_M0": 2.0, "V_over_V0": 2.0 / q}
        kept.append(law | {"ke_ratio": found.ke_ratio, "chaotic": False})
    (pair,) = alike(pd.DataFrame(kept)).to_dict("records")
    assert pair["ke_ratio"] == pytest.approx(pair["ke_ratio_other"], rel=2e-3)
    assert pair["ke_ratio"] != 1


def test_a_number_that_predicts_is_found_and_one_that_does_not_is_refused():
    laws = pd.DataFrame({C2: np.linspace(4, 7, 12), C3: np.linspace(5, 9, 12)})
    rng = np.random.default_rng(1)
    laws = laws.assign(good=np.geomspace(1, 10, 12), bad=rng.uniform(1, 10, 12))
    laws = laws.assign(b=0.3 + 0.2 * np.log(laws["good"]))
    found = judged(laws, "b", {"bad": "", "good": ""})
    assert found["name"].tolist() == ["good", "bad"]
    assert found["verdict"].tolist() == ["predicts", "does not"]
    assert found["rank"][0] == pytest.approx(1)
    assert found["explained"][0] == pytest.approx(1)
    assert (found["low"] <= found["explained"]).all()


def test_a_power_of_a_number_predicts_as_well_and_in_any_unit():
    laws = pd.DataFrame({C2: np.linspace(4, 7, 12), C3: np.linspace(5, 9, 12), "good": np.geomspace(1, 10, 12)})
    laws["b"] = 0.3 + 0.2 * np.log(laws["good"]) + 0.02 * np.sin(np.arange(12))
    laws["power"], laws["rare"] = laws["good"] ** 0.1, [4.0, 3.0, 2.0, *[1.0] * 9]  # of which a draw may be alike
    found, in_another_unit = (judged(laws.assign(b=unit * laws["b"]), "b", {"good": ""}) for unit in (1.0, 1e-3))
    (power, rare) = judged(laws, "b", {"power": "", "rare": ""}).to_dict("records")
    told = ["rank", "rank_low", "rank_high", "explained", "low", "high"]
    for other in (in_another_unit.iloc[0], power):
        assert [other[name] for name in told] == pytest.approx(found.loc[0, told].to_list(), rel=1e-6)
    assert np.isfinite([rare[name] for name in told]).all()


@pytest.mark.parametrize("values", [[2.0], [2.0, 3.0]])
def test_a_number_of_fewer_values_than_a_curve_has_numbers_is_not_judged(values):
    """With the law left out that differs, all others are alike: a division by zero."""
    laws = pd.DataFrame({C2: np.linspace(4, 7, 12), C3: np.linspace(5, 9, 12), "b": np.linspace(0, 1, 12)})
    laws["few"] = [*values, *[1.0] * (12 - len(values))]
    assert judged(laws, "b", {"few": ""}).empty


def test_too_few_laws_judge_no_number():
    laws = pd.DataFrame({C2: [4.0, 5.0], C3: [5.0, 5.0], "b": [0.4, 0.5], "good": [1.0, 2.0]})
    assert judged(laws, "b", {"good": ""}).empty


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_what_is_the_same_in_every_law_is_predicted_by_no_number(rounding):
    laws = pd.DataFrame({C2: np.linspace(4, 7, 12), C3: np.linspace(5, 9, 12), "one": np.geomspace(1, 10, 12)})
    assert judged(laws.assign(b=0.5 + rounding * np.sin(np.arange(12))), "b", {"one": ""}).empty


def test_the_exponent_of_the_optimum_is_found_and_its_best_impact_too():
    points = optima(with_optimum(0.7))
    assert (points["N"] == 320).all()
    assert (points["M_over_M0"] == 0.1).all()
    found = falls(points)
    assert found["s"].to_numpy() == pytest.approx(np.full(len(LAWS), 0.7), abs=1e-6)
    assert found["rank"].to_numpy() == pytest.approx(np.full(len(LAWS), -1))
    assert found["at_middle"].std() < 1e-6  # as one number, Pi_IV c2, is all


def test_the_optimum_is_fitted_past_the_threshold_only():
    table = with_optimum(0.7, laws=[(5.0, 6.0)])
    table.loc[table["zeta_T"] < 2e-4, "ke_ratio"] = 0.5
    points = optima(table)
    assert points.loc[points["zeta_T"] < 2e-4, "branch"].tolist() == [False, False]
    assert falls(points)["s"][0] == pytest.approx(0.7, abs=1e-6)


def test_a_chaotic_row_is_no_optimum_even_where_a_chain_has_no_other():
    table = with_optimum(0.7)
    table.loc[table["N"] == 320, "chaotic"] = True
    table.loc[table[C2] == LAWS[0][0], "chaotic"] = True
    points = optima(table)
    assert (points["N"] == 80).all()
    assert LAWS[0][0] not in points[C2].to_numpy()
    with pytest.raises(InputError, match="no law of the table has a finished row that is not chaotic"):
        optima(table.assign(chaotic=True))


def test_a_figure_that_is_the_kinetic_energy_has_its_findings_and_misleads_nobody():
    table = with_merits()
    found = held(table)
    for name in ("wall_force", "dissipated"):
        assert [one.verdict for one in found[name]] == [one.verdict for one in found["ke"]]
    assert [one.verdict for one in found["ke"]] == ["holds"] * 4
    assert "wall_force_ratio" in found["wall_force"][0].why
    away = misled(table)
    assert away["rank"].to_numpy() == pytest.approx(np.ones(4))
    assert away["price"].to_numpy() == pytest.approx(np.ones(4))
    assert (away["worse"] == 0).all()


def test_a_figure_that_goes_the_other_way_misleads():
    some = {"acceleration_ratio": lambda df: df["ke_ratio"] * df["M_over_M0"]}
    table = with_merits(impulse_ratio=lambda df: 1 / df["ke_ratio"], **some)
    found = misled(table).set_index("name")
    assert found.loc["impulse", "verdict"] == "misleads"
    assert found.loc["impulse", "rank"] == pytest.approx(-1)
    assert found.loc["acceleration", ["rank_low", "rank", "rank_high"]].is_monotonic_increasing
    assert found.loc["acceleration", "rank_low"] < found.loc["acceleration", "rank_high"]
    assert held(table)["impulse"][0].verdict == "does not hold"


def test_a_chain_is_worse_than_the_linear_one_however_little_and_not_where_they_are_alike():
    little = misled(with_merits(impulse_ratio=lambda df: df["ke_ratio"] ** -0.05)).set_index("name").loc["impulse"]
    assert little["worse"] == little["impacts"]
    alike = with_merits(impulse_ratio=lambda df: np.where(df["ke_ratio"] == df["ke_ratio"].min(), 1.0, 2.0))
    assert misled(alike).set_index("name").loc["impulse", "worse"] == 0


@pytest.mark.parametrize("nothing", [np.nan, 0.0])
def test_where_nothing_is_dissipated_or_felt_there_is_no_figure(nothing):
    table = with_merits(dissipated_ratio=lambda df: np.where(df["zeta_T"] == 0, nothing, 2.0))
    figure = in_place(table, MERITS[-1])["ke_ratio"]
    assert figure[table["zeta_T"] == 0].isna().all()
    assert set(figure.dropna()) == {0.5}
    assert in_place(table.assign(wall_force_ratio=nothing), MERITS[1])["ke_ratio"].isna().all()


def test_a_table_without_a_figure_names_it():
    with pytest.raises(InputError, match="acceleration_ratio"):
        misled(with_merits().drop(columns="acceleration_ratio"))


def test_disorder_that_changes_nothing_loses_nothing():
    found = survival(losses(with_disorder(1.0)))
    assert found["kind"].tolist() == ["both", "mass", "stiffness"]
    assert (found["spread"] == 0.1).all()
    assert found[["median", "low", "high", "worst", "median_ke", "below"]].to_numpy() == pytest.approx(np.ones((3, 6)))
    assert (found["verdict"] == "survives").all()


@pytest.mark.parametrize(("loss", "verdict"), [(1.9, "survives"), (2.1, "does not survive")])
def test_the_optimum_survives_what_costs_less_than_twice(loss, verdict):
    assert (survival(losses(with_disorder(loss)))["verdict"] == verdict).all()


def test_draws_about_the_border_cannot_tell():
    table = with_disorder(1.0)
    uniform = table["mass.seed"] == 0
    table["ke_ratio"] = np.where(uniform, 0.01, 0.01 * np.where(table.index % 2, 1.5, 3.0))
    assert (survival(losses(table))["verdict"] == "cannot tell").all()


def test_chaotic_draws_have_no_loss_and_are_counted():
    table = with_disorder(1.0)
    wild = (table["mass.seed"] > 0) & (table["mass.seed"] <= 5)
    table.loc[wild, "chaotic"] = True
    table.loc[wild, "ke_ratio"] = 1.0
    found = survival(losses(table))
    assert found["draws"].tolist() == [40] * 3
    assert found["calm"].tolist() == [30] * 3
    assert found["worst"].to_numpy() == pytest.approx(np.ones(3))


def test_a_table_without_a_calm_uniform_chain_says_so():
    table = with_disorder(1.0)
    with pytest.raises(InputError, match="uniform chain"):
        losses(table[table["mass.seed"] > 0])


def test_a_chain_has_a_threshold_or_not_by_the_rule_of_the_transitions():
    table = with_threshold(laws=[(5.0, 6.0)], speeds=[2.0]).drop(columns=[C2, C3])
    yes, no = answer(table), answer(table.assign(ke_ratio=0.5))
    assert [yes["verdict"], no["verdict"]] == ["yes", "no"]
    assert (yes["transitions"], yes["lines"]) == (6, 6)
    assert no["others"] == "6 never above 1"
    verdicts = {6e-5: "some lines", 4e-4: "yes"}  # of six lines one, and half
    for zeta_T, verdict in verdicts.items():
        some = table.assign(ke_ratio=table["ke_ratio"].where(table["zeta_T"] < zeta_T, 0.5))
        assert answer(some)["verdict"] == verdict


def test_a_share_of_few_trials_has_a_wide_interval():
    assert share_of(5, 10) == pytest.approx((0.5, 0.2366, 0.7634), abs=1e-4)
    assert share_of(0, 10)[1] == 0
    assert np.isnan(share_of(0, 0)).all()


def test_an_interval_is_a_dash_where_nothing_is_known():
    assert interval(0.512, 0.49, 0.53) == "0.512 (0.49 to 0.53)"
    assert interval(math.nan, math.nan, math.nan) == "–"
