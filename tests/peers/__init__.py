"""Other solvers on the same tasks, beside ours: the benchmark behind `make bench`."""
