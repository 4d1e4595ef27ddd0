# Two commands on a fresh machine (python3 >= 3.11 with venv, git, make):
#   make walk    install, then walk three tripod cycles on virtual hardware
#   make test    install, then formatting, lint, types, import contracts and tests
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
# workers; in soak one more than cores, as many tests wait for ports and clocks
JOBS   ?= 2
SOAK_JOBS ?= 3

.PHONY: help install walk test check format lint types imports tests soak thorough constraints golden reliability figures docs-assets docs clean
help: ## list the targets
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; assert sys.version_info >= (3, 11), "Python 3.11 or newer is needed; try: make PYTHON=python3.12 ..."'
	@if command -v uv >/dev/null 2>&1; then \
	    uv venv --quiet --allow-existing --python $(PYTHON) $(VENV) && \
	    uv pip install --quiet --python $(BIN)/python -c constraints.txt -e '.[dev]'; \
	else \
	    $(PYTHON) -m venv $(VENV) && \
	    $(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check -c constraints.txt -e '.[dev]'; \
	fi
	@$(BIN)/python -m bigant.import_all # compiled copies of what is imported; pip would make 7,000
	@touch $(STAMP)

install: $(STAMP) ## make .venv with all that development needs (with uv if it is there)

walk: install ## walk three tripod cycles on virtual hardware and print distance, speed and slip
	$(BIN)/bigant drive --gait tripod --cycles 3 --log runs/first_walk.mcap
	$(BIN)/bigant show runs/first_walk.mcap

test: check ## the same as check

# First what takes seconds; types take as long as a tenth of the tests, and one core, so they run beside them.
check: install ## everything that must hold before a commit
	@$(MAKE) --no-print-directory --jobs 2 format lint imports
	@$(MAKE) --no-print-directory --jobs 2 types tests

format: install
	$(BIN)/ruff format --check .

lint: install
	$(BIN)/ruff check .

types: install
	$(BIN)/mypy

imports: install
	$(BIN)/lint-imports

# Compiled tests are kept: many containers set PYTHONDONTWRITEBYTECODE, and every worker compiles them again.
tests soak thorough: export PYTHONDONTWRITEBYTECODE =
tests: install
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal

soak: install ## tests of more than two seconds: whole diagnoses, first days, pages in a browser
	$(BIN)/python -m pytest -n $(SOAK_JOBS) --dist worksteal -m "soak and not thorough"

thorough: install ## statistics over many runs, whole data sets, a hundred thousand poses, many examples
	$(BIN)/python -m pytest -n $(JOBS) --dist worksteal -m thorough

constraints: ## write constraints.txt again (needs uv)
	uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --upgrade \
	    --no-annotate --no-header --no-emit-index-url --quiet --output-file constraints.txt

golden: install ## write the change indicators of tests/replay again; git diff then shows what changed
	$(BIN)/python -m tests.replay.golden

reliability: install ## run the fault matrix and write its table into docs/reliability.md
	$(BIN)/python -m benchmarks matrix

figures: install ## draw the figures of docs/ again
	for script in docs/plot_*.py; do $(BIN)/python $$script || exit 1; done

docs-assets: figures ## draw all figures, run the commands whose output README.md shows, and compare
	$(BIN)/python docs/write_outputs.py
	$(BIN)/python docs/write_model_page.py
	$(BIN)/python docs/draw_walk.py
	$(BIN)/python docs/draw_viewer.py
	$(BIN)/python docs/draw_pages.py

docs: install ## write docs/reference/ from the parser and the docstrings, and the pages of all modules in site/
	$(BIN)/python docs/write_cli_reference.py
	$(BIN)/python docs/write_modules_reference.py
	PYTHONPATH=. $(BIN)/python docs/write_gap_constants.py
	$(BIN)/python docs/write_site.py

clean: ## remove everything that was made
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis site runs
