"""The headline numbers of work against precision."""

from typing import Any

import pandas as pd

from analysis.tradeoff import RK45, cost_of_a_digit

HEAD = f"{'':35}ms/task   on average  evaluations/time   error 50 %      90 %     worst"


def headlines(points: pd.DataFrame) -> list[str]:
    """One line per point, then what a tenth of the error costs by each method."""
    lines = [_point(points.iloc[i]) for i in range(len(points))]
    costs = [_decade(str(name), line) for name, line in points.groupby("method", sort=False)]
    return [HEAD, *lines, *costs]


def _point(row: "pd.Series[Any]") -> str:
    knob = "rtol" if row["method"] == RK45 else "target"
    name = f"{row['method']} at {knob} {row['setting']:.0e}{' (ode45)' if row['ode45_defaults'] else ''}"
    times = f"{row['ms_50']:7.2g}{row['ms_mean']:13.2g}{row['evaluations_per_time_50']:18.3g}"
    return f"{name:35}{times}{row['error_50']:13.1e}{row['error_90']:10.1e}{row['error_100']:10.1e}"


def _decade(name: str, line: pd.DataFrame) -> str:
    median, mean = cost_of_a_digit(line)
    return f"a tenth of the 90 % error costs {median:.2g} times as long ({mean:.2g} times on average) by {name}"
