# People and CI use the same commands. `make setup` is quick once .venv is there; every other target calls it.
#   make run     the quick sweep on two ranks, its picture, and a page to explore it in a browser
#   make test    lint, types, tests
#   make check   lint, types, and the tests that start no command and compile nothing: for people at work
#   make slurm-test  the tests with a real SLURM alone
#   make nodes-test  the tests on simulated nodes alone: network, shared disk, SLURM
#   make openmpi  .venv-openmpi, for the tests with Open MPI
#   make paper   the paper's figures and numbers on one page, paper.html: seven minutes on two cores
#   make paper-full   the same with figure 8 at the paper's own size: predicted one core-hour, more for chaos; resumable
#   make outlook  what the paper leaves open, asked of other laws, figures of merit, lattices, disorder: outlook.html,
#                ten minutes on two cores (docs/outlook.md)
#   make outlook-full  the same with larger specs: hours; resumable
#   make bench   ours beside other solvers, then what each saving saves (ten minutes; more peers with
#                apt-get install libboost-dev g++ octave)
#   make docs    the documentation, docs/_build/index.html; a warning is an error
#   make clean   removes what these left behind, but not the paper's tables; `make distclean` also removes .venv
# Another MPI than Debian's mpich: MPICC=/path/of/mpicc HDF5_DIR=/prefix/of/hdf5 make setup (see .ci/setup)
.DELETE_ON_ERROR:
.PHONY: setup openmpi run test check slurm-test nodes-test paper paper-full outlook outlook-full bench docs lint clean distclean stale

ENVIRONMENT := .venv/.environment
PACKAGE := .venv/.package
INSTALL := .venv/bin/python -m pip install --disable-pip-version-check -q --no-deps --no-build-isolation --force-reinstall
# Leaves the compiled kernel in numba's cache, and beside it how fast it is here, so that neither the first sweep nor the
# first test nor the first plan waits for them.
# -P: of the installed packages, not of the checkout.
COMPILE := .venv/bin/python -P -c 'from sweep.plan.speed import measure; measure()'
# Folders too: deleting or renaming a file changes only its folder.
SOURCES := $(shell find kernel sweep analysis -name __pycache__ -prune -o -print)

setup: $(PACKAGE)

# Where and for which MPI .venv was built. A moved checkout, or variables that ask for something else, make it stale.
-include .venv/built.mk
# What was not given stays unset: Gluster, for one, takes an empty PYTHON for the name of its interpreter, and ends.
$(foreach name,MPICC HDF5_DIR MPIEXEC PYTHON,$(if $($(name)),$(eval export $(name))))
ifneq ($(strip $(BUILT_IN) $(BUILT_FOR)),$(strip $(CURDIR) $(MPICC) $(HDF5_DIR) $(MPIEXEC) $(PYTHON)))
$(ENVIRONMENT): stale
endif

# The stamps carry the time when the work began: what is edited meanwhile counts as newer. A second make waits (flock).
$(ENVIRONMENT): .ci/setup .ci/constraints.txt pyproject.toml
	@start=$$(date +@%s.%N) && flock .ci/setup .ci/setup && touch -d $$start $@

# The wheel is built from build/, where deleted modules would live on.
$(PACKAGE): $(ENVIRONMENT) $(SOURCES)
	@start=$$(date +@%s.%N) && flock .ci/setup sh -c 'rm -rf build *.egg-info && $(INSTALL) . && rm -rf build *.egg-info' && \
	$(COMPILE) && touch -d $$start $@

# A second environment, for Open MPI: the tests that compare its bits with the first one's skip where it is not there.
# It needs what runs a sweep only, and takes over the first one's compiled kernel.
# As root and with more ranks than cores, as CI has it, Open MPI wants to be told that this is meant.
export OMPI_ALLOW_RUN_AS_ROOT = 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM = 1
openmpi: setup
	env -u MPICC -u HDF5_DIR -u MPIEXEC VENV=.venv-openmpi DEBIAN_MPI=openmpi EXTRAS= .ci/setup
	rm -rf build *.egg-info && $(subst .venv,.venv-openmpi,$(INSTALL)) . && rm -rf build *.egg-info
	cd .venv/lib && find . -name '*.nb[ic]' | xargs cp --parents -t ../../.venv-openmpi/lib
	$(subst .venv,.venv-openmpi,$(COMPILE))

run: setup
	.venv/bin/mpirun -n 2 .venv/bin/sweep run jobs/quick.toml -o quick.h5
	.venv/bin/analysis best quick.h5 -o quick.png
	.venv/bin/analysis page quick.h5 -o quick.html

lint: setup
	.venv/bin/ruff check
	.venv/bin/ruff format --check
	.venv/bin/mypy

test: lint
	.ci/test-packages
	.venv/bin/pytest -n 3 --dist loadfile --no-loadscope-reorder --durations=25

check: lint
	.venv/bin/pytest -q -n 2 --dist worksteal -m "not mpi and not slurm and not slow"

slurm-test: setup
	.ci/test-packages
	.venv/bin/pytest -m slurm

nodes-test: setup
	.ci/test-packages
	.venv/bin/pytest -m nodes

# A stopped sweep goes on where it was; exit status 1 tells of failed rows, which the page counts and leaves out.
PAPER := fig1 fig4 fig4-mass fig5 fig6 fig6b

paper paper-full: setup
	mkdir -p $@
	for spec in $(PAPER) $(if $(filter paper,$@),quick/)fig8; do \
	    .venv/bin/mpirun -n 2 .venv/bin/sweep run jobs/paper/$$spec.toml -o $@/$${spec#quick/}.h5 || [ $$? = 1 ] || exit; done
	.venv/bin/analysis paper --tables $@ -o $@.html

# Of outlook-full those specs that have a larger one in jobs/outlook/full.
OUTLOOK := bistable granular fput toda softening threshold optimum merit disorder

outlook outlook-full: setup
	mkdir -p $@
	for spec in $(OUTLOOK); do from=jobs/outlook; \
	    if [ $@ = outlook-full ] && [ -e $$from/full/$$spec.toml ]; then from=$$from/full; fi; \
	    .venv/bin/mpirun -n 2 .venv/bin/sweep run $$from/$$spec.toml -o $@/$$spec.h5 || [ $$? = 1 ] || exit; done
	.venv/bin/analysis outlook --tables $@ -o $@.html

bench: setup
	.venv/bin/python -m pip install --disable-pip-version-check -q -c .ci/constraints.txt scikit-sundae
	.venv/bin/python -m tests.peers.bench -o bench
	.venv/bin/python -m tests.peers.laws
	.venv/bin/python -m tests.measure

docs: setup
	.venv/bin/sphinx-build -q -W --keep-going -b html docs docs/_build

clean:
	rm -rf bench build docs/_build docs/_generated docs/auto_tutorials *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis quick.h5 quick.png quick.best.csv quick.html
	find . -path './.venv*' -prune -o -name __pycache__ -exec rm -rf {} +

distclean: clean
	rm -rf .venv .venv-openmpi
