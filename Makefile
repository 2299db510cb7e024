# Two commands do everything from a clean checkout: `make review` and `make test`.
# Needed beforehand: make, and Python 3.11 or newer with venv (on Debian 12: apt install make python3-venv).
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
REVIEW := out/review

.DEFAULT_GOAL := help
.PHONY: help install review test lint sample bench-speed clean

help: ## print this help
	@echo "Usage: make TARGET"
	@grep -E '^[a-z-]+:.*## ' $(firstword $(MAKEFILE_LIST)) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 16 | sed 's/^/  /'

$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("tsr needs Python 3.11 or newer, this is %d.%d. Name another one: make PYTHON=python3.12 ..." % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) cannot make environments. On Debian: apt install python3-venv"; exit 1; }
	@echo "Installing tsr into $(VENV), once; this takes a few minutes ..."
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

install: $(VENV)/.installed ## make the environment (VENV, default .venv)

review: $(VENV)/.installed ## run the engine on a shipped sample drive; results in ./out/review
	@VIDEO=$$($(BIN)/python -c 'from sample_videos import SHIPPED; print(SHIPPED[0].video)') && \
	mkdir -p $(REVIEW) && \
	echo "Tracking the signs of $$VIDEO ..." && \
	$(BIN)/tsr track "$$VIDEO" --restart --evidence $(REVIEW)/evidence --csv $(REVIEW)/tracks.csv \
	    --video $(REVIEW)/annotated.mp4 --timing > $(REVIEW)/summary.txt && \
	cat $(REVIEW)/summary.txt && \
	echo "Results in $(CURDIR)/$(REVIEW): play annotated.mp4 in any video player, open tracks.csv in a spreadsheet, read summary.txt; go on with '$(BIN)/tsr replay $(REVIEW)/evidence --set tau=25'."

test: $(VENV)/.installed ## all tests; those on real data run where TSR_DATA names it
	$(BIN)/python -m pytest

lint: $(VENV)/.installed ## style, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

sample: $(VENV)/.installed ## render a new sample drive with exact truth into ./out/sample
	$(BIN)/tsr sample --out out/sample

bench-speed: $(VENV)/.installed ## time the engine by stage; GTSDB=folder adds the detector on its scenes
	$(BIN)/tsr track "$$($(BIN)/python -c 'from sample_videos import SHIPPED; print(SHIPPED[0].video)')" --timing
	$(if $(GTSDB),$(BIN)/python benchmarks/detection_speed.py --gtsdb $(GTSDB))

clean: ## remove the environment and what was generated
	rm -rf $(VENV) out runs .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
