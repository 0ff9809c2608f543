"""Every picture and line says which part of its sweep a table holds, and its grid is the whole sweep's."""

import importlib
import json
import re

import h5py
import numpy as np
import pytest

import sweep
from analysis.cli import main
from analysis.part import axes_of, shard_of
from analysis.table import IMPACT, load
from sweep.plan.lowest import around
from sweep.schema import seal
from sweep.store.merge import merge

from .conftest import changed
from .drawn import legend, mesh, written
from .test_analysis_cli import rows, write

GRID = {
    "N": [5, 8, 13, 20, 50, 100],
    "zeta_T": [1e-5, 1e-4, 4e-4, 1e-3, 1e-2],
    "M_over_M0": [0.1, 1.0, 2.0],
    "V_over_V0": [1.0, 10.0],
}
LOWEST = {"find": "lowest", "of": "ke_ratio", "over": ["M_over_M0", "V_over_V0"]}
MAP = {"find": "map", "of": "ke_ratio", "over": ["N", "zeta_T"], "error": 0.05}
PICTURES = {
    "best": [],
    "map": ["--at", "M_over_M0=1", "V_over_V0=10"],
    "points": [],
    "level": ["--level", "0.02"],
    "collapse": [],
    "transition": [],
}


def table(path, data, **told):
    """A table that tells its spec, or its shard, as `sweep run` writes it."""
    write(path, data)
    with h5py.File(path, "r+") as file:
        resolved = {"grid": GRID} | {name: told.pop(name) for name in ("search",) if name in told}
        for name, text in ({"resolved": json.dumps(resolved)} | told).items():
            file[f"provenance/{name}"] = text.encode()
    return path


def searched(path, search, keep, **columns):
    """The table of a search that has computed the rows `keep`, with the numbers of some columns."""
    data = rows(tuple(GRID.values()))
    for name, value in columns.items():
        data[name] = value
    data["status"][~keep(data)] = b"unasked"
    seal(data)
    return table(path, data, search=search)


def best_impact(data):
    return (data["M_over_M0"] == 1) & (data["V_over_V0"] == 10)


def corners(data):
    """As a search for a map begins, of all impacts."""
    return np.isin(data["N"], [5, 100]) & np.isin(data["zeta_T"], [1e-5, 1e-2])


@pytest.fixture
def drawn(monkeypatch, tmp_path, capsys):
    """Run a command on a table: its figure and what it prints."""

    def draw(command, path, *more):
        figures, module = [], importlib.import_module(f"analysis.commands.{command}")
        monkeypatch.setattr(module, "write", lambda _, figure, *__: figures.append(figure))
        assert main([command, str(path), "-o", str(tmp_path / "a.png"), *more]) == 0
        return figures[0], capsys.readouterr().out

    return draw


@pytest.mark.parametrize("command", PICTURES)
def test_the_table_of_a_shard_says_so_in_every_picture_and_line(command, drawn, tmp_path):
    path = table(tmp_path / "s.h5", rows(tuple(GRID.values()))[1::2], shard="2/2")
    figure, told = drawn(command, path, *PICTURES[command])
    words = "Shard 2/2 of a sweep: 90 of its 180 rows; the others are in other tables."
    assert f"shard     {words}" in told
    assert words in written(figure)


@pytest.mark.parametrize("command", PICTURES)
def test_the_table_of_a_search_says_so_in_every_picture_and_line(command, drawn, tmp_path):
    figure, told = drawn(command, searched(tmp_path / "s.h5", LOWEST, best_impact), *PICTURES[command])
    assert "search    A search: " in told
    assert "30 that may be the lowest of their cell computed. Only these are shown." in written(figure)


def test_the_page_of_a_search_says_so(tmp_path, capsys):
    assert main(["page", str(searched(tmp_path / "s.h5", LOWEST, best_impact)), "-o", str(tmp_path / "s.html")]) == 0
    assert "search    A search: " in capsys.readouterr().out
    assert "30 that may be the lowest of their cell computed." in (tmp_path / "s.html").read_text()


def test_a_search_is_drawn_as_what_it_looked_for_unless_something_else_is_asked_for(drawn, tmp_path, capsys):
    path = searched(tmp_path / "map.h5", MAP | {"of": "ke_bistable", "screen": False}, corners, ke_bistable=0.1)
    figure, told = drawn("map", path, *PICTURES["map"])
    assert "4 of 30 have a number; 26 more inferred" in told
    assert "ke_bistable = 0.1 " in told
    assert "rows computed (dots); the others are interpolated" in written(figure)
    assert "lowest    ke_ratio = " in drawn("map", path, *PICTURES["map"], "--of", "ke_ratio")[1]
    low = searched(tmp_path / "low.h5", LOWEST | {"of": "ke_bistable"}, best_impact)
    assert main(["best", str(low), "-o", str(tmp_path / "b.png")]) == 2
    assert "is a search for the lowest ke_bistable, which tells nothing of ke_ratio" in capsys.readouterr().err
    of_force = table(tmp_path / "force.h5", rows(tuple(GRID.values())), search=LOWEST | {"of": "wall_force_ratio"})
    assert main(["best", str(of_force), "-o", str(tmp_path / "b.png")]) == 2  # whose rows lack it here
    assert "got 'wall_force_ratio'" in capsys.readouterr().err


@pytest.mark.parametrize("command", PICTURES)
def test_what_a_run_has_not_come_to_is_told_below_every_picture(command, drawn, tmp_path):
    data = rows(tuple(GRID.values()))
    data["status"][data["N"] == 8] = b"pending"
    path = table(tmp_path / "t.h5", data)
    figure, told = drawn(command, path, *PICTURES[command])
    words = f"{'5 of 30' if command == 'map' else '30 of 180'} rows are yet to be computed."
    assert f"pending   {words}" in told
    assert words in written(figure)
    data["status"] = np.where(data["M_over_M0"] == 2, b"pending", b"done")
    figure, told = drawn(command, table(tmp_path / "other.h5", data), *PICTURES[command])
    assert ("pending  " in told) == (command != "map"), "that is of another impact"


@pytest.mark.parametrize("command", PICTURES)
def test_failed_rows_are_told_below_every_picture(command, drawn, tmp_path):
    data = rows(tuple(GRID.values()))
    data["status"][data["N"] == 8] = b"step_budget"
    seal(data)
    figure, told = drawn(command, table(tmp_path / "t.h5", data), *PICTURES[command])
    words = f"{'5 of 30' if command == 'map' else '30 of 180'} rows failed."
    assert f"failed    {words}" in told
    assert words in written(figure)
    if command in ("transition", "level"):
        assert "left out: 30 failed, 0 chaotic" in told
    if command == "transition":
        assert ("are no neighbours: " in told) == ("are no neighbours: " in written(figure))
    if command == "best":
        assert "lowest KE ratio over the impacts computed" in written(figure)


@pytest.mark.parametrize("command", ["points", "level", "collapse", "transition"])
def test_every_row_is_used_or_left_out_for_one_reason_that_all_commands_tell_in_the_same_words(
    command, drawn, tmp_path
):
    """Done rows without the number were in no count, and in no picture."""
    data = rows(tuple(GRID.values()))
    data["status"][data["N"] == 8], data["status"][data["N"] == 13] = b"pending", b"step_budget"
    data["ke_ratio"][data["zeta_T"] == 1e-5], data["chaotic"][-2:] = np.nan, True
    seal(data)
    figure, told = drawn(command, table(tmp_path / "t.h5", data), *PICTURES[command])
    used, left_out = re.search(r"^used +(\d+) rows.*; left out: ([^;\n]+)", told, re.MULTILINE).groups()
    reasons = {why: int(n) for n, why in (one.split(maxsplit=1) for one in left_out.split(", "))}
    assert int(used) + sum(reasons.values()) == len(data)
    without = "without ke_ratio" + " above 0" * (command in ("collapse", "transition"))
    expected = {"pending": 30, "failed": 30, without: 24, "chaotic": 2, "without damping": 0}
    assert reasons == {why: n for why, n in expected.items() if why in reasons}
    assert without in reasons
    assert f"24 {'rows ' * (command != 'collapse')}{without}" in written(figure)
    if command == "points":  # one place for each zeta_T and N
        assert "4 no number" in written(figure)
    if command in ("level", "transition"):
        assert f"; 6 {without}" in told


def test_what_competes_in_a_robust_search_is_called_the_same_in_text_and_picture(drawn, tmp_path, capsys):
    """Candidates, each of nine rows: the picture spoke of as many rows as there are candidates."""
    axes = {name: around(values, 0.02) if name in IMPACT else values for name, values in GRID.items()}
    data, search = rows(tuple(axes.values())), LOWEST | {"robust": 0.02, "by": "worst"}
    data["chaotic"] = data["M_over_M0"] < 0.2
    seal(data)
    path = table(tmp_path / "t.h5", data, search=search)
    figure, told = drawn("best", path)
    candidates = len(data) // 9
    assert f"rows      {candidates} candidates: " in told
    said = f"{candidates // 3} of {candidates} candidates are chaotic (sensitive to their inputs) and left out."
    assert f"A candidate is an impact with those around it. {said}" in written(figure)
    assert main(["page", str(path), "-o", str(tmp_path / "t.html")]) == 0
    alone = "The search counts the worst within 2 % of an impact; here every row is one impact alone."
    assert f"robust    {alone}" in capsys.readouterr().out
    assert alone in (tmp_path / "t.html").read_text()


def test_a_search_of_which_a_row_failed_has_not_the_lowest_over_all_impacts(drawn, tmp_path):
    path = searched(tmp_path / "s.h5", LOWEST, best_impact)
    with changed(path) as data:
        data["status"][np.flatnonzero(best_impact(data))[0]] = b"not_finite"
        seal(data)
    figure, told = drawn("best", path)
    assert "failed    1 of 180 rows failed." in told
    assert "lowest KE ratio over the impacts computed" in written(figure)


def test_a_whole_table_says_nothing_of_parts(drawn, tmp_path):
    path = table(tmp_path / "t.h5", rows(tuple(GRID.values())))
    figure, told = drawn("best", path)
    assert not any(word in told for word in ("shard", "search", "pending"))
    assert "lowest KE ratio over all impacts" in written(figure)
    assert shard_of(path, 180) == shard_of("t.csv", 180) == ""
    assert shard_of(write(tmp_path / "plain.h5", rows()), 2) == ""
    assert axes_of(tmp_path / "plain.h5") == {}


def test_the_lowest_of_a_shard_is_not_called_that_of_all_impacts(drawn, tmp_path):
    path = table(tmp_path / "s.h5", rows(tuple(GRID.values()))[1::2], shard="2/2")
    assert "lowest KE ratio over the impacts computed" in written(drawn("best", path)[0])
    low = searched(tmp_path / "low.h5", LOWEST, best_impact)
    assert "lowest KE ratio over all impacts" in written(drawn("best", low)[0]), "the search has looked at all"


def test_a_search_over_an_axis_that_a_picture_keeps_apart_has_not_seen_the_lowest_of_its_cells(drawn, tmp_path):
    """Its rows are chosen for other cells: what it left out may be lower in these."""
    path = searched(tmp_path / "s.h5", LOWEST | {"over": ["N"]}, lambda data: data["N"] == 100)
    figure, told = drawn("best", path)
    words = "It looked for the lowest over all N: at one N a row may be lower that was not computed."
    assert words in written(figure)
    assert words in told
    assert "lowest KE ratio over the impacts computed" in written(figure)
    assert "looked for the lowest" not in drawn("best", path, "--over", "zeta_T,M_over_M0")[1]
    fixed = drawn("best", searched(tmp_path / "low.h5", LOWEST, best_impact), "--at", "M_over_M0=1")[0]
    assert "at one M_over_M0 a row may be lower" in written(fixed)
    assert "lowest KE ratio over the impacts computed" in written(fixed)


def test_the_optimum_of_a_search_is_known_to_half_a_step_of_the_grid_that_was_screened(drawn, tmp_path):
    told = drawn("best", searched(tmp_path / "s.h5", LOWEST, best_impact))[1]
    assert "M_over_M0 = 1 (0.316 to 1.41), V_over_V0 = 10 (3.16 to 10)" in told


def test_an_optimum_among_some_rows_says_that_others_may_be_lower(drawn, tmp_path):
    words = "; among the rows computed: others may be lower\n"
    data = rows(tuple(GRID.values()))
    assert words in drawn("best", searched(tmp_path / "map.h5", MAP, corners))[1]
    assert words in drawn("best", table(tmp_path / "shard.h5", data[1::2], shard="2/2"))[1]
    assert words in drawn("best", searched(tmp_path / "low.h5", LOWEST, best_impact), "--at", "M_over_M0=1")[1]
    known = words.replace("lower", "as low")
    for over in ("N,zeta_T", "M_over_M0,V_over_V0"):
        assert known in drawn("best", searched(tmp_path / "low.h5", LOWEST, best_impact), "--over", over)[1]
    assert "among the rows" not in drawn("best", table(tmp_path / "whole.h5", data))[1]
    data["status"][0] = b"step_budget"
    seal(data)
    assert words in drawn("best", table(tmp_path / "failed.h5", data))[1]


def test_a_shard_decides_no_finding_and_its_page_says_what_it_is(tmp_path, capsys):
    data = rows(tuple(GRID.values()))
    assert main(["findings", str(table(tmp_path / "t.h5", data))]) == 0
    assert "finding 1 cannot tell" not in capsys.readouterr().out
    path = table(tmp_path / "s.h5", data[1::2], shard="2/2")
    assert main(["findings", str(path)]) == 0
    told = capsys.readouterr().out
    assert told.count("cannot tell") == told.count("needs the rows of all shards") == 4
    assert "shard     Shard 2/2" in told
    assert main(["page", str(path), "-o", str(tmp_path / "s.html")]) == 0
    assert "shard     Shard 2/2" in capsys.readouterr().out
    assert "Shard 2/2 of a sweep" in (tmp_path / "s.html").read_text()


def test_a_search_for_the_lowest_decides_no_finding(tmp_path, capsys):
    assert main(["findings", str(searched(tmp_path / "s.h5", LOWEST, best_impact))]) == 0
    told = capsys.readouterr().out
    assert told.count("cannot tell") == told.count("not computed by this search") == 4
    assert "search    A search: " in told


@pytest.mark.parametrize("ending", ["h5", "csv"])
def test_the_rows_of_a_search_alone_are_no_grid(ending, drawn, tmp_path, capsys):
    """As `sweep merge` and `sweep export` give them, without those that the search did not ask for."""
    data = rows(tuple(GRID.values()))
    data = data[corners(data) | (best_impact(data) & (data["N"] < 50))]
    path = write(tmp_path / "t.h5", data)
    if ending == "csv":
        load(path).to_csv(path := tmp_path / "t.csv")
    figure, told = drawn("best", path)
    words = "No full grid: 42 of 132 pairs of a chain and an impact have a row."
    assert f"absent    {words}" in told
    assert words in written(figure)
    assert "lowest KE ratio over the impacts computed" in written(figure)
    assert main(["findings", str(path)]) == 0
    told = capsys.readouterr().out
    assert told.count("cannot tell") == told.count("not in the table") == 4
    assert "needs all of 42 rows; 15 of them not in the table" in told


def test_rows_that_a_search_chose_are_told_where_merged_they_form_a_grid_too(tmp_path, capsys):
    """Of one chain they always do; with all the others they are those of no search."""
    grid = {"N": 8, "zeta_T": 1e-3, "M_over_M0": 1.0, "V_over_V0": {"log": [0.1, 10], "points": 9}}
    asked = {"some": {"search": {"find": "lowest", "over": ["V_over_V0"]}}, "all": {}}
    for name, section in asked.items():
        sweep.run({"name": name, "grid": grid} | section, tmp_path / f"{name}.h5", progress=False)
    for name, parts in {"once": ["some"], "twice": ["once"], "whole": ["twice", "all"]}.items():
        assert merge([tmp_path / f"{part}.h5" for part in parts], tmp_path / f"{name}.h5")["kind"] == "grid"
    for name, chosen in {"once": True, "twice": True, "whole": False, "all": False}.items():
        assert main(["best", str(tmp_path / f"{name}.h5"), "-o", str(tmp_path / f"{name}.png")]) == 0
        told = capsys.readouterr().out
        assert ("chosen    Merged from a search, which has chosen its rows" in told) == chosen
        assert ("among the rows computed: others may be lower" in told) == chosen


def test_rows_that_a_search_chose_decide_no_finding(tmp_path, capsys):
    assert main(["findings", str(table(tmp_path / "t.h5", rows(tuple(GRID.values())), chosen="by a search"))]) == 0
    told = capsys.readouterr().out
    assert told.count("cannot tell") == told.count("needs the rows that the search left out") == 4


def test_the_best_of_a_search_for_a_map_tells_of_no_dots_and_shows_the_whole_grid(drawn, tmp_path):
    figure, told = drawn("best", searched(tmp_path / "s.h5", MAP, corners))
    assert "cells     4 of 30 have a number" in told
    assert "not computed: 26 cells" in legend(figure)
    assert mesh(figure.axes[0]).get_array().shape == (5, 6)
    assert "(dots)" not in written(figure)
    assert "A search for a map of ke_ratio: 24 of 180 rows computed; only these are shown." in written(figure)


def test_the_grid_of_a_shard_and_its_scales_are_those_of_the_sweep(drawn, tmp_path):
    """Also where the shard lacks a whole row of cells, and an impact."""
    data = rows(tuple(GRID.values()))
    some = data[(data["zeta_T"] > 1e-5) & (data["V_over_V0"] == 10)]
    path = table(tmp_path / "s.h5", some, shard="1/3")
    figure, told = drawn("best", path)
    assert "cells     24 of 30 have a number" in told
    assert "not computed: 6 cells" in legend(figure)
    assert "(c) its impact speed" in written(figure), "the other speed was scanned as well"
    assert "cells     24 of 30 have a number" in drawn("best", path, "--at", "M_over_M0=1", "V_over_V0=10")[1]
    assert mesh(drawn("map", path, *PICTURES["map"])[0].axes[0]).get_array().shape == (5, 6)


def test_a_value_that_no_finished_row_has_is_counted_where_one_is_to_be_chosen(tmp_path, capsys):
    path = searched(tmp_path / "s.h5", LOWEST, lambda data: data["M_over_M0"] != 2)
    assert main(["map", str(path), "-o", str(tmp_path / "a.png")]) == 2
    told = capsys.readouterr().err
    assert "M_over_M0 (there is 0.1, 1; 1 more without a finished row)" in told
    assert "V_over_V0 (there is 1, 10)" in told
