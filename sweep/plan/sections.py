"""The sections of a spec that need no other: [grid], [accuracy], [output]."""

from functools import partial
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from kernel.columns import KE, PEAK_KE
from kernel.hints import did_you_mean
from kernel.method import MAX_STEPS, Integrator, choose, stray
from kernel.task import broken_rule
from sweep.plan.axis import axis_values
from sweep.plan.problems import SpecError
from sweep.plan.section import Section, whole


def _keep_rule(name: str, value: object) -> object:
    if broken := broken_rule(name, value):
        raise ValueError(broken.removeprefix(f"{name}: "))
    return value


def _rule(name: str) -> BeforeValidator:
    """The kernel's own rule for a value."""
    return BeforeValidator(partial(_keep_rule, name))


def _axis(name: str) -> BeforeValidator:
    return BeforeValidator(partial(axis_values, name))


class Grid(Section):
    """The four axes; a task is one combination, the last axis varying fastest."""

    N: Annotated[tuple[int, ...], _axis("N")]
    zeta_T: Annotated[tuple[float, ...], _axis("zeta_T")]
    M_over_M0: Annotated[tuple[float, ...], _axis("M_over_M0")]
    V_over_V0: Annotated[tuple[float, ...], _axis("V_over_V0")]


class Accuracy(Section):
    """How good the numbers must be, and by which method."""

    target: Annotated[float, _rule("accuracy")] = 1e-3  # wanted relative error of ke_ratio; beside rtol it is not used
    method: Literal["auto", "rk45"] = "auto"  # what suits each task, or Dormand and Prince's method for all
    rtol: Annotated[float, _rule("rtol")] | None = None  # with method = "rk45" only; without it, it follows from target
    atol: Annotated[float, _rule("atol")] | None = None  # the same
    # Of one run; a task that needs more is a failed row.
    max_steps: Annotated[int, BeforeValidator(whole), _rule("max_steps")] = MAX_STEPS
    # Estimate the error of every row, and see whether it is chaotic: on average twice the time at a target of 1e-3,
    # less at tighter ones, nearly three times at looser ones, for which it keeps the steps short.
    certify: bool = True

    @model_validator(mode="after")
    def _goes_together(self) -> "Accuracy":
        if problems := self.problems():
            raise SpecError(problems)
        return self

    def problems(self) -> list[str]:
        """What its keys must not be together."""
        given = {"rtol": self.rtol, "atol": self.atol, **self._unsound}
        method = None if "method" in self._unsound else self.method
        return [f"accuracy.{line}" for line in stray(method, given["rtol"], given["atol"])]

    def integrator(self) -> Integrator:
        """The kernel's integrator for these settings."""
        return choose(self.method, self.target, self.rtol, self.atol, self.max_steps, certify=self.certify)


def _known_quantities(value: object) -> object:
    if value in ([PEAK_KE], [KE]):
        return [PEAK_KE]
    from kernel.quantities import QUANTITIES  # and with it numba, which most plans do without

    known = (PEAK_KE, KE, *QUANTITIES)
    rule = f"must be a list of distinct quantities out of: {', '.join(known)}"
    if not isinstance(value, list) or not value or len(set(map(str, value))) < len(value):
        raise ValueError(f"{rule}; got {value!r}")
    if others := [name for name in value if name not in known]:
        hints = (f"{name!r}{did_you_mean(str(name), known)}" for name in others)
        raise ValueError(f"{rule}; got {', '.join(hints)}")
    return [PEAK_KE, *sorted(name for name in value if name not in (PEAK_KE, KE))]


class Output(Section):
    """What every row holds, and how often the table goes to the disk."""

    # Every table has what ke, or peak_ke, stands for: ke_bistable, ke_linear, their ratio, times. Of another quantity q
    # it has q of the chain, q_linear of the same made linear, q_ratio and q_error.
    observe: Annotated[list[str], BeforeValidator(_known_quantities)] = Field(default_factory=lambda: [PEAK_KE])
    # Seconds between two writings to the disk.
    flush_every: Annotated[float, Field(ge=0.1, le=86400, allow_inf_nan=False)] = 30.0

    def quantities(self) -> tuple[str, ...]:
        """What is asked for beside the kinetic energy."""
        return tuple(name for name in self.observe if name != PEAK_KE)
