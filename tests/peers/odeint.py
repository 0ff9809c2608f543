"""Boost.odeint's dopri5: odeint.cpp, compiled with g++ once per source, flags and machine, called in this process."""

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np

from kernel.laws import PAPER, Bistable, PiecewiseLinear, Polynomial, PowerLaw, Toda
from kernel.task import T_END_OVER_N
from sweep.machine import processor_name

from .common import ATOL_OVER_RTOL, Missing, Solver, one_by_one, parameters

SOURCE = Path(__file__).with_name("odeint.cpp")
# What its users compile with. -ffast-math would let g++ vectorise odeint's error norm too, a tenth of the time.
FLAGS = ("-std=c++17", "-O3", "-march=native")
# In the order of odeint.cpp. Of straight pieces it knows two.
LAWS = (None, Bistable, Polynomial, PiecewiseLinear, PowerLaw, Toda)


@cache
def library(flags=FLAGS):
    """The compiled peer; Missing where there is no compiler or no Boost."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise Missing("no g++")
    identity = repr([platform.node(), processor_name(), *flags, SOURCE.read_text()])
    path = SOURCE.parent / "__pycache__" / f"odeint-{hashlib.sha256(identity.encode()).hexdigest()[:16]}.so"
    path.parent.mkdir(exist_ok=True)
    if not path.exists():
        made = path.with_suffix(f".{os.getpid()}")
        # Linked without the flags: with -ffast-math the library would switch subnormals off in whoever loads it.
        for command in (
            [*flags, "-fPIC", "-c", str(SOURCE), "-o", f"{made}.o"],
            ["-shared", f"{made}.o", "-o", str(made)],
        ):
            done = subprocess.run([compiler, *command], capture_output=True, text=True, check=False)
            if done.returncode:
                raise Missing(f"g++ cannot compile it (libboost-dev?): {done.stderr.strip().splitlines()[0]}")
        Path(f"{made}.o").unlink()
        made.replace(path)
    lib = ctypes.CDLL(str(path))
    number, pointer = ctypes.c_double, ctypes.POINTER(ctypes.c_double)
    lib.peak_speed.restype = number
    lib.peak_speed.argtypes = [ctypes.c_int, ctypes.c_int, pointer, pointer, number, number, number]
    lib.boost_version.restype = ctypes.c_char_p
    return lib


def peak_speed(task, rtol, atol, spring, flags=FLAGS):
    """max |v_mid| over continuous time of a chain of these springs (None: linear); nan where the solver gives up."""
    p = np.ascontiguousarray(parameters(task, bistable=False)[[0, 3, 4, 5]])
    law = np.hstack([0.0, *(spring or ())])[1:] if spring else np.zeros(1)
    values = (array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (law, p))
    which = LAWS.index(type(spring) if spring else None)
    return library(flags).peak_speed(task.N, which, *values, T_END_OVER_N * task.N, rtol, atol)


def ke_ratio(task, rtol, atol, spring=PAPER, flags=FLAGS):
    """ke_bistable / ke_linear of one task."""
    chain, linear = (peak_speed(task, rtol, atol, law, flags) for law in (spring, None))
    return (chain / linear) ** 2


def solvers(spring=PAPER, flags=FLAGS):
    """Two habits: an absolute tolerance like ode45's, and odeint's own default of two equal tolerances."""
    library(flags)
    ladder = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7, 1e-8)
    habits = {"Boost.odeint dopri5": ATOL_OVER_RTOL, "Boost.odeint dopri5, atol = rtol": 1.0}
    return [
        Solver(name, ladder, one_by_one(lambda task, rtol, r=ratio: ke_ratio(task, rtol, r * rtol, spring, flags)))
        for name, ratio in habits.items()
    ]


def versions():
    """What ran."""
    first = subprocess.run(["g++", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    return f"Boost {library().boost_version().decode()}, {first}, flags {' '.join(FLAGS[1:])}"
