"""What can be asked of a run beside the kinetic energy of its middle site: one quantity in one file.

A quantity is a named tuple with the methods of `Quantity` below. It is named once, at the end of this file. It sees the
chain through a `View`, which is the same for every integrator. There are two kinds. One is computed from its values and
slopes at the ends of all steps (kernel.watch), and at the start where the chain is not at rest there. The other is
computed once, from the last state. The splittings do not show what happens at the struck end within a step, but for the
push: where one of the first four sites is watched, or a quantity `sees_impactor`, Dormand-Prince computes all
quantities. Steps are chosen for the accuracy of ke_ratio, so each quantity has an error estimate of its own. In a table
a quantity q has four columns: q (the chain), q_linear (the linear chain), q_ratio and q_error.

Values are divided by the quantity's `scale`, in tables and in scenes. Before that they have the units of kernel.model:
strains in unit-cell lengths, velocities in long-wave sound speeds, forces in k_T L.
"""

from typing import Any, Protocol

from kernel.hints import shown
from kernel.jit import callable_in_compiled_code
from kernel.model import Array, Chain
from kernel.quantities.contact_force import ContactForce
from kernel.quantities.last import Dissipated, Flipped, Rebound, Stored
from kernel.quantities.site import Acceleration, Arrival
from kernel.quantities.wall_force import Impulse, WallForce


@callable_in_compiled_code
class View(Protocol):
    """The chain at one time; i = 1..N: sites and the links to their right."""

    def velocity(self, i: int) -> float:
        """Velocity of site i; of the impactor where i is 0."""

    def strain(self, i: int) -> float:
        """Strain of link i, negative in compression."""

    def gap(self) -> float:
        """Distance between impactor and site 1, negative where they overlap."""

    def tells_push(self) -> None:
        """Present only where the integrator itself tells the push of the contact (kernel.watch.take_push)."""

    def show(self, strains: Array, velocities: Array) -> None:
        """Write the strains of all links and the velocities of all sites, (N,).

        The view of Dormand-Prince lacks this method, as its state holds displacements.
        """


class Quantity(Protocol):
    """A number that follows from the states of a chain.

    One without `fold` is the largest magnitude over continuous time. One with
        fold(memory, t, h, now, rate): takes in a step from t to t + h with this value and slope at its end
    keeps books of its own in `memory` (indices: kernel.watch), until
        is_known(memory)
    is true, if it has that. One with
        at_end(chain, view, kept)
    instead of `value` and `slope` is told by the last state. Both may have
        kept(chain, V): a number that is kept for them, before a run at speed V.
    The methods that follow nobody calls: what counts is whether a quantity has them.
    One whose value or slope the contact's push enters, as the momentum of the chain, says so by
        sees_impactor(): it is told by Dormand-Prince, whose steps take contact and chain together.
    One that means nothing where nobody strikes the chain, as its impactor's rebound, says so by
        needs_impactor(): scenes of a released chain, or of a first site that is held, refuse it.
    One that asks where links flip, which not every law of somebody else's tells, says so by
        needs_barrier(): chains with a law that has no `barrier` refuse it.
    One that is the watched site's own, which a driver that holds it dictates, says so by
        needs_free_site(): scenes of a first site that is held and watched refuse it.
    One that counts, and so changes by whole ones, says so by
        counts(): it is as the tighter of two runs tells it (kernel.extrapolate).
    One that is the push of the contact says so by
        is_push(): integrators whose view `tells_push` tell its largest within their steps (kernel.watch.take_push).
    """

    def unit(self) -> str:
        """The unit of the quantity, in words."""

    def value(self, chain: Chain, view: Any) -> float:
        """The quantity in this state of the chain."""

    def slope(self, chain: Chain, view: Any) -> float:
        """The derivative of `value` by time."""

    def scale(self, chain: Chain, V: float) -> float:
        """What one unit of the quantity is, for an impact at speed V."""


def lacking(quantity: Any, spring: Any) -> list[str]:
    """What the spring law lacks that the quantity needs, in words."""
    if hasattr(quantity, "needs_barrier") and not hasattr(spring, "barrier"):
        return [f"needs a spring law with the method barrier, got {shown(spring)}"]
    return []


# No name may be that of a column or of an observer: a test sees to it.
QUANTITIES: dict[str, Any] = {
    "wall_force": WallForce(),
    "contact_force": ContactForce(),
    "acceleration": Acceleration(),
    "impulse": Impulse(),
    "arrival": Arrival(),
    "dissipated": Dissipated(),
    "stored": Stored(),
    "flipped": Flipped(),
    "rebound": Rebound(),
}
