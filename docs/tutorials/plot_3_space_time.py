"""
Space and time of one impact
============================

The spring law, and what it does to the wave that an impact sends through the chain.
"""

# %%
# In compression the bistable spring first softens, then pushes the other way, then stiffens; in tension it is
# linear.

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import kernel

c2, c3 = 1187 / 225.7, 1524 / 225.7
strain = np.linspace(-0.6, 0.15, 300)
m = np.minimum(strain, 0)
figure, ax = plt.subplots(layout="constrained", figsize=(6, 3.5))
ax.plot(-strain, -(strain + c2 * m**2 + c3 * m**3), label="bistable")
ax.plot(-strain, -strain, "--", label="linear")
ax.axhline(0, color="0.5", lw=0.8)
ax.set(xlabel="compression of a link, unit-cell lengths", ylabel="push, $k_T L$", ylim=(-0.15, 0.3))
ax.legend()

# %%
# A scene records only what is asked for: here the kinetic energy of every site at 300 times, and the energy in
# the chain.

observe = {"ke_field": {"times": 300}, "energy": {"times": 200}}
seen = {
    law: kernel.simulate(kernel.Scene(60, 4e-4, kernel.Impact(0.5, 4), law=law, observe=observe))
    for law in ("bistable", "linear")
}

# %%
# The linear chain passes the pulse on. In the bistable one the first cells snap through, and the dampers take
# most of the energy before it reaches the middle.

figure, axes = plt.subplots(1, 2, layout="constrained", figsize=(8, 3.8), sharey=True)
for ax, (law, run) in zip(axes, seen.items(), strict=True):
    field = run["ke_field"]
    ke = np.maximum(field["ke"], 1e-5)  # nothing has arrived yet: the lowest colour
    mesh = ax.pcolormesh(field["site"], field["t"], ke, norm=LogNorm(1e-5, 1e-1), shading="nearest")
    ax.set(title=law, xlabel="site")
    ax.axvline(30, color="w", lw=0.8, ls=":")
axes[0].set_ylabel("time over N")
figure.colorbar(mesh, ax=axes, label="kinetic energy of a site over TE")

# %%
# The dotted line is the middle site. ke_ratio compares the largest kinetic energies there:

r = kernel.ke_ratio(60, 4e-4, 0.5, 4)
print(f"ke_bistable {r.ke_bistable:.4f}, ke_linear {r.ke_linear:.4f}, ke_ratio {r.ke_ratio:.3f}")

# %%
figure, ax = plt.subplots(layout="constrained", figsize=(6, 3.5))
for law, run in seen.items():
    ax.plot(run["energy"]["t"], run["energy"]["dissipated"], "--" if law == "linear" else "-", label=law)
ax.set(xlabel="time over N", ylabel="energy taken by the dampers over TE")
ax.legend()
