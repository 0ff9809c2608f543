"""The program that measures a page of a million rows, tried on fewer: what it reports was seen in a browser."""

import pytest

from . import browser
from .million import IMPACTS, opened, table


@pytest.mark.slow
@browser.needed
def test_a_large_page_is_used_by_its_sliders_and_every_step_is_timed(tmp_path):
    from analysis.cli import main

    many = table(tmp_path / "t.h5", 5000)
    assert many > 4000
    assert main(["page", str(tmp_path / "t.h5"), "-o", str(tmp_path / "t.html")]) == 0
    ready, steps = opened((tmp_path / "t.html").as_uri())
    assert 0 < ready < browser.WAIT
    assert len(steps) == sum(IMPACTS)
    assert all(step >= 0 for step in steps)
