"""`tradeoff -o PICTURE`: work against precision of every method."""

import argparse
from typing import Any

from analysis.commands import common
from analysis.output import write


def add(commands: Any) -> None:
    """Add this command to the command line."""
    text = "work against precision of every method, measured now on random tasks"
    command = commands.add_parser("tradeoff", help=text)
    common.add_picture(command, "the axis of the errors")
    command.add_argument("--tasks", type=int, default=60, metavar="N", help="default: %(default)s")
    command.add_argument("--seed", type=int, default=1, help="of the sample, default: %(default)s")
    command.set_defaults(command=_tradeoff, name="tradeoff")


def _tradeoff(args: argparse.Namespace) -> list[str]:
    from analysis import draw_tradeoff, tradeoff  # the kernel, which the maps do without

    out, wanted = common.output_of(args)
    draw_tradeoff.rehearse(args.tasks, wanted)
    tasks, left_out = tradeoff.sample(args.tasks, args.seed)
    points = tradeoff.tradeoff(tasks)
    write(out, draw_tradeoff.tradeoff_figure(points, len(tasks), wanted), points, wanted)
    sample = f"sample    {len(tasks)} random tasks of the paper's domain, seed {args.seed}"
    return [f"{sample}; left out: {left_out} ill-conditioned", *tradeoff.headlines(points), *common.files(out)]
