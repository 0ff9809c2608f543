"""What another chain than the paper's costs over it, and what of that nobody predicts.

Uniform mass, stiffness and damping are exact: the chain is the paper's in units of its own. It runs for so much longer,
and all but the steps that resolve the impact are so many more. A law's factor was measured, at one set of its numbers:
`python -m tests.law_costs` prints it again.
"""

import math
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kernel.method import AUTO, SWITCH, Integrator, reference
from kernel.task import T_END_OVER_N

MODELLED = ("mass", "stiffness", "damping", "t_end")


class Factor(NamedTuple):
    """Seconds over those of the paper's law."""

    plain: float
    certified: float
    at: str  # the numbers that it was measured at


# Means of three targets, 400 random tasks of 5 to 200 sites each (python -m tests.law_costs).
FACTORS = {
    "bistable": Factor(1.0, 1.0, "the paper's numbers"),
    "polynomial": Factor(1.02, 0.78, "c2 = -1, c3 = 3"),
    "piecewise_linear": Factor(1.84, 2.88, "strains 0.1, 0.3, slopes -0.5, 2"),
    "power": Factor(1.89, 1.93, "exponent 1.5, precompression 0.05"),
    "toda": Factor(2.16, 2.05, "b = 3"),
}
# Seconds with all quantities over those without any, certified: with one it is 1.5 and 1.9. Where modes serve the
# linear chain, which know of one site, it is integrated once more (python -m tests.measure: all quantities over none).
ALL_QUANTITIES, ALL_QUANTITIES_DAMPED = 1.6, 2.4
NOT_UNIFORM = 3.3  # a step of Dormand-Prince where sites and links differ, over one where they are alike (60 sites)


def law_of(model: Any) -> str:
    """The name of its spring's law."""
    return str(model.settings()["spring"]["law"])


def in_own_units(columns: Mapping[str, NDArray[Any]], model: Any) -> dict[str, NDArray[Any]]:
    """The tasks of a uniform chain with the paper's mass and stiffness; `crossings`: times that sound takes through it.

    Of a chain that is not uniform: of one with its mean numbers.
    """
    mass, stiffness, damping, t_end = (_numbers(name, columns, model) for name in MODELLED)
    frequency = np.sqrt(stiffness / mass)
    return {
        "N": columns["N"],
        "zeta_T": columns["zeta_T"] * damping / np.sqrt(stiffness * mass),
        "M_over_M0": columns["M_over_M0"] / mass,
        "V_over_V0": columns["V_over_V0"] / frequency,
        "crossings": t_end * frequency,
    }


def _numbers(name: str, columns: Mapping[str, NDArray[Any]], model: Any) -> NDArray[np.float64]:
    if name in columns:
        return np.asarray(columns[name], np.float64)
    value = getattr(model, name)
    if isinstance(value, tuple):  # graded, disordered (of mean 1), or a list
        value = 1.0 if hasattr(value, "spread") else float(np.mean(value))
    return np.full(len(columns["N"]), value)


def share_until(until: float, model: Any, sharing: float) -> float:
    """Which part of a task is done where the chain's own run ends after `until` times what sound takes to its site.

    The linear chain runs to its end, for `sharing` tasks at once, nearly half of the work. Of a chain that is not
    uniform, or whose tasks differ in these numbers: of one with the model's mean numbers.
    """
    from kernel.lattice import Model

    chain = model or Model()
    mass, stiffness, _, t_end = (float(_numbers(name, {"N": np.ones(1)}, chain)[0]) for name in MODELLED)
    return 0.5 / sharing + 0.5 * min(1.0, until * float(chain.site) * math.sqrt(mass / stiffness) / t_end)


def integrator_for(model: Any, integrator: Integrator) -> Integrator:
    """What integrates this chain."""
    return integrator if model.is_uniform else reference(integrator)


def factor(model: Any, certify: bool) -> float:
    """Predicted work over that of the paper's law."""
    if model is None:
        return 1.0
    law = FACTORS.get(law_of(model), FACTORS["bistable"])
    return (law.certified if certify else law.plain) * (1.0 if model.is_uniform else NOT_UNIFORM)


def of_quantities(columns: Mapping[str, NDArray[Any]], integrator: Integrator, quantities: int) -> Any:
    """Predicted work of each task over that of the kinetic energy alone."""
    if not quantities:
        return 1.0
    if integrator.kind != AUTO:
        return ALL_QUANTITIES
    damped = np.asarray(columns["N"] * columns["zeta_T"]) >= SWITCH
    return np.where(damped, ALL_QUANTITIES_DAMPED, ALL_QUANTITIES)


def assumptions(model: Any, quantities: int, varied: Collection[str] = ()) -> list[str]:
    """In words: what a plan of this chain takes for granted, and leaves out; varied: its numbers that are axes."""
    said = []
    if model is not None:
        from kernel.laws import PAPER, Hertz

        law = law_of(model)
        if (known := FACTORS.get(law)) is None:
            said.append(f'law "{law}": predicted as the paper\'s; what it takes was not measured')
        elif law != "bistable":
            said.append(
                f'law "{law}": {known.plain:g} times the paper\'s, {known.certified:g} certified, as measured at '
                f"{known.at}; how its own numbers change that is not modelled"
            )
        elif model.spring != PAPER or any(name.startswith("spring.") for name in varied):
            said.append("the law's c2 and c3: predicted as the paper's; a stiffer or more chaotic one takes longer")
        if model.contact != Hertz() or any(name.startswith("contact.") for name in varied):
            said.append("contact: predicted as the paper's; a harder one takes up to hundreds of times as long")
        if not math.isclose(model.t_end, T_END_OVER_N):
            said.append(
                "t_end: the work goes with it, but for the impact's steps; "
                "that longer runs are more often chaotic is not modelled"
            )
        if not model.is_uniform:
            said.append("not uniform, or a free end: by Dormand-Prince, predicted as of the chain's mean numbers")
    if quantities:
        said.append(
            f"quantities: {ALL_QUANTITIES:g} times the time without them, {ALL_QUANTITIES_DAMPED:g} where N zeta_T is "
            f"{SWITCH:g} or more, however many they are"
        )
    if said:
        said.append("compiling: not counted; what the paper's chain does not need takes up to three minutes, once")
    return said
