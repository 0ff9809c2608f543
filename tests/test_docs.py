"""Public docstrings can be relied on: examples run, and each says what it takes, gives and refuses."""

import doctest
import importlib
import inspect
import math
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import analysis
import kernel
from analysis.cli import main
from analysis.cli import parser as analysis_parser
from kernel.laws import SPRINGS, Hertz
from kernel.quantities import QUANTITIES
from sweep.cli import parser as sweep_parser
from sweep.schema import seal
from sweep.serve import pulse
from sweep.store import lease

from .test_analysis_cli import rows, write

LARGE, LIGHT = (50, 200), (1e-4, 1e-3)
DOCS = Path(__file__).parent.parent / "docs"
LAWS = ("bistable", "hertz", "piecewise", "polynomial", "power", "toda")
MODULES = (
    *("kernel.along", "kernel.histories"),
    *("kernel.ke", "kernel.lattice", "kernel.merit", "kernel.scene", "kernel.simulation", "kernel.task"),
    *(f"kernel.laws.{law}" for law in LAWS),
)
READERS = (
    "arrays",
    "best",
    "collapse",
    "level",
    "optimum",
    "paper.findings",
    "plane",
    "power_law",
    "table",
    "transition",
)
CALLS = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (kernel, analysis)
    for name in module.__all__
    if not name.startswith("__") and name not in ("InputError", "KeRatio", "Simulation")  # nobody makes these
}


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_the_kernel_run(name):
    module = importlib.import_module(name)
    found = doctest.testmod(module)
    assert found.attempted > 0
    assert found.failed == 0


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """A folder with a small quick.h5, in which ke_ratio depends on Pi_IE and falls from above 1 with N."""
    grid = (
        (5, 8, 13, 20, 30, 50, 80, 120, 200),
        (1e-4, 3e-4, 1e-3, 3e-3, 1e-2),
        (0.5, 1.0, 2.0),
        (0.3, 1.0, 3.0, 10.0),
    )
    data = rows(grid)
    steep = 1 + (data["N"] / (0.7 * data["zeta_T"] ** -0.5)) ** 8
    data["ke_ratio"] = (0.1 + 3 / steep) * (data["M_over_M0"] * data["V_over_V0"] ** 2) ** -0.1
    data["chaotic"] = False
    seal(data)
    return write(tmp_path_factory.mktemp("docs") / "quick.h5", data).parent


@pytest.mark.parametrize("name", READERS)
def test_the_examples_of_the_analysis_run_on_a_table(name, quick, monkeypatch):
    monkeypatch.chdir(quick)
    module = importlib.import_module(f"analysis.{name}")
    found = doctest.testmod(module)
    assert found.attempted > 0
    assert found.failed == 0


def test_every_example_of_a_public_function_is_one_that_runs():
    homes = {inspect.getmodule(call).__name__ for call in CALLS.values()}
    assert homes == {*MODULES, *(f"analysis.{name}" for name in READERS)}
    assert all(">>> " in "\n".join(_sections(inspect.getdoc(call))["Examples"]) for call in CALLS.values())


@pytest.mark.parametrize("name", CALLS)
def test_every_public_docstring_names_its_parameters_results_and_errors(name):
    call = CALLS[name]
    sections = _sections(inspect.getdoc(call))
    wanted = {"Parameters", "Raises", "Examples", *([] if inspect.isclass(call) else ["Returns"])}
    assert wanted <= set(sections), name
    told = " ".join(line for line in sections["Parameters"] if not line.startswith(" "))
    assert [one for one in inspect.signature(call).parameters if one not in told] == []


def _sections(text):
    """The lines under each underlined word."""
    lines, found, name = text.splitlines(), {}, ""
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        name = line if below and set(below) == {"-"} else name
        found.setdefault(name, []).append(line)
    return found


@pytest.fixture
def generate(monkeypatch):
    """docs/generate.py, which is no package's."""
    monkeypatch.syspath_prepend(DOCS)
    yield importlib.import_module("generate")
    del sys.modules["generate"]


def test_the_page_of_the_model_has_every_law_and_quantity_as_the_code_has_them(generate):
    """Written out, as it is read in a checkout too: what `laws` and `quantities` of docs/generate.py give."""
    page = (DOCS / "model.md").read_text()
    for part, names in ((generate.laws(), [*SPRINGS, "contact"]), (generate.quantities(), ["peak_ke", *QUANTITIES])):
        assert part.strip() in page
        assert [name for name in names if f'"{name}"' not in part and f"`{name}`" not in part] == []


FORMULAS = {
    "bistable": "e + c2 e^2 + c3 e^3",
    "polynomial": "e + c2 e^2 + c3 e^3",
    "power": "d/n (1 - (1 - e/d)^n)",
    "toda": "(1 - exp(-b e)) / b",
}


@pytest.mark.parametrize("name", FORMULAS)
def test_the_formula_that_the_page_gives_of_a_law_is_the_law(name, generate):
    (row,) = [line for line in generate.laws().splitlines() if f'"{name}"' in line]
    assert f"ension {FORMULAS[name]}" in row
    formula = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", FORMULAS[name].replace("^", "**"))
    law = SPRINGS[name]()
    numbers = law._asdict() | {"exp": math.exp}
    numbers |= {"n": law.exponent, "d": law.precompression} if name == "power" else {}
    for e in (-0.3, -0.01):
        assert float(law.excess(e)) + e == pytest.approx(eval(formula, numbers | {"e": e}), rel=1e-9)


def test_the_laws_that_the_page_makes_of_a_measured_curve_are_near_it(tmp_path, monkeypatch):
    """Of 30 points of a bistable cell of 0.02 m, 500 N/m at rest."""
    strain, there = np.linspace(0, 1.1, 30), dict[str, Any]()
    tension = strain - 5 * strain**2 + 6 * strain**3
    np.savetxt(tmp_path / "curve.csv", np.transpose([0.02 * strain, 10 * tension]), delimiter=",", header="x,F")
    monkeypatch.chdir(tmp_path)
    (code,) = [block for block in blocks(DOCS / "model.md") if "curve.csv" in block]
    exec(code, there)
    for law, k, far in ((there["law"], there["k"], 0.03), (there["smooth"], there["a"] / 0.02, 1e-9)):
        spring = kernel.Model(spring=law).spring
        found = strain - np.array([float(spring.excess(-e)) for e in strain])
        np.testing.assert_allclose(found * k / 500, tension, atol=far * tension.max())


def test_the_page_s_stiffness_of_a_noisy_curve_is_better_than_that_of_its_first_point(tmp_path, monkeypatch):
    strain, there = np.linspace(0, 0.8, 161), dict[str, Any]()
    force = 10 * (strain - 5 * strain**2 + 6 * strain**3) + np.random.default_rng(1).normal(0, 0.02, 161)
    force[0] = 0
    np.savetxt(tmp_path / "curve.csv", np.transpose([0.02 * strain, force]), delimiter=",", header="x,F")
    monkeypatch.chdir(tmp_path)
    (code,) = [block for block in blocks(DOCS / "model.md") if "curve.csv" in block]
    exec(code, there)
    kernel.Model(spring=there["law"])  # no strain lies where nothing was measured
    assert abs(there["k"] / 500 - 1) < 0.15 < abs(force[1] / strain[1] / 10 - 1)


def test_a_curve_in_millimetres_is_told_by_the_page_s_own_lines(tmp_path, monkeypatch):
    np.savetxt(tmp_path / "curve.csv", [[0, 0], [0.5, 1], [16, 20]], delimiter=",", header="x,F")
    monkeypatch.chdir(tmp_path)
    (code,) = [block for block in blocks(DOCS / "model.md") if "curve.csv" in block]
    with pytest.raises(AssertionError, match="x and l are both to be in m"):
        exec(code, {})


def test_the_histories_of_the_page_obey_newton_and_reach_the_peak():
    there = dict[str, Any]()
    (code,) = [block for block in blocks(DOCS / "model.md") if "rate" in block]
    exec(code, there)
    N, v, tension = there["N"], there["three"][:, 1], there["tension"]
    TE = N * 2 * 0.159 * (5 * 0.26) ** 2 / 2
    expected = kernel.ke_ratio(N, there["zeta_T"], 2, 5).ke_bistable
    assert (v**2).max() / 2 / TE == pytest.approx(expected, rel=5e-3)  # the crest lies between two times
    pushed = np.trapezoid(tension[:, 29] - tension[:, 28], N * there["at"])
    assert pushed == pytest.approx(v[-1], abs=5e-3 * abs(v).max())


def test_the_figure_for_a_paper_is_drawn_of_the_numbers_beside_a_map(tmp_path, monkeypatch):
    page, there = DOCS / "commands.md", dict[str, Any]()
    write(tmp_path / "mine.h5", rows((LARGE, LIGHT, (0.5, 1.0, 2.0), (0.3, 1.0, 3.0))))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    (command,) = re.findall(r"`(analysis map mine\.h5 [^`]*)`", page.read_text())
    assert main(shlex.split(command)[1:]) == 0
    (code,) = blocks(page)
    with plt.rc_context():
        exec(code, there)
    assert there["cells"].shape == (3, 3)
    assert (tmp_path / "figure.pdf").stat().st_size > 5000


def test_every_command_that_the_first_page_shows_is_in_the_grammar():
    shown = re.findall(r"`((?:sweep|analysis) [a-z]+ [^`]*)`", (DOCS / "start.md").read_text())
    assert len(shown) > 8
    for program, *words in map(shlex.split, shown):
        grammar = sweep_parser() if program == "sweep" else analysis_parser()
        assert callable(grammar.parse_args(words).command)


def blocks(page):
    """The Python of a page."""
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize(
    ("law", "key", "low", "high"),
    [
        (law, key, float(low), float(high))
        for law in (kernel.Bistable(4.0, 3.5), kernel.Polynomial(), kernel.PowerLaw(), kernel.Toda(), Hertz())
        for key in law._fields
        for low, high in re.findall(rf"    {key} : .*\n[^:]*?(-?[\de.-]+) to (-?[\de.]+)", type(law).__doc__)
    ],
)
def test_the_range_that_a_law_tells_of_a_number_is_its_own(law, key, low, high):
    assert not [line for good in (low, high) for line in law._replace(**{key: good}).problems() if "from" in line]
    for bad in (low - abs(low) * 1e-6 - 1e-9, high * (1 + 1e-6)):
        assert law._replace(**{key: bad}).problems()[0].startswith(f"{key}: must be")


def test_every_number_of_a_law_tells_its_range():
    told = [len(re.findall(r" to \d", kind.__doc__.partition("Raises")[0])) for kind in (*SPRINGS.values(), Hertz)]
    assert told == [len(kind._fields) for kind in (*SPRINGS.values(), Hertz)]


@pytest.mark.parametrize(
    ("words", "number"),
    [
        ("Every rank tells rank 0 every {:g} s that it lives", pulse.BEAT),
        ("silent for {:g} s", pulse.SILENCE_MAX),
        ("a disk that does not answer one write for {:g} minutes", pulse.DISK_MAX / 60),
        ("its holder renews every {:g} s", lease.BEAT),
        ("lets go of its lock, or {:g} s", lease.LEASE_MAX),
        ("else after {:g} s without a sign of life", lease.LEASE_MAX),
    ],
)
def test_the_page_of_clusters_tells_after_which_time_what_is_silent_counts_as_dead(words, number):
    assert words.format(number) in " ".join((DOCS / "clusters.md").read_text().split())
