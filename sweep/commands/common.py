"""What commands share: the table that they look at, and an answer printed as text or as JSON."""

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

Answer = dict[str, Any]


def add_json(command: argparse.ArgumentParser) -> None:
    """The flag that `print_answer` looks at."""
    command.add_argument("--json", action="store_true")


def add_table(command: argparse.ArgumentParser) -> None:
    """The table to look at."""
    command.add_argument("table", type=Path)


def print_answer(args: argparse.Namespace, answer: Answer, as_text: Callable[[Answer], str]) -> None:
    """Print the answer as JSON where the user asked for it, else as text."""
    print(json.dumps(answer, indent=1) if args.json else as_text(answer))
