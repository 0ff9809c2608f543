"""Random options, each of which the --help of a command that draws allows."""

import numpy as np
import pandas as pd

from tests.asked.tables import Table

OBSERVED = ("wall_force_ratio", "wall_force_ratio", "wall_force", "wall_force_linear", "flipped", "flipped_ratio")


def any_look(rng: np.random.Generator, name: str) -> tuple[list[str], str, tuple[int, int] | None]:
    """How the picture is to look; its name; its pixels where a size is asked for."""
    words, pixels = list[str](), None
    if rng.random() < 0.2:
        words += ["--limits", "0.01,1" if name not in ("transition", "level") else "2,300"]
    if rng.random() < 0.2:
        words += ["--cmap", str(rng.choice(["viridis", "RdYlBu_r", "gray"]))]
    if rng.random() < 0.2:
        words += ["--title", "A title of $N$ cells"]
    dpi, side = int(rng.choice([50, 100])), (float(rng.choice([4, 6.5, 9])), float(rng.choice([3.5, 5])))
    words += ["--dpi", str(dpi)]
    if rng.random() < 0.3:
        words += ["--size", f"{side[0]:g},{side[1]:g}"]
        pixels = round(side[0] * dpi), round(side[1] * dpi)
    return words, f"a{rng.integers(10**6)}.{rng.choice(['png', 'png', 'pdf', 'svg'])}", pixels


def any_at(
    rng: np.random.Generator, rows: pd.DataFrame, names: list[str], share: float
) -> tuple[dict[str, float], list[str]]:
    """Values of one finished row, with all their digits or with six; now and then one that no row has."""
    done = rows[rows["status"] == "done"]
    if done.empty or not names:
        return {}, []
    row, strange = done.iloc[int(rng.integers(len(done)))], 1000.0 if rng.random() < 0.05 else 1.0
    at = {name: float(row[name]) * strange for name in names if rng.random() < share}
    words = [f"{name}={value:.6g}" if rng.random() < 0.3 else f"{name}={value!r}" for name, value in at.items()]
    return at, ["--at", *words] if words else []


def any_over(rng: np.random.Generator, table: Table) -> tuple[list[str], list[str]]:
    """The two axes, and the option."""
    if rng.random() < 0.3:
        return ["N", "zeta_T"], []
    over = [str(each) for each in rng.choice(table.inputs, 2, replace=False)]
    return over, ["--over", ",".join(over)]


def any_of(rng: np.random.Generator, table: Table, values: bool = True) -> tuple[str, list[str], list[str]]:
    """A quantity; the option; why it is refused."""
    there = "wall_force" in table.rows or rng.random() < 0.1
    of = str(rng.choice(OBSERVED)) if there and rng.random() < 0.5 else "ke_ratio"
    of = of if values or of.endswith("_ratio") else "wall_force_ratio"
    words = [] if of == "ke_ratio" and rng.random() < 0.5 else ["--of", of]
    return of, words, [] if of in table.rows else ["of: ", "lacks the columns"]
