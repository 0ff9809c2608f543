"""A larger sweep takes the rows that an older table has, and only those that it would compute to the same bits."""

import json
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import analysis
from analysis.paper.sweeps import history as told_on_the_page
from analysis.table import reused
from sweep.store.structure import seal_structure

from .conftest import SMALL, TIME_LIMIT, changed, clean_environment, rows_of


@pytest.fixture
def larger(tmp_path: Path) -> Path:
    """The small sweep with one more N."""
    path = tmp_path / "larger.toml"
    path.write_text(SMALL.replace("[5, 8, 13]", "[3, 5, 8, 13]"))
    return path


def test_finished_rows_of_older_tables_are_taken_and_the_table_is_the_same(
    sweep, small_spec, larger, tmp_path, physics
):
    sweep("run", small_spec, "-o", "old.h5", "--shard", "1/3")
    sweep("run", small_spec, "-o", "older.h5", "--shard", "3/3")
    sweep("run", larger, "-o", "fresh.h5")
    answer = sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5", "--reuse", "older.h5", ranks=2)
    assert answer.returncode == 0
    assert "8 rows taken from old.h5" in answer.stderr
    assert "8 rows taken from older.h5" in answer.stderr
    assert "32 tasks, 16 left; " in answer.stderr
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "fresh.h5")
    again = sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    assert "0 rows taken from old.h5" in again.stderr


def test_torn_and_failed_rows_are_not_taken(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    with changed(tmp_path / "old.h5") as rows:
        rows["ke_ratio"][2] = 1.0
    assert "23 rows taken from old.h5" in sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5").stderr


def test_tables_that_cannot_be_reused_are_all_named_and_nothing_is_written(sweep, small_spec, larger, tmp_path):
    rule = "its rows are not as accurate as this sweep's are to be"
    small_spec.write_text(SMALL.replace("1e-2", "1e-3"))
    sweep("run", small_spec, "-o", "kernel.h5")
    with h5py.File(tmp_path / "kernel.h5", "r+") as file:
        del file["provenance/kernel"]
        file["provenance/kernel"] = np.bytes_("0123456789abcdef")
    seal_structure(tmp_path / "kernel.h5")
    small_spec.write_text(SMALL + "certify = false\n")
    sweep("run", small_spec, "-o", "looser.h5")
    larger.write_text(larger.read_text().replace("1e-2", "1e-3"))
    olds = [f"--reuse={name}" for name in ("kernel.h5", "looser.h5", "none.h5")]
    answer = sweep("run", larger, "-o", "t.h5", *olds)
    assert answer.returncode == 2
    assert answer.stderr.splitlines() == [
        "sweep: --reuse kernel.h5: was computed by another version of the kernel",
        f"sweep: --reuse looser.h5: {rule} (target 0.01, wanted 0.001 or less; not certified)",
        "sweep: none.h5: cannot be read: No such file or directory",
    ]
    assert not (tmp_path / "t.h5").exists()


def test_recompute_throws_away_the_rows_of_another_kernel_and_only_those(sweep, small_spec, tmp_path, physics):
    sweep("run", small_spec, "-o", "fresh.h5")
    sweep("run", small_spec, "-o", "t.h5")
    assert "24 tasks, 0 left; " in sweep("run", small_spec, "-o", "t.h5", "--recompute").stderr
    with changed(tmp_path / "t.h5", "runs") as runs:
        runs["kernel"][0] = b"0123456789abcdef"  # as after --keep-rows, under a name that has changed back
    refused = sweep("run", small_spec, "-o", "t.h5")
    assert refused.returncode == 2
    assert "or --keep-rows to keep its finished rows all the same, or --recompute to throw them away" in refused.stderr
    assert "24 tasks, 24 left; " in sweep("run", small_spec, "-o", "t.h5", "--recompute").stderr
    assert physics(tmp_path / "t.h5") == physics(tmp_path / "fresh.h5")
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0


def test_a_table_cannot_be_reused_for_itself(sweep, small_spec, tmp_path):
    sweep("run", small_spec, "-o", "t.h5")
    before = (tmp_path / "t.h5").read_bytes()
    answer = sweep("run", small_spec, "-o", "t.h5", "--reuse", "./t.h5")
    assert answer.returncode == 2
    assert answer.stderr == "sweep: --reuse t.h5: is the table that is to be written\n"
    assert (tmp_path / "t.h5").read_bytes() == before


def test_a_table_open_elsewhere_takes_nothing_and_says_so(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "t.h5", "--shard", "1/1")
    with h5py.File(tmp_path / "t.h5", "r+"):
        answer = sweep("run", larger, "-o", "t.h5", "--shard", "1/1", "--reuse", "old.h5")
    assert answer.returncode == 2
    assert answer.stderr.startswith("sweep: t.h5: ")
    assert "Traceback" not in answer.stderr


def told(sweep, table) -> dict:
    return json.loads(sweep("show", table, "--json").stdout)


def test_what_was_taken_over_is_told_for_good(sweep, small_spec, larger, tmp_path, capsys):
    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    for _ in range(2):  # a second time there is nothing to take, and nothing more is told
        sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    (entry,) = told(sweep, "t.h5")["reused"]
    assert (entry["table"], entry["rows"]) == (str(tmp_path / "old.h5"), 24)
    assert entry["accuracy"] == "auto at target 0.01, certified"
    assert [run["rows"] for run in told(sweep, "t.h5")["runs"]] == [8, 0, 0]
    assert told(sweep, "old.h5")["reused"] == []
    shown = sweep("show", "t.h5").stdout.splitlines()
    place = next(k for k, line in enumerate(shown) if line.endswith("old.h5"))
    assert shown[place + 1].split() == ["rows", "24"]
    sweep("merge", "t.h5", "-o", "merged.h5")
    for name, rows in (("old.h5", 0), ("t.h5", 24), ("merged.h5", 24)):
        assert sum(reused(tmp_path / name).values()) == rows


def test_a_picture_says_how_much_of_its_table_was_taken_over(sweep, small_spec, larger, tmp_path, capsys):
    from analysis import cli

    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    assert cli.main(["best", str(tmp_path / "t.h5"), "-o", str(tmp_path / "best.png")]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("table "))
    taken = f"24 of 32 rows taken over from {tmp_path / 'old.h5'}"
    assert line.endswith(f" s without start and compiling, {taken}")
    assert f" s of computing, its own and that of {taken}, " in told_on_the_page(tmp_path / "t.h5")["seconds"]
    assert "taken over" not in told_on_the_page(tmp_path / "old.h5")["seconds"]


def test_a_path_too_long_for_its_place_keeps_its_end(tmp_path):
    from sweep.store.reuse import entry, reused

    (told,) = reused(entry(3, "/" + "é" * 300 + "/t.h5", "auto", "0123"))
    assert told["table"].startswith("...")
    assert told["table"].endswith("é/t.h5")


@pytest.mark.parametrize(
    ("had", "wanted"),
    [
        ("target = 1e-3", "target = 1e-2"),
        ("target = 1e-2", "target = 1e-2\ncertify = false"),
        ("method = 'rk45'\nrtol = 1e-7", "method = 'rk45'\nrtol = 1e-6"),
        ("target = 1e-2\nmax_steps = 2000000", "target = 1e-2\nmax_steps = 1000000"),
    ],
)
def test_rows_that_are_more_accurate_serve_a_looser_sweep_and_never_the_reverse(
    sweep, small_spec, larger, tmp_path, had, wanted
):
    small_spec.write_text(SMALL.replace("target = 1e-2", had))
    larger.write_text(larger.read_text().replace("target = 1e-2", wanted))
    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "begun.h5", "--max-fails", "0")
    assert "24 rows taken from old.h5" in sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5").stderr
    # Where a row is there already, it stays: that it differs is no disagreement.
    again = sweep("run", larger, "-o", "begun.h5", "--reuse", "old.h5")
    assert (again.returncode, "0 rows taken from old.h5" in again.stderr) == (0, True)
    ours, theirs = analysis.load(tmp_path / "t.h5"), analysis.load(tmp_path / "old.h5")
    both = ours[ours["N"] > 3]
    np.testing.assert_array_equal(both["ke_ratio"], theirs["ke_ratio"])
    reverse = sweep("run", small_spec, "-o", "r.h5", "--reuse", "t.h5")
    assert reverse.returncode == 2
    assert "are not as accurate as this sweep's are to be" in reverse.stderr
    assert not (tmp_path / "r.h5").exists()


def test_a_row_that_ran_out_of_steps_disagrees_with_no_row_that_was_given_more(sweep, small_spec, tmp_path, physics):
    small_spec.write_text(SMALL)
    assert sweep("run", small_spec, "-o", "old.h5").returncode == 0
    small_spec.write_text(f"{SMALL}max_steps = 400\n")
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 1
    before = physics(tmp_path / "t.h5")
    again = sweep("run", small_spec, "-o", "t.h5", "--reuse", "old.h5")
    assert (again.returncode, "0 rows taken from old.h5" in again.stderr) == (1, True)
    assert physics(tmp_path / "t.h5") == before


def test_another_sweep_in_the_place_of_the_table_is_refused_with_the_way_to_reuse_it(sweep, small_spec, larger):
    sweep("run", small_spec, "-o", "t.h5")
    refused = sweep("run", larger, "-o", "t.h5")
    assert refused.returncode == 2
    assert refused.stderr.endswith("give another -o, and --reuse t.h5 to take over the rows that both have\n")
    assert sweep("run", larger, "-o", "other.h5", "--reuse", "t.h5").returncode == 0


KILLED = """
import os, sys
from sweep import cli
from sweep.store import table

write, after = table.write_rows, sys.argv.pop(1) == "after"


def killed(dataset, ids, rows):
    if after:
        write(dataset, ids, rows)
        dataset.file.flush()
    os._exit(9)


table.write_rows = killed
cli.main(sys.argv[1:])
"""


def test_a_kill_after_rows_were_taken_leaves_the_word_where_they_come_from(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    command = [sys.executable, "-P", "-c", KILLED, "after", "run", str(larger), "-o", "t.h5", "--reuse", "old.h5"]
    killed = subprocess.run(command, cwd=tmp_path, env=clean_environment(), check=False, timeout=TIME_LIMIT)
    assert killed.returncode == 9
    assert (len(analysis.load(tmp_path / "t.h5")), sum(reused(tmp_path / "t.h5").values())) == (24, 24)
    assert sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5").returncode == 0
    assert sum(reused(tmp_path / "t.h5").values()) == 24


def test_where_rows_come_from_is_on_the_disk_before_them(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    command = [sys.executable, "-P", "-c", KILLED, "before", "run", str(larger), "-o", "t.h5", "--reuse", "old.h5"]
    killed = subprocess.run(command, cwd=tmp_path, env=clean_environment(), check=False, timeout=TIME_LIMIT)
    assert killed.returncode == 9
    assert sum(reused(tmp_path / "t.h5").values()) == 24


def log_of(path):
    return rows_of(path, "runs")


def fill_log(path, entries=()):
    """As after a thousand runs; those numbered `entries` stand for rows taken over."""
    with changed(path, "runs") as log:
        log[1:] = log[0]
        log["updated"] += np.arange(len(log))
        log["writer"][list(entries)] = b"reuse"


def test_a_full_list_of_runs_loses_none_to_rows_taken_over(sweep, small_spec, larger, tmp_path):
    sweep("run", small_spec, "-o", "old.h5")
    sweep("run", larger, "-o", "t.h5", "--max-fails", "0", "--until", "1s")
    sweep("run", larger, "-o", "whole.h5")
    for name in ("t.h5", "whole.h5"):
        fill_log(tmp_path / name)
    with changed(tmp_path / "t.h5") as rows:
        rows["status"] = b"pending"
    before = (tmp_path / "t.h5").read_bytes()
    refused = sweep("run", larger, "-o", "t.h5", "--reuse", "old.h5")
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)
    assert refused.stderr.endswith("give another -o, and --reuse t.h5 besides\n")
    assert (tmp_path / "t.h5").read_bytes() == before
    # Where nothing is taken nothing is to be said: only the run itself takes the last place, as ever.
    told = log_of(tmp_path / "whole.h5")
    assert "0 rows taken from old.h5" in sweep("run", larger, "-o", "whole.h5", "--reuse", "old.h5").stderr
    assert np.array_equal(log_of(tmp_path / "whole.h5")[:-1], told[:-1])
    assert log_of(tmp_path / "whole.h5")["start"][-1] > told["start"][-1]


def test_a_run_overwrites_no_word_of_rows_taken_over(sweep, small_spec, tmp_path):
    sweep("run", small_spec, "-o", "t.h5")
    fill_log(tmp_path / "t.h5", [998, 999])
    before = log_of(tmp_path / "t.h5")
    assert sweep("run", small_spec, "-o", "t.h5").returncode == 0
    changed = np.flatnonzero(log_of(tmp_path / "t.h5") != before)
    assert changed.tolist() == [997]


def test_nor_do_rows_of_a_store_where_the_list_of_runs_is_full(sweep, small_spec, tmp_path):
    sweep("run", small_spec, "-o", "old.h5", "--store", "rows")
    sweep("run", small_spec, "-o", "t.h5", "--max-fails", "0", "--until", "1s")
    fill_log(tmp_path / "t.h5", [998, 999])
    with changed(tmp_path / "t.h5") as rows:
        rows["status"] = b"pending"
    before = log_of(tmp_path / "t.h5")
    answer = sweep("run", small_spec, "-o", "t.h5", "--store", "rows")
    assert answer.stdout.startswith("24 done")
    assert "0 rows taken from the store rows" in answer.stderr
    assert np.flatnonzero(log_of(tmp_path / "t.h5") != before).tolist() == [997]


def test_a_run_calls_rows_unchecked_only_where_some_are(sweep, small_spec, tmp_path):
    """All that it took from a certified table are checked, though the run asked for no check."""
    (tmp_path / "loose.toml").write_text(SMALL + "certify = false\n")
    assert sweep("run", small_spec, "-o", "old.h5").returncode == 0
    taken = sweep("run", "loose.toml", "-o", "t.h5", "--reuse", "old.h5")
    assert "24 done, 0 failed, 0 left" in taken.stderr + taken.stdout
    assert "not checked for chaos" not in taken.stderr + taken.stdout
    fresh = sweep("run", "loose.toml", "-o", "fresh.h5")
    assert "; not checked for chaos" in fresh.stderr + fresh.stdout
