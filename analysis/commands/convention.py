"""`convention -o PICTURE`: which change of convention explains the paper's numbers."""

import argparse
from typing import Any

from analysis.commands.common import add_picture, files, output_of
from analysis.output import write


def add(commands: Any) -> None:
    command = commands.add_parser("convention", help="which change of convention explains the paper's numbers")
    add_picture(command, "the axis of our value over the paper's")
    command.set_defaults(command=_convention)


def _convention(args: argparse.Namespace) -> list[str]:
    from analysis.paper import convention, draw_convention  # the kernel, which the maps do without

    out, wanted = output_of(args)
    draw_convention.rehearse(wanted)
    scanned = convention.scan()
    write(out, draw_convention.convention_figure(scanned, wanted), scanned, wanted)
    return [*convention.summary(scanned).to_string(index=False).splitlines(), *files(out)]
