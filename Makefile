# Two commands do everything from a fresh clone: `make figures` and `make test`.
PYTHON  ?= python3
PROFILE ?= quick
JOBS    ?= 0
VENV    := .venv
PY      := $(VENV)/bin/python
READY   := $(VENV)/.ready

.PHONY: figures test test-slow lint types benchmark clean

figures: $(READY)
	$(PY) -m experiments run --all --profile $(PROFILE) --jobs $(JOBS)
	$(PY) -m paper_figs --profile $(PROFILE)

test: $(READY)
	$(PY) -m pytest -m "not slow" -n auto --dist loadscope

test-slow: $(READY)
	$(PY) -m pytest -m slow

lint: $(READY)
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .

types: $(READY)
	$(PY) -m mypy

benchmark: $(READY)
	$(PY) benchmarks/recursion.py
	$(PY) benchmarks/robust_fits.py
	$(PY) benchmarks/bearings.py
	$(PY) benchmarks/static_posterior.py
	$(PY) benchmarks/paths.py
	$(PY) benchmarks/tracks.py
	$(PY) benchmarks/registration.py

# rebuilt only when the lock or the project file changes
$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c "import sys; sys.exit(sys.version_info < (3, 11))" || \
	  { echo "probreg needs Python 3.11 or later; run: make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(PY) -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $(READY)

clean:
	rm -rf $(VENV) experiments/results paper_figs/out
