"""What the answers must be, worked out from a table's own rows: a second route to every number."""

from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
import pandas as pd

from tests.asked.tables import Table

M0, V0 = 0.159, 0.26
MATCH = 1e-9  # relative: a value that is typed from a list
Frame = pd.DataFrame


def error_of(of: str) -> str:
    """The column of a quantity's error."""
    name = of.removesuffix("_ratio").removesuffix("_linear")
    return "error" if name == "ke" else f"{name}_error"


def at_values(rows: Frame, at: dict[str, float]) -> tuple[Frame, list[str]]:
    """The rows with these values, and why they cannot be had."""
    for name, value in at.items():
        done = rows[rows["status"] == "done"]
        if not (np.abs(done[name] - value) <= MATCH * np.abs(done[name])).any():
            return rows, ["no finished row has"]
        rows = rows[np.abs(rows[name] - value) <= MATCH * np.abs(rows[name])]
    return rows, []


def varies(table: Table, rows: Frame, but: Sequence[str] = ()) -> list[str]:
    """Numbers of the model that must not vary."""
    several = [name for name in table.inputs[4:] if name not in but and len(rows[name].unique()) > 1]
    return ["the table varies"] if several else []


def no_grid(rows: Frame, over: Sequence[str], several: bool) -> list[str]:
    """Whether the rows are too few for cells."""
    across, up = (rows[name].nunique() for name in over)
    places = len(rows.drop_duplicates(list(over)))
    return ["form no grid"] if 4 * len(rows) < across * up and not (several and len(rows) >= 2 * places) else []


def with_number(rows: Frame, of: str, positive: bool = False) -> Frame:
    """The done rows that have it."""
    done = rows[rows["status"] == "done"]
    return done[np.isfinite(done[of]) & (done[of] > 0 if positive else True)]


def robust(table: Table, of: str) -> Frame:
    """A row for each impact of a search for what survives: the worst, or the median, of it and those around it."""
    rows, over, error = table.rows, table.search["over"], error_of(of)
    values = {name: list(dict.fromkeys(rows[name])) for name in table.inputs}
    steps = [range(0, len(each), 3 if name in over else 1) for name, each in values.items()]
    strides = [int(np.prod([len(each) for each in list(values.values())[k + 1 :]])) for k in range(len(values))]
    around = [range(3) if name in over else range(1) for name in values]
    found = []
    for start in product(*steps):
        ids = [int(np.dot(np.add(start, near), strides)) for near in product(*around)]
        some = rows.iloc[ids]
        if (some["status"] == "done").all():
            by = np.max if table.search["by"] == "worst" else np.median
            one = {**rows.iloc[ids[0]].to_dict(), "task": ids[0], of: by(some[of].to_numpy())}
            one |= {"chaotic": some["chaotic"].any(), "checked": some["checked"].all()}
            found.append(one | {error: some[error].max(skipna=False)})
    frame = pd.DataFrame(found) if found else rows.iloc[:0].reset_index()
    return frame.set_index("task").drop(columns=["spread_low", "spread_high"])


def best(rows: Frame, over: Sequence[str], of: str, chaotic_too: bool) -> tuple[Frame, Frame]:
    """The rows that compete, and the lowest of every cell, of equal ones the first."""
    used, cells = [], []
    for _, cell in with_number(rows, of).groupby(list(over)):
        firm = cell[~cell["chaotic"]]
        some = cell if chaotic_too or firm.empty else firm
        used.append(some)
        order = ["N", "zeta_T", "M_over_M0", "V_over_V0"]
        cells.append(some[some[of] == some[of].min()].sort_index().sort_values(order, kind="stable").iloc[:1])
    return pd.concat(used).sort_index(), pd.concat(cells)


def bounds(rows: Frame, of: str) -> tuple["pd.Series[float]", "pd.Series[float]"]:
    """Between which every row's number lies, by its error, of a chaotic one by its spread."""
    reach = rows[error_of(of)].where(np.isfinite(rows[error_of(of)])) * rows[of].abs()
    low, high = (rows[of] - reach), rows[of] + reach
    low = low.where(low.isna() | (rows[of] < 0) | (low > 0), 0.0)
    if of == "ke_ratio" and "spread_low" in rows:
        chaotic = rows["chaotic"] & np.isfinite(rows["spread_low"])
        low, high = low.mask(chaotic, rows["spread_low"]), high.mask(chaotic, rows["spread_high"])
    return low, high


def _calm(line: Frame, numbers: Frame, along: str) -> tuple[Frame, dict[str, int]]:
    """The rows with a number that are not chaotic, in order, and how many there are of which kind."""
    calm = numbers[~numbers["chaotic"]].sort_values(along).drop_duplicates(along)
    told = {"rows": len(calm), "chaotic": int(numbers["chaotic"].sum()), "unchecked": int((~calm["checked"]).sum())}
    return calm, told | {"without": len(line) - len(numbers)}


def transition(line: Frame, of: str) -> dict[str, object]:
    """N_transition of one line by each definition, or why there is none."""
    calm, told = _calm(line, with_number(line, of, positive=True), "N")
    N, ratio = calm["N"].tolist(), calm[of].tolist()
    high = [k for k in range(len(N) - 1) if ratio[k] > 1]
    if told["without"] == len(line):
        return told | {"why_not": f"without {of} above 0"}
    if len(N) < 3:
        return told | {"why_not": "fewer than 3 N"}
    if not high:
        return told | {"why_not": "never above 1"}
    if not ratio[-1] < 0.7:
        return told | {"why_not": "not below 0.7 at the largest N"}
    first = last = high[-1]
    while first > 0 and ratio[first - 1] * 1.1 > ratio[first]:
        first -= 1
    while last < len(N) - 1 and ratio[last + 1] < ratio[last] * 1.1:
        last += 1
    steps = range(first, max(last, first + 1))
    log = min(steps, key=lambda k: np.log(ratio[k + 1] / ratio[k]) / np.log(N[k + 1] / N[k]))
    slope = min(steps, key=lambda k: (ratio[k + 1] - ratio[k]) / (N[k + 1] - N[k]))
    places = {"N_transition": log, "by_slope": slope, "by_level": high[-1]}
    told |= {name: (N[k] * N[k + 1]) ** 0.5 for name, k in places.items()}
    return told | {"why_not": "", "ends": (N[log], N[log + 1])}


def law(lines: Frame, column: str) -> float | None:
    """The exponent b of one impact's transitions, by weighted least squares in logarithms."""
    rows = lines[(lines["zeta_T"] > 0) & (lines["zeta_T"] <= 1e-2) & lines[column].notna()]
    if rows["zeta_T"].nunique() < 4:
        return None
    weight = 1 / np.log(rows["N_high"] / rows["N_low"]) ** 2
    x, y = np.log(rows["zeta_T"]), np.log(rows[column])
    x, y = x - (weight * x).sum() / weight.sum(), y - (weight * y).sum() / weight.sum()
    return float(-(weight * x * y).sum() / (weight * x * x).sum())


def crossing(line: Frame, of: str, along: str, level: float, which: str) -> dict[str, object]:
    """Between which values of the axis the level is crossed, or why it is not."""
    calm, told = _calm(line, with_number(line, of), along)
    values = list(zip(calm[along], calm[of], strict=True))
    pairs = [(a, b) for a, b in pairwise(values) if (a[1] < level) != (b[1] < level)]
    if not values:
        return told | {"why_not": "chaotic" if told["without"] < len(line) else f"without {of}"}
    if len(values) == 1:
        return told | {"why_not": "fewer than 2 values"}
    if not pairs:
        return told | {"why_not": f"{'below' if values[0][1] < level else 'above'} throughout"}
    (low, at_low), (high, at_high) = pairs[0 if which == "first" else -1]
    return told | {"why_not": "", "low": low, "high": high, "at_low": at_low, "at_high": at_high}


def number(rows: Frame, name: str) -> "pd.Series[float]":
    """A dimensionless number of the impacts; infinite without damping."""
    M, V = rows["M_over_M0"] * M0, rows["V_over_V0"] * V0
    with np.errstate(divide="ignore"):
        return {"Pi_IE": M * V**2, "Pi_IV": M * V / (2 * rows["zeta_T"]), "N_over_zeta_T": rows["N"] / rows["zeta_T"]}[
            name
        ]


def scatter(x: Sequence[float], y: Sequence[float]) -> float:
    """Of y, in decades, about the median of the rows beside each one in x."""
    rank = np.round(np.asarray(x), 9)
    order = np.argsort(rank, kind="stable")
    rank, y = rank[order], np.asarray(y)[order]
    n, distances = len(y), []
    half = max(8, int(0.05 * n)) // 2
    for value in rank:
        first, past = int((rank < value).sum()), int((rank <= value).sum())
        if len(set(rank)) * 8 > n:  # no grid: so many rows, and all that have the values of the outermost
            low, high = max((first + past) // 2 - half, 0), min((first + past - 1) // 2 + half, n - 1)
            first, past = int((rank < rank[low]).sum()), int((rank <= rank[high]).sum())
        here = y[len(distances)]
        distances.append(abs(here - np.median(y[first:past])) / (1 - 1.25 / max(past - first, 4)))
    return float(1.4826 * np.median(distances))
