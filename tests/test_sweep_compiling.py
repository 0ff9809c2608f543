"""Claims about what a run compiles before it begins: what its own tasks need, and nothing else."""

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from numba import typeof

from sweep.plan import speed
from sweep.plan.search import COMPUTE, SCREEN
from sweep.serve import compiling
from sweep.serve.compiling import SMALLEST, compile_once

from .conftest import BIN

# Two ranks compile the paper's chain; each tells which functions it compiled itself.
TWO_RANKS = """
import json
from mpi4py import MPI
from numba.core import event

class Heard(event.Listener):
    names = []
    def on_start(self, what):
        self.names.append(what.data["dispatcher"].py_func.__name__)
    def on_end(self, what):
        pass

event.register("numba:compile", Heard())
from kernel.method import choose
from sweep.plan.tasks import Tasks
from sweep.serve.compiling import SMALLEST, compile_once
from sweep.serve.worker import Job

compile_once(MPI.COMM_WORLD, Job(Tasks({name: [value] for name, value in SMALLEST.items()}), choose(), True))
names = MPI.COMM_WORLD.gather(Heard.names)
if names:
    print(json.dumps(names))
"""


class Asked(list):
    """A job that notes for which columns it is asked; `model` and `quantities` are those of a spec."""

    def __init__(self, model, quantities, screens=0.0):
        super().__init__()
        self.model, self.quantities, self.screens = model, quantities, screens
        self.tasks = SimpleNamespace(columns=lambda ids: {name: np.array([value]) for name, value in SMALLEST.items()})

    def results_of(self, columns, asked=COMPUTE):
        self.append(asked)


def test_a_kernel_that_cannot_be_kept_is_told_with_its_folder(monkeypatch, tmp_path):
    assert compiling.what_follows() == "the next run finds it in the cache"
    monkeypatch.setattr(compiling, "why_not_kept", lambda: "No space left on device")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert f"cannot be kept in {tmp_path} (No space left on device), so every start" in compiling.what_follows()


@pytest.fixture
def measured(monkeypatch):
    """How often the paper's chain was measured, and so compiled."""
    times = []
    monkeypatch.setattr(speed, "measure", lambda: times.append(1) or 2.0)
    return times


@pytest.mark.parametrize(("model", "quantities"), [(SimpleNamespace(sites=None), ()), (None, ("wall_force",))])
def test_a_run_of_another_lattice_or_quantity_does_not_compile_the_papers_plain_chain_too(measured, model, quantities):
    job = Asked(model, quantities)
    assert compile_once(None, job) > 0
    assert (len(measured), len(job)) == (0, 1)


def test_a_run_of_the_papers_chain_compiles_it_by_measuring_how_fast_the_machine_is(measured):
    job = Asked(None, ())
    assert compile_once(None, job) == 2.0
    assert (len(measured), len(job)) == (1, 0)


@pytest.mark.parametrize("model", [SimpleNamespace(sites=None), None])
def test_a_search_that_screens_compiles_that_before_it_begins(measured, model):
    job = Asked(model, (), screens=1.5)
    compile_once(None, job)
    assert job == [COMPUTE, SCREEN]


@pytest.mark.slow
def test_two_ranks_of_a_node_compile_a_half_each_and_a_second_run_nothing(environment, tmp_path):
    environment["NUMBA_CACHE_DIR"] = str(tmp_path)

    def compiled():
        command = [str(BIN / "mpirun"), "-n", "2", sys.executable, "-c", TWO_RANKS]
        run = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=400)
        assert run.returncode == 0, run.stderr
        return [set(names) for names in json.loads(run.stdout.splitlines()[-1])]

    one, other = compiled()
    assert one >= {"solve", "run_explicit", "run_implicit", "run_modes"}
    assert "integrate" in other
    assert not one & {"integrate", "dissipated_within"}
    assert not other & {"solve", "run_explicit", "run_implicit", "run_modes"}
    assert compiled() == [set(), set()]


def test_the_first_half_is_the_part_that_others_are_linked_with_and_nothing_for_python():
    from kernel import integrate
    from kernel.halves import compile_half
    from kernel.lattice import Model
    from kernel.model import lattice_chain

    before = set(integrate.run_by.from_python.overloads)
    compile_half(False, Model(), {})
    assert set(integrate.run_by.from_python.overloads) == before
    own = typeof(lattice_chain(20, 0.0, 1.0, Model().lattice(20)))  # the linear chain's, too
    assert {str(sig[0]) for sig in integrate.run_by.called.overloads if sig[1] == own} == {"int64"}
