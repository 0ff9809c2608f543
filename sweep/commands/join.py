"""`sweep join TABLE`: help a run that is going on."""

import argparse
from pathlib import Path
from typing import Any

from sweep.errors import EXIT_STATUS
from sweep.site import launch


def add(commands: Any) -> None:
    command = commands.add_parser(
        "join", help="compute for a run that is going on, under mpirun or alone", epilog=EXIT_STATUS
    )
    command.add_argument("table", type=Path, help="the table of that run, on a disk that both see")
    command.set_defaults(command=_join, on_all_ranks=True)


def _join(args: argparse.Namespace) -> int:
    from sweep.guest import join  # the kernel's compiled functions, which most commands do without

    return join(launch.communicator(), args.table)
