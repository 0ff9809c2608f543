"""`atlas -o PICTURE`: how long a step every method may take, which scheme `auto` takes, where the chaos is."""

import argparse
from typing import Any

from analysis.commands import common
from analysis.output import write


def add(commands: Any) -> None:
    text = "how long a step every method may take, which scheme auto takes, where the chaos is"
    command = commands.add_parser("atlas", help=text)
    common.add_picture(command, "the colours of the steps")
    command.add_argument("--side", type=int, default=24, metavar="N", help="cells per axis, default: %(default)s")
    command.set_defaults(command=_atlas)


def _atlas(args: argparse.Namespace) -> list[str]:
    from analysis import atlas, draw_atlas  # the kernel, which the maps do without

    out, wanted = common.output_of(args)
    draw_atlas.rehearse(wanted)
    cells = atlas.atlas(args.side)
    write(out, draw_atlas.atlas_figure(cells, wanted), cells, wanted)
    return [*atlas.headlines(cells), *common.files(out)]
