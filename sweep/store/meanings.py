"""What every column of a table is, in words and units: for exports, pages and the documentation alike."""

from collections.abc import Mapping

from kernel.columns import columns_of_quantity

# Of a column: its unit in words ("1": none), and what it is. Times are over N: cell transit times a cell.
MEANINGS: Mapping[str, tuple[str, str]] = {
    "task": ("1", "number of the task: the row in the table"),
    "N": ("1", "number of unit cells"),
    "zeta_T": ("1", "bulk damping ratio; that of one damper is N times as large"),
    "M_over_M0": ("1", "impactor mass over the nominal mass M0, 0.159 of the chain's mass"),
    "V_over_V0": ("1", "impact speed over the nominal speed V0, 0.26 of the long-wave sound speed"),
    "ke_bistable": ("1", "peak kinetic energy of the watched site over the initial total energy"),
    "ke_linear": ("1", "the same in the same chain made linear"),
    "ke_ratio": ("1", "ke_bistable over ke_linear: below 1 the chain protects better than when made linear"),
    "t_peak_bistable": ("1", "when the chain's peak is, in cell transit times over N"),
    "t_peak_linear": ("1", "when the linear chain's peak is, in cell transit times over N"),
    "error": ("1", "estimated relative error of ke_ratio; unknown where not certified"),
    "condition": ("1", "relative change of ke_ratio over that of its inputs and of the first state, estimated"),
    "chaotic": ("1", "whether condition is above 1000; unknown where the row was not checked"),
    "checked": ("1", "whether condition is known, and with it chaotic"),
    "spread_low": ("1", "lower end of the range of ke_ratio of a chaotic task's neighbours; unknown of calm ones"),
    "spread_high": ("1", "upper end of the range of ke_ratio of a chaotic task's neighbours; unknown of calm ones"),
    "method": ("", "integrator of the chain, not of the linear one"),
    "steps": ("1", "accepted steps of all integrations of the task, those within an open contact too"),
    "seconds": ("s", "time that the task took"),
    "rank": ("1", "rank that computed the task"),
    "status": ("", "done, or why not"),
    "checksum": ("1", "CRC-32 of the row's other columns"),
}


def unit(name: str) -> str:
    """The unit of a column; "1" where it has none, and where it is a number of the model."""
    if name in MEANINGS:
        return MEANINGS[name][0]
    quantity = _quantity_of(name)
    if quantity is None or name.endswith(("_ratio", "_error")):
        return "1"
    from kernel.quantities import QUANTITIES  # loaded by now

    return str(QUANTITIES[quantity].unit())


def meaning(name: str) -> str:
    """What a column is, in one phrase."""
    if name in MEANINGS:
        return MEANINGS[name][1]
    quantity = _quantity_of(name)
    if quantity is None:
        return name.replace("_", " ").replace(".", " ")
    words = quantity.replace("_", " ")
    value, linear, ratio, error = columns_of_quantity(quantity)
    return {
        value: f"{words} of the chain",
        linear: f"{words} of the chain made linear",
        ratio: f"{words} of the chain over that of the chain made linear",
        error: f"estimated relative error of {value}, {linear} and {ratio}",
    }[name]


def _quantity_of(name: str) -> str | None:
    """The quantity (kernel.quantities) to which a column belongs."""
    from kernel.quantities import QUANTITIES  # and with it numba, which the columns of the kinetic energy do without

    return next((one for one in QUANTITIES if name in columns_of_quantity(one)), None)
