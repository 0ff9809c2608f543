"""One impact of a table, computed anew to be looked at: both chains in space and time, energies, a profile."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.checks import model_axes
from analysis.reading import is_csv
from analysis.searched import spec_of
from sweep.errors import InputError
from sweep.schema import PARAMETERS

TIMES, SITES, MOMENTS = 300, 240, 240  # of the maps, and of the curves: what a screen shows
PROFILE_AT = 0.5  # over N, where figure 11 of the paper looks
ACCURACY = 1e-3
DRAWN = (("ke_field", "ke"), ("energy", "total"), ("profile", "v"))  # what is dissipated is what the total lacks
_DIGITS = 5


def scene_of(rows: pd.DataFrame, task: int, path: Path) -> dict[str, Any]:
    """What the page draws of a task; InputError for a task that is none, or whose chain is not the paper's."""
    from kernel import Impact, Scene, simulate

    _refuse_other_models(rows, path)
    if task not in rows.index:
        raise InputError(f"there is no task {task}")
    N, zeta_T, M, V = (float(rows[name].loc[task]) for name in PARAMETERS)
    observe = {
        "ke_field": {"times": TIMES, "sites": SITES},
        "energy": {"times": MOMENTS},
        "profile": {"at": [PROFILE_AT]},
    }
    found, told = dict[str, Any](), list[str]()
    for law in ("bistable", "linear"):
        scene = Scene(int(N), zeta_T, Impact(M, V), law, observe)
        seen = simulate(scene, ACCURACY, certify=True)
        if seen.status != "done":
            raise InputError(f"task {task}, {law} chain: {seen.status}")
        worst = max(seen.errors[name][key] for name, key in DRAWN)
        told.append(f"{law} chain by {seen.method}, off by some {worst:.1g} of the largest at most")
        found[law] = _told(seen, scene)
    words = f"task {task}: N {N:.0f}, zeta_T {zeta_T:.4g}, M/M0 {M:.4g}, V/V0 {V:.4g}; {'; '.join(told)}"
    if is_csv(path):
        words += "; a .csv names no model: this is the paper's chain"
    return found | {"at": PROFILE_AT, "words": words}


def _refuse_other_models(rows: pd.DataFrame, path: Path) -> None:
    """Scenes are of the paper's chain: another one must not be drawn as if it were."""
    if strange := model_axes(rows) + ["[model]"] * ("model" in spec_of(path)):
        raise InputError(f"an impact is computed here for the paper's chain only, this table has {', '.join(strange)}")


def _told(seen: Any, scene: Any) -> dict[str, Any]:
    field, energy, profile = seen["ke_field"], seen["energy"], seen["profile"]
    ke = field["ke"]
    return {
        "ke": {
            "values": _short(ke.ravel()),
            "shape": list(ke.shape),
            "high": float(np.nanmax(ke[1:])),
            "N": scene.N,
            "t_end": scene.t_end / scene.N,
        },
        "t": _short(energy["t"]),
        "total": _short(energy["total"]),
        "dissipated": _short(energy["dissipated"]),
        "site": profile["site"].tolist(),
        "v": _short(profile["v"][0]),
    }


def _short(values: Any) -> list[float]:
    """Few digits: a screen shows no more, and the answer is a third as long."""
    return [float(f"{x:.{_DIGITS}g}") for x in values]
