"""`sweep audit`: a random sample of a table's done rows again, much more tightly, by Dormand-Prince."""

import hashlib
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.condition import CHAOTIC, DISTURBANCE
from kernel.ke import results_of
from kernel.lattice import Model, model_of
from kernel.method import ATOL_OVER_RTOL, AUTO, Integrator, choose
from kernel.task import RTOL_MIN, broken_rule
from sweep.errors import InputError
from sweep.log import say
from sweep.plan.cost import predict_work
from sweep.schema import DONE, PARAMETERS, RESULTS, axes_of, content_of, inputs_of, text_of
from sweep.store import table
from sweep.store.reuse import accuracy_of
from sweep.tell.promise import FRACTION, SAMPLE_MIN, Audited, judge, regions

if TYPE_CHECKING:
    from sweep.plan.sections import Accuracy

SECONDS_MAX = 60.0  # predicted for one reference; a row that takes longer is skipped: nobody waits for it
# The reference is rk45. Its rtol is this share of the target of a table by splitting, or of the rtol of a table by
# rk45, and at most this: at 1e-9 it is right to 2e-6 in 95 of 100 well-conditioned tasks
# (tests/data/references.csv), at 1e-7 to 4e-5, and one in a hundred is off by 1e-3.
RTOL_OVER_TARGET, RTOL_OVER_RTOL = 1e-6, 1e-3
REFERENCE_RTOL_MAX = 1e-9


def audit(path: Path, fraction: float = FRACTION) -> dict[str, Any]:
    """What the sample shows, region by region, and whether the table's promise (sweep.tell.promise) is kept.

    Relative errors of ke_ratio throughout. The sample follows from the table's content. Runs in this process.
    """
    if not 0.0 < fraction <= 1.0:
        raise InputError(f"--fraction: must be a number above 0 and at most 1, got {fraction!r}")
    with table.reading(path) as file:
        accuracy, model = accuracy_of(file), its_model(file)
        done, rows = _sample(file, fraction)
    reference, drawn = reference_of(accuracy.integrator()), len(rows)
    rows = _affordable(path, rows, reference, model)
    audited = _recomputed(rows, reference, model)
    if not len(audited.true):
        raise InputError(f"{path}: no row of the sample could be recomputed by {reference}")
    promised = None if accuracy.rtol is not None else accuracy.target
    promises = judge(audited, promised, accuracy.certify)
    return {
        "table": str(path),
        "done": done,
        "method": _method(accuracy),
        "target": promised,
        "reference": str(reference),
        "sampled": drawn,
        "skipped": drawn - len(rows),
        "not_recomputed": len(rows) - len(audited.true),
        "not_checked": int(np.count_nonzero(~rows["checked"])),
        "regions": regions(audited, promised, accuracy.certify),
        "promises": promises,
        "kept": not any(promise["broken"] for promise in promises),
    }


def its_model(file: h5py.File) -> Model:
    """The chain that a table's rows are about."""
    settings = table.resolved(file).get("model") or {}
    try:
        for name in axes_of(file[RESULTS].dtype):  # which a row holds: any good value stands for them here
            *parts, number = name.split(".")
            place = settings
            for part in parts:
                place = place.setdefault(part, {})
            place[int(number) if isinstance(place, list) else number] = float(file[RESULTS][0][name])
        return model_of(settings)
    except (ValueError, IndexError):
        raise InputError(f"{file.filename}: its provenance does not tell its model") from None


def reference_of(integrator: Integrator) -> Integrator:
    """The integrator that stands for the truth: tight rk45, another method unless the table's own is rk45 too."""
    if integrator.kind == AUTO:
        rtol = max(RTOL_MIN, min(REFERENCE_RTOL_MAX, RTOL_OVER_TARGET * integrator.target))
        return choose("rk45", rtol=rtol)
    rtol = max(RTOL_MIN, min(REFERENCE_RTOL_MAX, RTOL_OVER_RTOL * integrator.rtol))
    return choose("rk45", rtol=rtol, atol=min(ATOL_OVER_RTOL * rtol, RTOL_OVER_RTOL * integrator.atol))


def _method(accuracy: "Accuracy") -> str:
    """How the table was to be computed, and what was wanted where that does not say it."""
    integrator = accuracy.integrator()
    if integrator.kind == AUTO:
        return str(integrator)
    wanted = "tolerances of the user's own" if accuracy.rtol is not None else f"target {accuracy.target:g}"
    return f"{integrator}; {wanted}"


def _sample(file: h5py.File, fraction: float) -> tuple[int, NDArray[np.void]]:
    """How many rows are done, and some of them, in the table's order; the same for the same content."""
    count, content = 0, hashlib.sha256()
    for rows in table.done_rows(file):
        count += len(rows)
        content.update(content_of(rows).tobytes())
    if not count:
        raise InputError(f"{file.filename}: has no done row to audit")
    size = min(count, max(SAMPLE_MIN, math.ceil(fraction * count)))
    rng = np.random.default_rng(int.from_bytes(content.digest()))
    chosen, parts, first = np.sort(rng.choice(count, size, replace=False)), [], 0
    for rows in table.done_rows(file):
        parts.append(rows[chosen[(chosen >= first) & (chosen < first + len(rows))] - first])
        first += len(rows)
    sample = np.concatenate(parts)
    if broken := [line for row in sample for name in PARAMETERS if (line := broken_rule(name, row[name].item()))]:
        raise InputError(f"{file.filename}: holds a row of no sweep: {broken[0]}")
    return count, sample


def _affordable(path: Path, rows: NDArray[np.void], reference: Integrator, model: Model) -> NDArray[np.void]:
    """The rows whose reference is predicted to take at most SECONDS_MAX; says how long all will take."""
    work = predict_work({name: rows[name] for name in inputs_of(rows.dtype)}, reference, False, model)
    kept, runs = work <= SECONDS_MAX, np.where(rows["checked"], 1, 2)
    if not kept.any():
        raise InputError(f"{path}: every sampled row is predicted to take more than {SECONDS_MAX:g} s by {reference}")
    say(
        f"recomputing {kept.sum()} of {len(rows)} sampled rows by {reference}; "
        f"predicted {(runs * work)[kept].sum():.1f} s"
    )
    return rows[kept]


def _recomputed(rows: NDArray[np.void], reference: Integrator, model: Model) -> Audited:
    """The true errors of the rows, and which rows are chaotic; without the rows whose reference failed.

    A row that was not checked for chaos is checked here, by a second reference from a disturbed start.
    """
    truth, chaotic, asked = _ratios(rows, reference, model), rows["chaotic"].copy(), ~rows["checked"]
    beside, known = _ratios(rows[asked], reference, model, DISTURBANCE), np.isfinite(truth)
    chaotic[asked] = np.abs(beside / truth[asked] - 1.0) > CHAOTIC * DISTURBANCE
    known[asked] &= np.isfinite(beside)
    rows = rows[known]
    true = np.abs(rows["ke_ratio"] / truth[known] - 1.0)
    return Audited(rows["N"] * rows["zeta_T"], chaotic[known], true, rows["error"])


def _ratios(
    rows: NDArray[np.void], reference: Integrator, model: Model, disturbance: float = 0.0
) -> NDArray[np.float64]:
    """ke_ratio of every row, its start disturbed relatively, nan where the reference failed.

    One by one: a compiled call cannot be interrupted.
    """
    ratios = np.full(len(rows), np.nan)
    for i in range(len(rows)):
        columns = {name: rows[name][i : i + 1] for name in inputs_of(rows.dtype)}
        result = results_of(columns, reference, False, disturbance, model=model)[0]
        if result["status"] == text_of(DONE):
            ratios[i] = result["ke_ratio"]
    return ratios
