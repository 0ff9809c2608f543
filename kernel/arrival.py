"""Chains whose peak is the crest of the first arrival, by far.

What comes after sound has crossed such a chain decides nothing: the rest of a run is there to show that it does not.
Coarse steps (kernel.method.AFTERWARDS) do. Where they show a later crest that does not lose by far, the integrator goes
back to when sound had crossed the chain, and on with its own steps. Nine in ten of the linear and of the strongly
damped chains are such, and three in ten of the others.
"""

from typing import Any

from kernel.crests import wins_late
from kernel.jit import jit
from kernel.method import COARSE_TO
from kernel.model import Array, Chain

# The first arrival wins by far where no later crest exceeds this share of the largest. Of 2350 random linear chains of
# the wide box, at accuracies of 1e-2 to 3e-6, 1 % of those where it does are off by more than 1.7 times the accuracy;
# those where it does not are off by up to thousands of times, with condition numbers to 3e4. With 0.95 one in 1700 of
# the former is off by 26 times; from 0.8 to 0.9 it is the same. python -m tests.convergence shows the former.
SURE_BELOW = 0.85
# The watched site from which it is: nearer to the struck end the contact's substeps leave up to three accuracies, there
# one at most, with the watched site at 0.1 to 1 of the chain and contacts 2e4 times stiffer or softer, too.
SURE_FROM = 6
# Stiffness of a contact at a slight overlap over that at a thousand times as much, below which it counts as smooth: a
# power of the overlap from 1.2 on. With an exponent of 1 linear chains are up to 30 accuracies off, with 1.2 up to 1.3.
SLIGHT, SMOOTH = 1e-3, 0.3
# The share of SURE_BELOW for chains that are neither linear nor strongly damped, as these can be chaotic: coarse and
# fine steps then tell different late crests. Of 4386 random bistable chains at 1e-4, 3e-4 and 1e-3 the peak of none
# changes, with 0.7 that of 9 in 13158 runs by 4 to 34 %; other laws: one of straight pieces in 13000 runs. They take
# 0.83, 0.88 and 0.93 of their time, with 0.7 0.75, 0.81 and 0.88.
SURE_BELOW_IF_CHAOTIC = 0.5


@jit
def is_smooth(contact: Any) -> bool:
    """Whether the stiffness of a contact does not jump, or nearly, where it opens and closes."""
    return bool(contact.stiffness_at(SLIGHT) < SMOOTH * contact.stiffness_at(1.0))


@jit
def may_be_sure(chain: Chain) -> bool:
    """Whether a linear chain is one of which a late crest can tell that the first arrival wins."""
    return bool(is_smooth(chain.contact) and chain.site >= SURE_FROM and chain.t_end >= chain.N)


@jit
def may_be_coarse(chain: Chain) -> bool:
    """Whether coarse steps can show that the first arrival wins: over many reflections they flatten sharp crests."""
    return may_be_sure(chain) and chain.t_end <= COARSE_TO * chain.N


@jit
def first_arrival_wins(chain: Chain, KE: Array) -> bool:
    """Whether the crest of the first arrival exceeds all later ones by far.

    KE (PARTS,): largest kinetic energy of the watched site in each part of a run.
    """
    return not wins_late(KE, chain.t_end / chain.N, SURE_BELOW)
