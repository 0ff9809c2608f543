"""Claims about the file of a table's page: what may be written where, and that nothing in it can become code."""

import pandas as pd
import pytest

from analysis.cli import main
from analysis.page import build
from analysis.table import load

from .test_analysis_cli import rows, write
from .test_analysis_page_table import GRID

pytestmark = pytest.mark.slow


def test_a_column_name_or_a_table_name_cannot_become_code(tmp_path):
    df = load(write(tmp_path / "t.h5", rows(GRID)), done_only=False)
    text = build(df.assign(**{"</script><b>": 1.0}), "<i>&.h5")
    assert "</script><b>" not in text
    assert "<i>" not in text


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("page.txt", "-o: page.txt: a page ends in .html"),
        ("none/page.html", "-o: there is no directory 'none' to write 'page.html' in"),
        (f"{'x' * 300}.html", f"-o: '{'x' * 300}.html' cannot be written: File name too long"),
        ("notes.html", "-o: notes.html is not as this program left it; --force replaces it"),
    ],
)
def test_a_page_that_may_not_be_written_is_refused_in_one_line(name, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "t.h5", rows(GRID))
    (tmp_path / "notes.html").write_text("mine")
    assert main(["page", "t.h5", "-o", name]) == 2
    assert capsys.readouterr().err == f"analysis: {said}\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.html", "t.h5"]


def test_a_page_replaces_itself_and_reads_a_csv_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    df = load(write(tmp_path / "t.h5", rows(GRID)))
    df.to_csv("t.csv")
    for table in ("t.h5", "t.csv"):
        assert main(["page", table, "-o", "t.html"]) == 0
    assert "t.csv" in (tmp_path / "t.html").read_text()
    assert isinstance(pd.read_csv("t.csv"), pd.DataFrame)
