"""The open questions: a file each, which says in QUESTION what it asks, by which rule, and from which tables."""

from importlib import import_module

from analysis.outlook.part import Question

FILES = ("threshold", "optimum", "merit", "lattice", "disorder")

ALL: tuple[Question, ...] = tuple(import_module(f"analysis.outlook.questions.{name}").QUESTION for name in FILES)
