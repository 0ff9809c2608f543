"""Public docstrings can be relied on: examples run, and each says what it takes, gives and refuses."""

import doctest
import importlib
import inspect

import pytest

import analysis
import kernel

MODULES = ("kernel.ke", "kernel.scene", "kernel.simulate", "kernel.task")
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
