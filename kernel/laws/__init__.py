"""The laws that a chain may have: what a spring, what a contact tells of itself.

A law is one named tuple of numbers in a file of its own, with the methods of its face below; it is named once, at the
end of this file. Integrators know no more of it than its face: numba compiles each method for the law at hand, so that
a law costs what its own arithmetic costs. A law of somebody else's needs no line here: any named tuple with the
methods, and at least one number, can be the `spring` or the `contact` of a kernel.model.Chain, or of a kernel.Model.

Units of kernel.model: strains and overlaps in unit-cell lengths, forces in k_T L, energies in k_T L^2 / N.
"""

from typing import Any, Protocol

from kernel.jit import callable_in_compiled_code
from kernel.laws.bistable import Bistable as Bistable
from kernel.laws.hertz import Hertz as Hertz
from kernel.laws.piecewise import PiecewiseLinear as PiecewiseLinear
from kernel.laws.polynomial import Polynomial as Polynomial
from kernel.laws.power import PowerLaw as PowerLaw
from kernel.laws.toda import Toda as Toda


@callable_in_compiled_code
class Spring(Protocol):
    """A spring of unit stiffness at rest, as the linear one has with which it is compared; e: its strain, negative in
    compression.

    In Python it may also have problems(), every number of it that breaks its rule, by name (without: none), and
    has_sound(), whether it has a stiffness at rest at all (without: it has). It may lack barrier(): then `flipped` is
    refused.
    """

    def excess(self, e: Any) -> Any:
        """Tension beyond that of the linear spring, f(e) - e; e: a number, or packed ones (kernel.simd).

        Packed ones know +, -, *, /, abs, and what is in kernel.elementary; no `if`, nothing of math or NumPy. They
        may be in single precision: a small difference of large numbers must be formed in double, as by
        kernel.elementary.bend_of_power.
        """

    def energy_at(self, e: float) -> float:
        """Integral of the tension from 0 to e."""

    def stiffness_at(self, e: float) -> float:
        """Slope of the tension, f'(e): 1 at rest, as of the linear chain, or 0 of a law that has no sound."""

    def steepest(self, lowest: float, highest: float) -> float:
        """Largest stiffness between two strains, `lowest` <= 0 <= `highest`."""

    def is_linear(self) -> bool:
        """Whether `excess` is zero everywhere: then the chain's modes serve it."""

    def stiffens_in_tension(self) -> bool:
        """Whether `steepest` depends on `highest`: if not, nobody looks for the most stretched link."""

    def stiffness_jumps(self) -> bool:
        """Whether `stiffness_at` jumps somewhere: there every method is of a lower order than elsewhere."""

    def barrier(self) -> float:
        """The strain beyond which a link has flipped: the force's first zero beside rest; nan where there is none."""


@callable_in_compiled_code
class Contact(Protocol):
    """A contact that pushes and never pulls; d: overlap of impactor and first site, negative where they are apart.

    In Python it may also have problems(), as a spring, and compiled(), the law that the compiled code is to know in its
    place, which alone then needs these methods.
    """

    def push(self, d: float) -> float:
        """Force at overlap d, 0 where d is not above 0."""

    def energy_at(self, d: float) -> float:
        """Integral of the force from 0 to d."""

    def stiffness_at(self, d: float) -> float:
        """Slope of the force at overlap d > 0."""

    def period(self, mass: float, energy: float) -> float:
        """One over the largest angular frequency of a reduced mass that has this energy in the contact."""

    def duration(self, lightness: float, V: float) -> float:
        """How long an impact at speed V lasts between free bodies; lightness: one over their reduced mass."""

    def after(self, d: float, change: float) -> float:
        """The overlap at which the force is larger by `change` than at d > 0, to first order."""

    def overlap(self, free: float, softness: float, guess: float) -> float:
        """The d with d = free - softness push(d), from a guess; 0 where free is not above 0."""

    def impulse(self, d: float, free: float, softness: float) -> tuple[float, float]:
        """The overlap d1 at the end of a step that begins at d, and the mean force F, d1 = free - softness F.

        F is the discrete gradient (E(d1) - E(d)) / (d1 - d) of the contact's energy E: its work is what E gains.
        """

    def at_unit_speed(self, V: float) -> Any:
        """The law of the same impact in displacements over V: F(V d) / V."""

    def of_cells(self, N: int) -> Any:
        """A law in chain lengths, in the unit cells of a chain of N."""

    def softened(self, by: float) -> Any:
        """The law of 1/`by` times the force."""


PAPER = Bistable()
# By the names that specs and scenes give them; the first is meant where none is given.
SPRINGS = {
    "bistable": Bistable,
    "polynomial": Polynomial,
    "piecewise_linear": PiecewiseLinear,
    "power": PowerLaw,
    "toda": Toda,
}
CONTACTS = {"hertz": Hertz}
