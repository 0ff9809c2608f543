"""`view TABLE`: the table's page served on this machine only, growing while the sweep runs."""

import argparse
import contextlib
from pathlib import Path
from typing import Any

from analysis.commands import common
from sweep.errors import InputError


def add(commands: Any) -> None:
    view = commands.add_parser("view", help="the same page served on this machine: live, and each impact to look into")
    common.add_table(view)
    view.add_argument("--port", metavar="P", default="0", help="of 127.0.0.1, default: any that is free")
    view.set_defaults(command=_view)


def _view(args: argparse.Namespace) -> list[str]:
    text = args.port
    if not (text.isascii() and text.isdecimal() and int(text) < 1 << 16):
        raise InputError(f"--port must be a whole number from 0 to {(1 << 16) - 1}, got {text!r}")
    from analysis.view import Server  # Bokeh's scripts and jinja2, which the pictures do without

    with Server(Path(args.table), int(text)) as server, contextlib.suppress(KeyboardInterrupt):
        print(f"open      {server.address}\nends      with Ctrl-C", flush=True)
        server.serve_forever()
    return ["ended"]
