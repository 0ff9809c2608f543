"""A map shows any ratio that a table holds, under its own name and with its own error."""

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.cli import main
from analysis.draw import plane_map
from analysis.notes import of_plane
from analysis.plane import plane_of
from analysis.quantity import KE, quantity

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
        ("wall_force", "--of wall_force: is no ratio of two chains"),
        ("wal_force_ratio", "lacks the columns wal_force_ratio, wal_force_error; wal_force_ratio (did you mean"),
        ("_ratio", "--of _ratio: is no ratio of two chains"),
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
    assert "must hold numbers in the columns wall_force_ratio" in capsys.readouterr().err
