"""`sweep doctor [DIR]`: what this environment can and cannot do."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sweep.commands import common
from sweep.errors import ALL_DONE, BAD_INPUT

EPILOG = "exit status: 0 a sweep can run here; 2 it cannot"


def add(commands: Any) -> None:
    text = "what this environment can and cannot do, tried out in DIR"
    doctor = commands.add_parser("doctor", help=text, epilog=EPILOG, parents=[common.JSON])
    doctor.add_argument("folder", type=Path, nargs="?", default=Path(), metavar="DIR", help="default: here")
    doctor.set_defaults(command=_doctor)


def _doctor(args: argparse.Namespace) -> int:
    from sweep.site import doctor

    findings = doctor.examine(args.folder)
    can_run = doctor.can_run(findings)
    common.print_answer(args, {"can_run": can_run, "findings": [asdict(each) for each in findings]}, doctor.as_text)
    return ALL_DONE if can_run else BAD_INPUT
