"""Every drawing command takes the same options, and answers what they cannot be; tables come as HDF5 or CSV."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import analysis
from analysis.cli import main, parser
from analysis.look import Look, settings

from .test_analysis_cli import rows, write

DRAWING = ("best", "map", "transition", "collapse", "tradeoff", "atlas", "convention")
OPTIONS = ("--limits", "--cmap", "--size", "--title", "--dpi", "--force")


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "t.h5", rows())


@pytest.mark.parametrize("command", DRAWING)
def test_every_drawing_command_has_the_same_options(command, capsys):
    with pytest.raises(SystemExit):
        parser().parse_args([command, "--help"])
    text = capsys.readouterr().out
    assert all(option in text for option in OPTIONS)


BAD = [
    (["--limits", "1"], "--limits: must be two positive numbers LOW,HIGH with LOW below HIGH, got '1'"),
    (["--limits", "2,1"], "--limits: must be two positive"),
    (["--limits", "0,1"], "--limits: must be two positive"),
    (["--limits", "nan,1"], "--limits: must be two positive"),
    (["--size", "5"], "--size: must be W,H in inches"),
    (["--size", "5,500"], "--size: must be W,H in inches"),
    (["--dpi", "2.5"], "--dpi: must be a whole number from 30 to 2400, got '2.5'"),
    (["--dpi", "1"], "--dpi: must be a whole number"),
    (["--size", "40,40", "--dpi", "2400"], "at most 4e+08 pixels, or a .pdf, which has none, got 96000 x 96000 pixels"),
    (["--cmap", "virdis"], "(did you mean 'viridis'?), got 'virdis'"),
    (["--title", "$\\nothing$"], "--title: what stands between two $"),
]


@pytest.mark.parametrize(("arguments", "told"), BAD)
@pytest.mark.parametrize("command", ["best", "collapse"])
def test_what_an_option_cannot_be_is_answered_and_nothing_written(table, tmp_path, capsys, command, arguments, told):
    assert main([command, str(table), "-o", str(tmp_path / "a.png"), *arguments]) == 2
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["t.h5"]


def test_all_wrong_options_are_told_at_once(table, tmp_path, capsys):
    assert main(["best", str(table), "-o", str(tmp_path / "a.png"), "--dpi", "x", "--size", "x", "--cmap", "x"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 3


def test_a_picture_that_has_no_room_says_so(table, tmp_path, capsys):
    assert main(["best", str(table), "-o", str(tmp_path / "a.png"), "--size", "1,1"]) == 2
    assert "--size: 1 x 1 inches are too small for this picture" in capsys.readouterr().err


def test_a_size_that_leaves_a_strip_of_a_map_is_refused_and_a_long_title_is_wrapped(table, tmp_path, capsys):
    """At 3 x 3 inches a map was a quarter of an inch high, and its title was cut on both sides."""
    arguments = ["map", str(table), "-o", str(tmp_path / "a.png"), "--at", "M_over_M0=2", "V_over_V0=10", "--size"]
    assert main([*arguments, "3,3"]) == 2
    assert "--size: 3 x 3 inches are too small for this picture" in capsys.readouterr().err
    with settings():
        figure = Look(title="a long title " * 8).finish(Figure((4, 4), layout="constrained"))
        box = figure.texts[0].get_window_extent()
    assert 0 < box.x0 < box.x1 < figure.bbox.width


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "computes"),
    [("tradeoff", "tradeoff.sample"), ("atlas", "atlas.atlas"), ("convention", "paper.convention.scan")],
)
def test_a_size_without_room_is_told_before_anything_is_computed(tmp_path, capsys, monkeypatch, command, computes):
    class ComputedError(Exception):
        pass

    def compute(*_, **__):
        raise ComputedError

    monkeypatch.setattr(f"analysis.{computes}", compute)
    arguments = [command, "-o", str(tmp_path / "a.png")]
    assert main([*arguments, "--size", "2,2"]) == 2
    assert "--size: 2 x 2 inches are too small for this picture" in capsys.readouterr().err
    with pytest.raises(ComputedError):
        main(arguments)


@pytest.mark.parametrize("command", ["best", "map", "transition", "collapse"])
def test_size_and_dpi_give_the_pixels(table, tmp_path, command):
    from PIL import Image

    at = ["--at", "M_over_M0=2", "V_over_V0=10"] if command == "map" else []
    look = ["--size", "7,6", "--dpi", "50", "--title", "A title", "--cmap", "plasma", "--limits", "0.01,10"]
    assert main([command, str(table), "-o", str(tmp_path / "a.png"), *at, *look]) == 0
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (350, 300)


def test_at_takes_what_the_ticks_show_and_says_which_value_it_took(tmp_path, capsys):
    speeds = (0.316227766017, 3.16227766017)
    table = write(tmp_path / "t.h5", rows(((5, 20), (0.0, 1e-3), (2.0,), speeds)))
    assert main(["map", str(table), "-o", str(tmp_path / "a.png"), "--at", "V_over_V0=3.16"]) == 0
    assert "at        V_over_V0 = 3.16227766017, which is nearest to 3.16" in capsys.readouterr().out
    assert set(pd.read_csv(tmp_path / "a.map.csv")["V_over_V0"]) == {3.16227766017}
    assert main(["map", str(table), "-o", str(tmp_path / "b.png"), "--at", "V_over_V0=3.16227766017"]) == 0
    assert "which is nearest" not in capsys.readouterr().out
    command = ["map", str(table), "-o", str(tmp_path / "d.png"), "--over", "zeta_T,V_over_V0"]
    assert main([*command, "--at", "N=19"]) == 0
    assert "at        N = 20, which is nearest to 19\n" in capsys.readouterr().out
    assert main(["map", str(table), "-o", str(tmp_path / "c.png"), "--at", "V_over_V0=50"]) == 2
    assert "there is 0.316227766017, 3.16227766017" in capsys.readouterr().err


def test_a_damping_is_never_taken_for_none(tmp_path, capsys):
    table = write(tmp_path / "t.h5", rows(((5, 20), (0.0, 1e-3), (2.0,), (1.0, 2.0))))
    over = ["--over", "N,V_over_V0", "--at", "zeta_T=1e-5"]
    assert main(["map", str(table), "-o", str(tmp_path / "a.png"), *over]) == 2
    assert "no finished row has zeta_T = 1e-05" in capsys.readouterr().err


def test_a_mistyped_parameter_is_asked_for(table, tmp_path, capsys):
    assert main(["map", str(table), "-o", str(tmp_path / "a.png"), "--over", "N,zeta"]) == 2
    assert "(did you mean 'zeta_T'?)" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("command", ["best", "map", "transition", "collapse"])
def test_an_exported_csv_gives_what_its_table_gives(table, tmp_path, capsys, command):
    analysis.load(table, done_only=False).to_csv(tmp_path / "t.csv")
    at = ["--at", "M_over_M0=2", "V_over_V0=10"] if command == "map" else []
    said = []
    for name in ("t.h5", "t.csv"):
        folder = tmp_path / name.replace(".", "_")
        folder.mkdir()
        assert main([command, str(tmp_path / name), "-o", str(folder / "a.png"), *at]) == 0
        said.append([line for line in capsys.readouterr().out.splitlines() if str(tmp_path) not in line])
    assert said[0] == said[1]
    assert (tmp_path / "t_h5" / f"a.{command}.csv").read_bytes() == (
        tmp_path / "t_csv" / f"a.{command}.csv"
    ).read_bytes()


@pytest.mark.parametrize("command", ["best", "map", "points", "transition", "collapse", "page"])
@pytest.mark.parametrize(("text", "told"), [("", "cannot be read as CSV"), ("a,b\n1,2\n", "lacks the columns")])
def test_a_csv_that_is_no_table_is_told(tmp_path, capsys, text, told, command):
    (tmp_path / "t.csv").write_text(text)
    picture = tmp_path / ("a.html" if command == "page" else "a.png")
    assert main([command, str(tmp_path / "t.csv"), "-o", str(picture)]) == 2
    assert told in capsys.readouterr().err
    assert not picture.exists()


AT = {"best": [], "map": ["V_over_V0=10"], "points": [], "transition": [], "collapse": [], "level": ["V_over_V0=10"]}


@pytest.mark.slow
@pytest.mark.parametrize("command", AT)
def test_at_leaves_the_rows_of_one_value_whatever_is_drawn_of_them(tmp_path, capsys, command):
    table = write(tmp_path / "t.h5", rows(((5, 10, 20, 50, 100), (1e-4, 1e-3, 1e-2), (1.0, 2.0), (1.0, 10.0))))
    more = ["--level", "1"] if command == "level" else []
    at = ["--at", "M_over_M0=2", *AT[command]]
    assert main([command, str(table), "-o", str(tmp_path / "all.png"), *at, *more]) == 0
    df = analysis.load(table, done_only=False)
    some = df[(df["M_over_M0"] == 2) & ((df["V_over_V0"] == 10) | (not AT[command]))]
    some.to_csv(tmp_path / "some.csv")
    assert main([command, str(tmp_path / "some.csv"), "-o", str(tmp_path / "b.png"), *at, *more]) == 0
    assert (tmp_path / f"all.{command}.csv").read_bytes() == (tmp_path / f"b.{command}.csv").read_bytes()
    assert main([command, str(table), "-o", str(tmp_path / "c.png"), "--at", "M_over_M0=77", *AT[command], *more]) == 2
    assert "no finished row has M_over_M0 = 77; " in capsys.readouterr().err


def test_the_best_can_be_asked_for_over_any_two_parameters(table, tmp_path, capsys):
    arguments = ["best", str(table), "-o", str(tmp_path / "a.png"), "--over", "M_over_M0,zeta_T"]
    assert main(arguments) == 0
    shown = pd.read_csv(tmp_path / "a.best.csv")
    df = analysis.load(table)
    lowest = df[~df["chaotic"].fillna(False)].groupby(["M_over_M0", "zeta_T"])["ke_ratio"].min()
    found = shown[~shown["chaotic"]].set_index(["M_over_M0", "zeta_T"])["ke_ratio"]
    np.testing.assert_allclose(found, lowest.loc[found.index])
    assert len(shown) == df["M_over_M0"].nunique() * df["zeta_T"].nunique()
    assert main([*arguments[:4], "--over", "N,N"]) == 2
    assert "a picture is over two different parameters, not over N, N" in capsys.readouterr().err


def test_the_best_of_each_of_several_lattices_needs_one_of_them_or_their_axis(table, tmp_path, capsys):
    df = analysis.load(table)
    softer = df.assign(**{"spring.c2": 4.0}, ke_ratio=df["ke_ratio"] * 2)
    pd.concat([df.assign(**{"spring.c2": 5.0}), softer], ignore_index=True).to_csv(tmp_path / "laws.csv")
    arguments = ["best", str(tmp_path / "laws.csv"), "-o", str(tmp_path / "a.png"), "--force"]
    assert main(arguments) == 2
    assert "varies spring.c2: choose the rows of one chain (--at spring.c2=VALUE)" in capsys.readouterr().err
    assert main([*arguments, "--at", "spring.c2=4"]) == 0
    one = pd.read_csv(tmp_path / "a.best.csv")["ke_ratio"].min()
    assert main([*arguments, "--over", "spring.c2,zeta_T"]) == 0
    both = pd.read_csv(tmp_path / "a.best.csv").groupby("spring.c2")["ke_ratio"].min()
    assert both[4.0] == one == 2 * both[5.0]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["best", "map", "points", "transition", "collapse"])
def test_the_numbers_of_a_picture_do_not_pass_for_a_table_in_pictures_but_can_be_explored(
    table, tmp_path, capsys, command
):
    at = ["--at", "M_over_M0=2", "V_over_V0=10"] if command == "map" else []
    assert main([command, str(table), "-o", str(tmp_path / "a.png"), *at]) == 0
    numbers = tmp_path / f"a.{command}.csv"
    for other in ("best", "transition", "collapse"):
        capsys.readouterr()
        assert main([other, str(numbers), "-o", str(tmp_path / "b.png")]) == 2
        assert f"the numbers of a picture that `analysis {command}` drew" in capsys.readouterr().err
        assert not (tmp_path / "b.png").exists()
    if command in ("best", "map", "points"):  # rows, which a page shows under the names of their columns
        assert main(["page", str(numbers), "-o", str(tmp_path / "b.html")]) == 0


def test_curves_take_their_colours_from_the_same_two_ends_of_a_colour_map_however_many_they_are():
    look = Look(cmap="viridis")
    many = look.colours(9)
    assert len(set(many)) == 9
    assert look.colours(1) == many[:1]
    assert look.colours(2) == [many[0], many[-1]]
    assert look.colours(3) == [many[0], many[4], many[-1]]
