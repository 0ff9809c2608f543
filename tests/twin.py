"""Plain-Python twins of the compiled physics, written from the equations alone, one site at a time."""

from itertools import pairwise

import numpy as np


def spring_force(c2, c3, e):
    return e if e >= 0 else e + c2 * e**2 + c3 * e**3


def spring_energy(c2, c3, e):
    return e**2 / 2 if e >= 0 else e**2 / 2 + c2 * e**3 / 3 + c3 * e**4 / 4


def contact_force(K, overlap):
    return K * max(overlap, 0.0) ** 1.5


def contact_energy(K, overlap):
    return 2 / 5 * K * max(overlap, 0.0) ** 2.5


def strains(u):
    """e_i of links 1..N; the wall is at rest at N+1."""
    sites = [*u[1:], 0.0]
    return [right - left for left, right in pairwise(sites)]


def acceleration(chain, u, v):
    e, rate = strains(u), strains(v)
    tension = [
        spring_force(chain.spring.c2, chain.spring.c3, x) + 2 * chain.zeta * r for x, r in zip(e, rate, strict=True)
    ]
    push = contact_force(chain.contact.K, u[0] - u[1])
    sites = [tension[0] + push, *(b - a for a, b in pairwise(tension))]
    return np.array([-push / chain.impactor_mass, *sites])


def energy(chain, u, v):
    springs = sum(spring_energy(chain.spring.c2, chain.spring.c3, e) for e in strains(u))
    kinetic = chain.impactor_mass * v[0] ** 2 / 2 + sum(x**2 / 2 for x in v[1:])
    return kinetic + springs + contact_energy(chain.contact.K, u[0] - u[1])


def dissipated_power(chain, v):
    return 2 * chain.zeta * sum(rate**2 for rate in strains(v))
