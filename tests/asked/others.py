"""Questions whose answer is no picture: what `sweep` tells and exports, findings, the page, the trade-off."""

import base64
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import analysis.cli
from analysis.view import Server
from sweep import cli
from sweep.errors import InputError
from tests.asked.judge import alike, said
from tests.asked.options import any_at
from tests.asked.tables import Table, exported
from tests.asked.told import Told, must, tell
from tests.asked.truth import at_values

LEFT = ("pending", "torn")


def _sweep(folder: Path, *words: str) -> Told:
    return tell(lambda: cli.main(list(words)), folder, f"sweep {' '.join(words)}")


def _analysis(folder: Path, *words: str) -> Told:
    return tell(lambda: analysis.cli.main(list(words)), folder, f"analysis {' '.join(words)}")


def _fine(told: Told, wrote: set[str] | None = None, statuses: tuple[int, ...] = (0,)) -> None:
    must(told.status in statuses and not told.err, f"{told.line}: exit status {told.status}\n{told.err}")
    must(told.wrote == (wrote or set()), f"{told.line}: has written {set(told.wrote)}")


def _refused(told: Told, *words: str) -> None:
    must(told.status == 2 and not told.out and not told.wrote, f"{told.line}: is not refused: {told}")
    must(any(word in told.err for word in words) and len(told.err.splitlines()) == 1, f"{told.line}: {told.err}")


def _status(_rng: np.random.Generator, table: Table, folder: Path) -> None:
    told = _sweep(folder, "status", table.path.name, "--json")
    _fine(told)
    answer, counts = json.loads(told.out), table.rows["status"].value_counts().to_dict()
    done, left = counts.pop("done", 0), sum(counts.pop(name, 0) for name in LEFT)
    counts.pop("unasked", 0)
    must((answer["done"], answer["failures"]) == (done, counts), f"{told.line}: {answer}, has {done} done, {counts}")
    must(answer["failed"] == sum(counts.values()) and answer["running"] is False, f"{told.line}: {answer}")
    must(answer["tasks"] == done + answer["failed"] + answer["left"], f"{told.line}: {answer}")
    must(table.asked.is_search or answer["left"] == left, f"{told.line}: {answer}, {left} are left")
    must(answer.get("screened", 0) == table.screened, f"{told.line}: {answer}, {table.screened} are screened")
    _fine(_sweep(folder, "status", table.path.name))


def _show(_rng: np.random.Generator, table: Table, folder: Path) -> None:
    told = _sweep(folder, "show", table.path.name, "--json")
    _fine(told)
    must(table.asked.text.strip() in json.loads(told.out)["spec"], f"{told.line}: does not hold the spec")
    _fine(_sweep(folder, "show", table.path.name))


def _audit(rng: np.random.Generator, table: Table, folder: Path) -> None:
    told = _sweep(folder, "audit", table.path.name, "--fraction", "0.02", "--json")
    if table.done.empty:
        _refused(told, "has no done row to audit")
        return
    if told.status == 2:
        _refused(told, "is predicted to take more than", "no row of the sample could be recomputed")
        return
    must(told.status in (0, 1), f"{told.line}: exit status {told.status}\n{told.err}")
    must(
        all(re.match(r"sweep: recomputing \d+ of", line) for line in told.err.splitlines()), f"{told.line}: {told.err}"
    )
    answer, done = json.loads(told.out), len(table.done)
    must((answer["done"], answer["sampled"]) == (done, min(done, 30)), f"{told.line}: {answer}")
    regions = sum(region["rows"] for region in answer["regions"])
    known = answer["sampled"] - answer["skipped"] - answer["not_recomputed"]
    must(regions == known, f"{told.line}: {answer}")
    must(answer["kept"] == (told.status == 0), f"{told.line}: {answer}")


def _export(rng: np.random.Generator, table: Table, folder: Path) -> None:
    ending, every = str(rng.choice(["csv", "parquet", "nc"])), bool(rng.random() < 0.5)
    every = every and ending != "nc"  # which holds every row anyway
    name = f"e.{ending}"
    told = _sweep(folder, "export", table.path.name, "-o", name, *(["--all"] if every else []))
    rows = table.rows if every or ending == "nc" else table.done
    _fine(told, {name})
    must(told.out == f"{len(rows)} rows in {name}\n", f"{told.line}: {told.out}")
    found = exported(folder / name)
    computed = ~rows["status"].isin(["pending", "unasked", "torn"])
    must(found["task"].tolist() == rows.index.tolist(), f"{told.line}: tasks {found['task'].tolist()}")
    must(set(found) == {"task", *rows} - {"checksum"}, f"{told.line}: columns {list(found)}")
    for column in set(found) - {"task"}:
        ours, theirs = rows[column] & computed if column == "checked" else rows[column], found[column]
        if column == "chaotic":
            known = (rows["checked"] & computed).to_numpy()
        elif column not in (*table.inputs, "status", "checked"):
            known = computed.to_numpy()
        else:
            known = np.ones(len(rows), bool)
        must(
            alike(theirs[known], ours[known]),
            f"{told.line}: {column} is {theirs[known].tolist()}, not {ours[known].tolist()}",
        )
        if ours.dtype.kind == "f":
            must(theirs[~known].isna().all(), f"{told.line}: {column} of rows that are not known: {theirs[~known]}")
    _refused(_sweep(folder, "export", table.path.name, "-o", name), "exists; give another -o")


def _findings(rng: np.random.Generator, table: Table, folder: Path) -> None:
    told = _analysis(folder, "findings", table.path.name)
    if table.done.empty:
        _refused(told, "has no finished row")
        return
    if told.status == 2:
        _refused(told, "the table varies", "no finished row has a ke_ratio", "compares chains of different N")
        return
    _fine(told)
    lines = re.findall(r"^finding (\d) (holds|does not hold|cannot tell|needs)", told.out, re.MULTILINE)
    must(sorted(number for number, _ in lines) == list("12345"), f"{told.line}: {told.out}")


def _page(rng: np.random.Generator, table: Table, folder: Path) -> None:
    at, words = any_at(rng, table.rows, table.inputs, 0.1)
    told = _analysis(folder, "page", table.path.name, "-o", "p.html", *words)
    rows, missing = at_values(table.rows, at)
    if missing:
        _refused(told, *missing)
        return
    _fine(told, {"p.html"})
    said(told, rf"^rows +{(rows['status'] == 'done').sum()} done of {len(rows)}$")
    text = (folder / "p.html").read_text()
    must(text.rstrip().endswith("</html>"), f"{told.line}: no whole page")
    held = dict(re.findall(r'<script type="application/[a-z-]+" id="([^"]+)">([^<]*)</script>', text))
    facts = json.loads(held.pop("facts"))
    _shown(told, facts, {name.removeprefix("column-"): data for name, data in held.items()}, rows)


def _shown(told: Told, facts: dict[str, Any], data: dict[str, str], rows: pd.DataFrame) -> None:
    """A page, or what is sent to one, holds the done rows, and counts the others."""
    done = rows[rows["status"] == "done"]
    counts = rows["status"].value_counts().drop("done", errors="ignore").to_dict()
    must((facts["rows"], facts["all_rows"], facts["left"]) == (len(done), len(rows), counts), f"{told.line}: {facts}")
    must(facts["unchecked"] == (~done["checked"]).sum(), f"{told.line}: {facts['unchecked']} unchecked")
    chaotic = done["chaotic"].map({True: "yes", False: "no"}).where(done["checked"], "not checked")
    every = done.assign(task=done.index, chaotic=chaotic).drop(columns=["status", "checked", "checksum"])
    must({column["name"] for column in facts["columns"]} == set(every), f"{told.line}: columns {list(data)}")
    for column in facts["columns"]:
        ours, raw = every[column["name"]], data[column["name"]]
        codes = range(len(done)) if column["kind"] == "count" else _unpacked(raw, column["kind"])
        theirs = [column["values"][code] for code in codes] if "values" in column else codes
        must(len(codes) == len(done) and alike(theirs, ours), f"{told.line}: {column}, {list(theirs)}, not {[*ours]}")


def _unpacked(data: str, kind: str) -> list[Any]:
    found: list[Any] = np.frombuffer(zlib.decompress(base64.b64decode(data)), f"<{kind}").tolist()
    return found


def _view(rng: np.random.Generator, table: Table, folder: Path) -> None:
    task, lone = int(rng.choice(table.rows.index)), rng.random() < 0.3  # a scene takes a while

    def served() -> int:
        with Server(Path(table.path.name)) as server:
            answers = {"page": server.page().decode()[-20:], "rows": server.answer("/rows", {})}
            try:
                answers["scene"] = server.answer("/scene", {"task": [str(task)]}) if lone else None
            except InputError as error:
                answers["scene"] = {"problem": str(error)}
        print(json.dumps(answers, allow_nan=False))
        return 0

    told = tell(served, folder, f"analysis view {table.path.name}")
    _fine(told)
    answers = json.loads(told.out)
    must(answers["page"].rstrip().endswith("</html>"), f"{told.line}: no whole page")
    _shown(told, answers["rows"], {column["name"]: column["data"] for column in answers["rows"]["columns"]}, table.rows)
    if lone and (table.asked.model or table.inputs[4:]):
        must("for the paper's chain only" in answers["scene"].get("problem", ""), f"{told.line}: {answers['scene']}")
    elif lone:
        N = table.rows.loc[task, "N"]
        must(answers["scene"]["words"].startswith(f"task {task}: N {N}, "), f"{told.line}: {answers['scene']}")
        must(all(len(answers["scene"][law]["v"]) == N for law in ("bistable", "linear")), f"{told.line}: no {N} sites")


def _tradeoff(rng: np.random.Generator, table: Table, folder: Path) -> None:
    if rng.random() < 0.8:  # it times many runs
        return
    told = _analysis(folder, "tradeoff", table.path.name, "--tasks", "2", "-o", "w.png")
    if table.done.empty:
        _refused(told, "has no done row")
        return
    if told.status == 2:
        _refused(told, "has no row with a converged ratio")
        return
    _fine(told, {"w.png", "w.tradeoff.csv"})
    line = said(told, r"^sample +(\d) random tasks of t.h5, seed 1; left out: ")
    must(1 <= int(line[1]) <= min(2, len(table.done)), f"{told.line}: {line[0]}")


def as_csv(rng: np.random.Generator, table: Table, folder: Path) -> Table:
    """The same rows, or the done ones alone, as an exported .csv, which tells no spec."""
    every = bool(rng.random() < 0.5)
    told = _sweep(folder, "export", table.path.name, "-o", "t.csv", *(["--all"] if every else []))
    _fine(told, {"t.csv"})
    return replace(table, path=folder / "t.csv", rows=table.rows if every else table.done, search={})


ALL = (_status, _show, _audit, _export, _findings, _page, _view, _tradeoff)
