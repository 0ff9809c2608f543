"""Rows that form no grid are drawn as the points that they are."""

import numpy as np
import pandas as pd
import pytest

from analysis.cli import main
from analysis.draw_points import points_figure
from analysis.level import crossings
from analysis.notes import of_points
from analysis.scatter import refuse_points, scattered
from analysis.ticks import label
from sweep.errors import InputError

from .drawn import legend, written


def sample(n=40, seed=None):
    """Random points, some chaotic, two failed, and a number of the model among the inputs."""
    rng = np.random.default_rng(seed)
    status = np.full(n, "done", object)
    status[:2] = "step_budget"
    return pd.DataFrame(
        {
            "N": rng.integers(5, 200, n),
            "zeta_T": 10 ** rng.uniform(-5, -2, n),
            "M_over_M0": 10 ** rng.uniform(-1, 1, n),
            "V_over_V0": 2.0,
            "spring.c2": rng.uniform(4.0, 5.2, n),
            "ke_ratio": np.where(status == "done", 10 ** rng.uniform(-1, 0.5, n), np.nan),
            "error": 1e-4,
            "chaotic": np.arange(n) % 7 == 6,
            "checked": True,
            "spread_low": np.nan,
            "spread_high": np.nan,
            "status": status,
        }
    )


def test_every_finished_row_is_a_dot_at_its_own_place():
    table, over = sample(), ("zeta_T", "spring.c2")
    rows = scattered(table, over)
    assert len(rows) == 38
    figure = points_figure(rows, over, of_points(table, rows, over))
    ax = figure.axes[0]
    dots = ax.collections[0].get_offsets()
    drawn = {(float(x), float(y)) for x, y in dots}
    assert drawn == set(zip(rows["zeta_T"], rows["spring.c2"], strict=True))
    assert len(ax.collections[1].get_offsets()) == int(rows["chaotic"].sum()), "a ring around every chaotic one"
    assert ax.get_xscale() == "log"
    text = " ".join(one.get_text() for one in figure.texts)
    assert "2 failed" in text
    assert "Here $N$ from" in figure.texts[0].get_text(), "what is not drawn differs from point to point, and is said"
    assert "spring.c2 from" not in written(figure)
    other = written(points_figure(rows, ("N", "zeta_T"), of_points(table, rows, ("N", "zeta_T"))))
    low, high = (label(float(end)) for end in (rows["spring.c2"].min(), rows["spring.c2"].max()))
    assert f"spring.c2 from {low} to {high}." in other


def test_points_that_nobody_checked_are_not_called_calm(tmp_path, capsys):
    sample().assign(chaotic=None, checked=False).to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["points", str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png")]) == 0
    told = capsys.readouterr().out
    assert "not checked" in told
    assert "none of them chaotic" not in told


def test_points_are_drawn_by_their_command_and_refused_by_map(tmp_path, capsys):
    table, picture = tmp_path / "t.csv", tmp_path / "p.png"
    made = sample(60, 1)
    made.loc[6, "ke_ratio"] = 1e-3  # a chaotic one
    made.to_csv(table, index=False)
    assert main(["points", str(table), "-o", str(picture)]) == 0
    assert picture.stat().st_size > 10_000
    assert len(pd.read_csv(tmp_path / "p.points.csv")) == 58
    told = capsys.readouterr().out
    assert "58 rows, each a point; 8 of 58 points, chaotic" in told
    assert "lowest    ke_ratio = " in told
    assert "chaotic   1 point is lower, down to ke_ratio = " in told
    assert main(["map", str(table), "-o", str(tmp_path / "m.png")]) == 2
    assert "form no grid over N and zeta_T" in capsys.readouterr().err
    assert main(["points", str(table), "-o", str(picture), "--force", "--over", "N,zeta"]) == 2
    assert "unknown parameters zeta" in capsys.readouterr().err
    assert main(["points", str(table), "-o", str(picture), "--force", "--over", "c2,N"]) == 2
    assert "V_over_V0, spring.c2; c2 (did you mean 'spring.c2'?)" in capsys.readouterr().err


def test_the_best_of_points_is_refused_too_unless_there_are_several_at_a_place(tmp_path, capsys):
    table, picture = tmp_path / "t.csv", tmp_path / "b.png"
    one = sample(60, 1).assign(**{"spring.c2": 4.0})
    one.to_csv(table, index=False)
    assert main(["best", str(table), "-o", str(picture)]) == 2
    assert "60 rows form no grid over N and zeta_T" in capsys.readouterr().err
    assert not picture.exists()
    pd.concat([one, one.assign(V_over_V0=4.0)]).to_csv(table, index=False)
    assert main(["best", str(table), "-o", str(picture)]) == 0


def test_of_points_at_one_place_the_lowest_is_on_top_and_how_many_there_are_is_told(tmp_path, capsys):
    table, over = sample().assign(N=10, zeta_T=1e-3), ("N", "zeta_T")
    rows = scattered(table, over)
    figure = points_figure(rows, over, of_points(table, rows, over))
    calm = rows.loc[~rows["chaotic"], "ke_ratio"]
    assert figure.axes[0].collections[0].get_array()[-1] == calm.min()
    said = "38 points lie at 1 place, the lowest on top, chaotic ones (ringed) below the others."
    assert said in written(figure)
    table.to_csv(tmp_path / "t.csv", index=False)
    assert main(["points", str(tmp_path / "t.csv"), "-o", str(tmp_path / "a.png")]) == 0
    assert f"places    {said}" in capsys.readouterr().out
    apart = scattered(sample(), over)
    assert "lie at" not in written(points_figure(apart, over, of_points(sample(), apart, over)))


@pytest.mark.parametrize("over", [("N", "zeta_T"), ("zeta_T", "spring.c2")])
def test_the_star_of_a_point_at_the_edge_lies_within_the_axes_and_off_the_title(over):
    table = sample(seed=1)
    table.loc[table[over[1]][2:6].idxmax(), "ke_ratio"] = 1e-3
    table.loc[table["ke_ratio"].idxmin(), over[1]] = 1.01 * table[over[1]].max()
    rows = scattered(table, over)
    ax = points_figure(rows, over, of_points(table, rows, over)).axes[0]
    (star,) = (line for line in ax.get_lines() if line.get_marker() == "*")
    box, inside = star.get_window_extent(), ax.get_window_extent()
    assert inside.fully_contains(*box.min)
    assert inside.fully_contains(*box.max)


def test_the_star_covers_no_point_and_its_inputs_are_named():
    table, over = sample(), ("N", "zeta_T")
    rows = scattered(table, over)
    figure = points_figure(rows, over, of_points(table, rows, over))
    (star,) = (line for line in figure.axes[0].get_lines() if line.get_marker() == "*")
    assert star.get_markerfacecolor() == "none"
    (lowest,) = (text for text in legend(figure) if text.startswith("lowest: "))
    assert all(f"{name} = " in lowest for name in ("$N$", r"$\zeta_T$", "$M/M_0$", "spring.c2"))
    assert "$V/V_0$" not in lowest, "which is the same for all"


def test_a_grid_is_no_scatter_even_where_rows_are_missing():
    grid = pd.MultiIndex.from_product([range(5, 25), np.geomspace(1e-5, 1e-2, 20)], names=["N", "zeta_T"])
    table = grid.to_frame(index=False).assign(status="done")
    refuse_points(table.sample(frac=0.3, random_state=0), ("N", "zeta_T"))
    with pytest.raises(InputError, match=r"`analysis points` draws them"):
        refuse_points(sample(), ("zeta_T", "M_over_M0"))
    line = pd.DataFrame({"N": np.arange(60), "zeta_T": np.arange(60) % 5})
    for over in (("N", "zeta_T"), ("zeta_T", "N")):
        with pytest.raises(InputError, match="60 rows form no grid"):
            refuse_points(line, over)


def test_what_cannot_be_drawn_is_said():
    with pytest.raises(InputError, match=r"rows form no lines along N: .* `analysis points` draws them"):
        crossings(sample(), 1.0)
    with pytest.raises(InputError, match="two different parameters"):
        scattered(sample(), ("N", "N"))
    with pytest.raises(InputError, match="there is no finished row with a ke_ratio"):
        scattered(sample().assign(ke_ratio=np.nan), ("N", "zeta_T"))
