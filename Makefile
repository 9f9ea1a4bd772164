# Every target is self-contained: it makes .venv, installs what it needs once, and runs. `make help` lists them.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
NODE := node_modules/.bin
NOTES := $(VENV)/notes
AGAIN := -p tests.again --notes $(NOTES)
BROWSER := '{anfis,fuzzy,robotics}/**/*.{js,css}' eslint.config.js
# What the tests of the core need, and where they are: no designer, no plug-ins of robotics.
TESTING := array-api-strict build hatchling hypothesis psutil pytest pytest-timeout pytest-xdist scikit-learn shapely
CORE := tests/fuzzy tests/anfis tests/robotics/world tests/robotics/simulation --ignore=tests/fuzzy/plugins/designer --ignore=tests/anfis/plugins
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
# Tests and examples start Python more than a hundred times: each time it would read every module's text anew.
export PYTHONDONTWRITEBYTECODE :=

# JavaScript and CSS are checked where there is a Node.js that eslint runs on: nothing else needs it.
NEW_ENOUGH := const [a, b] = process.versions.node.split(".").map(Number); process.exit(a > 20 || (a === 20 && b > 18) ? 0 : 1)
browser = +@if command -v npm > /dev/null && node -e '$(NEW_ENOUGH)'; then $(MAKE) --no-print-directory $(1); \
	else echo "JavaScript and CSS are skipped, because Node.js 20.19 or newer with npm is not installed."; fi

.DEFAULT_GOAL := help
.PHONY: help venv wheel release oldest demo design docs test test-notebook test-scale check-all lint lint-style lint-types lint-scripts lint-browser format format-browser bench clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-13s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

$(VENV)/.runtime: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "fuzzyfleet needs Python 3.11 or newer: make PYTHON=python3.11 ...")'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "installing into $(VENV) (only when pyproject.toml or constraints.txt changed)"
	@$(PIP) install -c constraints.txt -e .
	@touch $@

# By two processes, where tests and commands would compile by one; what changes later is compiled when it runs.
$(VENV)/.kernels: | $(VENV)/.runtime
	@echo "compiling the kernels of every day, once, for some minutes: tail $(VENV)/kernels.log tells how far"
	@$(BIN)/python -m kernels --here > $(VENV)/kernels.log 2>&1 || true
	@touch $@

$(VENV)/.development: $(VENV)/.runtime
	@echo "installing the tools of the tests"
	@$(MAKE) --no-print-directory $(VENV)/.kernels & \
	$(PIP) install -c constraints.txt -e '.[test]'; installed=$$?; wait; exit $$installed
	@$(PIP) install -c constraints.txt -e '.[ros]' 2> $(VENV)/ros.log || \
		echo "ROS 2 cannot be installed here, and the tests that need it will be skipped: see $(VENV)/ros.log"
	@touch $@

$(VENV)/.peers: $(VENV)/.development
	@echo "installing the peers of the benchmarks"
	@$(PIP) install -c constraints.txt -e '.[bench]'
	@touch $@

$(VENV)/.release: $(VENV)/.development
	@echo "installing the tools of a release"
	@$(PIP) install -c constraints.txt -e '.[release]'
	@touch $@

$(VENV)/.notebooks: $(VENV)/.development
	@echo "installing JupyterLab"
	@$(PIP) install -c constraints.txt -e '.[jupyter]'
	@touch $@

$(VENV)/.everything: $(VENV)/.development
	@echo "installing what the long tests need: Sphinx, JupyterLab, CasADi"
	@$(BIN)/robotics run three-cross -c fuzzy-team --quiet > /dev/null 2>&1 & \
	$(PIP) install -c constraints.txt -e '.[docs,jupyter,mpc]'; installed=$$?; wait; exit $$installed
	@touch $@ $(VENV)/.docs $(VENV)/.notebooks

$(VENV)/.docs: $(VENV)/.runtime
	@echo "installing Sphinx"
	@$(BIN)/robotics run trap-u --quiet > /dev/null 2>&1 & \
	$(PIP) install -c constraints.txt -e '.[docs]'; installed=$$?; wait; exit $$installed
	@touch $@

$(VENV)/.designer: $(VENV)/.runtime
	@echo "installing the designer"
	@$(PIP) install -c constraints.txt -e '.[design]'
	@touch $@

node_modules/.installed: package.json package-lock.json
	@echo "installing the tools that check the browser's code"
	@npm ci --silent --no-audit --no-fund
	@touch $@

venv: $(VENV)/.development ## the environment of the tests

demo: $(VENV)/.kernels ## compare controllers, teams and formations: out/report.html, out/tasks/tasks.html
	$(BIN)/robotics compare --out out
	$(BIN)/robotics arena tasks-demo --out out/tasks

design: $(VENV)/.designer ## the designer in a browser: make design FILE=go.fis
	$(BIN)/fuzzy design $(FILE)

# Types and scripts are checked while the tests run; what was found is printed after them. Two workers at once would
# compile every kernel twice, here and for the site, so one run compiles them first.
test: $(VENV)/.development lint-style ## lint, types and tests: the gate of every commit
	@$(MAKE) --no-print-directory lint-types lint-scripts > $(VENV)/lint.log 2>&1 & lint=$$!; \
	$(BIN)/robotics run trap-u --quiet > /dev/null; \
	$(BIN)/python -m pytest $(NOTED); tested=$$?; \
	wait $$lint; linted=$$?; cat $(VENV)/lint.log; exit $$((tested | linted))

test-notebook: $(VENV)/.notebooks ## the widgets in a real JupyterLab, which is installed for this
	$(BIN)/python -m pytest -n 0 -m long tests/fuzzy/plugins/designer/test_jupyterlab.py

test-scale: $(VENV)/.everything ## before a release: what the long tests try, with all cases
	$(BIN)/python -m pytest -m scale

# The site is made beside the long tests, which often wait (so four at a time); what looks at it comes after both. A
# browser test that fails is run once more by itself; skipped and flaky tests are named at the end.
check-all: $(VENV)/.everything ## make test, the site, the tests marked long, and every random case
	@rm -f $(NOTES) && touch $(NOTES)
	@$(MAKE) --no-print-directory test NOTED='$(AGAIN)'
	@$(MAKE) --no-print-directory docs > $(VENV)/docs.log 2>&1 & docs=$$!; \
	EVERY_RANDOM_CASE=1 $(BIN)/python -m pytest $(AGAIN) -n 4 -m 'long or hypothesis' --ignore=tests/test_site.py; tested=$$?; \
	wait $$docs; made=$$?; cat $(VENV)/docs.log; \
	EVERY_RANDOM_CASE=1 $(BIN)/python -m pytest $(AGAIN) -m 'long or hypothesis' tests/test_site.py; seen=$$?; \
	$(BIN)/python -m tests.again $(NOTES); exit $$((tested | made | seen))

lint: $(VENV)/.development ## what the tools say: ruff, mypy, prettier, eslint
	@$(MAKE) --no-print-directory lint-style
	@$(MAKE) --no-print-directory -j2 --output-sync=target lint-types lint-scripts

lint-style: $(VENV)/.development
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

lint-types: $(VENV)/.development
	$(BIN)/mypy

lint-scripts:
	$(call browser,lint-browser)

format: $(VENV)/.development ## mend what ruff can mend
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(call browser,format-browser)

lint-browser: node_modules/.installed
	$(NODE)/prettier --check --log-level warn $(BROWSER)
	$(NODE)/eslint anfis fuzzy robotics eslint.config.js

format-browser: node_modules/.installed
	$(NODE)/prettier --write --log-level warn $(BROWSER)

# The kernels take minutes; those that are there are not compiled again.
wheel: $(VENV)/.development ## both wheels and the source archive: dist/
	$(BIN)/python -m kernels
	$(BIN)/python -m build
	FUZZYFLEET_KERNELS=build/kernels/wheel $(BIN)/python -m build --wheel

# The check comes first, and refuses placeholders and what is not committed: make release REHEARSAL=1 goes on.
release: $(VENV)/.release ## all that is published, built, tried and listed: dist/
	$(BIN)/python -m release check $(if $(REHEARSAL),--rehearsal)
	rm -rf dist
	@$(MAKE) --no-print-directory wheel
	$(BIN)/python -m twine check --strict dist/*.whl dist/*.tar.gz
	$(BIN)/python -m release try
	$(BIN)/python -m release notes

# Kernels of another Numba would push those of this environment off the disk; old packages warn of each other.
oldest: export NUMBA_CACHE_DIR = $(CURDIR)/build/oldest/kernels
oldest: $(VENV)/.runtime ## the tests of the core with the oldest packages that are allowed
	@$(PYTHON) -m venv build/oldest && $(BIN)/python -m release oldest > build/oldest/constraints.txt
	@build/oldest/bin/python -m pip --disable-pip-version-check install -q -c build/oldest/constraints.txt -e . $(TESTING)
	build/oldest/bin/python -m pytest -W default -m 'not long and not scale and not browser' $(CORE)

docs: $(VENV)/.docs ## the site, whose examples run and draw while it is made: docs/_build/html/index.html
	@$(BIN)/robotics run trap-u --quiet > /dev/null
	$(BIN)/python -m sphinx -j 2 -W --keep-going -q -b html -d docs/_build/doctrees docs docs/_build/html
	@echo "open docs/_build/html/index.html"

bench: $(VENV)/.peers ## speed, beside other packages
	$(BIN)/python -m benchmarks

clean: ## remove what the targets made, compiled kernels included
	rm -rf $(VENV) node_modules out dist build *.egg-info ros/build ros/*.egg-info docs/_build docs/gallery docs/howto/designer/made docs/interactive/made docs/paper/made docs/reference/made .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find anfis benchmarks datasets docs examples fuzzy kernels release robotics ros tests -name __pycache__ -type d -prune -exec rm -rf {} +
