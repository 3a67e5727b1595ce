# The verbs of this repository. `make help` lists them.
# Needed: Python 3.11 or later, make, a C library. Everything else is installed into $(VENV).

PYTHON ?= python3
VENV ?= .venv
OUT ?= out
BIN := $(VENV)/bin
PY := $(BIN)/python
PYTEST_ARGS ?=

# Programs that write committed files. With --check they only compare. (The figure has no --check: the sets that it shows
# may grow or shrink with a new version of a library.)
GENERATORS := $(wildcard tools/bundle_schema.py tools/property_reference.py conformance/build_cases.py tools/annex_a.py)

.DEFAULT_GOAL := help
.PHONY: help setup demo test check lint types contracts generated cover bless bench site clean

help:  ## list the verbs
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

setup: $(VENV)/.installed  ## create the environment (done by every other verb)

$(VENV)/.installed: pyproject.toml validator/pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or later is needed; this is %d.%d. Name another: make PYTHON=python3.12" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install -qq --disable-pip-version-check --editable '.[dev]' --editable ./validator
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(PY) -m pip install -qq --disable-pip-version-check --editable '.[docs]'
	@touch $@

demo: setup  ## sample scene -> tileset -> verdict, with a table of what was made
	$(PY) tools/demo.py $(OUT)/demo

test: setup  ## every test; those that need npm or ../shared/data say so where they are skipped
	$(PY) -m pytest -rs $(PYTEST_ARGS)

check: lint types contracts generated  ## everything that is decided without running the tests

lint: setup  ## style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet tools benchmarks tests/external

types: setup  ## mypy --strict
	$(BIN)/mypy

contracts: setup  ## who may import whom
	$(BIN)/lint-imports

generated: setup  ## committed files that a program writes are what it would write now
	@set -e; for one in $(GENERATORS); do echo "$$one --check"; $(PY) $$one --check; done

cover: setup  ## branch coverage, with the kernels run as plain Python
	$(PY) tools/cover.py

bless: setup  ## write the generated and golden files anew; look at the diff before you commit it
	@set -e; for one in $(GENERATORS) tools/readme_figure.py; do echo "$$one"; $(PY) $$one; done

bench: setup  ## one table of times, each beside a peer in the same run
	$(PY) benchmarks/run.py

site: $(VENV)/.installed-docs  ## the documentation as a folder of pages, ./site
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "site/index.html"

clean:  ## remove what the verbs have made, except the environment
	rm -rf build dist site $(OUT) .coverage .mypy_cache .pytest_cache .ruff_cache .import_linter_cache
