"""What `sweep status` tells, for people."""

from typing import Any

from kernel.status import SENTENCES
from sweep.tell.report import as_text

RUNNING = {True: "yes", False: "no", None: "unknown: its lock cannot be seen from this host"}
CHECKED = {True: "yes", False: "no: not checked for chaos", None: "unknown"}
ADAPTIVE: dict[bool | None, str] = {True: "yes: more tasks may follow those known so far", False: "no"}


def status_as_text(report: dict[str, Any]) -> str:
    """Failed rows kind by kind, with what each kind means."""
    failures = {kind: f"{rows:<8} {SENTENCES.get(kind, '')}".rstrip() for kind, rows in report["failures"].items()}
    words: dict[str, dict[bool | None, str]] = {"running": RUNNING, "certified": CHECKED, "adaptive": ADAPTIVE}
    return as_text(report | {"failures": failures} | {key: said[report[key]] for key, said in words.items()})
