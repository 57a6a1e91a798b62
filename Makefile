# Everything the project needs is installed by `make setup`; every other target depends on it.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

CORES ?= 2
CONFIG ?= config/config.yaml
MOTIONS ?=
RETRY ?=
RESULTS ?= results
PROFILE ?=
PYTHON_VERSION := $(shell cat .python-version)
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# Two processes share two cores: more threads inside them only wait for each other.
export OMP_NUM_THREADS ?= 1

.PHONY: help setup study choices check-predict headline smoke test test-browser test-cluster test-exports lint bench verify verify-accuracy audit mutants docs clean

help:
	@echo "make study        install everything, run the default study   (CONFIG=config/real.yaml MOTIONS=DIR for yours)"
	@echo "                  RETRY=failed tries analyses without a result again, RETRY=crash those that ended their process"
	@echo "                  on a Slurm cluster with PROFILE=slurm: docs/cluster.md"
	@echo "make choices      the modeller's choices one at a time, next to friction, gap and skew"
	@echo "make check-predict  error of predict inside the grid: three new variants, 16 motions each"
	@echo "make test         install everything, run all checks"
	@echo "make headline     table and picture of the README from a finished study   (RESULTS=folder)"
	@echo "make test-browser the page in a real browser   (needs chromium)"
	@echo "make test-cluster the smoke study through a real Slurm on this host (root, slurm-wlm, munge)"
	@echo "make test-exports  exported curves read by pelicun and OpenQuake, in environments of their own"
	@echo "make smoke        two variants x three motions, full report"
	@echo "make verify       the paper's studies and statements against references, the hard set, and the slow tests"
	@echo "make verify-accuracy  effects of friction, gap and skew at default against reference: 1 to 2 hours, goes on"
	@echo "                  where it was broken off   (WHOLE=1 for motions of full length: 4 to 6 hours)"
	@echo "make bench        what things cost, as ratios: about 20 minutes   (FULL=1 for the full sets: hours)"
	@echo "make audit        known vulnerabilities of the locked packages   (skipped where PyPI cannot be asked)"
	@echo "make mutants      do the tests notice? 200 small changes of the sources; hours, goes on where it was broken off"
	@echo "make docs         reference pages from the code, and the documentation site in docs/_build/html"
	@echo "make setup lint clean"

setup: $(STAMP)

# ASSUME a Python 3 with venv; uv brings Python $(PYTHON_VERSION) if the machine has none.
$(STAMP): requirements.lock pyproject.toml .python-version
	@bash workflow/setup.sh "$(PYTHON_VERSION)" "$(VENV)"
	@touch $@

study: setup
	@bash workflow/study.sh $(BIN) $(CORES) $(CONFIG) "$(MOTIONS)" all "$(RETRY)" "$(PROFILE)"

choices: setup
	@bash workflow/study.sh $(BIN) $(CORES) $(CONFIG) "$(MOTIONS)" choices "" "$(PROFILE)"

check-predict: setup
	@bash workflow/study.sh $(BIN) $(CORES) $(CONFIG) "$(MOTIONS)" predict_check "" "$(PROFILE)"

headline: setup
	$(BIN)/python docs/headline.py $(RESULTS)

smoke: setup
	@bash workflow/study.sh $(BIN) $(CORES) config/smoke.yaml

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python src
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/deptry src

test: setup lint
	$(BIN)/pytest -n $(CORES) --dist loadfile \
		-m "not slow and not browser and not cluster and not exports" tests/workflow tests

# The page of a study in Chromium at two widths; skipped, with the reason, where there is none.
test-browser: setup
	@VIRTUAL_ENV=$(VENV) $$(command -v uv || echo .uv/bin/uv) pip install --quiet --require-hashes --requirement workflow/browser.txt
	$(BIN)/pytest -rs -m browser tests/browser

# A Slurm of two nodes on this host, started and stopped by the test; skipped where it cannot be.
test-cluster: setup
	$(BIN)/pytest -rs -m cluster tests/cluster

# In .exports stand pelicun and OpenQuake; what cannot be installed is skipped.
test-exports: setup
	bash tests/exports/setup.sh "$$(command -v uv || echo .uv/bin/uv)" $(abspath $(BIN))/python .exports
	$(BIN)/pytest -rs -m exports tests/exports

verify: setup
	$(BIN)/skewbridge verify
	$(BIN)/pytest -n $(CORES) --dist loadfile -m slow

# Finished analyses stand in results/verification/accuracy*.jsonl and are not repeated.
verify-accuracy: setup
	$(BIN)/skewbridge verify accuracy$(if $(WHOLE),-whole)

bench: setup
	FULL=$(FULL) bash benchmarks/run.sh

audit: setup
	@bash workflow/audit.sh $(BIN)
# Finished changes stand in results/mutants/mutants.jsonl and are not repeated; hours for all.
mutants: setup
	nice -n 10 $(BIN)/python benchmarks/mutants.py
	$(BIN)/python benchmarks/mutants.py --table docs/mutants.md

# The site stands in docs/_build/html; a warning is an error.
docs: setup
	$(BIN)/python docs/reference_pages.py
	$(BIN)/python docs/commands_page.py
	$(BIN)/python workflow/licences.py requirements.lock > docs/licences.md
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going -c docs . docs/_build/html

clean:
	rm -rf results .snakemake .bench docs/_build
