"""A map shows any ratio that a table holds, under its own name and with its own error."""

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.cli import main
from analysis.commands.transition import law_lines
from analysis.draw import best_maps, plane_map
from analysis.draw_collapse import collapse_figure
from analysis.draw_transition import transition_figure
from analysis.notes import of_best, of_plane
from analysis.plane import plane_of
from analysis.quantity import KE, quantity, shown_by, typeset
from kernel.quantities import QUANTITIES

from .drawn import frame, legend, mesh, stars, written
from .test_analysis_cli import rows, write

GRID = ((5, 10, 40, 200), (0.0, 1e-4, 1e-3, 1e-2), (2.0,), (2.0,))
FORCE = quantity("wall_force_ratio")


def table(**columns):
    """The ke_ratio is lowest in the finest chain, the wall force's ratio in the coarsest."""
    df = frame(GRID, spread_low=0.5, spread_high=0.6)
    ratio = df["N"] / 20 * (1 + df["zeta_T"])
    return df.assign(**{"wall_force_ratio": ratio, "wall_force_error": 0.02} | columns)


@pytest.fixture
def csv(tmp_path):
    table().to_csv(tmp_path / "t.csv", index_label="task")
    return tmp_path / "t.csv"


def drawn(df, of=FORCE):
    cells = plane_of(of, df, ("N", "zeta_T"), None)
    return plane_map(cells, ("N", "zeta_T"), of_plane(df, cells, ("N", "zeta_T"), of=of))


def test_a_map_of_another_quantity_shows_its_numbers_and_names_it(csv, tmp_path, capsys):
    assert main(["map", str(csv), "-o", str(tmp_path / "a.png"), "--of", "wall_force_ratio"]) == 0
    told = capsys.readouterr().out
    assert "lowest    wall_force_ratio = 0.25 (estimated error 0.02 relative) at N = 5, zeta_T = 0" in told
    shown = pd.read_csv(tmp_path / "a.map.csv", index_col="task")
    assert not {"ke_ratio", "error", "spread_low", "spread_high"} & set(shown)
    expected = table().loc[shown.index, ["wall_force_ratio", "wall_force_error"]]
    pd.testing.assert_frame_equal(shown[["wall_force_ratio", "wall_force_error"]], expected, check_names=False)


@pytest.mark.parametrize(("column", "chain"), [("ke_bistable", ""), ("ke_linear", ", in the chain made linear")])
@pytest.mark.parametrize("command", ["map", "points"])
def test_the_kinetic_energy_of_either_chain_is_shown_with_the_error_that_is_known(
    tmp_path, capsys, command, column, chain
):
    df = table(ke_bistable=table()["N"] / 1000, ke_linear=table()["N"] / 500)
    df.to_csv(tmp_path / "t.csv", index_label="task")
    assert main([command, str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png"), "--of", column]) == 0
    lowest = df[column].min()
    told = f"lowest    {column} = {lowest:g} (estimated error 0.0001 relative, of ke_ratio) at N = 5"
    assert told in capsys.readouterr().out
    shown = pd.read_csv(tmp_path / f"a.{command}.csv", index_col="task")
    pd.testing.assert_series_equal(shown[column], df.loc[shown.index, column], check_names=False)
    assert not {"ke_ratio", "spread_low", "spread_high"} & set(shown)
    assert f"over TE, the total energy at the start{chain}." in written(drawn(df, shown_by(column)))


def test_its_picture_has_its_colours_its_star_and_its_name():
    figure = drawn(table())
    values = mesh(figure.axes[0]).get_array().compressed()
    np.testing.assert_allclose(np.sort(values), np.sort(table()["wall_force_ratio"]))
    assert [x for x, _ in stars(figure.axes[0])] == [5.0]
    text = written(figure)
    assert "wall force ratio: wall force over that of the same chain made linear." in text
    assert "KE ratio" not in text
    assert stars(drawn(table(), KE).axes[0])[0][0] == 200.0


def test_a_row_without_it_has_no_number_though_it_has_a_ke_ratio():
    ratio = table()["wall_force_ratio"].where(table()["N"] > 5)
    assert "no number: 4 cells" in legend(drawn(table(wall_force_ratio=ratio)))


def test_a_ratio_of_zero_is_said_to_be_one_and_not_left_white():
    ratio = table()["wall_force_ratio"].where(table()["N"] > 5, 0.0)
    assert "zero or negative: 4 cells" in legend(drawn(table(wall_force_ratio=ratio)))


@pytest.mark.parametrize(
    ("unit", "seen"),
    [
        ("k_T L", r"$k_T\,L$"),
        ("k_T L / m_T", r"$k_T\,L/m_T$"),
        ("sqrt(m_T / k_T)", r"$\sqrt{m_T/k_T}$"),
        ("m_im V", r"$m_\mathrm{im}\,V$"),
        ("share of the links", "share of the links"),
        ("s", "s"),
    ],
)
def test_a_unit_is_typeset_and_words_stay_words(unit, seen):
    assert typeset(unit) == seen


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_picture_of_a_value_says_in_words_what_it_is_and_what_its_unit_means(name):
    for column, whose in ((name, ""), (f"{name}_linear", "in the chain made linear")):
        of = quantity(column)
        words, _, what = of.meaning.partition(": ")
        assert of.title.startswith(words)
        assert not what.startswith(words)
        assert whose in what
        assert not any(raw in of.title + of.meaning for raw in ("_T L", "sqrt(", "m_im "))
    assert quantity("arrival").meaning.startswith("arrival: when the site's speed first exceeds")
    assert "$m_T$: mass of the chain" in quantity("arrival").meaning


def test_a_table_with_further_columns_is_drawn_as_its_csv_is(tmp_path):
    made = rows(((5, 20, 100), (0.0, 1e-4, 1e-2), (2.0,), (1.0,)))
    wide = np.empty(len(made), [*made.dtype.descr, ("wall_force_ratio", "<f8"), ("wall_force_error", "<f8")])
    for name in made.dtype.names:
        wide[name] = made[name]
    wide["wall_force_ratio"], wide["wall_force_error"] = made["N"] / 20, 0.02
    path = write(tmp_path / "t.h5", wide)
    analysis.load(path).to_csv(tmp_path / "t.csv")
    for source, picture in (("t.h5", "a.png"), ("t.csv", "b.png")):
        command = ["map", str(tmp_path / source), "-o", str(tmp_path / picture), "--of", "wall_force_ratio"]
        assert main(command) == 0
    assert (tmp_path / "a.map.csv").read_bytes() == (tmp_path / "b.map.csv").read_bytes()
    assert sorted(pd.read_csv(tmp_path / "a.map.csv")["wall_force_ratio"].unique()) == [0.25, 1.0, 5.0]


def test_ke_ratio_is_what_a_map_shows_unless_told_otherwise(csv, tmp_path):
    for name, more in (("a", []), ("b", ["--of", "ke_ratio"])):
        (tmp_path / name).mkdir()
        assert main(["map", str(csv), "-o", str(tmp_path / name / "a.png"), *more]) == 0
    for file in ("a.png", "a.map.csv"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


@pytest.mark.parametrize(
    ("of", "said"),
    [
        ("seconds", "of: must be ke_ratio, or q_ratio of another quantity q that the spec observes, or q itself, or"),
        ("flipped", "of: must be one of ke_ratio, wall_force_ratio, got 'flipped'; of a quantity q that"),
        (
            "wal_force_ratio",
            "of: must be one of ke_ratio, wall_force_ratio, got 'wal_force_ratio' (did you mean 'wall_",
        ),
        ("wall_force_error", "got 'wall_force_error'; `analysis page` shows any column of a table"),
        ("t_peak_linear", "or q itself, or on a map or points ke_bistable or ke_linear, got 't_peak_linear';"),
        ("ke", "or on a map or points ke_bistable or ke_linear, got 'ke';"),
        ("_ratio", "got '_ratio'; `analysis page` shows any column of a table"),
    ],
)
def test_what_is_no_ratio_of_the_table_is_refused_in_one_line(csv, tmp_path, capsys, of, said):
    assert main(["map", str(csv), "-o", str(tmp_path / "a.png"), "--of", of]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert said in err
    assert not (tmp_path / "a.png").exists()


def test_a_quantity_that_is_text_is_refused(tmp_path, capsys):
    table(wall_force_ratio="low").to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["map", str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png"), "--of", "wall_force_ratio"]) == 2
    assert "wall_force_ratio, line 2: must be a finite number, or empty, got 'low'" in capsys.readouterr().err


WIDE = ((5, 20, 80, 320), (1e-5, 1e-4, 1e-3, 1e-2), (0.5, 2.0), (1.0, 3.0))


def fallen(name="wall_force_ratio", **columns):
    """A ratio that falls through 1 at N = 0.8 zeta_T^-0.5, whatever the impact; the ke_ratio, if it is another, never.

    Its lowest impact is the heaviest and fastest one.
    """
    df = frame(WIDE).drop(columns=["ke_ratio", "error"])
    ratio = (0.8 * df["zeta_T"] ** -0.5 / df["N"]) ** 2 * (1 + 0.01 / (df["M_over_M0"] * df["V_over_V0"]))
    error = "error" if name == "ke_ratio" else name.replace("_ratio", "_error")
    return df.assign(**{"ke_ratio": 3.0, "error": 1e-3} | {name: ratio, error: 1e-4} | columns)


def alike(found, df):
    """`found` of the ratio of the wall force as of the ke_ratio of the same numbers, but for the names."""
    pd.testing.assert_frame_equal(
        found, df.rename(columns={"ke_ratio": "wall_force_ratio", "error": "wall_force_error"})
    )


def test_every_function_tells_of_another_ratio_what_it_tells_of_the_same_numbers_as_ke_ratio():
    of, (df, ke) = "wall_force_ratio", (fallen(name) for name in ("wall_force_ratio", "ke_ratio"))
    alike(analysis.best(df, of=of), analysis.best(ke))
    pd.testing.assert_frame_equal(analysis.transition(df, of), analysis.transition(ke))
    assert str(analysis.optimum(df, of=of)) == str(analysis.optimum(ke)).replace("ke_ratio", of)
    assert np.isnan(analysis.optimum(df, of=of).ke_ratio)
    assert str(analysis.collapse(df, "Pi_IV", of)) == str(analysis.collapse(ke)).replace("ke_ratio", of)
    told, same = analysis.findings(df, of), analysis.findings(ke)
    assert [(one.number, one.verdict) for one in told] == [(one.number, one.verdict) for one in same]
    assert [one.text for one in told] == [one.text.replace("ke_ratio", of) for one in same]
    assert [one.verdict for one in told] != [one.verdict for one in analysis.findings(df)]


@pytest.mark.parametrize("command", ["best", "collapse", "transition"])
def test_commands_name_the_ratio_that_they_are_asked_for_in_what_they_print_and_write(tmp_path, capsys, command):
    fallen().to_csv(tmp_path / "t.csv", index_label="task")
    assert main([command, str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png"), "--of", "wall_force_ratio"]) == 0
    told, numbers = capsys.readouterr().out, (tmp_path / f"a.{command}.csv").read_text()
    assert "wall_force_ratio" in told
    assert "wall_force_ratio" in numbers
    assert "ke_ratio" not in told + numbers
    assert "the paper" not in told


def test_their_pictures_name_it_too():
    df, of = fallen(), FORCE
    cells = analysis.best(df, of=of.ratio)
    impacts = {name: df[name].unique() for name in ("M_over_M0", "V_over_V0")}
    figures = [
        best_maps(cells, impacts, of_best(df, df, cells, of=of)),
        transition_figure(analysis.transition(df, of.ratio), of=of),
        collapse_figure(analysis.collapse(df, of=of.ratio), "N"),
    ]
    for figure in figures:
        assert "wall force ratio: wall force over that of the same chain made linear." in written(figure)
        assert "KE ratio" not in written(figure)


def test_findings_say_which_ratio_is_judged_and_refuse_what_is_none(tmp_path, capsys):
    fallen().to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["findings", str(tmp_path / "t.csv"), "--of", "wall_force_ratio"]) == 0
    told = capsys.readouterr().out
    assert "of        wall_force_ratio in place of ke_ratio: the lower, the better\nfinding 1 " in told
    assert "the lowest wall_force_ratio of the largest N" in told
    for command in (["findings"], ["collapse", "-o", str(tmp_path / "a.png")], ["transition", "-o", "a.png"]):
        assert main([command[0], str(tmp_path / "t.csv"), *command[1:], "--of", "wall_force"]) == 2
        assert "of: must be the ratio of two chains, ke_ratio, or q_ratio of another" in capsys.readouterr().err


def test_the_law_of_every_impact_stands_beside_its_transitions(tmp_path):
    fallen().to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["transition", str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png"), "--of", "wall_force_ratio"]) == 0
    numbers = pd.read_csv(tmp_path / "a.transition.csv")
    laws = analysis.power_laws(analysis.transition(fallen(), "wall_force_ratio")).set_index(["definition"])
    assert len(law_lines(laws.reset_index(), FORCE, beside=False)) == len(laws) > 0
    for definition, ending in (("log_slope", ""), ("slope", "_by_slope"), ("level", "_by_level")):
        for law in laws.loc[[definition]].to_dict("records"):
            own = numbers[(numbers["M_over_M0"] == law["M_over_M0"]) & (numbers["V_over_V0"] == law["V_over_V0"])]
            for name in ("A", "b", "b_low", "b_high", "points"):
                assert own[f"{name}{ending}"].tolist() == [law[name]] * 4


def test_a_value_that_has_no_ratio_is_mapped_in_colours_that_turn_nowhere():
    """No link of a linear chain flips."""
    share = table()["N"] / 200 * (table()["N"] > 5)
    df = table(flipped=share, flipped_linear=np.nan, flipped_ratio=np.nan, flipped_error=np.nan)
    figure = drawn(df, quantity("flipped"))
    drawn_values = mesh(figure.axes[0])
    np.testing.assert_allclose(np.sort(drawn_values.get_array().compressed()), np.sort(share))
    assert drawn_values.get_cmap().name == "viridis"
    assert "flipped (share of the links)" in written(figure)
    assert "no number" not in written(figure)
    assert "zero or negative" not in written(figure)
    assert legend(figure)[0].startswith("lowest: 0 at $N$ = 5")
