"""`tradeoff [TABLE] -o PICTURE`: work against precision of every method, on the tasks of a table or of the paper."""

import argparse
from pathlib import Path
from typing import Any

from analysis.commands import common
from analysis.output import write
from analysis.reading import is_csv
from sweep.errors import InputError
from sweep.files import as_text
from sweep.log import Bar


def add(commands: Any) -> None:
    text = "work against precision of every method, measured now on tasks of a table, or on random ones"
    command = commands.add_parser("tradeoff", help=text)
    text = "whose done rows are the tasks; default: random tasks of the paper's domain"
    command.add_argument("table", nargs="?", metavar="TABLE", help=text)
    common.add_picture(command, "the axis of the errors")
    command.add_argument("--tasks", type=int, default=60, metavar="N", help="default: %(default)s")
    command.add_argument("--seed", type=int, default=1, help="of the sample, default: %(default)s")
    command.set_defaults(command=_tradeoff)


def _tradeoff(args: argparse.Namespace) -> list[str]:
    from analysis import draw_tradeoff, tradeoff  # the kernel, which the maps do without

    out, wanted = common.output_of(args)
    draw_tradeoff.rehearse(args.tasks, wanted)
    if args.table is not None and is_csv(args.table):
        raise InputError(f"{args.table}: does not tell its chains' model; give the table that it was exported from")
    with Bar() as progress:
        if args.table is None:
            sample, source = tradeoff.sample(args.tasks, args.seed, progress), "random tasks of the paper's domain"
        else:
            sample = tradeoff.sample_of(Path(args.table), args.tasks, args.seed, progress)
            source = f"random tasks of {as_text(Path(Path(args.table).name))}"
        points = tradeoff.tradeoff(sample.tasks, sample.model, progress)
    write(out, draw_tradeoff.tradeoff_figure(points, len(sample.tasks), wanted, source), points, wanted)
    dear = f", {sample.dear} whose reference takes too long" if sample.dear else ""
    told = f"sample    {len(sample.tasks)} {source}, seed {args.seed}"
    left_out = f"left out: {sample.ill_conditioned} ill-conditioned{dear}"
    return [f"{told}; {left_out}", *tradeoff.headlines(points), *common.files(out)]
