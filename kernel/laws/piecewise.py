"""A spring of straight pieces in compression: bilinear, trilinear, bistable or merely softening."""

import math
from itertools import pairwise
from typing import Any, NamedTuple

from kernel.simd import negative_part
from kernel.task import breaking, list_of, outside

PIECES_MAX = 8
TOUCHED = 1e-12  # of a strain, in k_T L: so small a force is 0 but for rounding


class PiecewiseLinear(NamedTuple):
    """Slope 1 in tension and in compression to -strains[0], then slopes[0] to -strains[1], and so on.

    Of two slopes as L. Truskinovsky and A. Vainchtein, SIAM J. Appl. Math. 66, 533, 2005, have it.

    Parameters
    ----------
    strains : tuple of float
        Where the slope changes, ascending, 1e-6 to 100, 8 at most.
    slopes : tuple of float
        The slope beyond each of these, -1000 to 1000; the last one 1e-6 or more, or a link would collapse without end.

    Raises
    ------
    ValueError
        By the `kernel.Model` that it is given to, naming every number that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> law = kernel.PiecewiseLinear((0.1, 0.3), (-0.5, 2.0))
    >>> [round(float(law.energy_at(e)), 4) for e in (-0.1, -0.3)]
    [0.005, 0.015]
    """

    strains: tuple[float, ...]
    slopes: tuple[float, ...]

    def excess(self, e: Any) -> Any:
        strains, slopes = self.strains, self.slopes
        before, total = 1.0, 0.0 * e
        for k in range(len(strains)):
            total = total + (slopes[k] - before) * negative_part(e + strains[k])
            before = slopes[k]
        return total

    def energy_at(self, e: float) -> float:
        strains, slopes = self.strains, self.slopes
        before, total = 1.0, 0.5 * e * e
        for k in range(len(strains)):
            m = negative_part(e + strains[k])
            total += 0.5 * (slopes[k] - before) * m * m
            before = slopes[k]
        return total

    def stiffness_at(self, e: float) -> float:
        strains, slopes = self.strains, self.slopes
        slope = 1.0
        for k in range(len(strains)):
            if e < -strains[k]:
                slope = slopes[k]
        return slope

    def steepest(self, lowest: float, highest: float) -> float:
        strains, slopes = self.strains, self.slopes
        most = 1.0
        for k in range(len(strains)):
            if lowest < -strains[k]:
                most = max(most, slopes[k])
        return most

    def is_linear(self) -> bool:
        strains, slopes = self.strains, self.slopes
        same = True
        for k in range(len(strains)):
            same = same and slopes[k] == 1.0
        return same

    def stiffens_in_tension(self) -> bool:
        return False

    def stiffness_jumps(self) -> bool:
        return not self.is_linear()

    def barrier(self) -> float:
        strains, slopes = self.strains, self.slopes
        tension, found = -strains[0], math.nan
        for k in range(len(strains)):
            length = strains[k + 1] - strains[k] if k + 1 < len(strains) else math.inf
            end = tension - slopes[k] * length
            if slopes[k] < 0.0 and math.isnan(found) and end >= -TOUCHED * strains[k]:
                found = -tension / slopes[k] - strains[k]
            tension = end
        return found

    def problems(self) -> list[str]:
        """Every number that breaks its rule."""
        found = breaking(list_of(1e-6, 100.0), strains=self.strains) + breaking(
            list_of(-1000.0, 1000.0), slopes=self.slopes
        )
        if found:
            return found
        many, slopes = len(self.strains), len(self.slopes)
        if many != slopes or many > PIECES_MAX:
            found.append(f"strains, slopes: must be as many, {PIECES_MAX} at most, got {many} and {slopes}")
        if any(a >= b for a, b in pairwise(self.strains)):
            found.append(f"strains: must ascend, got {self.strains}")
        return found + outside(1e-6, 1000.0, **{f"slopes[{len(self.slopes) - 1}]": self.slopes[-1]})
