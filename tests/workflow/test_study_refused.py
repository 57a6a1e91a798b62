"""Faults that stop a study before any analysis, plans, rules, the site, and a study's start."""

import json
import re
import shlex
import shutil
import sys
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

from skewbridge.errors import InputError
from skewbridge.study.folder import STARTER_PARTS, write_starter
from skewbridge.study.jobs import RECIPES
from small_study import ROOT, SNAKEMAKE, copy_sources, done, run


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return copy_sources(tmp_path_factory.mktemp("refused") / "tree")


def test_what_a_rule_reads_of_others_is_in_its_recipe():
    """The gate is only an input to come first: where it alone has changed, journals are whole."""
    text = "".join(path.read_text() for path in sorted((ROOT / "workflow/rules").glob("*.smk")))
    found = re.split(r"^(?:rule|checkpoint) (\w+):", text, flags=re.MULTILINE)[1:]
    blocks = dict(zip(found[::2], found[1::2], strict=True))
    assert set(blocks) == set(RECIPES)

    def behind(rule):
        after = set(RECIPES[rule].after)
        return after.union(*map(behind, after))

    for name, block in blocks.items():
        inputs = set(re.findall(r"rules\.(\w+)\.output", block))
        assert inputs - {"verify_contact"} <= behind(name), name
        assert f'made_from=MADE_FROM["{name}"]' in block, name


def test_a_copied_configuration_has_results_of_its_own_and_a_cluster_a_job_for_each_variant(tree):
    shutil.copy(tree / "config/smoke.yaml", tree / "config/mine.yaml")
    plan = done([SNAKEMAKE, "-n", "--configfile", "config/mine.yaml"], tree)
    assert "results/smoke" not in plan.stdout + plan.stderr
    assert "output: results/mine/report.html" in plan.stdout + plan.stderr
    assert "digraph" in done([SNAKEMAKE, "--rulegraph"], tree).stdout  # needs no processors
    # with the processors, time and partition that the environment names
    site = {"SKEWBRIDGE_JOB_CORES": "2", "SKEWBRIDGE_JOB_MINUTES": "17", "SBATCH_PARTITION": "long"}
    profile = ("--workflow-profile", "workflow/profiles/slurm")
    plan = done([SNAKEMAKE, "-n", *profile], tree, environment=site)
    text = plan.stdout + plan.stderr
    assert re.search(r"^analyse +24$", text, re.MULTILINE)
    jobs = re.findall(r"rule analyse:.*?resources: (.*?)$", text, re.DOTALL | re.MULTILINE)
    assert len(jobs) == 24
    asked = {"mem_mb=1600", "runtime=17", "slurm_partition=long"}
    assert all(asked <= set(job.split(", ")) for job in jobs)


def test_bad_configurations_and_motions_stop_before_any_analysis(tree, tmp_path):
    first, second = sorted((ROOT / "motions").rglob("*.AT2"))[:2]
    shutil.copy(first, tmp_path)
    head, _, _ = second.read_text().rstrip().rpartition(" ")
    (tmp_path / second.name).write_text(f"{head} NaN\n")
    for over, step, *words in (
        ("grdi: {gap_mm: [25]}", "study", "grdi: unknown key"),
        ("{figures: {font: Nowhere Sans}, motions: {folder: nowhere}}", "study",
         "figures.font must be sans-serif, serif", "motions folder nowhere does not exist"),
        ("results: Snakefile", "study", "cannot write to the folder 'Snakefile'"),
        (f"motions: {{folder: {tmp_path}, count: 1}}", "prepare_motions", second.name),
    ):  # fmt: skip
        answer = run(tree, "--until", step, over=over, check=False)
        assert answer.returncode != 0
        assert all(each in answer.stdout + answer.stderr for each in words)
        assert not re.search("Traceback|in <module>", answer.stdout + answer.stderr)


def test_every_variable_of_make_study_is_understood(tree, tmp_path):
    """With a `snakemake` that only plans, in a study without a finished analysis."""
    (tmp_path / "skewbridge").symlink_to(SNAKEMAKE.with_name("skewbridge"))
    planner = tmp_path / "snakemake"
    planner.write_text(f'#!/bin/sh\nexec {SNAKEMAKE} -n "$@"\n')
    planner.chmod(0o755)
    config = tmp_path / "empty.yaml"
    config.write_text(f"results: {tmp_path / 'none'}\n")
    given = [config, ROOT / "motions", "all", "crash", "", "decided"]
    command = ["bash", "workflow/study.sh", tmp_path, "1", *given]
    answer = done(command, tree, environment={"UNCERTAINTY": "false"})
    assert "study repeats: 0" in answer.stderr
    assert "plan_round" in answer.stdout
    answer = done([*command[:4], "config/nowhere.yaml"], tree, check=False)
    assert answer.returncode == 1
    assert answer.stderr == "study: there is no configuration config/nowhere.yaml\n"


def test_folder_configuration_and_motions_may_have_names_that_a_shell_would_split(tmp_path):
    """From the command of `make` to the script of a rule; the environment is in the same folder."""
    folder = copy_sources(tmp_path / "A&B's (study) 1")
    config, motions = folder / "it's & (mine).yaml", folder / "two pairs (A&B's)"
    config.write_text("results: R&D's (1) results\nmotions: {count: 1}\n")
    motions.mkdir()
    for path in (ROOT / "motions/synthetic").glob("syn001_*"):
        shutil.copy(path, motions)
    variables = (f"CONFIG={config.name}", f"MOTIONS={motions}", "CORES=1")
    asked = ["make", "--no-print-directory", "-n", "-o", ".venv/.installed", "choices", *variables]
    listed = done(asked, folder).stdout
    command = shlex.split(listed.splitlines()[-1].removeprefix("@"))
    assert command[2:] == [".venv/bin", "1", config.name, str(motions), "choices", "", ""]
    # as installed there: Python with a path that has the name of the folder
    programs = folder / ".venv/bin"
    programs.mkdir(parents=True)
    (programs / "python").symlink_to(sys.executable)
    shutil.copy(f"{sys.prefix}/pyvenv.cfg", programs.parent)
    (programs.parent / "lib").symlink_to(f"{sys.prefix}/lib")
    (programs / "snakemake").write_text('#!/bin/sh\nexec "${0%/*}/python" -m snakemake "$@"\n')
    (programs / "snakemake").chmod(0o755)
    script = folder / "workflow/scripts/prepare_motions.py"
    with script.open("a") as text:
        text.write("    import skewbridge as s\n    print(s.__file__, __import__('sys').prefix)\n")
    suite = "R&D's (1) results/motions/suite.parquet"
    answer = done([*command[:-3], suite], folder)
    assert (folder / suite).is_file()
    assert f"{folder}/src/skewbridge/__init__.py {programs.parent}" in answer.stdout


def test_the_site_is_built_without_a_warning(tmp_path):
    """Unknown pages in a toctree, pages in none, links and docstrings that fail are warnings."""
    command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going"]
    done([*command, "-c", "docs", "-d", str(tmp_path / "d"), ".", str(tmp_path / "s")], ROOT)
    page = (tmp_path / "s/docs/theory/contact.html").read_text()
    assert "<math" in page
    loaded = [line for line in page.splitlines() if "<script" in line or "stylesheet" in line]
    assert "https://" not in "".join(loaded)
    drawn = ROOT / "docs/gallery/images/sphx_glr_plot_bridge_001.png"
    assert drawn.read_bytes() == (ROOT / "docs/theory/bridge_model.png").read_bytes()  # make docs


def test_an_installed_package_starts_a_study_without_overwriting_and_shows_the_stored_one(tmp_path):
    """The files of a wheel, as an installer unpacks them, outside a clone."""
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site-packages")
    environment = {"PYTHONPATH": str(tmp_path / "site-packages")}

    def called(folder, *arguments):
        return done([sys.executable, "-m", *arguments], folder, environment=environment)

    started = called(tmp_path, "skewbridge", "init", "my study")
    study = tmp_path / "my study"
    assert "cd 'my study', then: snakemake" in started.stderr
    assert all((study / part).exists() for part in STARTER_PARTS)
    planned = called(study, "snakemake", "-n", "--configfile", "config/smoke.yaml")
    assert "collect_demands" in planned.stdout
    plan = called(study, "skewbridge", "plan", "--config", "config/smoke.yaml", "--json")
    assert '"analyses": 6' in plan.stdout
    shown = called(tmp_path, "skewbridge", "demo", "--out", "shown", "--json", "--units=us")
    page = Path(json.loads(shown.stdout)["report"])
    assert page == tmp_path / "shown/report.html"
    assert "state at 4.49 in<" in page.read_text(encoding="utf-8")
    (other := tmp_path / "other/config").mkdir(parents=True)
    with pytest.raises(InputError, match="already has config"):
        write_starter(other.parent)
    assert [*other.parent.rglob("*")] == [other]
