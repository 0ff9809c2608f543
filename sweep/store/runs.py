"""A row of the table's list of runs: how a run begins, and when it will end."""

import platform
import time
from collections import Counter
from collections.abc import Iterable

import numpy as np

from sweep.schema import REUSED, RUN, text_of


def seconds_to_go(run: np.void) -> float | None:
    """Seconds to the end of a run when its row (dtype schema.RUN) was last updated; None before a task is finished.

    The tasks left, and half of those running, are taken to be as much slower than predicted as the finished ones.
    """
    if not (run["work_finished"] > 0 and run["busy"] > 0):
        return None
    predicted = float(run["work_left"]) + 0.5 * float(run["work_running"])
    return predicted * (float(run["busy"]) / float(run["work_finished"])) / max(1, int(run["computing"]))


def new_run(left: int, writer: str, kernel: str, hosts: str = "", job: str = "", ranks: int = 1) -> np.ndarray:
    """A row for the list of runs, shape (1,). Texts that are too long for their column are cut off."""
    run = np.zeros(1, RUN)
    run["start"] = run["updated"] = time.time()
    run["left"] = run["left_at_start"] = left
    run["ranks"], run["writer"], run["kernel"] = ranks, writer, kernel
    run["host"], run["hosts"], run["job"] = platform.node(), hosts, job
    return run


def places_text(hosts: Iterable[str], kinds: Iterable[str], room: int) -> str:
    """`a*64 b*64; znver4-1234abcd*128`: the hosts of ranks, and behind them the kinds of their processors."""
    behind = f"; {hosts_text(kinds, room // 3)}"
    return hosts_text(hosts, room - len(behind)) + behind


def places_of(text: str) -> tuple[str, str]:
    """The hosts and the kinds of processors that `places_text` told; of tables of earlier versions no kind."""
    hosts, _, kinds = text.partition("; ")
    return hosts, kinds


def kinds_of(runs: np.ndarray) -> set[str]:
    """The kinds of processors on which runs have computed, as far as their rows (dtype schema.RUN) tell."""
    computed = runs[runs["writer"] != REUSED]
    told = (places_of(text_of(hosts))[1].split() for hosts in computed["hosts"])
    return {one.rpartition("*")[0] for each in told for one in each if "*" in one}


def hosts_text(hosts: Iterable[str], room: int) -> str:
    """`a*64 b*64`: every host once, with its ranks; where that exceeds `room` bytes, the first and how many more."""
    counted = [f"{host}*{ranks}" for host, ranks in Counter(hosts).items()]
    for shown in range(len(counted), -1, -1):
        more = [f"+ {len(counted) - shown} more"] if shown < len(counted) else []
        if len(text := " ".join([*counted[:shown], *more])) <= room:
            return text
    return ""
