"""Claims about results in notebooks: a table of HTML that holds every field, and nothing that is taken for a tag."""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field, fields

import numpy as np
import pytest

import analysis
import kernel
from kernel.notebook import ShownAsTable

from .test_analysis_unknown import table

RESULTS = {
    "optimum": lambda: analysis.optimum(table()),
    "collapse": lambda: analysis.collapse(table()),
    "finding": lambda: analysis.findings(table())[0],
    "ke_ratio": lambda: kernel.ke_ratio(20, 4e-4, 2, 2, 1e-2),
    "simulation": lambda: kernel.simulate(kernel.Scene(5, 1e-2, kernel.Impact(1, 1)), 1e-2),
}


def cells(result):
    """Name and text of every row of the HTML."""
    return {row[0].text: row[1].text for row in ET.fromstring(result._repr_html_())}


@pytest.mark.slow
@pytest.mark.parametrize("make", RESULTS.values(), ids=RESULTS)
def test_a_result_is_a_table_of_its_fields(make):
    result = make()
    assert list(cells(result)) == [one.name for one in fields(result)]


def test_numbers_intervals_sizes_and_what_is_not_known_are_told_in_words():
    @dataclass(frozen=True)
    class Some(ShownAsTable):
        x: float = 1 / 3
        between: tuple = (0.5, 2.0)
        rows: object = field(default_factory=lambda: np.zeros((3, 4)))
        of: object = None
        text: str = "<b> & more"

    told = {"x": "0.333333", "between": "0.5 to 2", "rows": "3 x 4", "of": "not known", "text": "<b> & more"}
    assert cells(Some()) == told


@pytest.mark.slow
def test_a_simulation_that_is_printed_says_what_it_holds_and_not_every_number():
    scene = kernel.Scene(5, 1e-2, kernel.Impact(1, 1), observe={"energy": {"times": 300}, "wall_force": {}})
    seen = kernel.simulate(scene, 1e-2)
    told = repr(seen)
    assert told.startswith(
        f"Simulation(status='done', method='{seen.method}', steps={seen.steps}, observed: energy (t: 300, "
    )
    assert f"wall_force (value: {seen['wall_force']['value']}, " in told
    assert len(told) < 200
