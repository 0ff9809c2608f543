"""Malformed specs and damaged tables, thrown at the command line: `python -m tests.fuzz`."""
