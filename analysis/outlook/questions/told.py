"""What the questions about laws both say of the numbers that might predict."""

import pandas as pd

from analysis.outlook.part import Grid, interval


def candidates_grid(caption: str, judged: pd.DataFrame, off: str) -> Grid:
    """A row per candidate, best first."""
    columns = ("number", "laws", "rank correlation", "explained, each law left out", off, "verdict")
    rows = [
        [
            f"{one['name']}: {one['words']}",
            str(one["laws"]),
            interval(one["rank"], one["rank_low"], one["rank_high"], ".2f"),
            interval(one["explained"], one["low"], one["high"], ".2f"),
            f"{one['off']:.3f}",
            str(one["verdict"]),
        ]
        for one in judged.to_dict("records")
    ]
    return Grid(caption, columns, rows)


def best_of(judged: pd.DataFrame, what: str) -> str:
    """A sentence on the best candidate."""
    if judged.empty:
        return f"Too few laws tell {what}, so that no number is judged."
    one = judged.iloc[0]
    share = f"{interval(100 * one['explained'], 100 * one['low'], 100 * one['high'], '.0f')} % of its variance"
    verb = {"predicts": "One number predicts", "helps": "The best number helps, but does not predict"}
    start = verb.get(one["verdict"], "No number predicts")
    return f"{start} {what}: {one['name']} ({one['words']}) explains {share} over laws that it was not fitted to."
