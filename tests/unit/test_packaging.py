"""Files for other tools: the catalogue of workflows, pre-commit, the picture of the rules."""

import re
from pathlib import Path

import yaml

from skewbridge.study.products import RECIPES

ROOT = Path(__file__).parents[2]


def test_the_catalogue_lists_the_workflow() -> None:
    settings = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert set(settings) == {"mandatory-flags", "software-stack-deployment", "report"}
    assert set(settings["mandatory-flags"]) == {"desc", "flags"}
    assert set(settings["software-stack-deployment"]) == {"conda", "apptainer", "apptainer+conda"}
    assert "snakemake workflow" in (ROOT / "README.md").read_text()
    assert all((ROOT / name).is_file() for name in ("workflow/Snakefile", "config/README.md"))


def test_pre_commit_has_the_locked_versions() -> None:
    locked = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(), re.M))
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    names = [each["repo"].rsplit("/")[-1].removesuffix("-pre-commit") for each in hooks]
    assert [each["rev"] for each in hooks] == [f"v{locked[name]}" for name in names]


def test_the_picture_of_the_rules_shows_those_of_the_report() -> None:
    """`make docs` draws it from the rule graph of Snakemake."""
    texts = re.findall(r">([a-z_]+)</text>", (ROOT / "docs/images/rules.svg").read_text())
    on_request = {"verification", "modelling_choices", "check_predict"}
    in_rounds = {"plan_round", "analyse_round", "collect_rounds"}
    assert set(texts) == RECIPES.keys() - on_request - in_rounds
