"""A chain by scipy's DOP853, from the equations alone: what the integrators are held against."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


def rates_of(chain):
    """Right-hand side of the first-order system y = (u_0 .. u_N, v_0 .. v_N) of a kernel.model.Chain."""
    N = chain.N

    def rates(_, y):
        u, v = y[: N + 1], y[N + 1 :]
        e, slip = np.diff(u[1:], append=0.0), np.diff(v[1:], append=0.0)
        pull = e + np.array([chain.spring.excess(float(x)) for x in e]) + 2.0 * chain.zeta * slip
        push = chain.contact.push(float(u[0] - u[1]))
        return np.concatenate([v, [-push / chain.impactor_mass], np.diff(pull, prepend=-push)])

    return rates


def run(chain, V, rtol=1e-10):
    """scipy's solution of an impact at speed V, with its continuous extension."""
    start = np.zeros(2 * chain.N + 2)
    start[chain.N + 1] = V
    how = {"rtol": rtol, "atol": 1e-3 * rtol, "max_step": 0.05, "dense_output": True}
    return solve_ivp(rates_of(chain), (0.0, chain.t_end), start, "DOP853", **how)


def largest(seen, f):
    """Largest magnitude over continuous time of f(state)."""
    rough = np.array([abs(f(y)) for y in seen.y.T])
    top = int(rough.argmax())
    near = np.linspace(seen.t[max(top - 1, 0)], seen.t[min(top + 1, len(seen.t) - 1)], 400)
    return max(abs(f(seen.sol(t))) for t in near)


def numbers(chain, V):
    """Every quantity of kernel.quantities by its name, and the largest speed of the site as "speed"."""
    N, seen, rates = chain.N, run(chain, V), rates_of(chain)
    site, TE = N + 1 + chain.site, 0.5 * chain.impactor_mass * V * V

    def wall(y):
        e, slip = -y[N], -y[-1]
        return -(e + chain.spring.excess(float(e)) + 2.0 * chain.zeta * slip)

    t = np.linspace(0.0, chain.t_end, 20001)
    felt = np.flatnonzero(np.abs(seen.sol(t)[site]) > V / 100)[0]
    arrival = brentq(lambda x: abs(seen.sol(x)[site]) - V / 100, t[felt - 1], t[felt])
    last = seen.y[:, -1]
    strains = np.diff(last[1 : N + 1], append=0.0)
    stored = sum(chain.spring.energy_at(float(e)) for e in strains)
    rebound = 0.5 * chain.impactor_mass * last[N + 1] ** 2
    left = stored + rebound + 0.5 * np.sum(last[N + 2 :] ** 2) + chain.contact.energy_at(float(last[0] - last[1]))
    return {
        "speed": largest(seen, lambda y: y[site]),
        "wall_force": largest(seen, wall) * chain.force,
        "contact_force": largest(seen, lambda y: chain.contact.push(float(y[0] - y[1]))) * chain.force,
        "acceleration": largest(seen, lambda y: rates(0.0, y)[site]) * N * chain.frequency**2,
        "impulse": np.trapezoid([wall(y) for y in seen.sol(t).T], t) / (chain.impactor_mass * V),
        "arrival": arrival / (N * chain.frequency),
        "dissipated": 1.0 - left / TE,
        "stored": stored / TE,
        "flipped": float(np.sum(strains < chain.spring.barrier())) / N,
        "rebound": rebound / TE,
    }
