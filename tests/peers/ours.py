"""Ours: rk45 at tolerances, and the default method at accuracies, one task at a time and in batches."""

import inspect
from importlib.metadata import version
from time import process_time

import numpy as np

import kernel
from kernel.task import Task

from .common import Solver, one_by_one

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5)
ALONE, BATCHED = "ours auto, one task alone", "ours auto, in a batch"  # the two that peers are compared with


def rk45(task, rtol):
    """The paper's integrator at one tolerance."""
    return kernel.ke_ratio(**vars(task), method="rk45", rtol=rtol, certify=False).ke_ratio


def auto(task, accuracy, certify):
    """What a user gets who asks for an accuracy."""
    return kernel.ke_ratio(**vars(task), accuracy=accuracy, certify=certify).ke_ratio


def in_batch(tasks, accuracy, certify):
    """Ratios and seconds per task of kernel.ke_ratios, or of a loop where the kernel has no batches."""
    ratios = getattr(kernel, "ke_ratios", None)
    if ratios is None:
        return one_by_one(lambda task, setting: auto(task, setting, certify))(tasks, accuracy)
    keywords = {"certify": certify} if "certify" in inspect.signature(ratios).parameters else {}
    rows = [Task(**vars(task)) for task in tasks]
    start = process_time()
    result = ratios(rows, accuracy, **keywords)
    seconds = (process_time() - start) / len(rows)
    return column(result), seconds


def column(result):
    """ke_ratio of every row, whether the rows are objects or the result is a table of columns."""
    if hasattr(result, "ke_ratio"):
        return np.asarray(result.ke_ratio, dtype=float)
    if getattr(getattr(result, "dtype", None), "names", None) or isinstance(result, dict):
        return np.asarray(result["ke_ratio"], dtype=float)
    return np.array([row.ke_ratio for row in result], dtype=float)


def solvers():
    """Without an error estimate, as the peers give none; and with it."""
    lines = [Solver("ours rk45", TOLERANCES, one_by_one(rk45))]
    for certify, suffix in ((False, ""), (True, ", certified")):
        alone = one_by_one(lambda task, accuracy, c=certify: auto(task, accuracy, c))
        lines.append(Solver(ALONE + suffix, ACCURACIES, alone))
        batched = lambda tasks, accuracy, c=certify: in_batch(tasks, accuracy, c)  # noqa: E731
        lines.append(Solver(BATCHED + suffix, ACCURACIES, batched, batch=True))
    return lines


def versions():
    """What ran, and from where."""
    batches = "" if hasattr(kernel, "ke_ratios") else " (no kernel.ke_ratios: its batches are loops)"
    return f"bistable-sweep {version('bistable-sweep')}{batches}, numba {version('numba')}, numpy {np.__version__}"
