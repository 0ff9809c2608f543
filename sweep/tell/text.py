"""What `plan`, `status`, `show`, `merge` and `audit` print for people: every number with its unit."""

from textwrap import indent
from typing import Any

from kernel.hints import exactly
from kernel.status import SENTENCES
from sweep.plan.search import ended
from sweep.tell.promise import PROMISED, SIGNIFICANCE

SECONDS = (("d", 86400.0), ("h", 3600.0), ("min", 60.0))
BYTES = (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3))

GIT_TITLE = "git of the spec"  # the revision of the folder in which the spec lay, for people
LISTED_MAX = 12  # values of a list that are all shown

ESTIMATES = {True: "certified: error and chaos of every row", False: "not certified: neither error nor chaos"}
RUNNING = {True: "yes", False: "no", None: "unknown: its lock cannot be seen from this host"}
CHECKED = {True: "yes", False: "no: not checked for chaos", None: "unknown"}
SEARCH: dict[bool | None, str] = {True: "yes: more tasks may follow those known so far", False: "no"}
SEARCH_ENDED = "yes: the tasks are those that it has asked for"

AUDIT_HEAD = (
    f"{'':24}      {'relative error of ke_ratio':^27}   {'stated error over true':^24}   within  covered",
    f"{'region':24}  rows{'50 %':>9}{'90 %':>9}{'100 %':>9}   {'50 %':>8}{'90 %':>8}{'100 %':>8}   target by error",
)
AUDIT_END = (
    f"p: chance of so few good rows, or fewer, in a sample of a table that keeps its promise of {PROMISED:.0%}; "
    f"broken below {SIGNIFICANCE:g}"
)
MORE = " or more: the longest of the sample"
UNCHECKED = "chaos      {} of them were not checked for chaos: told here by one neighbour of the reference"


def duration(seconds: float) -> str:
    """`0.047 s`, `12 min`, `3.4 h`, `41 d`: the largest unit of which there are two."""
    return _in_units(seconds, SECONDS, "s")


def size(count: float) -> str:
    """`636 kB`: a number of bytes, in powers of 1000."""
    return _in_units(count, BYTES, "bytes", 1.0)


def _in_units(value: float, units: tuple[tuple[str, float], ...], smallest: str, least: float = 2.0) -> str:
    name, unit = next(((name, unit) for name, unit in units if value >= least * unit), (smallest, 1.0))
    return f"{three_digits(value / unit)} {name}"


def three_digits(value: float) -> str:
    """A number without an exponent where it has at most nine digits before its point."""
    return f"{value:.0f}" if 100 <= abs(value) < 1e9 else f"{value:.3g}"


def of_answer(answer: dict[str, Any]) -> str:
    """`key  value` lines; what has several lines, or keys of its own, stands below its key."""
    lines = []
    for key, value in answer.items():
        text = value.strip() if isinstance(value, str) else _compact(value)
        below = "\n" in text or (isinstance(value, dict) and value)
        lines.append(f"{key}\n{indent(text, '    ')}" if below else f"{key:15} {text}")
    return "\n".join(lines)


def of_show(known: dict[str, Any]) -> str:
    """What `sweep.tell.report.show` tells. The git revision is not the program's, told by `versions` and `kernel`."""
    told = _titled(known)
    if isinstance(merged := told.get("merged"), list):
        told["merged"] = [_titled(one) if isinstance(one, dict) else one for one in merged]
    return of_answer(told)


def _titled(known: dict[str, Any]) -> dict[str, Any]:
    told = known | ({"resolved": _exact(known["resolved"])} if "resolved" in known else {})
    return {GIT_TITLE if key == "git" else key: value for key, value in told.items()}


def _exact(value: Any) -> Any:
    """A spec's numbers with all their digits: who computes a row again types them."""
    if isinstance(value, dict):
        return {key: _exact(one) for key, one in value.items()}
    return exactly(value) if isinstance(value, float) else value


def _compact(value: Any) -> str:
    if value is None or value in ([], {}):
        return "-"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict):
        return of_answer(value)
    if isinstance(value, list) and isinstance(value[0], dict):
        return of_answer({f"{number} of {len(value)}": one for number, one in enumerate(value, 1)})
    if isinstance(value, list):
        shown = value if len(value) <= LISTED_MAX else [*value[:3], "..", value[-1]]
        more = "" if shown is value else f" ({len(value)} values)"
        return ", ".join(map(str, shown)) + more
    return str(value)


def of_status(report: dict[str, Any]) -> str:
    """The report of `sweep.tell.report.status`: the failed rows kind by kind, with what each kind means."""
    failures = {kind: f"{rows:<8} {SENTENCES.get(kind, '')}".rstrip() for kind, rows in report["failures"].items()}
    words: dict[str, dict[bool | None, str]] = {"running": RUNNING, "certified": CHECKED, "search": SEARCH}
    told = {key: of[report[key]] for key, of in words.items()}
    if report["search"] and report["running"] is False and not report["left"]:
        told["search"] = SEARCH_ENDED
    return of_answer(report | {"failures": failures} | told)


def of_counts(counts: dict[str, Any]) -> str:
    """The first lines of a plan; `counts`: of `sweep.tell.report.counted`."""
    tasks = str(counts["tasks"])
    if "at_most" in counts:
        tasks += f" to begin with, at most {counts['at_most']}: a search; what follows is for the most"
    if "screened" in counts:
        many, most = counts["screened"], counts["at_most"]
        tasks = f"{many} screened, at most {most} {ended('tried' in counts)}: a search; what follows is for the most"
    lines = {
        "name": counts["name"],
        "tasks": tasks,
        "method": f"{counts['method']}; {ESTIMATES[counts['certified']]}",
    }
    return "\n".join(f"{key:14} {text}" for key, text in lines.items())


def of_prediction(plan: dict[str, Any]) -> str:
    """The lines that follow; `plan`: of `sweep.tell.report.plan`."""
    lines = {
        "work": _work(plan),
        **_screening(plan),
        "longest task": f"{duration(plan['longest_task_s'])}{MORE if _is_sampled(plan) else ''}",
        **({"assumed": f"\n{'':14} ".join(plan["assumed"])} if plan["assumed"] else {}),
        "memory": f"{size(plan['memory_rank_0'])} on rank 0",
        "table": size(plan["table_bytes"]),
    }
    walls = [f"{ranks:>7}   {duration(seconds)}" for ranks, seconds in plan["wall_s"].items()]
    return "\n".join([*(f"{key:14} {text}" for key, text in lines.items()), "", "  ranks   wall time", *walls])


def _screening(plan: dict[str, Any]) -> dict[str, str]:
    if "screening_core_hours" not in plan:
        return {}
    hours = plan["screening_core_hours"]
    return {"of which": f"{three_digits(hours)} core hours for screening; the rest is at most"}


def _work(plan: dict[str, Any]) -> str:
    hours = plan["core_hours"]
    text = f"{three_digits(hours)} core hours ({duration(3600 * hours)} of one core like this machine's), predicted"
    if not _is_sampled(plan):
        return text
    error = plan["core_hours_standard_error"] / hours
    return f"{text} from a sample of {plan['looked_at']} tasks: standard error {three_digits(100 * error)} %"


def _is_sampled(plan: dict[str, Any]) -> bool:
    return bool(plan["looked_at"] < plan.get("at_most", plan["tasks"]))


def of_audit(report: dict[str, Any]) -> str:
    """The report of `sweep.tell.audit.audit`: what was recomputed, the regions, the verdicts."""
    lost = f", {report['not_recomputed']} that it failed on" if report["not_recomputed"] else ""
    return "\n".join(
        [
            f"table      {report['table']}: {report['done']} done rows by {report['method']}",
            f"sample     {report['sampled']} rows; {report['skipped']} skipped as too expensive{lost}",
            f"reference  {report['reference']}",
            *([UNCHECKED.format(report["not_checked"])] if report["not_checked"] else []),
            "",
            *AUDIT_HEAD,
            *map(_region_line, report["regions"]),
            "",
            *map(_promise_line, report["promises"]),
            AUDIT_END
            if report["promises"]
            else "nothing is promised: tolerances of the user's own, and no error estimated",
        ]
    )


def _region_line(region: dict[str, Any]) -> str:
    name = f"{region['region']}{', chaotic' if region['chaotic'] else ''}"
    true = "".join(f"{x:9.1e}" for x in region["true_error"].values())
    stated = region["stated_over_true"] or dict.fromkeys(region["true_error"])
    ratios = "".join(f"{_or_dash(x, '.2g'):>8}" for x in stated.values())
    shares = "".join(f"{_or_dash(x, '.1%'):>9}" for x in (region["within_target"], region["covered"]))
    return f"{name:24}{region['rows']:6}{true}   {ratios}{shares}"


def _or_dash(x: float | None, form: str) -> str:
    return "-" if x is None else format(x, form)


def _promise_line(promise: dict[str, Any]) -> str:
    good, rows = promise["good"], promise["rows"]
    if not rows:
        return f"{promise['promise']:17} not judged: every row of the sample is chaotic"
    verdict = "BROKEN" if promise["broken"] else "kept"
    share = f"{good / rows:.1%} of {rows} rows that are not chaotic"
    return f"{promise['promise']:17} {verdict}: {share}; p = {promise['chance']:.2g}"
