# Two commands do everything from a clean checkout: `make review` and `make test`.
# Needed beforehand: make, and Python 3.11 or newer with venv (on Debian 12: apt install make python3-venv). What else the
# tests need is fetched; a browser too where there is none (tests/e2e/chromium.py).
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
HOME_DIR ?= out/review
ARGS ?=
# Three at a time keep two cores busy, since some wait. A file of tests stays in one process, as its fixtures are
# shared, and tests/conftest.py says which file comes first.
TOGETHER ?= 3
KILLS ?= 200
HOURS ?= 1
SEED ?= 1
FUZZ ?= 40
PYTEST := $(VENV)/bin/python -m pytest --numprocesses $(TOGETHER) --dist loadfile --no-loadscope-reorder
ORACLES ?= .oracles
# PyTorch without CUDA; where this does not answer, pip's usual index is asked.
TORCH_INDEX ?= https://download.pytorch.org/whl/cpu
NODE := $(BIN)/node

.DEFAULT_GOAL := help
.PHONY: help install review test test-quick test-long attack oracles lint lint-ruff lint-types lint-js wheel wheel-check screenshots sample bench bench-speed clean

help: ## print this help
	@echo "Usage: make TARGET"
	@grep -E '^[a-z-]+:.*## ' $(firstword $(MAKEFILE_LIST)) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 16 | sed 's/^/  /'

$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("tsr needs Python 3.11 or newer, this is %d.%d. Name another one: make PYTHON=python3.12 ..." % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) cannot make environments. On Debian: apt install python3-venv"; exit 1; }
	@echo "Installing tsr into $(VENV), once; this takes a few minutes ..."
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@echo "Compiling the numeric kernels and trying the engine on the sample drive, once; about a minute ..."
	@$(BIN)/tsr track "$$($(BIN)/python -c 'from sample_videos import SHIPPED; print(SHIPPED[0].video)')" --frames :120 > /dev/null
	@touch $@

$(VENV)/.tools: package.json $(VENV)/.installed
	@$(BIN)/npm install --no-package-lock --no-audit --no-fund --loglevel=error
	@touch $@

install: $(VENV)/.installed ## make the environment (VENV, default .venv)

review: $(VENV)/.installed ## open the review tool on the sample drive (HOME_DIR, default out/review; ARGS for tsr review)
	$(BIN)/tsr review --home $(HOME_DIR) $(ARGS)

# The tests in JavaScript mostly wait, so they run beside the others.
test: $(VENV)/.installed $(VENV)/.tools ## all tests; TSR_DATA names the real data, CHROMIUM a browser (unset: found, or fetched)
	@$(NODE) --test --test-isolation=none --test-reporter=spec 'tests/js/**/*.test.js' > $(VENV)/js-tests.log 2>&1 & js=$$!; \
	CHROMIUM="$$($(BIN)/python -m tests.e2e.chromium)" $(PYTEST) --durations 25 --durations-min 5; code=$$?; \
	wait $$js || code=1; echo "Tests of the page without a browser:"; grep -v '^✔' $(VENV)/js-tests.log; exit $$code

test-quick: $(VENV)/.installed ## the tests that need no browser and no packages besides Python's
	$(PYTEST) --ignore tests/e2e

test-long: $(VENV)/.installed ## the tests with random examples on new ones; FUZZ requests a route and phase
	TSR_FUZZ=$(FUZZ) TSR_EXPLORE=1 $(PYTEST) $$(grep -rl --include 'test_*.py' '@given' tests)

attack: $(VENV)/.installed ## attack a server for hours: kills, damaged imports, full memory, disks, clocks (KILLS, HOURS, SEED)
	$(BIN)/python -m tests.attack.campaign --kills $(KILLS) --hours $(HOURS) --seed $(SEED)
	TSR_TREE=. $(BIN)/python -m pytest tests/attack/test_from_outside.py

# The other libraries want versions of their own, so they get an environment of their own (2 GB with PyTorch).
$(ORACLES)/.installed: tests/oracles/requirements.txt
	@echo "Installing the other libraries into $(ORACLES), once; this takes some minutes ..."
	@$(PYTHON) -m venv $(ORACLES)
	@$(ORACLES)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --index-url $(TORCH_INDEX) \
		$$(grep '^torch' $<) || echo "$(TORCH_INDEX) does not have it; asking the usual index, which may bring CUDA along."
	@$(ORACLES)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	@touch $@

$(ORACLES)/label-studio/.installed: tests/oracles/requirements-label-studio.txt $(ORACLES)/.installed
	@$(PYTHON) -m venv $(ORACLES)/label-studio
	@$(ORACLES)/label-studio/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	@touch $@

oracles: $(VENV)/.installed $(ORACLES)/.installed $(ORACLES)/label-studio/.installed ## let other libraries judge exports and imports (ORACLES, default .oracles)
	TSR_ORACLES=$(abspath $(ORACLES))/bin/python $(BIN)/python -m pytest tests/oracles

lint: lint-ruff lint-types lint-js ## style, types, layers

lint-ruff: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

lint-types: $(VENV)/.installed
	$(BIN)/mypy
	$(BIN)/lint-imports

lint-js: $(VENV)/.installed $(VENV)/.tools
	$(NODE) node_modules/typescript/bin/tsc -p tsconfig.json
	$(NODE) node_modules/typescript/bin/tsc -p tsconfig.pure.json
	$(NODE) node_modules/typescript/bin/tsc -p tsconfig.tests.json
	$(NODE) node_modules/eslint/bin/eslint.js static/js tests/js eslint.config.js
	$(NODE) node_modules/prettier/bin/prettier.cjs --check .

wheel: $(VENV)/.installed ## wheel and source archive into ./dist
	$(BIN)/python -m build --outdir dist

wheel-check: wheel ## the wheel in empty environments: tsr track with the base, tsr review with [all]
	$(BIN)/python -m tests.packaging.wheel_check dist

screenshots: $(VENV)/.installed ## pictures of every screen into ./out/screenshots (needs Chromium)
	$(BIN)/python -m tests.e2e.screenshots --out out/screenshots

sample: $(VENV)/.installed ## render a new sample drive with exact truth into ./out/sample
	$(BIN)/tsr sample --out out/sample

bench-speed: $(VENV)/.installed ## time the engine by stage; GTSDB=folder adds the detector on its scenes
	$(BIN)/tsr track "$$($(BIN)/python -c 'from sample_videos import SHIPPED; print(SHIPPED[0].video)')" --timing
	$(if $(GTSDB),$(BIN)/python -m benchmarks.timing.detection --gtsdb $(GTSDB))

bench: $(VENV)/.installed ## benchmarks/REPORT.md anew; GTSDB=, GTSRB=, CLIPS=, LOOMING=, TUNING=, BOARDS=, BEFORE=, FOREIGN=, DRIVES= name the data, ONLY= some experiments
	$(BIN)/python -m benchmarks $(ONLY) $(if $(GTSDB),--gtsdb $(GTSDB)) $(if $(GTSRB),--gtsrb $(GTSRB)) \
		$(if $(CLIPS),--clips $(CLIPS)) $(if $(LOOMING),--looming $(LOOMING)) $(if $(TUNING),--tuning $(TUNING)) $(if $(BOARDS),--boards $(BOARDS)) \
		$(if $(BEFORE),--before $(BEFORE)) $(if $(FOREIGN),--foreign $(FOREIGN)) $(if $(DRIVES),--drives $(DRIVES))

clean: ## remove the environment and what was generated
	rm -rf $(VENV) $(ORACLES) out runs .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
