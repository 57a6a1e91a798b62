# The study as a DAG: motions -> contact gate -> analyses -> demands -> fits -> figures -> report.
import sys
from pathlib import Path

from snakemake.utils import min_version

min_version("9.20")

# Rules, scripts and workers import the package of this tree, whatever is installed.
SOURCES = str(Path(workflow.basedir) / "src")
sys.path.insert(0, SOURCES)
# Ctrl-C is for the main process, which ends all others.
shell.prefix(f"trap '' INT; export PYTHONPATH={SOURCES}; ")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/motions.smk"
include: "workflow/rules/verify.smk"
include: "workflow/rules/demands.smk"
include: "workflow/rules/fragility.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        study_products,


rule choices:
    input:
        choice_products,


rule predict_check:
    input:
        predict_check_products,


tell_rules(config, {rule.name: dict(rule.params) for rule in workflow.rules}, MOTIONS)
