"""What was edited into an exported .csv and can stand in no table is told by file, column, line and value."""

import numpy as np
import pandas as pd
import pytest

from analysis.cli import main
from analysis.exported import read_exported
from analysis.optimum import optimum

from .conftest import problems_of
from .drawn import frame

GRID = ((5, 10, 40), (0.0, 1e-3), (2.0,), (1.0, 2.0))


@pytest.fixture
def csv(tmp_path):
    more = {"wall_force_ratio": 0.5, "wall_force_error": 1e-3, "spring.c2": 5.0, "rank": -1, "mine": "?"}
    frame(GRID).assign(checked=True, **more).to_csv(tmp_path / "t.csv", index_label="task")
    return tmp_path / "t.csv"


def edited(csv, column, value, lines):
    """The table with this value, as text, in these lines of the file."""
    df = pd.read_csv(csv, dtype=str)
    df.loc[[line - 2 for line in lines], column] = value
    df.to_csv(csv, index=False)


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("N", "5.5", "must be a whole number from 2 to 10000, got 5.5"),
        ("N", "ten", "must be a whole number from 2 to 10000, got 'ten'"),
        ("zeta_T", "-1", "must be a number from 0 to 10, got -1.0"),
        ("zeta_T", "", "must be a number from 0 to 10, got nothing"),
        ("V_over_V0", "inf", "must be a number from 0.01 to 20, got inf"),
        ("ke_ratio", "-0.5", "must be a finite number of 0 or more, or empty, got -0.5"),
        ("ke_ratio", "inf", "must be a finite number of 0 or more, or empty, got inf"),
        ("error", "small", "must be a finite number of 0 or more, or empty, got 'small'"),
        ("wall_force_ratio", "True", "must be a finite number, or empty, got 'True'"),
        ("wall_force_error", "-inf", "must be a finite number, or empty, got -inf"),
        ("spring.c2", "soft", "must be a finite number, or empty, got 'soft'"),
        ("chaotic", "maybe", "must be True, False or empty, got 'maybe'"),
        ("task", "first", "must be a finite number of 0 or more, or empty, got 'first'"),
    ],
)
@pytest.mark.parametrize("command", [["best", "-o", "a.png"], ["findings"], ["page", "-o", "a.html"]])
def test_what_no_table_holds_is_told_in_one_line(csv, tmp_path, capsys, monkeypatch, command, column, value, said):
    edited(csv, column, value, [4, 7])
    monkeypatch.chdir(tmp_path)
    assert main([command[0], "t.csv", *command[1:]]) == 2
    assert capsys.readouterr() == ("", f"analysis: t.csv: {column}, line 4: {said} (and 1 more)\n")
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


@pytest.mark.parametrize("command", ["points", "level", "collapse", "transition", "best", "map", "findings", "page"])
def test_a_column_that_is_missing_cannot_be_fixed_by_at(csv, tmp_path, capsys, command):
    pd.read_csv(csv).drop(columns="M_over_M0").to_csv(csv, index=False)
    out = [] if command == "findings" else ["-o", str(tmp_path / ("a.html" if command == "page" else "a.png"))]
    level = ["--level", "1"] if command == "level" else []
    assert main([command, str(csv), "--at", "M_over_M0=2", *out, *level]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "lacks the columns M_over_M0" in err


@pytest.mark.parametrize("command", [["points"], ["level", "--level", "1"]])
def test_rows_without_a_number_of_the_model_are_refused_and_never_left_out_in_silence(csv, tmp_path, capsys, command):
    edited(csv, "spring.c2", "", [4, 7])
    command = [*command, str(csv), "-o", str(tmp_path / "a.png")]
    assert main(command) == 2
    said = "2 of 12 finished rows have no spring.c2: give it, or choose others (--at spring.c2=VALUE)"
    assert capsys.readouterr() == ("", f"analysis: {said}\n")
    assert main([*command, "--at", "spring.c2=5"]) == 0


@pytest.mark.parametrize("column", ["spread_low", "spread_high"])
def test_half_of_a_spread_says_nothing_of_it(csv, column):
    """Chaotic rows are as sure as their error says, as without a spread."""
    whole = pd.read_csv(csv).assign(chaotic=True, spread_low=0.5, spread_high=7.0)
    found = [str(optimum(whole.drop(columns=names))) for names in ([column], ["spread_low", "spread_high"])]
    assert found[0] == found[1] != str(optimum(whole))


def test_every_column_that_is_wrong_is_told(csv):
    for column in ("N", "ke_ratio", "checked"):
        edited(csv, column, "x", [3])
    assert [problem.split(": ")[1] for problem in problems_of(read_exported, csv)] == [
        f"{name}, line 3" for name in ("N", "ke_ratio", "checked")
    ]


def test_what_is_not_known_may_be_empty_and_columns_of_others_hold_what_they_like(csv):
    for column in ("ke_ratio", "error", "chaotic", "checked"):
        edited(csv, column, "", [3])
    table = read_exported(csv)
    assert table.iloc[1][["ke_ratio", "error", "chaotic", "checked"]].isna().all()
    assert table["chaotic"].dtype == table["checked"].dtype == "boolean"
    assert (table["mine"] == "?").all()
    edited(csv, "checked", "0", [3])  # as other programs write a flag
    assert np.count_nonzero(~read_exported(csv)["checked"]) == 1
