"""Answers to the user: what a sweep will take, how far it is, where a table comes from, how good it is."""
