"""The chain's derivative as users of a Python solver would compile it, with the flags and fused loops of ours.

p = [zeta, c2, c3, K, impactor mass, V]; index 0 is the impactor, 1..N the sites, the wall is at rest.
"""

import math

import numpy as np

from kernel.jit import jit


@jit
def tension(c2, c3, e):
    """Spring law; nonlinear in compression only."""
    m = e if e < 0.0 else 0.0
    return e + m * m * (c2 + c3 * m)


@jit
def push(K, overlap):
    """Hertz contact of impactor and first site."""
    return K * overlap * math.sqrt(overlap) if overlap > 0.0 else 0.0


@jit
def blocked(y, p, g):
    """dy/dt for y = [u_0 .. u_N, v_0 .. v_N]; `g` is scratch of N+1."""
    n = g.shape[0]
    u, v, dy = y[:n], y[n:], np.empty(2 * n)
    a, eta, c2, c3 = dy[n:], 2.0 * p[0], p[1], p[2]
    g[0] = -push(p[3], u[0] - u[1])
    for i in range(1, n - 1):
        g[i] = tension(c2, c3, u[i + 1] - u[i]) + eta * (v[i + 1] - v[i])
    g[n - 1] = tension(c2, c3, -u[n - 1]) - eta * v[n - 1]
    for i in range(n):
        dy[i] = v[i]
    for i in range(1, n):
        a[i] = g[i] - g[i - 1]
    a[0] = g[0] / p[4]
    return dy


@jit
def interleaved(y, p, dy):
    """Write dy/dt for y = [u_0, v_0, u_1, v_1, ...]: the Jacobian's band is 3 below and 2 above the diagonal."""
    n, eta, c2, c3 = y.shape[0] // 2, 2.0 * p[0], p[1], p[2]
    left = -push(p[3], y[0] - y[2])
    dy[0] = y[1]
    dy[1] = left / p[4]
    for i in range(1, n - 1):
        right = tension(c2, c3, y[2 * i + 2] - y[2 * i]) + eta * (y[2 * i + 3] - y[2 * i + 1])
        dy[2 * i] = y[2 * i + 1]
        dy[2 * i + 1] = right - left
        left = right
    dy[2 * n - 2] = y[2 * n - 1]
    dy[2 * n - 1] = tension(c2, c3, -y[2 * n - 2]) - eta * y[2 * n - 1] - left


@jit
def middle_acceleration(y, p, out):
    """Write the middle site's acceleration into out[0], for the interleaved order; 1e-30 at rest, not to be a root."""
    n, eta = y.shape[0] // 2, 2.0 * p[0]
    total = 0.0
    for i in (n // 2 - 1, n // 2):  # the links left and right of it, i the site left of the link
        u, v = (y[2 * i + 2], y[2 * i + 3]) if i + 1 < n else (0.0, 0.0)
        pull = tension(p[1], p[2], u - y[2 * i]) + eta * (v - y[2 * i + 1]) if i > 0 else -push(p[3], y[0] - y[2])
        total = pull - total
    out[0] = total + 1e-30


@jit
def crest(v0, a0, v1, a1, h, best):
    """Where in (0, 1) of a step of size h |v| may exceed `best`: the larger crest of the cubic through both ends.

    -1 where the cubic's convex hull stays below 0.99 best, or where it has no crest inside.
    """
    b, c = v0 + h * a0 / 3.0, v1 - h * a1 / 3.0
    if max(abs(v0), abs(b), abs(c), abs(v1)) < 0.99 * best:
        return -1.0
    # A slope of (1-x)^2 p + 2 x (1-x) q + x^2 r, up to a factor.
    p, q, r = b - v0, c - b, v1 - c
    root = q * q - p * r
    if not root >= 0.0:
        return -1.0
    where, largest = -1.0, -1.0
    for sign in (-1.0, 1.0):
        below = p - q + sign * math.sqrt(root)
        x = p / below if below != 0.0 else -1.0
        if 0.0 < x < 1.0:
            w = 1.0 - x
            value = abs(w * w * w * v0 + 3.0 * x * w * w * b + 3.0 * x * x * w * c + x * x * x * v1)
            if value > largest:
                where, largest = x, value
    return where
