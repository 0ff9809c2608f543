"""
The fit of N_transition
=======================

With how many unit cells does the bistable chain begin to protect better, and how does that depend on the damping?
"""

# %%
# One impact, many chains: ke_ratio falls from above 1 to low values at some N, which grows as the damping
# shrinks. With the section ``[adaptive]`` a sweep starts from a few N and adds those that bracket the fall: here
# its steepest place in logarithms.

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import analysis
import sweep

folder = Path(tempfile.mkdtemp())
spec = {
    "name": "transition",
    "grid": {
        "N": {"log": [5, 160], "points": 8},
        "zeta_T": {"log": [3e-4, 5e-3], "points": 6},
        "M_over_M0": 2.0,
        "V_over_V0": 4.0,
    },
    "adaptive": {"find": "log_slope", "until": 0.05},
}
df = analysis.load(sweep.run(spec, folder / "transition.h5", progress=False))
print(f"{len(df)} impacts computed")

# %%
# Where it falls, on every line of one damping: ``N_transition``, between ``N_low`` and ``N_high``, is where the
# logarithm falls most steeply. ``by_slope`` and ``by_level`` define it otherwise, and may lie beyond these two
# (:func:`analysis.transition`).

found = analysis.transition(df)
print(found.to_string(index=False))

# %%
# The power law ``N_transition = A zeta_T^-b`` with its confidence interval, for each way to say where the fall
# is:

print(analysis.power_laws(found).to_string(index=False))

# %%
figure, ax = plt.subplots(layout="constrained")
for zeta_T, line in df.groupby("zeta_T"):
    ax.loglog(*line.sort_values("N")[["N", "ke_ratio"]].to_numpy().T, ".-", label=f"zeta_T = {zeta_T:.1e}")
ax.axhline(1, color="0.5", lw=0.8)
ax.set(xlabel="N, unit cells", ylabel="ke_ratio")
ax.legend(fontsize=8)
