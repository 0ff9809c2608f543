"""Claims about what a run compiles before it begins: what its own tasks need, and nothing else."""

from types import SimpleNamespace

import numpy as np
import pytest

from sweep.plan import speed
from sweep.serve.compiling import SMALLEST, compile_once


class Asked(list):
    """A job that notes for which columns it is asked; `model` and `quantities` are those of a spec."""

    def __init__(self, model, quantities):
        super().__init__()
        self.model, self.quantities = model, quantities
        self.tasks = SimpleNamespace(columns=lambda ids: {name: np.array([value]) for name, value in SMALLEST.items()})

    def results_of(self, columns):
        self.append(columns)


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
