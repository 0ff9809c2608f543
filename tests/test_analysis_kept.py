"""What the commands draw, write and print is what it was when it was last looked at."""

import pytest

from tests import pictures
from tests.sketch import assert_kept, differences

pytestmark = pytest.mark.slow


def test_what_the_commands_draw_and_print_is_what_was_looked_at(tmp_path):
    assert_kept(pictures.commands(tmp_path), "commands")


@pytest.mark.parametrize(
    ("now", "alike"),
    [
        ("text 'N' at [10 501 30 40] 0.20001", True),
        ("text 'N' at [10 502 30 40] 0.2", False),
        ("text 'N' at [10 500 30 40] 0.201", False),
        ("text 'M' at [10 500 30 40] 0.2", False),
    ],
)
def test_a_picture_differs_by_a_thousandth_or_by_a_word(now, alike):
    assert (differences(["text 'N' at [10 500 30 40] 0.2"], [now]) == []) == alike


def test_a_line_that_is_not_drawn_is_a_difference():
    assert differences(["one", "two"], ["one"])[0] == "1 lines for 2"
