# Every target is self-contained: it makes .venv, installs what it needs once, and runs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
NODE := node_modules/.bin
BROWSER := '{anfis,fuzzy,robotics}/**/*.{js,css}' eslint.config.js
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

# JavaScript and CSS are checked where there is Node.js: nothing else needs it.
browser = @if command -v npm > /dev/null; then $(MAKE) --no-print-directory $(1); \
	else echo "JavaScript and CSS are skipped, because npm is not installed."; fi

.PHONY: venv demo design test lint lint-browser format format-browser bench clean

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

node_modules/.installed: package.json package-lock.json
	@echo "installing the tools that check the browser's code"
	@npm ci --silent --no-audit --no-fund
	@touch $@

venv: $(VENV)/.development

demo: $(VENV)/.runtime
	$(BIN)/robotics compare --out out

design: $(VENV)/.designer
	$(BIN)/fuzzy design $(FILE)

# Two workers at once would compile every kernel twice: one run compiles them while types are checked.
test: $(VENV)/.development
	@$(BIN)/robotics run chapter-6-simulation-3 --quiet > /dev/null & \
	$(MAKE) --no-print-directory lint; status=$$?; wait; exit $$status
	$(BIN)/python -m pytest

lint: $(VENV)/.development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(call browser,lint-browser)

format: $(VENV)/.development
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(call browser,format-browser)

lint-browser: node_modules/.installed
	$(NODE)/prettier --check --log-level warn $(BROWSER)
	$(NODE)/eslint anfis fuzzy robotics eslint.config.js

format-browser: node_modules/.installed
	$(NODE)/prettier --write --log-level warn $(BROWSER)

bench: $(VENV)/.peers
	$(BIN)/python -m benchmarks

clean:
	rm -rf $(VENV) node_modules out dist build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find fuzzy robotics tests benchmarks -name __pycache__ -type d -prune -exec rm -rf {} +
