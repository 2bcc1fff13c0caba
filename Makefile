# Two commands do everything from a fresh clone: `make figures` and `make test`.
PYTHON  ?= python3
PROFILE ?= quick
JOBS    ?= 0
PYTHONS ?=
VENV    := .venv
PY      := $(VENV)/bin/python
PIP     := $(PY) -m pip install --quiet --disable-pip-version-check
READY   := $(VENV)/.ready
TORCH   := $(shell sed -n 's/^\(torch==[^ ]*\).*/\1/p' requirements.lock)

.PHONY: help figures test test-slow lint types benchmark check-install lock clean

help:  ## what there is to make (the default)
	@sed -n 's/^\([a-z-]*\):.*  ## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 24
	@echo "Settings: PYTHON=$(PYTHON) PROFILE=$(PROFILE) JOBS=$(JOBS) PYTHONS=\"$(PYTHONS)\""

figures: $(READY)  ## run the studies and draw every figure and table (PROFILE, JOBS)
	$(PY) -m experiments run --all --profile $(PROFILE) --jobs $(JOBS)
	$(PY) -m paper_figs --profile $(PROFILE)

test: $(READY)  ## the tests, but for the long statistical ones
	$(PY) -m pytest -m "not slow" -n auto --dist loadscope

test-slow: $(READY)  ## the long statistical tests
	$(PY) -m pytest -m slow

lint: $(READY)  ## style and format
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

types: $(READY)  ## types
	$(PY) -m mypy

benchmark: $(READY)  ## timings
	$(PY) benchmarks/recursion.py
	$(PY) benchmarks/robust_fits.py
	$(PY) benchmarks/bearings.py
	$(PY) benchmarks/static_posterior.py
	$(PY) benchmarks/paths.py
	$(PY) benchmarks/tracks.py
	$(PY) benchmarks/registration.py

check-install: $(READY)  ## the wheel in empty environments, newest dependencies (PYTHONS)
	$(PY) .ci/check_install.py $(PYTHONS)

lock:  ## write the locks afresh from pyproject.toml
	$(PYTHON) .ci/lock.py

# Rebuilt only when the lock or the project file changes. Torch comes first, by its own download:
# where pip knows hashes it prefers the index's CUDA build to a CPU build on disk. A CUDA build
# brings its libraries.
$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))" || \
	  { echo "probreg needs Python 3.11 or later; run: make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	rm -rf $(VENV)/torch
	$(PY) -m pip download --quiet --no-deps --dest $(VENV)/torch $(TORCH)
	$(PY) -m pip hash $(VENV)/torch/*.whl | grep -o "sha256:.*" | grep -qFf - requirements.lock
	$(PIP) --no-deps --no-index --find-links $(VENV)/torch $(TORCH)
	rm -r $(VENV)/torch
	$(PIP) --no-deps --require-hashes -r requirements.lock
	@if $(PY) -m pip check 2>/dev/null | grep -q "requires nvidia-"; then set -x; \
	  $(PIP) --no-deps --require-hashes -r requirements-cuda.lock; fi
	$(PIP) --no-deps --no-build-isolation -e .
	touch $(READY)

clean:  ## remove environment, results and figures
	rm -rf $(VENV) experiments/results paper_figs/out
