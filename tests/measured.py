"""What the measuring programs found, kept for the documentation, so that no table there is typed by hand.

A program that is given `--keep` writes its table here, with the command and the processor; docs/generate.py turns it
into Markdown, and a test holds the README to it.
"""

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sweep.machine import processor_name

FOLDER = Path(__file__).parent / "data" / "measured"


def keep(name: str, rows: Sequence[Mapping[str, str]], about: str) -> None:
    """Write a table of texts, column by column as the documentation shows it; `about`: what was asked, in words."""
    module = sys.modules["__main__"].__spec__
    command = ["python", "-m", module.name if module else name, *(word for word in sys.argv[1:] if word != "--keep")]
    told = {"command": shlex.join(command), "processor": processor(), "about": about, "rows": list(rows)}
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def processor() -> str:
    """Its name, and whether it takes eight sites at once or four."""
    lanes = "with" if "avx512f" in Path("/proc/cpuinfo").read_text() else "without"
    return f"{processor_name()} {lanes} AVX-512"


def kept(name: str) -> dict[str, Any]:
    """What was kept under that name."""
    found: dict[str, Any] = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
    return found


def markdown(name: str) -> str:
    """The table, as the documentation and the README have it."""
    rows = kept(name)["rows"]
    lines = [list(rows[0]), ["---"] * len(rows[0]), *(list(row.values()) for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def source(name: str) -> str:
    """By what the table was measured, in one sentence."""
    told = kept(name)
    return f"(`{told['command']}`: {told['about']}; {told['processor']}.)"
