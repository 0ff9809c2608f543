"""A search is steered by a sampler of the user's own: the same tasks on any number of ranks, after kills, and again."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import analysis
import kernel
from sweep.errors import InputError
from sweep.plan.own import Own
from sweep.plan.spec import parse_spec
from sweep.plan.tasks import Tasks
from sweep.schema import DONE, PENDING, UNASKED, blank_of, inputs_of
from sweep.tell import report

from .conftest import changed, problems_of

EXAMPLE = Path(__file__).parent.parent / "docs/sampler"


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """The folder with the example of the documentation, where its table is kept."""
    folder = tmp_path_factory.mktemp("example")
    for name in ("evolution.toml", "evolution.py"):
        shutil.copy(EXAMPLE / name, folder)
    return folder


@pytest.fixture
def alone(sweep, example):
    """The table of one process."""
    if not (example / "one.h5").exists():
        answer = sweep("run", example / "evolution.toml", "-o", example / "one.h5")
        assert answer.returncode == 0, answer.stderr
    return example / "one.h5"


def test_scipys_evolution_finds_a_low_ratio_with_a_part_of_the_grid(alone):
    table = analysis.load(alone)
    assert len(table) < 1681 / 4
    calm = table[~table["chaotic"]]
    lowest = calm.loc[calm["ke_ratio"].idxmin()]
    random = np.random.default_rng(1).choice(1681, len(table), replace=False)
    axis = np.geomspace(0.1, 10, 41)
    M, V = axis[random // 41], axis[random % 41]
    rows = kernel.ke_ratios({"N": 40, "zeta_T": 1e-3, "M_over_M0": M, "V_over_V0": V})
    assert lowest["ke_ratio"] <= rows["ke_ratio"][~rows["chaotic"]].min()


@pytest.mark.mpi
def test_three_ranks_choose_the_tasks_of_one(sweep, example, alone, tmp_path, physics):
    answer = sweep("run", example / "evolution.toml", "-o", "three.h5", ranks=3)
    assert answer.returncode == 0, answer.stderr
    assert physics(tmp_path / "three.h5") == physics(alone)


def test_a_table_that_has_lost_rows_becomes_what_it_was(sweep, example, alone, tmp_path, physics):
    shutil.copy(alone, tmp_path / "t.h5")
    with changed(tmp_path / "t.h5") as rows:
        done = np.flatnonzero(~np.isin(rows["status"], (PENDING, UNASKED)))
        lost = np.random.default_rng().choice(done, len(done) // 2, replace=False)
        empty = blank_of({name: rows[name][lost] for name in inputs_of(rows.dtype)}, rows.dtype)
        empty["status"] = UNASKED
        rows[lost] = empty
    answer = sweep("run", example / "evolution.toml", "-o", "t.h5")
    assert answer.returncode == 0, answer.stderr
    assert physics(tmp_path / "t.h5") == physics(alone)


def test_a_look_at_its_table_does_not_run_the_sampler(alone, example, tmp_path):
    shutil.copy(alone, tmp_path / "elsewhere.h5")  # where no sampler lies
    done = len(analysis.load(alone))
    assert report.status(tmp_path / "elsewhere.h5")["done"] == done
    assert report.show(tmp_path / "elsewhere.h5")["search"] == f"{done} of 1681 rows computed"


def test_another_sampler_is_another_sweep(sweep, example, alone, tmp_path):
    for name in ("evolution.toml", "evolution.py", "one.h5"):
        shutil.copy(example / name, tmp_path)
    (tmp_path / "evolution.py").write_text((example / "evolution.py").read_text().replace("rng=1", "rng=2"))
    answer = sweep("run", "evolution.toml", "-o", "one.h5")
    assert answer.returncode == 2
    assert "holds another sweep (it differs in search.sha256)" in answer.stderr


SPEC = """
name = "own"
[grid]
N = [5, 8]
zeta_T = [0.0, 1e-3, 1e-2]
M_over_M0 = 1
V_over_V0 = 1
[search]
find = "own"
file = "mine.py"
"""


FACE = "class Sampler:\n    __init__ = lambda self, axes: None\n    tell = lambda self, rows: rows[9]\n"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (None, "s.toml: search.file: mine.py cannot be read: No such file or directory"),
        ("x = 1", "search.file: mine.py must have a class Sampler with the methods ask and tell"),
        ("class Sampler: ask = tell = 3", "search.file: mine.py must have a class Sampler with the methods ask and"),
        ("x = 3\n1 / 0", "search.file: mine.py cannot be run: ZeroDivisionError: division by zero (line 2)"),
        ("import sys; sys.exit(0)", "search.file: mine.py cannot be run: SystemExit: 0 (line 1)"),
        ("class Sampler:\n    a = b =", "search.file: mine.py cannot be run: SyntaxError: invalid syntax (line 2)"),
        (f"{FACE}    ask = lambda self: [[9] * 4]", "search.file: mine.py: ask must give whole numbers (n, 4), each"),
        (f"{FACE}    ask = lambda self: exit()", "search.file: mine.py failed in Sampler.ask: SystemExit: None (line"),
    ],
)
def test_a_file_that_is_no_sampler_is_one_problem_and_nothing_is_written(sweep, tmp_path, text, problem):
    (tmp_path / "s.toml").write_text(SPEC)
    if text is not None:
        (tmp_path / "mine.py").write_text(text)
    answer = sweep("run", "s.toml", "-o", "t.h5")
    assert answer.returncode == 2
    assert answer.stderr.startswith(f"sweep: {problem}")
    assert answer.stderr.count("\n") == 1
    assert not (tmp_path / "t.h5").exists()
    assert {path.name for path in tmp_path.iterdir()} <= {"s.toml", "mine.py"}


@pytest.mark.mpi
def test_a_sampler_that_cannot_begin_leaves_nothing_on_several_ranks(sweep, tmp_path):
    (tmp_path / "s.toml").write_text(SPEC)
    (tmp_path / "mine.py").write_text(f"{FACE}    ask = lambda self: [[9] * 4]")
    answer = sweep("run", "s.toml", "-o", "t.h5", ranks=2)
    assert answer.returncode == 2
    assert answer.stderr.startswith("sweep: search.file: mine.py: ask must give whole numbers")
    assert {path.name for path in tmp_path.iterdir()} == {"s.toml", "mine.py"}


def test_its_key_stands_only_with_it():
    spec = SPEC.replace('find = "own"', 'find = "level"\nlevel = 1\nalong = "N"')
    assert problems_of(parse_spec, spec, "x") == ('x: search.file: stands only with find = "own", got find = "level"',)


def test_a_given_hash_must_be_that_of_the_file(tmp_path):
    """Before, any was taken, and replaced by the file's."""
    (tmp_path / "x.py").write_text(ROUNDS)
    text = 'name = "t"\n[grid]\nN = [5, 8]\nzeta_T = 0\nM_over_M0 = 1\nV_over_V0 = 1\n'
    text += '[search]\nfind = "own"\nfile = "x.py"\n'
    found = parse_spec(text, "s.toml", tmp_path).search.sha256
    assert parse_spec(f'{text}sha256 = "{found}"\n', "s.toml", tmp_path).search.sha256 == found
    for given, shown in (('"abc"', "'abc'"), ("3", "3")):
        assert problems_of(parse_spec, f"{text}sha256 = {given}\n", "s.toml", tmp_path) == (
            f"s.toml: search.sha256: must be that of x.py, {found}, got {shown}",
        )


def played(tmp_path, code: str, order) -> list[list[int]]:
    """What is asked for, part by part, where results arrive as `order` puts them."""
    (tmp_path / "mine.py").write_text(code)
    tasks = Tasks({"N": [5, 8], "zeta_T": [0.0, 1e-3, 1e-2], "M_over_M0": [1.0], "V_over_V0": [1.0]})
    rows = blank_of(tasks.columns(np.arange(6)))
    rows["status"], rows["ke_ratio"] = DONE, np.arange(6) / 10
    search, parts = Own(tasks, "ke_ratio", tmp_path / "mine.py"), []
    while len(new := search.ask()):
        parts.append(new.tolist())
        for task in order(new):
            search.tell(np.array([task]), rows[[task]])
            if task != order(new)[-1]:
                assert not len(search.ask())  # the round is not over
    return parts


ROUNDS = """
import numpy as np
class Sampler:
    def __init__(self, axes):
        assert [len(axis) for axis in axes.values()] == [2, 3, 1, 1]
        self.rounds = [[5, 0, 5], [0, 3], [2]]
        self.told = []
    def ask(self):
        return np.array([[k // 3, k % 3, 0, 0] for k in self.rounds[len(self.told)]]) if len(self.told) < 3 else []
    def tell(self, rows):
        assert (10 * rows["ke_ratio"]).round().tolist() == self.rounds[len(self.told)]
        assert not {"seconds", "rank", "checksum"} & set(rows.dtype.names)
        self.told.append(rows)
"""


@pytest.mark.parametrize("order", [lambda new: new, lambda new: new[::-1]])
def test_it_is_told_whole_rounds_in_its_own_order(tmp_path, order):
    assert played(tmp_path, ROUNDS, order) == [[0, 5], [3], [2]]


SETTLED = """
class Sampler:
    def __init__(self, axes):
        self.rounds = 0
    def ask(self):
        self.rounds += 1
        return [[self.rounds // 900 % 2, 0, 0, 0]]
    def tell(self, rows):
        pass
"""


def test_a_sampler_that_asks_for_nothing_new_any_more_has_ended(tmp_path):
    """A run that waited for it could not be stopped. 900 rounds alike are fewer than a thousand."""
    assert played(tmp_path, SETTLED, lambda new: new) == [[0], [3]]


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (f"{FACE}    ask = lambda self: [[0] * 4]", "failed in Sampler.tell: IndexError: .* (line 3)"),
        (f"{FACE}    def ask(self):\n        return 1 / 0", "failed in Sampler.ask: ZeroDivisionError: .* (line 5)"),
        ("class Sampler:\n    ask = tell = print", "failed in Sampler.__init__: TypeError: Sampler.. takes no"),
    ],
)
def test_what_a_sampler_raises_is_told_with_its_method_and_line(tmp_path, code, told):
    with pytest.raises(InputError, match=told.replace("(", r"\(").replace(")", r"\)")) as caught:
        played(tmp_path, code, list)
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    "asked", ["[[0, 3, 0, 0]]", "[[0] * 4, [0]]", "[[0, -1, 0, 0]]", "[[0.0, 0, 0, 0]]", "[0, 0, 0, 0]", "[[0, 0]]"]
)
def test_what_is_no_task_is_refused_in_words(tmp_path, asked):
    code = f"class Sampler:\n    __init__ = lambda self, axes: None\n    tell = print\n    ask = lambda self: {asked}\n"
    with pytest.raises(InputError, match="ask must give whole numbers"):
        played(tmp_path, code, list)


@pytest.mark.parametrize("nothing", ["None", "[]", "np.empty((0, 4), int)"])
def test_nothing_or_none_ends_the_search(tmp_path, nothing):
    path = tmp_path / "mine.py"
    path.write_text(f"import numpy as np\n{FACE}    ask = lambda self: {nothing}")
    tasks = Tasks({"N": [5, 6], "zeta_T": [0.0], "M_over_M0": [1.0], "V_over_V0": [1.0]})
    assert not len(Own(tasks, "ke_ratio", path).ask())
