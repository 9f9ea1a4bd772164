# Every target is self-contained: it makes .venv, installs what it needs once, and runs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: venv demo design test lint format bench clean

$(VENV)/.runtime: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "fuzzyfleet needs Python 3.11 or newer: make PYTHON=python3.11 ...")'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "installing into $(VENV) (only when pyproject.toml or constraints.txt changed)"
	@$(PIP) install -c constraints.txt -e .
	@touch $@

$(VENV)/.development: $(VENV)/.runtime
	@echo "installing the tools of the tests"
	@$(PIP) install -c constraints.txt -e '.[test]'
	@touch $@

$(VENV)/.peers: $(VENV)/.development
	@echo "installing the peers of the benchmarks"
	@$(PIP) install -c constraints.txt -e '.[bench]'
	@touch $@

$(VENV)/.designer: $(VENV)/.runtime
	@echo "installing the designer"
	@$(PIP) install -c constraints.txt -e '.[design]'
	@touch $@

venv: $(VENV)/.development

demo: $(VENV)/.runtime
	$(BIN)/robotics compare --out out

design: $(VENV)/.designer
	$(BIN)/fuzzy design $(FILE)

# Two workers at once would compile every kernel twice: one run compiles them while types are checked.
test: $(VENV)/.development
	@$(BIN)/robotics run trap-u --quiet > /dev/null & \
	$(MAKE) --no-print-directory lint; status=$$?; wait; exit $$status
	$(BIN)/python -m pytest

lint: $(VENV)/.development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(VENV)/.development
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(VENV)/.peers
	$(BIN)/python -m benchmarks

clean:
	rm -rf $(VENV) out dist build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find fuzzy robotics tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
