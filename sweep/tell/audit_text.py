"""What `sweep audit` found, as text for people."""

from typing import Any

from sweep.tell.promise import PROMISED, SIGNIFICANCE

HEAD = (
    f"{'':24}      {'relative error of ke_ratio':^27}   {'stated error over true':^24}   within  covered",
    f"{'region':24}  rows{'50 %':>9}{'90 %':>9}{'100 %':>9}   {'50 %':>8}{'90 %':>8}{'100 %':>8}   target by error",
)
END = (
    f"p: chance of so few good rows, or fewer, in a sample of a table that keeps its promise of {PROMISED:.0%}; "
    f"broken below {SIGNIFICANCE:g}"
)

UNCHECKED = "chaos      {} of them were not checked for chaos: told here by one neighbour of the reference"


def as_text(report: dict[str, Any]) -> str:
    """The report of `sweep.tell.audit.audit`: what was recomputed, the regions, the verdicts."""
    lost = f", {report['not_recomputed']} that it failed on" if report["not_recomputed"] else ""
    return "\n".join(
        [
            f"table      {report['table']}: {report['done']} done rows by {report['method']}",
            f"sample     {report['sampled']} rows; {report['skipped']} skipped as too expensive{lost}",
            f"reference  {report['reference']}",
            *([UNCHECKED.format(report["not_checked"])] if report["not_checked"] else []),
            "",
            *HEAD,
            *map(_region_line, report["regions"]),
            "",
            *map(_promise_line, report["promises"]),
            END if report["promises"] else "nothing is promised: tolerances of the user's own, and no error estimated",
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
