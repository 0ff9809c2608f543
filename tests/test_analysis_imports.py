"""The files of analysis build on each other one way."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parent.parent
FILES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
    for file in (ROOT / "analysis").rglob("*.py")
}


def imported(file):
    """The modules of analysis that a file names in an import, wherever it stands, also one for types only."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom):
            for name in node.names:
                module = f"{node.module}.{name.name}"
                yield module if module in FILES else node.module
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


def test_no_file_imports_one_that_imports_it():
    uses = {module: set(imported(file)) & set(FILES) for module, file in FILES.items()}
    order = list(TopologicalSorter(uses).static_order())  # CycleError names the circle
    assert len(order) == len(FILES) > 50


# What is about the paper: its figures, what it leaves open, and the commands.
OF_THE_PAPER = ("analysis.paper", "analysis.outlook", "analysis.commands")


def test_what_is_general_knows_of_the_paper_only_its_numbers():
    general = [file for module, file in FILES.items() if not module.startswith(OF_THE_PAPER)]
    known = {module for file in general for module in imported(file) if module.startswith(OF_THE_PAPER[:2])}
    assert known == {"analysis.paper.numbers", "analysis.paper.findings"}  # the findings are public
