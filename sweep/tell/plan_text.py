"""What `sweep plan` tells, for people: every number with its unit."""

from typing import Any

from sweep.tell.units import duration, size, three_digits

ESTIMATES = {True: "certified: error and chaos of every row", False: "not certified: neither error nor chaos"}


def counted_as_text(counted: dict[str, Any]) -> str:
    """`counted`: of sweep.tell.report.counted."""
    lines = {
        "name": counted["name"],
        "tasks": _tasks(counted),
        "method": f"{counted['method']}; {ESTIMATES[counted['certified']]}",
    }
    return "\n".join(f"{key:14} {text}" for key, text in lines.items())


def predicted_as_text(plan: dict[str, Any]) -> str:
    """What follows; `plan`: of sweep.tell.report.plan."""
    lines = {
        "work": _work(plan),
        "longest task": f"{duration(plan['longest_task_s'])}{_at_least(plan)}",
        "memory": f"{size(plan['memory_rank_0'])} on rank 0",
        "table": size(plan["table_bytes"]),
    }
    walls = [f"{ranks:>7}   {duration(seconds)}" for ranks, seconds in plan["wall_s"].items()]
    return "\n".join([*(f"{key:14} {text}" for key, text in lines.items()), "", "  ranks   wall time", *walls])


def _tasks(plan: dict[str, Any]) -> str:
    if "at_most" not in plan:
        return str(plan["tasks"])
    return f"{plan['tasks']} to begin with, at most {plan['at_most']}: adaptive; what follows is for the most"


def _work(plan: dict[str, Any]) -> str:
    hours = plan["core_hours"]
    told = f"{three_digits(hours)} core hours ({duration(3600 * hours)} of one core like this machine's), predicted"
    if not _is_sampled(plan):
        return told
    error = plan["core_hours_standard_error"] / hours
    return f"{told} from a sample of {plan['looked_at']} tasks: standard error {three_digits(100 * error)} %"


def _at_least(plan: dict[str, Any]) -> str:
    return " or more: the longest of the sample" if _is_sampled(plan) else ""


def _is_sampled(plan: dict[str, Any]) -> bool:
    return bool(plan["looked_at"] < plan.get("at_most", plan["tasks"]))
