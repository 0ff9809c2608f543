"""The command `findings`: every finding of every table, and bad tables refused in one line."""

import numpy as np
import pandas as pd
import pytest

from analysis.cli import main
from sweep.schema import ROW, seal

from .test_analysis_cli import write
from .test_analysis_findings import frame, profiles
from .test_analysis_refusals import BAD_TABLES


def table(path, df):
    rows = np.zeros(len(df), ROW)
    for name in ("N", "zeta_T", "M_over_M0", "V_over_V0", "ke_ratio", "error", "chaotic"):
        rows[name] = df[name]
    rows["status"], rows["checked"] = b"done", True
    seal(rows)
    return write(path, rows)


def test_the_command_tells_every_finding_of_every_table(tmp_path, capsys):
    table(tmp_path / "a.h5", frame())
    profiles().to_csv(tmp_path / "fig11.csv")
    assert main(["findings", str(tmp_path / "a.h5"), str(tmp_path / "fig11.csv")]) == 0
    told = capsys.readouterr().out.splitlines()
    tables = [line.split()[-1] for line in told if line.startswith("table")]
    assert tables == [str(tmp_path / name) for name in ("a.h5", "fig11.csv")]
    held = [line.partition(":")[0] for line in told if line.startswith("finding")]
    assert held == [f"finding {number} holds" for number in (1, 2, 3, 5, 4)]
    assert sum(line.startswith("  rule") for line in told) == 5


def test_the_command_reads_an_exported_table(tmp_path, capsys):
    frame().to_csv(tmp_path / "a.csv")
    assert main(["findings", str(tmp_path / "a.csv")]) == 0
    assert capsys.readouterr().out.count(" holds: ") == 4


def refused(paths, said, capsys):
    assert main(["findings", *map(str, paths)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.removeprefix("analysis: ").splitlines()
    assert len(lines) == len(said)
    assert all(text in line for text, line in zip(said, lines, strict=True))


@pytest.mark.parametrize(("make", "told"), BAD_TABLES)
def test_a_bad_table_exits_2_with_one_line(tmp_path, capsys, make, told):
    make(tmp_path / "t.h5")
    refused([tmp_path / "t.h5"], [told], capsys)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "there is no table"),
        ("", "a.csv cannot be read as CSV"),
        ("\0\0\n1,2,3", "a.csv: the table lacks the columns"),
        ("n,v\n1,2\n", "a.csv: the table lacks the columns"),
        ("n,v,N,V_over_V0,law,against\nx,1,50,4,linear,N\n", "a.csv: the table must hold numbers"),
    ],
)
def test_a_bad_csv_exits_2_with_one_line(tmp_path, capsys, text, said):
    if text is not None:
        (tmp_path / "a.csv").write_text(text)
    refused([tmp_path / "a.csv"], [said], capsys)


def test_all_bad_tables_are_told_at_once_and_a_good_one_beside_them_is_not(tmp_path, capsys):
    paths = [tmp_path / f"{name}.h5" for name in ("none", "good", "chaotic", "one")]
    table(paths[1], frame())
    table(paths[2], frame().assign(chaotic=True))
    table(paths[3], frame(N=[50]))
    refused(paths, ["there is no table", "chaotic.h5: every finished row", "one.h5: every finding compares"], capsys)


def test_the_rows_of_one_chain_are_chosen_as_the_message_says(tmp_path, capsys):
    """A table over a law's number holds several chains, of which each has findings of its own."""
    several = pd.concat([frame().assign(**{"spring.c2": c2}) for c2 in (4.0, 5.0)], ignore_index=True)
    several.to_csv(tmp_path / "t.csv", index_label="task")
    assert main(["findings", str(tmp_path / "t.csv")]) == 2
    assert "choose the rows of one chain (--at spring.c2=VALUE)" in capsys.readouterr().err
    assert main(["findings", str(tmp_path / "t.csv"), "--at", "spring.c2=4"]) == 0
    assert "finding 1 holds" in capsys.readouterr().out
