"""Claims about scene files."""

from pathlib import Path

import numpy as np
import pytest

import kernel
from analysis import InputError
from analysis.paper.scenes import read_scenes, simulate_all

SCENES = sorted((Path(__file__).parent.parent / "jobs/paper/scenes").glob("*.toml"))
GOOD = """
name = "two small chains"
[[scene]]
N = [4, 6]
zeta_T = 1e-3
M_over_M0 = 2.0
V_over_V0 = 1.0
observe = { peak_ke = {} }
"""


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "scenes.toml"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.name)
def test_every_scene_file_in_jobs_is_valid(path):
    assert all(isinstance(scene, kernel.Scene) for spec in read_scenes(path).scene for scene in spec.scenes())


def test_lists_make_one_scene_per_combination_and_each_is_the_kernels_own(written):
    seen = simulate_all(read_scenes(written(GOOD.replace("1.0", "[1.0, 2.0]"))))
    assert [(one.scene.N, one.scene.event.V_over_V0) for one in seen] == [(4, 1), (6, 1), (4, 2), (6, 2)]
    direct = kernel.simulate(kernel.Scene(6, 1e-3, kernel.Impact(2, 2)), 1e-3)["peak_ke"]["ke"]
    np.testing.assert_array_equal(seen[3]["peak_ke"]["ke"], direct)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("N = [4, 6]", "N = 1"), "N: must be a whole number from 2 to 10000, got 1"),
        (("N = [4, 6]", "N = []"), "scene.0.N: must have at least 1 item"),
        (("N = [4, 6]", 'N = "4"'), "scene.0.N.0: must be a valid integer"),
        (("peak_ke = {}", "peak = {}"), "observe: must be one of peak_ke"),
        (("peak_ke = {}", "ke_field = { times = 1 }"), "times must be a whole number from 2 to 1000000, got 1"),
        (("V_over_V0 = 1.0", ""), "give either M_over_M0 and V_over_V0"),
        (("zeta_T", "zeta"), "scene.0.zeta: is not a known key (did you mean 'zeta_T'?)"),
        (("[[scene]]", "[[scene"), "is not TOML"),
    ],
)
def test_a_bad_file_is_refused_by_a_line_that_names_the_problem(written, change, said):
    with pytest.raises(InputError) as caught:
        read_scenes(written(GOOD.replace(*change)))
    assert said in str(caught.value)


def test_all_problems_are_told_at_once_a_line_each(written):
    text = GOOD.replace("[4, 6]", '"4"').replace("1e-3", '"thin"')
    with pytest.raises(InputError) as caught:
        read_scenes(written(text))
    assert len(str(caught.value).splitlines()) == 2


def test_a_missing_file_is_told_by_name(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: cannot be read: No such file"):
        read_scenes(tmp_path / "none.toml")
