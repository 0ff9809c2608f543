"""
A first map
===========

From a question to a picture: which chain lets the least kinetic energy pass its middle, whatever strikes it?
"""

# %%
# A sweep is a grid of impacts. Here 5 chains, 4 dampings, 3 masses and 3 speeds: 180 tasks. The same can be
# written as a TOML file, and started with ``sweep run`` (:doc:`/spec`).

import tempfile
from pathlib import Path

import analysis
import sweep

folder = Path(tempfile.mkdtemp())
spec = {
    "name": "first map",
    "grid": {
        "N": {"log": [5, 80], "points": 5},
        "zeta_T": {"log": [1e-4, 1e-1], "points": 4},
        "M_over_M0": [0.1, 1.0, 2.0],
        "V_over_V0": [0.3, 1.0, 3.0],
    },
}
finished = sweep.run(spec, folder / "first.h5", progress=False)
print(f"{finished.done} done, {finished.failed} failed, {finished.left} left")

# %%
# The table is a data frame. A ke_ratio below 1 means that the bistable chain protects better than the linear
# one.

df = analysis.load(finished)
print(df[["N", "zeta_T", "M_over_M0", "V_over_V0", "ke_ratio", "error", "chaotic"]].head())

# %%
# The best of the best: for every chain and damping the impact that suits it most. ``analysis best`` draws the
# same with its numbers beside it; ``analysis page`` makes a page to explore in a browser (:doc:`/explore`).

import matplotlib.pyplot as plt
from matplotlib.colors import LogNorm

cells = analysis.best(df).pivot_table(index="zeta_T", columns="N", values="ke_ratio")
figure, ax = plt.subplots(layout="constrained")
mesh = ax.pcolormesh(range(6), range(5), cells.to_numpy(), norm=LogNorm(), cmap="viridis")
ax.set_xticks([k + 0.5 for k in range(5)], [str(N) for N in cells.columns])
ax.set_yticks([k + 0.5 for k in range(4)], [f"{z:.0e}" for z in cells.index])
ax.set(xlabel="N, unit cells", ylabel="zeta_T, bulk damping ratio")
figure.colorbar(mesh, label="lowest ke_ratio over all impacts")

# %%
# And the lowest of all:

print(analysis.optimum(df))
