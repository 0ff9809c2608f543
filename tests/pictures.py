"""Keeps what every picture holds, so that a test tells when one holds something else.

    python -m tests.pictures --keep [ROOM ..]
    python -m tests.pictures --show FOLDER

The first draws the pictures of every room (the commands of `analysis`, the paper's page, the page of what it leaves
open) from small tables, and keeps their lines (tests/sketch.py) in tests/data/pictures.json: after a change that was to
change them, and only after they were looked at. The second draws them into a folder, to be looked at.
"""

import argparse
import contextlib
import io
import json
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests import outlook_source, paper_source, test_analysis_cli, test_analysis_curves, test_analysis_part
from tests.sketch import KEPT, NUMBER, sketched, told_of_numbers

Sketches = dict[str, list[str]]
AT = ["--at", "M_over_M0=2", "V_over_V0=10"]
CHAOTIC = "figA1"  # of undamped chains whose forces differ from processor to processor: its numbers are not kept
CHANGES = re.compile(r"in \d+\.\d+ s without start")  # how long a table took

# By the picture's name: the command, the table, and what else is asked.
COMMANDS: dict[str, tuple[str, str, list[str]]] = {
    "best": ("best", "grid", []),
    "best-search": ("best", "search", ["--cmap", "magma"]),
    "best-over": ("best", "grid", ["--over", "V_over_V0,M_over_M0", "--chaotic-too", "--limits", "0.05,1"]),
    "map": ("map", "grid", AT),
    "map-falls": ("map", "falls", [*AT, "--title", "a title", "--size", "6,5"]),
    "map-quantity": ("map", "merit", ["--at", "M_over_M0=1", "V_over_V0=1", "--of", "wall_force_ratio"]),
    "level": ("level", "falls", ["--level", "1"]),
    "level-last": ("level", "grid", ["--level", "0.2", "--along", "zeta_T", "--crossing", "last"]),
    "transition": ("transition", "falls", []),
    "transition-one": ("transition", "falls", AT),
    "collapse": ("collapse", "cloud", []),
    "collapse-other": ("collapse", "cloud", ["--against", "Pi_IV"]),
    "points": ("points", "sample", []),
    "points-over": ("points", "sample", ["--over", "zeta_T,spring.c2"]),
    "findings": ("findings", "merit", []),
}


def tables(folder: Path) -> dict[str, Path]:
    """Small tables in a folder."""
    from tests.test_analysis_points import sample

    falls = test_analysis_curves.falling(((0.5, 2.0), (2.0, 2.0), (2.0, 10.0)), chaotic=40)
    frames = {"falls": falls, "cloud": test_analysis_curves.random_rows(400, 30), "sample": sample(40, 1)}
    frames["merit"] = outlook_source.with_merits()
    made = {name: folder / f"{name}.csv" for name in frames}
    for name, frame in frames.items():
        frame.to_csv(made[name], index_label="task")
    grid = test_analysis_cli.rows()
    grid["status"][5:7] = b"failed"
    made["grid"] = test_analysis_cli.write(folder / "grid.h5", grid)
    search = (test_analysis_part.LOWEST, test_analysis_part.best_impact)
    made["search"] = test_analysis_part.searched(folder / "search.h5", *search)
    return made


def commands(folder: Path) -> Sketches:
    """What each command draws, writes as numbers, and prints."""
    from analysis.cli import main

    found, made = Sketches(), tables(folder)
    for name, (command, table, more) in COMMANDS.items():
        out = [] if command == "findings" else ["-o", str(folder / f"{name}.png")]
        with sketched() as one, contextlib.redirect_stdout(io.StringIO()) as said:
            if main([command, str(made[table]), *out, *more]):
                raise SystemExit(f"{name} failed")
        told = CHANGES.sub("", said.getvalue().replace(str(folder), "")).splitlines()
        found |= {name: [*one.get(name, []), *_numbers(folder / f"{name}.{command}.csv"), *told]}
    return found | measured(folder)


def measured(folder: Path) -> Sketches:
    """What the commands draw that measure for themselves, of made-up measurements."""
    from analysis import atlas, draw_atlas, draw_tradeoff, tradeoff
    from analysis.output import output, write
    from tests.test_analysis_tradeoff import cells

    rng, points = np.random.default_rng(1), []
    for at in tradeoff.settings():
        error = at.setting * rng.uniform(0.1, 0.3)
        work = {"ms_50": 0.1 * error**-0.3, "ms_mean": 0.2 * error**-0.3, "evaluations_per_time_50": 30 * error**-0.3}
        errors = {"error_50": 0.3 * error, "error_90": error, "error_100": 3 * error}
        what = {"method": at.method, "setting": at.setting, "ode45_defaults": at.ode45}
        points.append(what | errors | work | {"tasks": 60, "failed": 0})
    frame, planes = pd.DataFrame(points), cells(step_rk45=np.geomspace(0.01, 1, 8), chaotic=np.arange(8) == 1)
    with sketched() as found:
        write(output(folder / "tradeoff.png", "tradeoff"), draw_tradeoff.tradeoff_figure(frame, 60), frame)
        write(output(folder / "atlas.png", "atlas"), draw_atlas.atlas_figure(planes), planes)
    found["tradeoff"] += tradeoff.headlines(frame)
    found["atlas"] += atlas.headlines(planes)
    return found


def paper(folder: Path) -> tuple[Any, Sketches]:
    """The paper's page, of one of its numbers, and what its pictures hold."""
    from analysis.paper.page import build

    with sketched() as found:
        page = build(paper_source.small_source(), folder, points=(paper_source.SMALL,))
    told = _page(page, found, folder, "paper")
    return page, told | {CHAOTIC: [NUMBER.sub("#", line) for line in told[CHAOTIC]]}


def outlook(folder: Path) -> tuple[Any, Sketches]:
    """The page of what the paper leaves open, and what its pictures hold."""
    from analysis.outlook.page import build

    with sketched() as found:
        page = build(outlook_source.small_source(), folder)
    return page, _page(page, found, folder, "outlook")


def _page(page: Any, found: Sketches, folder: Path, name: str) -> Sketches:
    """The pictures with their numbers, and the page's own words."""
    for stem in found:
        found[stem] += _numbers(folder / f"{stem}.{name}.csv")
    words = re.sub(r"<[^>]*>", " ", re.sub(r"(?s)<style.*?</style>|<script.*?</script>", "", page.html))
    return found | {"page": [*page.lines, *(" ".join(line.split()) for line in words.splitlines() if line.strip())]}


def _numbers(csv: Path) -> list[str]:
    return told_of_numbers(pd.read_csv(csv)) if csv.is_file() else []


ROOMS: dict[str, Callable[[Path], Sketches]] = {
    "commands": commands,
    "paper": lambda folder: paper(folder)[1],
    "outlook": lambda folder: outlook(folder)[1],
}


def main() -> None:
    """Keep, or show."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", nargs="*", choices=[*ROOMS, []], metavar="ROOM")
    parser.add_argument("--show", type=Path, metavar="FOLDER")
    args = parser.parse_args()
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name in args.keep or ROOMS:
        with tempfile.TemporaryDirectory() as temporary:
            folder = args.show / name if args.show else Path(temporary)
            folder.mkdir(parents=True, exist_ok=True)
            kept[name] = ROOMS[name](folder)
    if not args.show:
        KEPT.write_text(json.dumps(kept, indent=0, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
