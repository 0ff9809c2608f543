"""Random tables, and every command that reads one: `python -m tests.asked [--seed S] [--cases N]`.

Each case draws a small spec, makes its table, whole, stopped, resumed, in shards or with torn rows, and asks every
command about it, with random options that its --help allows. An answer must come with a documented exit status,
without a traceback or a warning; its numbers must be those of the table's rows, by a second route. A refusal must be
due, is one line for each problem, and writes nothing.

Case number k has the seed S + k. What is wrong is told with the spec and the command; exit status 1.
"""

import argparse
import importlib
import sys
import tempfile
import traceback
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import analysis.cli
import kernel
from analysis import output
from analysis.look import settings
from tests.asked import others, pictures
from tests.asked.judge import judge
from tests.asked.tables import QUANTITIES, Table, drawn
from tests.asked.told import Wrong, tell
from tests.drawn import crowded
from tests.histories.commands import load

# What the commands import when they need it.
MODULES = ("analysis.draw_collapse", "analysis.page", "analysis.tradeoff", "analysis.draw_tradeoff")
MODULES += ("matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf", "matplotlib.backends.backend_svg")


def case(seed: int, each: int, keep: Path | None) -> list[str]:
    """What is wrong with its answers; nothing, where nothing is."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "here"
        folder.mkdir()
        try:
            table = drawn(rng, folder)
        except Exception:
            return [f"seed {seed}: {traceback.format_exc(limit=-3)}\n{(folder / 's.toml').read_text()}"]
        wrong = _asked(rng, table, folder, each, keep and keep / str(seed))
        counts = table.rows["status"].value_counts().to_dict()
        head = f"seed {seed}, {table.asked.kind}, {table.fate}: {counts}\n{table.asked.text}"
        return [f"{head}{one}" for one in wrong]


def _asked(rng: np.random.Generator, table: Table, folder: Path, each: int, keep: Path | None) -> list[str]:
    questions: list[Callable[[], None]] = [lambda one=one: one(rng, table, folder) for one in others.ALL]  # type: ignore
    kinds = [kind for kind in pictures.KINDS for _ in range(each)]
    questions += [lambda kind=kind: _picture(rng, table, kind, folder, keep) for kind in kinds]  # type: ignore
    if each:
        kind, text = str(rng.choice(list(pictures.KINDS))), others.as_csv(rng, table, folder)
        questions.append(lambda: _picture(rng, text, kind, folder, keep))
    wrong = list[str]()
    for question in questions:
        try:
            question()
        except Exception as error:  # of this program, where it is no Wrong
            wrong.append(str(error) if isinstance(error, Wrong) else traceback.format_exc(limit=-3))
    return wrong


def _picture(rng: np.random.Generator, table: Table, kind: str, folder: Path, keep: Path | None) -> None:
    asked = pictures.question(rng, table, kind)
    told = tell(lambda: _watched(asked.arguments), folder, f"analysis {' '.join(asked.arguments)}")
    if keep is not None and asked.picture.endswith("png") and told.status == 0:
        keep.mkdir(parents=True, exist_ok=True)
        (keep / f"{kind}.{asked.picture}").write_bytes((folder / asked.picture).read_bytes())
    judge(asked, told, folder)


def _watched(arguments: list[str]) -> int:
    """In a process of its own: the command, which also tells the texts of its picture that are cut or overlap."""
    save = output.save

    def look(figure: Any, *rest: Any) -> None:
        with settings():
            for pair in crowded(figure):
                sys.stderr.write(f"crowded: {pair}\n")
        save(figure, *rest)

    output.save = look
    return analysis.cli.main(arguments)


def main() -> int:
    """Print what was found; the exit status."""
    parser = argparse.ArgumentParser(
        prog="tests.asked", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--cases", type=int, default=1, metavar="N")
    parser.add_argument("--each", type=int, default=2, metavar="K", help="questions to each command that draws")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="put the .png files there, to be looked at")
    args = parser.parse_args()
    load()
    for model in (kernel.Model(), kernel.Model(kernel.Bistable(4.5, 6.0), site=0.4)):
        kernel.measure({"N": 5, "zeta_T": [1e-4, 0.3], "M_over_M0": 1, "V_over_V0": 1}, observe=QUANTITIES, model=model)
    for zeta_T, law in product((1e-4, 0.3), ("bistable", "linear")):  # as `analysis view` shows an impact
        kernel.simulate(kernel.Scene(5, zeta_T, kernel.Impact(1, 1), law, ("ke_field", "energy", "profile")))
    analysis.cli.parser()
    for name in MODULES:
        importlib.import_module(name)
    wrong = 0
    for seed in range(args.seed, args.seed + args.cases):
        found = case(seed, args.each, args.keep)
        wrong += len(found)
        for one in found:
            print(one, end="\n\n", flush=True)
    print(f"{args.cases} tables, {wrong} wrong answers")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
