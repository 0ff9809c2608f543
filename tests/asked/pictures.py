"""Questions whose answer is a picture with its numbers: what is asked at random, and whether the answer is right."""

import numpy as np
import pandas as pd

from tests.asked import truth
from tests.asked.judge import Judge, Question, is_told, lowest, never, rows_line, said, same
from tests.asked.options import any_at, any_look, any_of, any_over
from tests.asked.tables import Table
from tests.asked.told import Told, must

CURVES_MAX = 8  # of a picture of `level`


def question(rng: np.random.Generator, table: Table, name: str) -> Question:
    """One command with random options that its --help allows."""
    look, picture, pixels = any_look(rng, name)
    words, refused, judge = KINDS[name](rng, table)
    if table.done.empty:
        refused = ["has no finished row", *refused]
    return Question([name, table.path.name, "-o", picture, *words, *look], refused, judge, picture, pixels)


def _best(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    (over, first), (of, second, refused) = any_over(rng, table), any_of(rng, table)
    chaotic_too = bool(rng.random() < 0.3)
    search = table.search if table.search.get("find") == "lowest" else {}
    among = [name for name in search.get("over", []) if name not in over]
    rows = truth.robust(table, of) if search.get("robust") and of in table.rows else table.rows
    at, third = any_at(rng, rows, table.inputs, 0.15)
    words = [*first, *second, *third, *(["--chaotic-too"] if chaotic_too else [])]
    if search and of != search.get("of", "ke_ratio"):
        return words, [*refused, "which tells nothing of"], never
    if search:
        rows = rows[rows["checked"] | (rows["status"] != "done")]
    rows, missing = truth.at_values(rows, at)
    refused += missing + truth.varies(table, rows, [*over, *among])
    if not refused:
        refused = truth.no_grid(table.rows, over, several=True)
        refused += [] if len(truth.with_number(rows, of)) else ["no finished row has a "]
    if refused:
        return words, refused, never

    def judge(told: Told, csv: pd.DataFrame) -> None:
        used, cells = truth.best(rows, over, of, chaotic_too)
        rows_line(told, rows, " candidates?" if search.get("robust") else "")
        line = said(told, r"^used +(\d+) finished (?:row|candidate)s; left out: (\d+) without")
        done = rows[rows["status"] == "done"]
        must(int(line[1]) == len(used), f"{told.line}: {line[0]}, {len(used)} used")
        must(int(line[2]) == len(done) - len(truth.with_number(rows, of)), f"{told.line}: {line[0]}")
        filled = said(told, r"^cells +(\d+) of (\d+) have a number")
        must(int(filled[1]) == len(cells), f"{told.line}: {filled[0]}, {len(cells)} have")
        same(told, csv, cells, (f"{of}_here",))
        lowest(told, cells, of, chaotic_too)
        _optimum(told, table, used, of, chaotic_too, over)

    return words, [], judge


def _optimum(told: Told, table: Table, used: pd.DataFrame, of: str, chaotic_too: bool, over: list[str]) -> None:
    firm = used[~used["chaotic"]]
    some = used if chaotic_too or firm.empty else firm
    top = some[some[of] == some[of].min()].sort_index().sort_values(list(table.inputs[:4]), kind="stable").iloc[:1]
    some_rows = "(?:; among the rows computed: others may be (?:lower|as low))?"
    line = said(told, rf"^optimum +{of} = (\S+) \((.*?)\) at (.*?)(?:; (\d+) other rows? may be as low)?{some_rows}$")
    must(is_told(line[1], top[of].iloc[0]), f"{told.line}: {line[0]}, not {top[of].iloc[0]}")
    low, high = (float(each.iloc[0]) for each in truth.bounds(top, of))
    if np.isnan(high):
        must("error not estimated" in line[2] and not line[4], f"{told.line}: {line[0]}")
        return
    must(line[2].startswith(f"{low:.4g} to {high:.4g}"), f"{told.line}: {line[0]}, {low} to {high}")
    least = truth.bounds(used, of)[0]
    rivals = int((least.where(least.notna(), used[of]) <= high).sum()) - 1
    must(int(line[4] or 0) == rivals, f"{told.line}: {line[0]}, {rivals} rivals")


def _map(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    (over, first), (of, second, refused) = any_over(rng, table), any_of(rng, table)
    others = [name for name in table.inputs if name not in over]
    at, third = any_at(rng, table.rows, others, 0.85)
    whole, missing = truth.at_values(table.rows, at)
    rows = whole[whole["status"] == "done"]
    refused = [*refused, *missing, *truth.no_grid(table.rows, over, several=False)]
    if any(len(rows[name].unique()) > 1 for name in others if name not in at):
        refused.append("choose a value of")
    if not refused and not np.isfinite(rows[of]).any():
        refused.append("no finished row of this map has a ")
    if refused:
        return [*first, *second, *third], refused, never
    inferred = table.search.get("find") == "map" and of == table.search.get("of", "ke_ratio")

    def judge(told: Told, csv: pd.DataFrame) -> None:
        drawn = rows.sort_values([*over, truth.error_of(of)], kind="stable").drop_duplicates(over)
        computed = csv[~csv["inferred"]] if inferred and "inferred" in csv else csv
        same(told, computed, drawn, ("inferred",))
        rows_line(told, table.rows)
        said(told, rf"^cells +{np.isfinite(drawn[of]).sum()} of \d+ have a number")
        lowest(told, drawn[np.isfinite(drawn[of])], of)
        if len(between := csv.drop(computed.index)):
            must((between[of] > 0).all(), f"{told.line}: inferred {between[of].tolist()}")
            fate = whole.loc[between["task"], "status"]
            must(fate.isin(["pending", "unasked"]).all(), f"{told.line}: inferred what is {set(fate)}")

    return [*first, *second, *third], [], judge


def _points(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    (_, first), (of, second, refused) = any_over(rng, table), any_of(rng, table)
    at, third = any_at(rng, table.rows, table.inputs, 0.15)
    rows, missing = truth.at_values(table.rows, at)
    refused = [*refused, *missing]
    if not refused and truth.with_number(rows, of).empty:
        refused.append("there is no finished row with a ")

    def judge(told: Told, csv: pd.DataFrame) -> None:
        drawn = truth.with_number(rows, of)
        same(told, csv, drawn)
        rows_line(told, rows)
        said(told, rf"^used +{len(drawn)} rows?, each a point; ")
        lowest(told, drawn, of)

    return [*first, *second, *third], refused, judge


def _transition(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    of, first, refused = any_of(rng, table, values=False)
    at, second = any_at(rng, table.rows, table.inputs[1:], 0.2)
    rows, missing = truth.at_values(table.rows, at)
    refused = [*refused, *missing, *truth.varies(table, rows)]
    line = ["M_over_M0", "V_over_V0", "zeta_T"]
    some = rows.iloc[:0] if refused else truth.with_number(rows, of, positive=True)
    done = rows[rows["status"] == "done"]
    if not refused and some.empty:
        refused.append("no finished row has a ")
    elif not refused and some.groupby(line)["N"].nunique().max() < 3:
        refused.append("needs at least 3 different N")
    elif not refused and some["chaotic"].all():
        refused.append("every finished row is chaotic")
    elif not refused and not done["zeta_T"].any():
        refused.append("is drawn against zeta_T above 0")

    def judge(told: Told, csv: pd.DataFrame) -> None:
        groups = list(done.groupby(line))
        must(len(csv) == len(groups), f"{told.line}: {len(csv)} lines, not {len(groups)}")
        for (_, found), (key, rows_of) in zip(csv.fillna({"why_not": ""}).iterrows(), groups, strict=True):
            ours = truth.transition(rows_of, of) | dict(zip(line, key, strict=True))
            low, high = ours.pop("ends", (np.nan, np.nan))
            wrong = [name for name, value in ours.items() if not _equal(found[name], value)]
            must(not wrong, f"{told.line}: {found[wrong].to_dict()}, not {ours}")
            if ours["why_not"] == "":
                must(
                    found["N_low"] <= low and high <= found["N_high"], f"{told.line}: {found.to_dict()}, {low}, {high}"
                )
            else:
                must(np.isnan(found["N_transition"]), f"{told.line}: {found.to_dict()}")
        said(told, rf"^lines +{len(groups)}, {int(csv['N_transition'].notna().sum())} with a transition")
        for _, lines in csv.groupby(line[:2]):
            for column, ending in (("N_transition", ""), ("by_slope", "_by_slope"), ("by_level", "_by_level")):
                b = truth.law(lines, column)
                must(
                    (lines[f"b{ending}"].isna() if b is None else np.isclose(lines[f"b{ending}"], b, rtol=1e-6)).all(),
                    f"{told.line}: b{ending} {lines[f'b{ending}'].tolist()}, not {b}",
                )

    return [*first, *second], refused, judge


def _equal(a: object, b: object) -> bool:
    return a == b or (isinstance(b, float) and bool(np.isclose(float(str(a)), b, rtol=1e-12)))


def _level(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    search = table.search if table.search.get("find") == "level" else {}
    of, words, refused = any_of(rng, table)
    along, which = str(rng.choice(table.inputs)), str(rng.choice(["first", "last"]))
    words += ["--along", along, "--crossing", which]
    numbers = truth.with_number(table.rows, of)[of] if of in table.rows else table.rows["N"][:0]
    level = float(f"{np.quantile(numbers, rng.random()):.3g}") if len(numbers) else 0.5
    if search and rng.random() < 0.7:
        of, along, which, level, words, refused = (
            "ke_ratio",
            search["along"],
            search["crossing"],
            search["level"],
            [],
            [],
        )
    else:
        words += [f"--level={level}"]
    at, more = any_at(rng, table.rows, [name for name in table.inputs if name != along], 0.3)
    rows, missing = truth.at_values(table.rows, at)
    refused = [*refused, *missing]
    some = rows.iloc[:0] if refused else truth.with_number(rows, of)
    done = rows[rows["status"] == "done"]
    others = [name for name in table.inputs if name != along]
    if not refused and some.empty:
        refused.append("no finished row has a ")
    elif not refused and len(done) > 1 and done.groupby(others)[along].nunique().max() < 2:
        refused.append("form no lines along")
    elif not refused:
        order = [name for name in ("zeta_T", "V_over_V0", "M_over_M0", "N", *table.inputs[4:]) if name in others]
        across = max(order, key=lambda name: done[name].nunique())
        if len(done.drop_duplicates([name for name in others if name != across])) > CURVES_MAX:
            refused.append("can be told apart")

    def judge(told: Told, csv: pd.DataFrame) -> None:
        groups = list(done.groupby(others))
        must(len(csv) == len(groups), f"{told.line}: {len(csv)} lines, not {len(groups)}")
        for (_, found), (key, line) in zip(csv.fillna({"why_not": ""}).iterrows(), groups, strict=True):
            ours = truth.crossing(line, of, along, level, which) | dict(zip(others, key, strict=True))
            wrong = [name for name, value in ours.items() if found[name] != value]
            must(not wrong, f"{told.line}: {found[wrong].to_dict()}, not {ours}")
        crossed = int(csv["why_not"].fillna("").eq("").sum())
        said(told, rf"^lines +{len(groups)}, {crossed} with the {which} crossing of {of} = ")
        rows_line(told, rows)

    return [*words, *more], refused, judge


def _collapse(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str], Judge]:
    of, words, refused = any_of(rng, table, values=False)
    against = str(rng.choice(["Pi_IE", "Pi_IV", "N_over_zeta_T"]))
    words += ["--against", against, "--colour", str(rng.choice(table.inputs[:4]))]
    at, more = any_at(rng, table.rows, table.inputs, 0.05)
    rows, missing = truth.at_values(table.rows, at)
    refused = [*refused, *missing, *truth.varies(table, rows)]
    some = rows.iloc[:0] if refused else truth.with_number(rows, of, positive=True)
    some = some[~some["chaotic"]]
    some = some[np.isfinite(truth.number(some, against))]
    if not refused and len(some) < 20:
        refused += ["a collapse needs at least 20 rows", "no finished row has a "]

    def judge(told: Told, csv: pd.DataFrame) -> None:
        ours = some.assign(**{against: truth.number(some, against)})
        same(told, csv, ours, (against,))
        must(np.allclose(csv[against], ours[against], rtol=1e-12), f"{told.line}: {against} differs")
        line = said(told, rf"^collapse +scatter (\S+) decades of {of} against {against}, ")
        expected = truth.scatter(np.log10(ours[against]), np.log10(ours[of]))
        must(line[1] == f"{expected:.3f}", f"{told.line}: {line[0]}, not {expected}")
        rows_line(told, rows)

    return [*words, *more], refused, judge


KINDS = {
    "best": _best,
    "map": _map,
    "points": _points,
    "transition": _transition,
    "level": _level,
    "collapse": _collapse,
}
