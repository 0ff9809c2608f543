"""Figure 1a: a drawing of the struck chain, and the energy of one of its springs."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from analysis.look import COLOURS
from kernel.laws import PAPER

SITES = {1.9: "1", 3.6: "2", 5.3: "3", 8.2: "$N$"}  # where the sites stand, with their names; dots between 3 and N
WALL = 9.9
MASS = 0.45  # half the side of a site
SPRING, DAMPER = 0.22, -0.24  # heights above the middle line


def chain(ax: Any) -> None:
    """Draw impactor, sites, springs over dampers, and the wall."""
    black = {"color": "black", "linewidth": 0.9}
    _box(ax, 0.35, 0.55, COLOURS[1], "$M$")
    ax.annotate("", (0.75, 0.85), (-0.05, 0.85), arrowprops={"arrowstyle": "->", "lw": 1})
    ax.text(0.35, 0.95, "$V$", ha="center", va="bottom")
    for place, name in SITES.items():
        _box(ax, place, MASS, "0.85", name)
    for left, right in ((1.9, 3.6), (3.6, 5.3), (8.2, WALL + MASS)):
        _link(ax, left + MASS, right - MASS, black)
    ax.text(6.75, 0, r"$\cdots$", ha="center", va="center", fontsize=14)
    ax.plot([WALL, WALL], [-0.7, 0.7], color="black", linewidth=1.2)
    for y in np.linspace(-0.7, 0.55, 7):
        ax.plot([WALL, WALL + 0.15], [y, y + 0.15], **black)
    ax.text(2.75, 0.4, "$f(x)$", ha="center", va="bottom", fontsize=8)
    ax.text(2.75, -0.5, r"$2\zeta = 2N\zeta_T$", ha="center", va="top", fontsize=8)
    ax.annotate("", (WALL, -1.0), (1.9 - MASS, -1.0), arrowprops={"arrowstyle": "<->", "lw": 0.8})
    ax.text((WALL + 1.9 - MASS) / 2, -1.05, "$L$", ha="center", va="top")
    ax.set(xlim=(-0.3, 10.2), ylim=(-1.5, 1.4), aspect="equal")
    ax.axis("off")


def energy(ax: Any) -> None:
    """Draw the energy of a spring, in k_T L^2 / N, against its strain, with its stable states."""
    x = np.linspace(-0.56, 0.08, 300)
    second = 1 / (PAPER.c3 * PAPER.barrier())  # the force's other zero beside rest: their product is 1/c3
    ax.plot(x, _energy(x), color=COLOURS[0], linewidth=1.2)
    stable = [0, second]
    ax.plot(stable, _energy(stable), "o", color=COLOURS[2], markersize=4, label="stable")
    ax.set(xlabel="displacement $x$", ylabel="energy ($k_T L^2/N$)", ylim=(-0.001, 0.016), yticks=[0, 0.01])
    ax.legend(fontsize=7.5, frameon=False, loc="upper center")


def _energy(strains: Iterable[float]) -> list[float]:
    return [PAPER.energy_at(e) for e in strains]


def _box(ax: Any, middle: float, half: float, colour: str, name: str) -> None:
    from matplotlib.patches import Rectangle

    corner = (middle - half, -half)
    ax.add_patch(Rectangle(corner, 2 * half, 2 * half, facecolor=colour, edgecolor="black", linewidth=0.9))
    ax.text(middle, 0, name, ha="center", va="center")


def _link(ax: Any, left: float, right: float, line: dict[str, Any]) -> None:
    """Draw a zigzag spring over a piston in its cylinder."""
    turns = np.linspace(left + 0.12, right - 0.12, 9)
    heights = SPRING + 0.12 * np.array([0, 1, -1, 1, -1, 1, -1, 1, 0])
    ax.plot([left, *turns, right], [SPRING, *heights, SPRING], **line)
    middle, side = (left + right) / 2, 0.12
    ax.plot([left, middle], [DAMPER, DAMPER], **line)
    ax.plot([middle, middle], [DAMPER - 0.6 * side, DAMPER + 0.6 * side], **line)
    cylinder = [middle - side, middle + side, middle + side, middle - side]
    ax.plot(cylinder, [DAMPER + side, DAMPER + side, DAMPER - side, DAMPER - side], **line)
    ax.plot([middle + side, right], [DAMPER, DAMPER], **line)
