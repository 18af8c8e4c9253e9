# SPDX-License-Identifier: BSD-3-Clause
# Needs Python >= 3.11 and make; everything else is installed into .venv at the versions in requirements/.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet
JOBS   ?= 2
SYSTEMS ?= 1000
FULL   ?= 1
unexport PYTHONDONTWRITEBYTECODE  # hundreds of interpreters start in the tests: without bytecode each compiles all that it imports

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test test-full test-package test-machines test-torch golden test-pythons check format docs figures bench bench-rhs bench-calls bench-trees bench-precision bench-bicycle bench-beams lock clean

help:  ## list the targets
	@awk -F':.*## ' '/^[a-z-]+:.*## /{printf "make %-15s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(VENV)/.run-stamp  ## derive, check and simulate the rolling disk; write out/rolling_disk/report.html
	$(BIN)/kane demo --out out

test: $(VENV)/.dev-stamp  ## the quick tests (about five minutes on two cores; less where what they compile is kept)
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal --hypothesis-profile=quick -q

test-full: $(VENV)/.dev-stamp  ## all tests, many random examples (half an hour on two cores); FULL=rest: less what `make test` ran alike
	KANE_FULL=$(FULL) $(BIN)/python -m pytest -n $(JOBS) --dist worksteal --hypothesis-profile=full -q --durations=15

test-package: $(VENV)/.dev-stamp  ## the wheel as users have it: alone, and at the lowest versions allowed
	bash requirements/package.sh $(PYTHON)

test-machines: $(VENV)/.dev-stamp  ## the quick tests as on older processors; what is made is the same there
	bash requirements/machines.sh

test-torch: $(VENV)/.dev-stamp  ## the tests of what is made for PyTorch, which it installs: 3 GB that other tests do without
	$(PIP) install "torch>=2.5"
	CI=true $(BIN)/python -m pytest -n 0 --hypothesis-profile=full -q tests/program/emit/test_languages.py tests/interop/test_autodiff.py tests/interop/test_native_torch.py -k torch

golden: $(VENV)/.dev-stamp  ## every system made anew, compared with tests/golden/golden.json.gz; SYSTEMS random ones
	$(BIN)/python -m tests.golden --jobs $(JOBS) --random $(SYSTEMS)

test-pythons: $(VENV)/.dev-stamp  ## the quick tests on the newest other Python, as on a Haswell; fewer on those between
	bash requirements/pythons.sh

check: $(VENV)/.dev-stamp  ## style, format, types, layers, length of functions
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --strict
	$(BIN)/lint-imports --no-logo
	$(BIN)/python requirements/structure.py

format: $(VENV)/.dev-stamp  ## rewrite the sources as `make check` wants them
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

docs: $(VENV)/.dev-stamp  ## the documentation, in docs/_build/html, and the listings of its pages
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	KANE_FULL=pages $(BIN)/python -m pytest -n $(JOBS) --dist worksteal -q tests/docs

figures: $(VENV)/.dev-stamp  ## pictures of the tutorials and of the gallery, and the gallery's page
	PYTHONPATH=. $(BIN)/python docs/make_figures.py

bench: $(VENV)/.dev-stamp  ## operation counts and timings
	$(BIN)/python benchmarks/run.py

bench-rhs: $(VENV)/.dev-stamp  ## right-hand sides against peers; write benchmarks/rhs.json and rhs.md
	$(BIN)/python -m benchmarks.rhs

bench-calls: $(VENV)/.dev-stamp  ## what calls from Python cost beside peers; write benchmarks/calls.json and calls.md
	$(BIN)/python -m benchmarks.calls

bench-trees: $(VENV)/.dev-stamp  ## trees against robotics engines, and growth; write benchmarks/trees.json and trees.md
	$(BIN)/python -m benchmarks.trees

bench-precision: $(VENV)/.dev-stamp  ## work and precision of motions, with Numba and diffrax beside; write benchmarks/precision.json and .md
	$(PIP) install "pip>=25.1"  # the first that knows groups
	$(PIP) install --group motions
	$(BIN)/python -m benchmarks.precision

bench-bicycle: $(VENV)/.dev-stamp  ## the Whipple bicycle beside SymPy; write benchmarks/bicycle.json and bicycle.md
	$(BIN)/python -m benchmarks.bicycle

bench-beams: $(VENV)/.dev-stamp  ## the spin-up of a beam beside Exudyn; write benchmarks/beams.json and beams.md
	$(BIN)/python -m benchmarks.beams

lock:  ## resolve the dependency groups anew into requirements/ (any machine with pip's index)
	bash requirements/lock.sh $(PYTHON)

clean:  ## remove everything made here, the environment too
	rm -rf $(VENV) out dist build docs/_build .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis .coverage htmlcov
	find src tests benchmarks examples docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

# The stamps: .run-stamp says that the run-time packages and kane itself are installed, .dev-stamp that all are.
# The second implies the first, so either order of `make demo` and `make test` does the least.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "kane needs Python 3.11 or later; set PYTHON=")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run-stamp: pyproject.toml requirements/run.txt | $(BIN)/python
	$(PIP) install --no-compile -r requirements/run.txt
	$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/.dev-stamp: pyproject.toml requirements/dev.txt requirements/run.txt | $(BIN)/python
	$(PIP) install --no-compile -r requirements/dev.txt
	$(PIP) install --no-deps --no-build-isolation -e .
	@touch $(VENV)/.run-stamp $@
