"""Public docstrings can be relied on: examples run, and each says what it takes, gives and refuses."""

import doctest
import importlib
import inspect

import pytest

import analysis
import kernel
from sweep.schema import seal

from .test_analysis_cli import rows, write

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
