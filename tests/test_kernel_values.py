"""Claims about the objects that users make: what they compare to, what they keep, which numbers they take."""

import copy
import pickle
from typing import NamedTuple

import numpy as np
import pytest

import kernel


def release(first=0.1):
    return kernel.Release(u=[0.0] * 5, v=[first, 0.0, 0.0, 0.0, 0.0])


def pickled(x):
    return pickle.loads(pickle.dumps(x))


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, pickled, lambda _: release()])
def test_a_released_chain_and_its_scene_equal_their_copies_and_no_other(again):
    event = release()
    assert again(event) == event
    assert hash(again(event)) == hash(event)
    assert again(event) != release(0.2)
    assert kernel.Scene(5, 0.0, again(event), observe="energy") == kernel.Scene(5, 0.0, event, observe="energy")


def test_a_scene_does_not_change_with_the_options_that_it_was_given():
    options = {"ke_field": {"times": 4}}
    scene = kernel.Scene(5, 1e-3, kernel.Impact(2, 2), observe=options)
    options["ke_field"]["times"] = -3
    options["energy"] = {}
    assert scene.observe == {"ke_field": {"times": 4}}


@pytest.mark.slow
def test_what_a_scene_has_seen_is_asked_for_by_name():
    seen = kernel.simulate(kernel.Scene(5, 1e-3, kernel.Impact(2, 2), observe=["energy", "peak_ke"]))
    assert list(seen) == ["energy", "peak_ke"]
    assert "energy" in seen
    assert "ke" not in seen
    assert pickled(seen) != seen


class Saturating(NamedTuple):
    """A law of one's own, linear at rest, whose tension stays below `most`."""

    most: float

    def excess(self, e):
        return e * (1.0 / (1.0 + abs(e) / self.most)) - e

    def energy_at(self, e):
        return self.most * abs(e) - self.most**2 * np.log1p(abs(e) / self.most)

    def stiffness_at(self, e):
        return 1.0 / (1.0 + abs(e) / self.most) ** 2

    def steepest(self, lowest, highest):
        return 1.0

    is_linear = stiffens_in_tension = stiffness_jumps = lambda self: False


@pytest.mark.slow
def test_a_law_of_ones_own_takes_whole_numbers_as_the_product_s_laws_do():
    assert kernel.Model(spring=Saturating(1)) == kernel.Model(spring=Saturating(1.0))


@pytest.mark.parametrize("most", ["x", None, np.nan, np.timedelta64(5, "D")])
def test_a_law_of_ones_own_that_holds_no_number_is_named(most):
    with pytest.raises(ValueError, match=r"^spring\.most: must be a number, got "):
        kernel.Model(spring=Saturating(most))


def test_a_difference_of_dates_is_no_number():
    with pytest.raises(ValueError, match=r"^N: must be a whole number from 2 to 10000, got "):
        kernel.ke_ratio(np.timedelta64(5, "D"), 1e-2, 1, 1)
