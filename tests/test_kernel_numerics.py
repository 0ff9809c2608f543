"""The number of the kernel's bits is raised where bits change, and only there: a store hands out what has the same."""

import json
import subprocess
import sys

import numpy as np
import pytest

from kernel import Disordered, Model, Polynomial, PowerLaw, numerics
from sweep.plan.tasks import Tasks
from sweep.serve import worker

from . import bits

KNOWN = json.loads(bits.DIGESTS.read_text())
HERE = numerics.processor_kind()


@pytest.fixture(scope="module")
def digest():
    kept = KNOWN.get(str(numerics.NUMERICS))
    if kept is not None and HERE not in kept:
        pytest.skip(f"no digest of {HERE} is kept for {numerics.NUMERICS}: python -m tests.bits --digest")
    return bits.digest()


def test_bits_are_those_that_this_number_stands_for(digest):
    """If this fails, bits have changed: if that is meant, raise NUMERICS, then python -m tests.bits --digest."""
    assert KNOWN[str(numerics.NUMERICS)][HERE] == digest


def test_the_number_was_raised_only_where_bits_changed(digest):
    earlier = [
        digests[HERE] for number, digests in KNOWN.items() if int(number) < numerics.NUMERICS and HERE in digests
    ]
    assert digest not in earlier
    assert max(map(int, KNOWN)) == numerics.NUMERICS


def test_what_a_machine_says_of_its_bits_is_the_same_in_another_process():
    said = "from kernel.numerics import numerics; print(numerics())"
    answer = subprocess.run([sys.executable, "-P", "-c", said], capture_output=True, text=True, timeout=240, check=True)
    assert answer.stdout.strip() == numerics.numerics()
    assert answer.stdout.startswith(f"{numerics.NUMERICS} {HERE} ")


def test_a_change_of_the_last_bit_of_one_number_is_told(monkeypatch):
    before = numerics.digest([numerics.choose(accuracy=1e-2)])
    results = numerics.results_of

    def moved(*asked, **how):
        rows = results(*asked, **how)
        rows["ke_ratio"].view("i8")[-1] += 1
        return rows

    monkeypatch.setattr(numerics, "results_of", moved)
    assert numerics.digest([numerics.choose(accuracy=1e-2)]) != before


@pytest.fixture
def asked(monkeypatch):
    """What is computed for a digest, which is not computed here."""
    calls = list[dict]()

    def noted(tasks, integrator, **how):
        calls.append({"tasks": tasks, "integrator": integrator, **how})
        return np.zeros(1)

    monkeypatch.setattr(numerics, "results_of", noted)
    return calls


def test_the_digest_is_of_the_model_at_hand_and_its_quantities_and_of_nothing_else(asked):
    model = Model(spring=Polynomial(3.0, 4.0), mass=Disordered(0.1))
    numerics.numerics.__wrapped__(model, ("wall_force", "arrival"))
    assert [call["model"] for call in asked] == [model, model]
    assert {tuple(call["quantities"]) for call in asked} == {("wall_force", "arrival")}
    assert all(call["certify"] for call in asked), "what is judged is told by the bits, too"


def test_a_digest_takes_no_longer_for_a_long_watch_or_a_long_list(asked):
    long = Model(t_end=1000.0, damping=[1.0 + 1e-3 * i for i in range(9000)], stiffness=2.0)
    numerics.numerics.__wrapped__(long)
    for call in asked:
        assert call["model"] == Model(damping=long.damping[: numerics.LISTED], stiffness=2.0)
        assert set(call["tasks"]["N"]) == {call["model"].sites} == {numerics.LISTED}
        assert call["integrator"].max_steps == numerics.STEPS_MAX


def test_a_model_that_only_its_tasks_complete_is_told_by_the_papers(monkeypatch):
    monkeypatch.setattr(worker, "numerics", lambda model, quantities: (model, quantities))
    tasks = Tasks({"N": [5], "zeta_T": [0.0], "M_over_M0": [1.0], "V_over_V0": [1.0], "spring.precompression": [0.1]})
    loose = Model(spring=PowerLaw(1.5, 0.0))
    job = worker.Job(tasks, numerics.choose(), True, varied=("spring.precompression",), model=loose)
    assert job.numerics() == (Model(), ())
    assert job.numerics_of_first() == (Model(spring=PowerLaw(1.5, 0.1)), ())


def test_the_bound_of_the_steps_leaves_the_papers_rows_as_they_are():
    for integrator in (numerics.choose(accuracy=1e-2), numerics.choose("rk45", rtol=1e-3)):
        bounded = integrator._replace(max_steps=numerics.STEPS_MAX)
        assert numerics.digest([bounded]) == numerics.digest([integrator])
