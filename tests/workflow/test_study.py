"""The whole study in a copied tree: killed, resumed, run again, changed."""

import json
import shutil
import subprocess

import pandas as pd
import pyarrow.parquet as pq
import pytest

import small_study as small
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.study.processes import LOCK_NAME

SLUGS = ("osb1_cf_skew30_gap025_mu000", "osb1_cf_skew30_gap025_mu050")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    tree = small.copy_sources(tmp_path_factory.mktemp("study") / "tree")
    smoke = tree / "config/smoke.yaml"
    text = smoke.read_text().replace("duration_s: 10.0", "duration_s: 4.0")
    smoke.write_text(f"results: results\n{text}")
    small.killed_after_one_analysis(tree, "--configfile", "config/smoke.yaml")
    (tree / "killed.json").write_text(json.dumps(small.journal_keys(tree)))
    # The same command again; its locks are the tree's, so that those of the killed run are stale.
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    again = small.command("--configfile", "config/smoke.yaml")
    resumed = subprocess.Popen(again, cwd=tree, **given)
    lock = tree / ".snakemake" / LOCK_NAME
    assert small.wait_for(lambda: lock.read_text() == str(resumed.pid), 120)
    second = small.run(tree, over="results: elsewhere", check=False)
    (tree / "second.log").write_text(f"{resumed.pid}\n{second.stdout}{second.stderr}")
    smoke.write_text(smoke.read_text() + "# a note\n")
    printed, _ = resumed.communicate()
    (tree / "resumed.log").write_text(printed)
    if resumed.returncode != 0:
        pytest.fail(printed)
    shutil.rmtree(tree / "elsewhere")
    return tree


def test_a_second_run_stops_and_a_killed_study_repeats_nothing_and_is_complete(study):
    """Whatever folder the second run writes to."""
    holder, *printed = (study / "second.log").read_text().strip().splitlines()
    assert printed[-1].startswith(f"another study is running in {study} (process {holder})")
    assert "Traceback" not in "".join(printed)
    printed = (study / "resumed.log").read_text()
    assert "config/smoke.yaml was edited while the study ran" in printed
    assert "config/config.yaml was edited" not in printed
    finished, keys = json.loads((study / "killed.json").read_text()), small.journal_keys(study)
    assert finished
    assert len(keys) == len(set(keys)) == 6
    assert set(finished) <= set(keys)
    assert small.planned_jobs(study) == set()
    demands = pd.read_parquet(study / "results/demands.parquet")
    assert len(demands) == 6
    assert demands["status"].isin(["ok", "collapse"]).all()
    assert json.loads((study / "results/checks.json").read_text())["passed"]
    for name in ("demands", "fragility/curves", "fragility/effects"):
        metadata = pq.read_schema(study / f"results/{name}.parquet").metadata
        assert metadata[b"openseespy_version"]
        assert metadata[b"git_commit"]
    skewbridge = [str(small.SNAKEMAKE.parent / "skewbridge"), "provenance", "results/report.html"]
    assert json.loads(small.done([*skewbridge, "--json"], study).stdout)["current"]
    assert 'src="http' not in (study / "results/report.html").read_text()


def test_modelling_choices_are_made_on_request_only_in_the_configured_folder(study):
    assert small.planned_jobs(study, "", "choices") == {"modelling_choices", "choices"}
    outdated = study / "results/modelling_choices.parquet"
    write_frame(pd.DataFrame({"name": ["keys"]}), outdated, provenance(rule_digest="another"))
    assert small.planned_jobs(study) == set()
    outdated.unlink()
    plan = small.run(study, "-n", over="results: elsewhere/mine")
    assert "output: elsewhere/mine/report.html" in plan.stdout + plan.stderr
    assert "results/" not in plan.stdout + plan.stderr
    shutil.rmtree(study / "elsewhere")


def test_workers_and_the_growth_of_a_grid_leave_the_tables_as_they_are(study):
    """The study again: half of its grid, whose variant has both cores, then all on one core."""
    half = "{results: again, grid: {friction: [0.0]}}"
    first = small.run(study, "--", "again/demands.parquet", over=half)
    keys = small.journal_keys(study, "again")
    second = small.run(study, "--", "again/demands.parquet", over="results: again", cores=1)
    for each, workers in ((first, 2), (second, 1)):
        text = each.stdout + each.stderr
        assert text.count("rule analyse:") == 1
        assert ("threads: 2" in text.split("rule analyse:")[1].split("rule ")[0]) == (workers == 2)
    assert len(keys) == 3
    assert small.journal_keys(study, "again")[:3] == keys
    assert sorted(small.journal_keys(study, "again")) == sorted(small.journal_keys(study))
    for name in ("demands", *(f"demands/{slug}" for slug in SLUGS)):
        paths = (study / root / f"{name}.parquet" for root in ("again", "results"))
        found, expected = (pd.read_parquet(path).drop(columns=small.TIMES) for path in paths)
        pd.testing.assert_frame_equal(found, expected, check_exact=True)
    merged = (study / "config/smoke.yaml").read_text().replace("results: results", "results: again")
    (study / "merged.yaml").write_text(merged)
    skewbridge = [str(small.SNAKEMAKE.parent / "skewbridge"), "status", "--json", "--study"]
    state = json.loads(small.done([*skewbridge, "merged.yaml"], study).stdout)
    assert state.items() >= {"variants": 2, "analyses": 6, "done": 6, "left": 0}.items()
    shutil.rmtree(study / "again")


@pytest.fixture(scope="module")
def copy(study, tmp_path_factory):
    """The finished study in a tree copied without the times of its files, to be edited."""
    tree = tmp_path_factory.mktemp("copy") / "tree"
    shutil.copytree(study, tree, copy_function=shutil.copy)
    for path in sorted(tree.rglob("*"), reverse=True):
        path.touch()  # folders with sources last, results first
    return tree


ANALYSES = {"analyse", "collect_demands", "sensitivity"}
FITS = {"fit_fragility", "figures", "report"}
OSB1 = "src/skewbridge/bridge/catalogue/osb1.yaml"
COMMENTED = (
    "motions/README.md", "config/config.yaml", "config/limit_states.yaml", OSB1,
    "workflow/scripts/analyse.py",
)  # fmt: skip
EDITS = {
    "notes, comments and a bridge that extends that of the study": (
        dict.fromkeys(COMMENTED, ("", "\n# a comment\n"))
        | {OSB1.replace("osb1.", "osb1_fixed."): ("base: fixed", "base: pinned")},
        set(),
    ),
    "limit state": ({"config/limit_states.yaml": ("dcr_050: 0.5", "dcr_050: 0.55")}, FITS),
    "mechanics": (
        {"src/skewbridge/contact/law.py": ("", "\nEXTRA = 1.0\n")},
        ANALYSES | FITS | {"verify_contact"},
    ),
    "period": (
        {OSB1: ("t1_s: {v: 0.7192", "t1_s: {v: 0.75")}, ANALYSES | FITS | {"prepare_motions"}
    ),
    "bridge": ({OSB1: ("base: pinned", "base: fixed")}, ANALYSES | FITS),
}  # fmt: skip


@pytest.mark.parametrize(("edits", "jobs"), EDITS.values(), ids=EDITS)
def test_an_edit_reruns_the_rules_that_depend_on_it(copy, edits, jobs):
    before = {copy / name: (copy / name).read_text() for name in edits}
    try:
        for (path, text), (old, new) in zip(before.items(), edits.values(), strict=True):
            assert old in text
            path.write_text(text.replace(old, new) if old else text + new)
        assert small.planned_jobs(copy) - {"study"} == jobs
    finally:
        for path, text in before.items():
            path.write_text(text)


def test_a_deleted_table_or_folder_of_figures_is_made_again(copy):
    fits = FITS - {"fit_fragility"}
    for name, jobs in (("demands.parquet", {"collect_demands"} | FITS), ("figures", fits)):
        aside = (copy / "results" / name).rename(copy / "aside")
        assert small.planned_jobs(copy) - {"study"} == jobs
        aside.rename(copy / "results" / name)
