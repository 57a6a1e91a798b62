"""A small study that runs until its effects are decided: killed, resumed, given more time."""

import json

import pandas as pd
import pytest

import small_study as small
from small_study import copy_sources, journal_keys, killed_after_one_analysis, planned_jobs, run

TARGETS = ("results/fragility/effects.parquet", "results/rounds.parquet")
DESIGN = "design: {until: decided, first: 6, step: 2, most: 10, hours: 2}"
OVER = f"{{results: results, analysis: {{duration_s: 2.0}}, {DESIGN}}}"


def plans(tree):
    found = [json.loads(path.read_text()) for path in (tree / "results/rounds").glob("*.json")]
    return sorted(found, key=lambda plan: plan["round"])


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    tree = copy_sources(tmp_path_factory.mktemp("rounds") / "tree")
    (tree / "over.yaml").write_text(OVER)
    configuration = ("--configfile", "config/smoke.yaml", "over.yaml")
    killed_after_one_analysis(tree, *configuration, "--", *TARGETS)
    run(tree, "--", *TARGETS, over=OVER)
    return tree


def test_rounds_have_plans_demands_and_the_verdicts_of_the_tables_and_repeat_no_analysis(study):
    found = plans(study)
    assert [plan["round"] for plan in found] == list(range(1, len(found) + 1))
    assert [plan["ended"] for plan in found[:-1]] == [None] * (len(found) - 1)
    assert found[-1]["ended"] in {"decided", "most"}
    for plan in found[:-1]:
        changed = [name for name, (start, end) in plan["motions"].items() if end > start]
        folder = study / f"results/demands/round{plan['round']}"
        assert sorted(path.stem for path in folder.iterdir()) == sorted(changed)
    keys = journal_keys(study)
    demands = pd.read_parquet(study / "results/demands.parquet")
    assert len(keys) == len(set(keys)) == len(demands) == sum(p["analyses"] for p in plans(study))
    assert demands.equals(demands.sort_values(["variant", "motion_id"], ignore_index=True))
    assert planned_jobs(study, OVER, *TARGETS) == set()
    command = [small.SNAKEMAKE.with_name("skewbridge"), "status", "--study", "results", "--json"]
    progress = small.done(command, study)
    assert json.loads(progress.stdout)["left"] == 0
    assert f"rounds ended after round {len(found) - 1}: " in progress.stderr
    plain = planned_jobs(study, "{results: plain}")
    assert "analyse" in plain
    assert not {name for name in plain if "round" in name}
    rounds = pd.read_parquet(study / "results/rounds.parquet")
    last = rounds[rounds["round"] == rounds["round"].max()]
    effects = pd.read_parquet(study / "results/fragility/effects.parquet")
    pooled = effects[effects["scope"] == "pooled"]
    both = last.merge(pooled, on=["demand", "axis", "to_value"], suffixes=("", "_table"))
    assert len(both) >= 4
    assert both["verdict"].tolist() == both["verdict_table"].tolist()
    assert both["ci_low"].tolist() == pytest.approx(both["ci_low_table"].tolist())
    assert json.loads((study / "results/checks.json").read_text())["passed"]


def test_more_time_resumes_a_study(study):
    """The last plan is replaced by one that ended for lack of time; a dry run deletes nothing."""
    last = study / f"results/rounds/round{len(plans(study))}.json"
    last.write_text(json.dumps(json.loads(last.read_text()) | {"ended": "hours"}))
    more = OVER.replace("hours: 2", "hours: 3")
    before = {path: path.read_bytes() for path in (study / "results").rglob("*.*")}
    dry = run(study, "-n", "--", *TARGETS, over=more)
    assert "checkpoint plan_round" in dry.stdout + dry.stderr
    assert {path: path.read_bytes() for path in before} == before
    done = run(study, "--", *TARGETS, over=more)
    assert f"round{len(plans(study))}.json" in done.stdout + done.stderr
    made = json.loads(last.read_text())
    assert made["hours"] == 3.0
    assert made["ended"] in {"decided", "most"}
    assert len(journal_keys(study)) == len(set(journal_keys(study)))
    assert planned_jobs(study, more, *TARGETS) == set()
