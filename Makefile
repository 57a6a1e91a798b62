# Everything the project needs is installed by `make setup`; every other target depends on it.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

CORES ?= 2
CONFIG ?= config/config.yaml
MOTIONS ?=
PROFILE ?=
PYTHON_VERSION := $(shell cat .python-version)
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
# Two processes share two cores: more threads inside them only wait for each other.
export OMP_NUM_THREADS ?= 1

.PHONY: help setup study choices smoke test test-cluster lint bench verify verify-accuracy docs clean

help:
	@echo "make study        install everything, run the default study   (CONFIG=config/real.yaml MOTIONS=DIR for yours)"
	@echo "                  on a Slurm cluster with PROFILE=slurm: docs/cluster.md"
	@echo "make choices      the modeller's choices one at a time, beside friction, gap and skew"
	@echo "make test         install everything, run all checks"
	@echo "make test-cluster the smoke study through a real Slurm on this host (root, slurm-wlm, munge)"
	@echo "make smoke        two variants x three motions, full report"
	@echo "make verify       the paper's studies and statements against references, the hard set, and the slow tests"
	@echo "make verify-accuracy  effects of friction, gap and skew at default against reference: 1 to 2 hours, goes on"
	@echo "                  where it was broken off   (WHOLE=1 for motions of full length: 4 to 6 hours)"
	@echo "make bench        what things cost, as ratios: about 20 minutes   (FULL=1 for the full sets: hours)"
	@echo "make setup lint docs clean"

setup: $(STAMP)

# ASSUME a Python 3 with venv; uv brings Python $(PYTHON_VERSION) if the machine has none.
$(STAMP): requirements.lock pyproject.toml .python-version
	@bash workflow/setup.sh "$(PYTHON_VERSION)" "$(VENV)"
	@touch $@

study: setup
	@bash workflow/study.sh $(BIN) $(CORES) $(CONFIG) "$(MOTIONS)" all "$(PROFILE)"

choices: setup
	@bash workflow/study.sh $(BIN) $(CORES) $(CONFIG) "$(MOTIONS)" choices "$(PROFILE)"

smoke: setup
	@bash workflow/study.sh $(BIN) $(CORES) config/smoke.yaml

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python src
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/deptry src

test: setup lint
	$(BIN)/pytest -n $(CORES) --dist loadfile -m "not slow and not cluster" tests/workflow tests

# A Slurm of two nodes on this host, started and stopped by the test; skipped where it cannot be.
test-cluster: setup
	$(BIN)/pytest -rs -m cluster tests/cluster

verify: setup
	$(BIN)/skewbridge verify
	$(BIN)/pytest -n $(CORES) --dist loadfile -m slow

# Finished analyses stand in results/verification/accuracy*.jsonl and are not repeated.
verify-accuracy: setup
	$(BIN)/skewbridge verify accuracy$(if $(WHOLE),-whole)

bench: setup
	FULL=$(FULL) bash benchmarks/run.sh

docs: setup
	$(BIN)/python -m skewbridge.report.reference_pages

clean:
	rm -rf results .snakemake .bench
