"""What `sweep status` tells, for people."""

from typing import Any

from kernel.status import SENTENCES
from sweep.tell.report import as_text

RUNNING = {True: "yes", False: "no", None: "unknown: its lock cannot be seen from this host"}


def status_as_text(report: dict[str, Any]) -> str:
    """Failed rows kind by kind, with what each kind means."""
    failures = {kind: f"{rows:<8} {SENTENCES.get(kind, '')}".rstrip() for kind, rows in report["failures"].items()}
    return as_text(report | {"failures": failures, "running": RUNNING[report["running"]]})
