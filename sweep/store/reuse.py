"""`sweep run --reuse OLD`: which tables are good enough, what is taken over, and what the new table says of it."""

import json
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from kernel.method import MAX_STEPS
from kernel.version import source_hash
from sweep.errors import InputError, gathered
from sweep.plan.tasks import TaskList
from sweep.schema import RESULTS, REUSED, RUN, RUNS, axes_of, quantities_of, text_of
from sweep.store import table
from sweep.store.join import DisagreementError, lacking
from sweep.store.runs import new_run

if TYPE_CHECKING:
    from sweep.plan.sections import Accuracy

CERTIFICATION = {True: "certified", False: "not certified"}


def reusable(olds: Sequence[Path], wanted: "Accuracy", layout: np.dtype[Any], model: dict[str, Any] | None) -> None:
    """Check that the rows of the tables `olds` are of this layout and model, and at least as good as `wanted`.

    InputError naming every problem.
    """
    gathered(*(partial(_refuse_unfit, old, wanted, layout, model) for old in olds))


def _refuse_unfit(old: Path, wanted: "Accuracy", layout: np.dtype[Any], model: dict[str, Any] | None) -> None:
    with table.reading(old) as file:
        found, kernels, has = accuracy_of(file), table.kernels(file), file[RESULTS].dtype
        its, problems = table.resolved(file).get("model"), list[str]()
    if lines := lacks(found, wanted):
        problems.append(f"--reuse {old}: its rows are not as accurate as this sweep's are to be ({'; '.join(lines)})")
    for what, told in (("quantities", quantities_of), ("numbers of the model", axes_of)):
        if told(has) != told(layout):
            words = (", ".join(told(one)) or "none" for one in (has, layout))
            problems.append("--reuse {}: has the {} {}, wanted {}".format(old, what, *words))
    if its != model:
        problems.append(f"--reuse {old}: is of another model ({json.dumps(its)}, wanted {json.dumps(model)})")
    if kernels != {source_hash()}:
        problems.append(f"--reuse {old}: was computed by another version of the kernel")
    if problems:
        raise InputError(*problems)


def accuracy_of(file: h5py.File) -> "Accuracy":
    """How good the numbers of a table were asked to be."""
    from sweep.plan.sections import Accuracy  # pydantic, which the workers of a run do without

    resolved = table.resolved(file)
    try:
        return Accuracy.model_validate(resolved["accuracy"])
    except (KeyError, ValueError):
        raise InputError(f"{file.filename}: its provenance does not tell how accurate it is") from None


def lacks(found: "Accuracy", wanted: "Accuracy") -> list[str]:
    """The settings in which rows computed as `found` fall short of `wanted`: looser, or not certified."""
    has, asked, lines = found.integrator(), wanted.integrator(), list[str]()
    if found.method != wanted.method:
        lines.append(f"method {found.method}, not {wanted.method}")
    given = [name for name in ("rtol", "atol") if getattr(found, name) or getattr(wanted, name)]  # else by the target
    for name in ("target", *given):
        if getattr(has, name) > getattr(asked, name):
            lines.append(f"{name} {getattr(has, name):g}, wanted {getattr(asked, name):g} or less")
    if has.max_steps < asked.max_steps:
        lines.append(f"max_steps {has.max_steps}, wanted {asked.max_steps} or more")
    if wanted.certify and not found.certify:
        lines.append(CERTIFICATION[False])
    return lines


def reuse(path: Path, tasks: TaskList, old: Path, wanted: "Accuracy") -> int:
    """Put the done rows of `old`, which is `reusable`, into the table at `path`; how many rows it lacked.

    The table's list of runs says how many came from where (`reused`).
    """
    try:
        with table.reading(old) as source, h5py.File(path, "r+") as target:
            return _take(target, tasks, source, in_words(accuracy_of(source)), in_words(wanted))
    except DisagreementError as error:
        raise InputError(*(f"--reuse {old}: {path} disagrees: {line}" for line in error.lines())) from None
    except OSError as error:  # open in another program, or the disk is full
        raise InputError(f"{path}: cannot be written: {' '.join(str(error).split())}") from None


def _take(target: h5py.File, tasks: TaskList, source: h5py.File, found: str, wanted: str) -> int:
    alike = {found, *(entry["accuracy"] for entry in reused(table.runs(target)))} == {wanted}
    slot, count = table.free_slot(target), 0
    for rows in table.done_rows(source):
        ids, new = lacking(target, tasks, rows, alike)
        if not len(ids):
            continue
        if slot is None:
            raise InputError(
                f"{target.filename}: its list of runs is full, so that it could not say where rows come from; "
                f"give another -o, and --reuse {target.filename} besides"
            )
        count += len(ids)
        place = os.fsdecode(Path(source.filename).absolute())
        target[RUNS][slot] = entry(count, place, found, source_hash())[0]  # before the rows: a kill may come in between
        target.flush()
        table.write_rows(target[RESULTS], ids, new)
    return count


def in_words(accuracy: "Accuracy") -> str:
    """How rows of this accuracy are told from others."""
    steps = f", max_steps {accuracy.max_steps}" if accuracy.max_steps != MAX_STEPS else ""
    return f"{accuracy.integrator()}, {CERTIFICATION[accuracy.certify]}{steps}"


def entry(count: int, place: str, accuracy: str, kernel: str) -> NDArray[np.void]:
    """A row (1,) of the list of runs that stands for `count` rows taken from a place, a table or a store."""
    run = new_run(count, text_of(REUSED), kernel, job=accuracy)
    where = place.encode(errors="surrogateescape")
    room = RUN["hosts"].itemsize
    run["hosts"] = where if len(where) <= room else b"..." + where[3 - room :]
    run["left"], run["ended"] = 0, True
    return run


def reused(runs: NDArray[np.void]) -> list[dict[str, Any]]:
    """What a table's list of runs says of rows that were taken from other tables, one entry for each taking.

    `table`: its path, at most 192 bytes; `rows`: how many; `accuracy`: how they were computed; `kernel`: its hash.
    """
    return [
        {
            "table": text_of(run["hosts"]),
            "rows": int(run["left_at_start"]),
            "accuracy": text_of(run["job"]),
            "kernel": text_of(run["kernel"]),
        }
        for run in runs[runs["writer"] == REUSED]
    ]
