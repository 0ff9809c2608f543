"""What commands share: the table that they look at, and an answer printed as text or as JSON."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

Answer = dict[str, Any]
# Parents (argparse) of the commands that look at a table, and of those that print an answer.
TABLE, JSON = (argparse.ArgumentParser(add_help=False) for _ in range(2))
TABLE.add_argument("table", type=Path, help="written by `sweep run`")
JSON.add_argument("--json", action="store_true", help="the answer as JSON")
SPEC = "the sweep, in TOML, as jobs/quick.toml"


def print_answer(args: argparse.Namespace, answer: Answer, as_text: Callable[[Answer], str]) -> None:
    """Print the answer as JSON where the user asked for it, else as text."""
    print(json.dumps(answer, indent=1) if args.json else as_text(answer))
