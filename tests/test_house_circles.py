"""No module needs, by whatever way round, a module that needs it."""

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


def modules(package):
    """Every module of the package, by its dotted name."""
    for file in (ROOT / package).rglob("*.py"):
        parts = file.relative_to(ROOT).with_suffix("").parts
        yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), file


def imported(file, known):
    """Those of the `known` modules that a module imports anywhere: at its top, in a function, for the types alone."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: an import must name its module in full"
            names = (f"{node.module}.{alias.name}" for alias in node.names)  # modules, or what a module holds
            yield from (name if name in known else node.module for name in names if {name, node.module} & set(known))


@pytest.mark.parametrize("package", ["kernel", "sweep", "analysis"])
def test_no_imports_run_in_a_circle(package):
    files = dict(modules(package))
    graph = {name: set(imported(file, files)) for name, file in files.items()}
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))
