"""Claims about `analysis tradeoff` and `atlas`, at tiny sizes, computed for real."""

import re
import sys
from itertools import combinations, product

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Annotation

import analysis
import sweep
from analysis import tradeoff
from analysis.cli import main
from analysis.draw_atlas import atlas_figure
from analysis.draw_tradeoff import STYLES, tradeoff_figure
from analysis.stability import METHODS
from kernel import Bistable, Model, ke_ratio
from kernel.method import SWITCH, choose
from sweep.schema import PARAMETERS

from .drawn import legend

pytestmark = pytest.mark.slow

TASKS = 3


@pytest.fixture(scope="module")
def small():
    """Well-conditioned tasks of small chains, with references."""
    rows = [(5, 0.0, 1.0, 0.3), (12, 1e-3, 0.5, 1.0), (20, 0.05, 2.0, 2.0)]
    frame = pd.DataFrame(rows, columns=["N", "zeta_T", "M_over_M0", "V_over_V0"])
    truth = [ke_ratio(*row, method="rk45", rtol=1e-10, atol=1e-13, certify=False).ke_ratio for row in rows]
    return frame.assign(ke_ratio=truth)


@pytest.fixture(scope="module")
def points(small):
    return tradeoff.tradeoff(small)


def test_every_method_and_target_is_one_point_and_ode45s_defaults_are_marked(points):
    assert len(points) == 2 * len(tradeoff.TARGETS) + len(tradeoff.RTOLS)
    (star,) = points[points["ode45_defaults"]].to_dict("records")
    assert (star["method"], star["setting"]) == ("rk45", 1e-3)
    (setting,) = [setting for setting in tradeoff.settings() if setting.ode45]
    assert (setting.integrator.rtol, setting.integrator.atol) == (1e-3, pytest.approx(1e-6))


def test_a_smaller_error_costs_more_force_evaluations_by_every_method(points):
    for _, line in points.groupby("method"):
        assert line["evaluations_per_time_50"].is_monotonic_increasing
        assert line["error_90"].iloc[-1] < 1e-2 * line["error_90"].iloc[0]


def test_without_an_estimate_a_loose_target_costs_less_than_a_tighter_one(points):
    plain = points[points["method"] == tradeoff.UNCERTIFIED].set_index("setting")["evaluations_per_time_50"]
    assert plain[1e-1] < plain[1e-2] < plain[1e-3]


def test_every_number_beside_a_point_stands_by_a_point_of_its_own_colour(points):
    from matplotlib.colors import to_rgba

    figure = tradeoff_figure(points, TASKS)
    for ax in figure.axes:
        notes = ax.findobj(Annotation)
        for name, line in points.groupby("method"):
            own = [note for note in notes if to_rgba(note.get_color()) == to_rgba(STYLES[name]["color"])]
            assert {note.xy[1] for note in own} <= set(line["error_90"])
            shown = "\n".join(note.get_text() for note in own)
            told = [f"10^{{{round(np.log10(one))}}}" for one in line.loc[line["error_90"] > 0, "setting"]]
            assert all(text in shown for text in told)


@pytest.mark.parametrize("rk45", [30.0, 70.0, 100.0])
def test_labels_lie_within_the_axes_and_apart_where_targets_or_lines_coincide(rk45):
    """The three loosest targets take the same steps; their times differ by what the clock does."""
    rows = []
    for one in tradeoff.settings():
        same = max(-3.0, np.log10(one.setting)) if one.method != tradeoff.RK45 else np.log10(one.setting)
        start = {tradeoff.CERTIFIED: 76.0, tradeoff.UNCERTIFIED: 46.0, tradeoff.RK45: rk45}[one.method]
        work, error = start * 10 ** (-0.25 * (same + 3)), 1e-1 * 10**same
        rows.append({"method": one.method, "setting": one.setting, "ode45_defaults": one.ode45, "error_90": error})
        rows[-1] |= {"error_50": error / 5, "evaluations_per_time_50": work, "ms_50": work * (1 - 0.1 * one.setting)}
    figure = tradeoff_figure(pd.DataFrame(rows).assign(ms_mean=lambda df: df["ms_50"]), TASKS)
    figure.draw_without_rendering()
    for ax in figure.axes:
        notes = ax.findobj(Annotation)
        boxes, inside = [note.get_window_extent() for note in notes], ax.get_window_extent()
        assert sum("\n" in note.get_text() for note in notes) == 2
        assert all(inside.x0 < box.x0 < box.x1 < inside.x1 and inside.y0 < box.y0 for box in boxes)
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize("decades", [0.1, 0.4, 1.0, 1.3, 1.9, 3.0, 5.0])
def test_the_numbers_along_the_axes_stand_apart_however_little_or_much_the_work_differs(points, decades):
    power = decades / np.log10(points["ms_50"].max() / points["ms_50"].min())
    squeezed = points.assign(**{work: points[work] ** power for work in ("ms_50", "evaluations_per_time_50")})
    figure = tradeoff_figure(squeezed, TASKS)
    figure.draw_without_rendering()
    for ax in figure.axes:
        labels = [tick.label1 for tick in (*ax.xaxis.get_major_ticks(), *ax.xaxis.get_minor_ticks())]
        inside = [
            text
            for text in labels
            if text.get_text() and ax.get_xlim()[0] <= text.get_position()[0] <= ax.get_xlim()[1]
        ]
        assert len(inside) >= 2
        assert not any(one.overlaps(other) for one, other in combinations([x.get_window_extent() for x in inside], 2))


# Force evaluations and error of every point of the shipped picture, tests/tradeoff.png.
SHIPPED = {
    tradeoff.CERTIFIED: [
        (40.6, 0.000435),
        (40.6, 0.000435),
        (68.5, 0.000109),
        (137, 7.6e-06),
        (349, 6.85e-07),
        (961, 4.59e-08),
        (2.34e03, 5.76e-09),
        (3.63e03, 8.95e-10),
    ],
    tradeoff.UNCERTIFIED: [
        (13.8, 0.00698),
        (18.4, 0.00326),
        (40.6, 0.000127),
        (97.7, 8.11e-06),
        (251, 6.85e-07),
        (659, 5.84e-08),
        (1.18e03, 7.08e-09),
        (1.86e03, 1.03e-09),
    ],
    tradeoff.RK45: [
        (61, 0.606),
        (89, 0.00291),
        (118, 0.000367),
        (172, 0.00014),
        (250, 3.4e-05),
        (366, 5.31e-06),
        (524, 2.96e-07),
        (776, 5.14e-08),
    ],
}


def test_every_label_stands_nearest_to_its_own_point_of_its_line():
    """The last two points of rk45 seemed to have each other's."""
    settings, places = tradeoff.settings(), {name: iter(points) for name, points in SHIPPED.items()}
    rows = [
        {"method": one.method, "setting": one.setting, "ode45_defaults": one.ode45}
        | dict(zip(("ms_50", "error_90"), next(places[one.method]), strict=True))
        for one in settings
    ]
    points = pd.DataFrame(rows).assign(error_50=lambda df: df["error_90"] / 5, ms_mean=lambda df: df["ms_50"])
    figure = tradeoff_figure(points.assign(evaluations_per_time_50=points["ms_50"]), TASKS)
    figure.draw_without_rendering()
    for ax in figure.axes:
        for note in ax.findobj(Annotation):
            lines = [x for x in ax.lines if x.get_color() == note.get_color() and x.get_linestyle() != "--"]
            places_of = ax.transData.transform(np.concatenate([line.get_xydata() for line in lines]))
            own, box = ax.transData.transform(note.xy), note.get_window_extent()
            middle = np.mean([box.min, box.max], axis=0)
            assert np.hypot(*(own - middle)) <= np.hypot(*(places_of - middle).T).min() + 8, note.get_text()


def test_the_errors_are_those_of_the_kernel(points, small):
    plain = points[(points["method"] == tradeoff.UNCERTIFIED) & (points["setting"] == 1e-3)].iloc[0]
    tasks = small[["N", "zeta_T", "M_over_M0", "V_over_V0"]].itertuples(index=False, name=None)
    ratios = np.array([ke_ratio(*task, accuracy=1e-3, certify=False).ke_ratio for task in tasks])
    errors = np.sort(np.abs(ratios / small["ke_ratio"] - 1))
    assert (plain["error_50"], plain["error_100"]) == (errors[1], errors[2])


def test_a_digit_of_a_power_law_costs_what_its_exponent_says():
    error = np.array([1e-1, 1e-2, 1e-3])
    line = pd.DataFrame({"error_90": error, "ms_50": error**-0.25, "ms_mean": error**-0.5})
    assert tradeoff.cost_of_a_digit(line) == pytest.approx((10**0.25, 10**0.5))


def test_the_sample_is_well_conditioned_repeatable_and_inside_the_domain(monkeypatch):
    monkeypatch.setitem(tradeoff.DOMAIN, "N", (5, 20))
    tasks, left_out, *_ = tradeoff.sample(6, 3)
    again = tradeoff.sample(6, 3).tasks
    pd.testing.assert_frame_equal(tasks, again)
    assert (len(tasks), left_out >= 0) == (6, True)
    for name, (low, high) in tradeoff.DOMAIN.items():
        assert ((tasks[name] >= low) & (tasks[name] <= high) | (tasks[name] == 0)).all()
    task = tasks.iloc[0]
    arguments = (int(task["N"]), task["zeta_T"], task["M_over_M0"], task["V_over_V0"] * (1 + 1e-6))
    beside = ke_ratio(*arguments, method="rk45", rtol=1e-10, atol=1e-13, certify=False).ke_ratio
    assert abs(beside / task["ke_ratio"] - 1) < 1e-4


@pytest.mark.parametrize(("N", "M", "V"), [(40, 1.0, 0.01), (42, 1.2301706548443592, 2.5817731860998565)])
def test_a_task_that_its_mass_alone_shows_to_be_chaotic_is_no_well_conditioned_one(N, M, V):
    assert ke_ratio(N, 0.0, M, V).chaotic
    assert np.isnan(tradeoff._converged({"N": N, "zeta_T": 0.0, "M_over_M0": M, "V_over_V0": V}, Model()))


def test_tradeoff_writes_picture_and_csv_and_tells_the_headlines(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(tradeoff.DOMAIN, "N", (5, 20))
    monkeypatch.setitem(tradeoff.DOMAIN, "zeta_T", (1e-5, 1e-2))
    picture = tmp_path / "t.png"
    assert main(["tradeoff", "-o", str(picture), "--tasks", str(TASKS), "--seed", "5"]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    told = capsys.readouterr().out
    assert told.startswith("sample    3 random tasks")
    assert "rk45 at rtol 1e-03 (ode45)" in told
    assert told.count("a tenth of the 90 % error costs") == 3
    numbers = pd.read_csv(tmp_path / "t.tradeoff.csv")
    assert (numbers["tasks"] == TASKS).all()
    assert (numbers["failed"] == 0).all()


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """A table of another chain, with a number of its law and its end time as axes."""
    grid = {"N": [5, 12], "zeta_T": [1e-3], "M_over_M0": 1.0, "V_over_V0": [0.5, 2.0], "spring.c2": [4.0, 4.2]}
    spec = {"name": "own", "grid": grid | {"t_end": [1.5, 2.0]}, "model": {"spring": {"law": "bistable", "c3": 5.5}}}
    return sweep.run(spec, tmp_path_factory.mktemp("own") / "own.h5", progress=False).table


def test_the_trade_of_a_table_is_measured_on_its_own_rows_and_chain(own):
    tasks, left_out, dear, model = tradeoff.sample_of(own, 100, 1)
    rows = analysis.load(own)
    assert (len(tasks) + left_out, dear) == (len(rows), 0) == (16, 0)
    assert model.spring == Bistable(4.0, 5.5)
    both = tasks.merge(rows, on=["N", "zeta_T", "M_over_M0", "V_over_V0", "spring.c2", "t_end"], suffixes=("", "_row"))
    assert len(both) == len(tasks) > 8
    assert (abs(both["ke_ratio_row"] / both["ke_ratio"] - 1) < 1e-3).all()
    one = tradeoff.Setting(tradeoff.RK45, 1e-9, choose("rk45", rtol=1e-9, atol=1e-12), False)
    assert tradeoff.measure(tasks, one, model)["error_100"] < 1e-5
    few, others = (tradeoff.sample_of(own, 3, seed).tasks for seed in (1, 2))
    assert len(few) == 3
    assert not few.equals(others)


def test_rows_whose_reference_takes_too_long_are_left_out_and_counted(own, monkeypatch):
    too_long = tradeoff.SECONDS_MAX + 1.0
    monkeypatch.setattr(tradeoff, "predict_work", lambda columns, *_: np.where(columns["N"] == 12, too_long, 1.0))
    sample = tradeoff.sample_of(own, 100, 1)
    assert sample.dear == 8
    assert set(sample.tasks["N"]) == {5}


def test_the_picture_of_a_table_names_it(own, tmp_path, capsys):
    assert main(["tradeoff", str(own), "-o", str(tmp_path / "t.svg"), "--tasks", "2"]) == 0
    assert capsys.readouterr().out.startswith("sample    2 random tasks of own.h5, seed 1; left out: ")
    assert "random tasks of own.h5" in (tmp_path / "t.svg").read_text().replace("\n", " ")


@pytest.mark.parametrize("terminal", [True, False])
def test_only_a_terminal_is_shown_how_far_references_and_methods_are(own, tmp_path, capsys, monkeypatch, terminal):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    assert main(["tradeoff", str(own), "-o", str(tmp_path / "t.png"), "--tasks", "2"]) == 0
    shown = re.findall(r"(references|methods timed) +(\d+) of (\d+)", capsys.readouterr().err)
    methods = str(len(tradeoff.settings()))
    steps = [("references", "0", "2"), ("references", "2", "2"), ("methods timed", "1", methods)]
    assert [step in shown for step in steps] == [terminal] * 3
    assert bool(shown) == terminal


def test_a_table_without_calm_rows_or_model_has_no_trade(own, tmp_path, capsys):
    assert main(["tradeoff", str(tmp_path / "none.h5"), "-o", str(tmp_path / "t.png")]) == 2
    assert "none.h5: cannot be read" in capsys.readouterr().err
    assert main(["tradeoff", str(tmp_path / "rows.csv"), "-o", str(tmp_path / "t.png")]) == 2
    assert "give the table that it was exported from" in capsys.readouterr().err
    grid = {"N": 160, "zeta_T": 1e-6, "M_over_M0": 2.0, "V_over_V0": 0.9}
    wild = sweep.run({"name": "wild", "grid": grid}, tmp_path / "wild.h5", progress=False).table
    assert main(["tradeoff", str(wild), "-o", str(tmp_path / "t.png")]) == 2
    assert "of 1 drawn 1 are chaotic or ill-conditioned, 0 would take more than 60 s" in capsys.readouterr().err


def test_atlas_draws_both_planes_with_both_schemes(tmp_path, capsys, monkeypatch):
    from analysis import atlas

    monkeypatch.setitem(atlas.DOMAIN, "N", (5, 30))
    monkeypatch.setitem(atlas.AT, "N", 20.0)
    picture = tmp_path / "a.svg"
    assert main(["atlas", "-o", str(picture), "--side", "4"]) == 0
    assert picture.read_bytes().startswith(b"<?xml")
    cells = pd.read_csv(tmp_path / "a.atlas.csv")
    for plane, at in ((0, {"M_over_M0": 2.0, "V_over_V0": 2.0}), (1, {"N": 20.0, "zeta_T": 4e-5})):
        assert (cells.loc[cells["plane"] == plane, list(at)] == at).to_numpy().all()
    assert cells["checked"].all()
    assert cells.groupby("plane").size().tolist() == [16, 16]
    for one in cells.to_dict("records"):
        task = (int(one["N"]), one["zeta_T"], one["M_over_M0"], one["V_over_V0"])
        assert one["method"] == ke_ratio(*task, accuracy=1e-3, certify=False).method
    assert set(cells["method"]) == {"explicit", "implicit", "rk45"}
    stiff = cells["N"] * cells["zeta_T"] > 10 * SWITCH
    assert (cells["step_implicit"] > cells["step_explicit"])[stiff].all()
    calm = cells["N"] * cells["zeta_T"] < 0.01
    assert (cells["step_explicit"] > cells["step_rk45"])[calm].all()
    out = capsys.readouterr().out
    assert out.count("cell transit times") == 6
    assert out.splitlines()[-2:] == [f"picture   {picture}", f"numbers   {tmp_path / 'a.atlas.csv'}"]


def cells(**columns):
    """Both planes of an atlas, of four cells each."""
    from analysis import atlas

    tasks = [(k, *task) for k in (0, 1) for task in product((20, 40), (1e-5, 1e-3), (1.0, 2.0), (1.0, 2.0))]
    df = pd.DataFrame(tasks, columns=["plane", *PARAMETERS])
    some = df[(df["plane"] == 0) & (df[list(atlas.OVER[1])] == 1).all(axis=1)]
    more = df[(df["plane"] == 1) & (df["N"] == 20) & (df["zeta_T"] == 1e-5)]
    steps = {f"step_{method}": 0.1 for method in METHODS}
    rest = {"method": "explicit", "chaotic": False, "checked": True}
    return pd.concat([some, more], ignore_index=True).assign(**steps | rest | columns)


def test_the_atlas_counts_no_failed_task_as_calm():
    from analysis.atlas import headlines

    df = cells()
    df.loc[0, "checked"] = False
    assert headlines(df)[0].endswith("0 of 4 cells chaotic; 1 not checked for chaos")
    assert headlines(df)[4].endswith("0 of 4 cells chaotic")
    assert any("1 not checked for chaos" in text for text in legend(atlas_figure(df)))


@pytest.mark.parametrize(("step", "extend"), [(2.0**-7, "neither"), (2.0**-8, "min"), (3.0, "max")])
def test_steps_beyond_the_scale_of_the_atlas_have_an_arrow(step, extend):
    figure = atlas_figure(cells(step_rk45=[step] * 8))
    (bar,) = (ax for ax in figure.axes if ax.get_label() == "<colorbar>")
    assert bar._colorbar.extend == extend


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["tradeoff", "-o", "a.jpg"], "a picture ends in"),
        (["tradeoff", "-o", "a.png", "--tasks", "0"], "--tasks must be"),
        (["tradeoff", "-o", "a.png", "--seed", "-1"], "--seed at least 0"),
        (["atlas", "-o", "none/a.png"], "there is no directory"),
        (["atlas", "-o", "a.png", "--side", "1"], "--side must be"),
    ],
)
def test_bad_input_exits_2_with_one_line_and_leaves_no_file(tmp_path, capsys, monkeypatch, arguments, told):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n"), err.startswith("analysis: ")) == ("", 1, True)
    assert told in err
    assert not list(tmp_path.iterdir())
