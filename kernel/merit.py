"""Figures of merit of many tasks: the kinetic energy, and whatever else kernel.quantities knows."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kernel.columns import KE, PEAK_KE, columns_of, columns_of_quantity
from kernel.hints import shown, unknown
from kernel.ke import rows_of
from kernel.lattice import PAPER_MODEL, Model, check_comparable, names_of_numbers
from kernel.method import ACCURACY, MAX_STEPS, choose
from kernel.problems import ProblemsError
from kernel.quantities import QUANTITIES, lacking
from kernel.task import PARAMETERS, check, gathered

# Where a row has what `measure` calls the columns of the kinetic energy.
OF_KE = {"ke": "ke_bistable", "ke_error": "error"}


def measure(
    tasks: Any,
    observe: Iterable[str] = ("ke",),
    model: Model = PAPER_MODEL,
    accuracy: float = ACCURACY,
    method: str = "auto",
    rtol: float | None = None,
    atol: float | None = None,
    *,
    certify: bool = True,
    max_steps: int = MAX_STEPS,
    workers: int = 1,
) -> NDArray[np.void]:
    """Figures of merit of many tasks, each of the chain, of its linear companion, their ratio, and their error.

    Parameters
    ----------
    tasks
        As of `ke_ratios`; columns named as numbers of the model ("spring.c2") give each task its own.
    observe : str or names
        Out of "ke" or "peak_ke" (largest kinetic energy of the site over TE; its columns are those of "ke"),
        "wall_force" and "contact_force" (largest, in k_T L), "acceleration" (largest of the site, in k_T L / m_T),
        "impulse" (wall force over time, over the impactor's momentum), "arrival" (when the site's speed first exceeds
        V/100, over N), and at the end of the run "dissipated", "stored", "rebound" (energy taken by the dampers, in the
        springs, of the impactor, over TE), "flipped" (share of the links beyond their barrier).
    model : Model
        The chain.
    accuracy, method, rtol, atol, certify, max_steps
        As of `ke_ratio`, for whose sake steps are chosen.
    workers : int
        As of `ke_ratios`.

    Returns
    -------
    structured array (n,)
        The inputs; for each quantity q its columns q, q_linear, q_ratio, q_error (estimated, relative: of these three,
        of "ke" of the ratio alone); then `condition`, `chaotic`, `checked` (of the kinetic energy), `method`, `steps`,
        `status`. What is not known, as the ratio where the linear chain has nothing of q, is nan.

    Raises
    ------
    ValueError
        Naming every argument that breaks its rule.

    Examples
    --------
    >>> import kernel
    >>> model = kernel.Model(spring=kernel.Bistable(c2=5.0, c3=6.5))
    >>> rows = kernel.measure({"N": 20, "zeta_T": 4e-4, "M_over_M0": 2, "V_over_V0": 2}, observe="ke", model=model)
    >>> rows.dtype.names[4:8], rows["status"].tolist()
    (('ke', 'ke_linear', 'ke_ratio', 'ke_error'), ['done'])
    """
    columns, integrator, _, _, asked = gathered(
        lambda: columns_of(tasks, also=names_of_numbers(model)),
        lambda: choose(method, accuracy, rtol, atol, max_steps, certify=certify),
        lambda: check({"certify": certify, "workers": workers}),
        lambda: check_comparable(model),
        lambda: _asked(observe, model),
    )
    # Sorted, as a sweep asks for them: what was compiled for one serves the other.
    quantities = {name: QUANTITIES[name] for name in sorted(QUANTITIES) if name in asked}
    found = rows_of(columns, integrator, bool(certify), model, quantities, int(workers))
    axes = [name for name in columns if name not in PARAMETERS]
    numbers = [column for name in asked for column in columns_of_quantity(name)]
    told = ("condition", "chaotic", "checked", "method", "steps", "status")
    home = {name: OF_KE.get(name, name) for name in (*PARAMETERS, *axes, *numbers, *told)}
    result = np.empty(len(found), [(name, found.dtype[column]) for name, column in home.items()])
    for name, column in home.items():
        result[name] = found[column]
    return result


def _asked(observe: Any, model: Any) -> tuple[str, ...]:
    """The quantities' names; ValueError naming all that are none, or that the model's law cannot tell."""
    known = (KE, PEAK_KE, *QUANTITIES)
    names = (observe,) if isinstance(observe, str) else tuple(observe) if isinstance(observe, Iterable) else ()
    strange = [unknown("observe", x, known) for x in names if not isinstance(x, str) or x not in known]
    told = [(x, QUANTITIES[x]) for x in names if isinstance(x, str) and x in QUANTITIES and isinstance(model, Model)]
    strange += [f"observe: {x}: {line}" for x, one in told for line in lacking(one, model.spring)]
    if strange:
        raise ProblemsError(strange)
    names = tuple(KE if name == PEAK_KE else name for name in names)
    if not names or len(set(names)) < len(names):
        raise ValueError(f"observe: must name distinct ones of {', '.join(known)}, got {shown(observe)}")
    return names
