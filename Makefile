# Everything the project needs is installed by `make setup`; every other target depends on it.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

CORES ?= 2
CONFIG ?= config/config.yaml
MOTIONS ?=
RETRY ?=
# true or false: draw random properties or not, whatever the configuration says
UNCERTAINTY ?=
export UNCERTAINTY
RESULTS ?= results
PROFILE ?=
UNTIL ?=
PYTHON_VERSION := $(shell cat .python-version)
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# Two processes share two cores: more threads inside them only wait for each other.
export OMP_NUM_THREADS ?= 1
# Otherwise every process compiles the packages that it imports.
unexport PYTHONDONTWRITEBYTECODE
LINTERS := lint-pyright lint-ruff lint-snakemake lint-starter lint-deptry

.PHONY: help setup study choices headline smoke demo-data test test-browser test-cluster test-exports lint $(LINTERS) bench verify verify-accuracy audit mutants docs clean

help:
	@echo "make study        install, run the default study   (CONFIG=config/real.yaml MOTIONS=DIR for yours)"
	@echo "                  RETRY=failed repeats failed analyses, RETRY=crash those that ended their process"
	@echo "                  UNCERTAINTY=true draws random properties of the bridge for each motion, false does not"
	@echo "                  UNTIL=decided selects analyses in rounds until the effects are decided"
	@echo "                  PROFILE=slurm runs on a Slurm cluster: docs/cluster.md"
	@echo "make choices      compare other modelling choices with friction, gap and skew"
	@echo "make test         install, run all checks"
	@echo "make headline     write sentences, table and picture of the README from a finished study   (RESULTS=folder)"
	@echo "make test-browser test the page in a browser   (needs chromium)"
	@echo "make test-cluster run the smoke study through Slurm on this host   (root, slurm-wlm, munge)"
	@echo "make test-exports read exported curves with pelicun and OpenQuake; validate the archive"
	@echo "make smoke        run two variants x three motions with the full report"
	@echo "make demo-data    run config/demo.yaml and store it for skewbridge demo"
	@echo "make verify       compare the paper's studies with references, run the stress cases and slow tests"
	@echo "make verify-accuracy  effects at the default against the reference accuracy: 1 to 2 hours, can be resumed"
	@echo "make bench        measure costs as ratios: about 20 minutes   (FULL=1 for the full sets: hours)"
	@echo "make audit        check locked packages for known vulnerabilities   (skipped without PyPI)"
	@echo "make mutants      test the tests with 200 small changes of the sources: hours, can be resumed"
	@echo "make docs         write keys and schemas of config/, build the site in docs/_build/html"
	@echo "make setup lint clean"

setup: $(STAMP)
	@$(if $(filter setup,$(MAKECMDGOALS)),echo "setup: done. Next: make smoke (a minute) or make study (about 16 minutes); the page is report.html in results")

# ASSUME a Python 3 with venv; uv brings Python $(PYTHON_VERSION) if the machine has none.
$(STAMP): requirements.lock workflow/recorded.txt pyproject.toml .python-version
	@bash workflow/setup.sh "$(PYTHON_VERSION)" "$(VENV)"
	@touch $@

study: setup
	@bash workflow/study.sh $(BIN) $(CORES) "$(CONFIG)" "$(MOTIONS)" all "$(RETRY)" "$(PROFILE)" "$(UNTIL)"

choices: setup
	@bash workflow/study.sh $(BIN) $(CORES) "$(CONFIG)" "$(MOTIONS)" choices "" "$(PROFILE)"

headline: setup
	$(BIN)/python docs/headline.py "$(RESULTS)"

smoke: setup
	@bash workflow/study.sh $(BIN) $(CORES) config/smoke.yaml

# Tables and pictures that `skewbridge demo` shows.
demo-data: setup
	@bash workflow/study.sh $(BIN) $(CORES) config/demo.yaml
	$(BIN)/python workflow/demo_data.py results/demo

# As many at a time as there are cores; each prints its messages in one piece, none stops another.
lint: setup
	@$(MAKE) --no-print-directory --jobs=$(CORES) --output-sync=target --keep-going $(LINTERS)

lint-pyright: setup
	$(BIN)/pyright --pythonpath $(BIN)/python src
lint-ruff: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
lint-snakemake: setup
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint
lint-starter: setup
	$(BIN)/snakemake --lint --directory .test
lint-deptry: setup
	$(BIN)/deptry src

# Files run in this order, the folders of the longest tests first, so that at the end no process runs
# alone: xdist would begin with the files of most tests, and pytest sorts the folders of `tests`.
TESTS := $(addprefix tests/,workflow verification faults unit property recorded)
test: setup lint
	$(BIN)/pytest -n $(CORES) --dist loadfile --no-loadscope-reorder \
		-m "not slow and not browser and not cluster and not exports" $(TESTS)

# The page of a study in Chromium at two widths; skipped, with the reason, where there is none.
test-browser: setup
	@VIRTUAL_ENV=$(VENV) "$$(command -v uv || echo .uv/bin/uv)" pip install --quiet --require-hashes --requirement workflow/browser.txt
	$(BIN)/pytest -rs -m browser tests/browser

# A Slurm of two nodes on this host, started and stopped by the test; skipped where it cannot be.
test-cluster: setup
	$(BIN)/pytest -rs -m cluster tests/cluster

# pelicun, OpenQuake and the RO-Crate validator go into .exports; what cannot be installed is skipped.
test-exports: setup
	bash tests/exports/setup.sh "$$(command -v uv || echo .uv/bin/uv)" "$$PWD/$(BIN)/python" .exports
	$(BIN)/pytest -rs -m exports tests/exports tests/unit/test_cli_study.py

verify: setup
	$(BIN)/skewbridge verify
	$(BIN)/pytest -n $(CORES) --dist loadfile -m slow

# Finished analyses are in a journal and are not repeated.
verify-accuracy: setup
	$(BIN)/skewbridge verify accuracy

bench: setup
	FULL=$(FULL) bash benchmarks/run.sh

audit: setup
	@bash workflow/audit.sh $(BIN)
# Finished changes are in results/mutants/mutants.jsonl and are not repeated.
mutants: setup
	nice -n 10 $(BIN)/python benchmarks/mutants.py
	$(BIN)/python benchmarks/mutants.py --table results/mutants/report.md

# The site is in docs/_build/html; a warning is an error.
docs: setup
	$(BIN)/python docs/reference_pages.py
	$(BIN)/snakemake --rulegraph -- report | $(BIN)/python docs/rule_graph.py docs/images/rules.svg
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -c docs . docs/_build/html
	cp docs/gallery/images/sphx_glr_plot_bridge_001.png docs/theory/bridge_model.png

clean:
	rm -rf results .snakemake .bench docs/_build
