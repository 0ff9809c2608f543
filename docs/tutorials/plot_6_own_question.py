"""
A question of one's own
=======================

Does the push on the wall follow the kinetic energy at the middle? The table of one sweep answers both.
"""

# %%
# ``observe`` adds a quantity beside the kinetic energy: the largest push on the wall, of both chains.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import analysis
import sweep

folder = Path(tempfile.mkdtemp())
spec = {
    "name": "wall",
    "grid": {
        "N": [10, 20, 40, 80],
        "zeta_T": {"log": [1e-4, 1e-2], "points": 3},
        "M_over_M0": [0.5, 2.0],
        "V_over_V0": {"log": [0.2, 5], "points": 8},
    },
    "output": {"observe": ["peak_ke", "wall_force"]},
}
df = analysis.load(sweep.run(spec, folder / "wall.h5", progress=False))

# %%
# Chaotic rows are drawn hollow: their ke_ratio is known as a range only.

figure, ax = plt.subplots(layout="constrained")
wild = df["chaotic"].fillna(False).to_numpy(bool)
for N, marker in zip(sorted(df["N"].unique()), "osD^", strict=True):
    calm = df[(df["N"] == N) & ~wild]
    line = ax.loglog(calm["ke_ratio"], calm["wall_force_ratio"], marker, ms=4, label=f"N = {N}")[0]
    some = df[(df["N"] == N) & wild]
    ax.loglog(some["ke_ratio"], some["wall_force_ratio"], marker, ms=4, mfc="none", color=line.get_color())
ax.axhline(1, color="0.5", lw=0.8)
ax.axvline(1, color="0.5", lw=0.8)
ax.set(xlabel="ke_ratio", ylabel="wall_force_ratio")
ax.legend()

# %%
# In the lower left both are lower than in the linear chain. How often each is, and both at once:

both = (df["ke_ratio"] < 1) & (df["wall_force_ratio"] < 1)
print(
    f"ke_ratio below 1: {(df['ke_ratio'] < 1).mean():.0%}, wall_force_ratio below 1: "
    f"{(df['wall_force_ratio'] < 1).mean():.0%}, both: {both.mean():.0%}"
)

# %%
# The same columns in a browser, with any of them as an axis: ``analysis page wall.h5 -o wall.html``
# (:doc:`/explore`).
