"""Ours: rk45 at tolerances, and the default method at accuracies, one task at a time and in batches."""

from importlib.metadata import version
from time import process_time

import numpy as np

import kernel
from kernel.lattice import PAPER_MODEL

from .common import Solver, one_by_one

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5)
ALONE, BATCHED = "ours auto, one task alone", "ours auto, in a batch"  # the two that peers are compared with


def solvers(model=PAPER_MODEL):
    """Without an error estimate, as the peers give none; and with it."""

    def rk45(task, rtol):
        return kernel.ke_ratio(**vars(task), method="rk45", rtol=rtol, certify=False, model=model).ke_ratio

    lines = [Solver("ours rk45", TOLERANCES, one_by_one(rk45))]
    for certify, suffix in ((False, ""), (True, ", certified")):

        def alone(task, accuracy, certify=certify):
            return kernel.ke_ratio(**vars(task), accuracy=accuracy, certify=certify, model=model).ke_ratio

        def batched(tasks, accuracy, certify=certify):
            start = process_time()
            found = kernel.ke_ratios(tasks, accuracy, certify=certify, model=model)
            return found["ke_ratio"], (process_time() - start) / len(tasks)

        lines.append(Solver(ALONE + suffix, ACCURACIES, one_by_one(alone)))
        lines.append(Solver(BATCHED + suffix, ACCURACIES, batched, batch=True))
    return lines


def versions():
    """What ran, and from where."""
    return f"bistable-sweep {version('bistable-sweep')}, numba {version('numba')}, numpy {np.__version__}"
