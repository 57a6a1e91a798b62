"""Commands about a study, or two: what they answer, refuse and publish; jobs on a cluster."""

import hashlib
import json
import subprocess
import zipfile
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yte
from reference_pages import ROOT
from rocrate.rocrate import ROCrate

from cli_json import answer, invoke
from fragility_tables import IM, synthetic_demands
from motions_files import at2_text, shaken_g
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.cli.output import config_of, folder_of
from skewbridge.demands.columns import COLUMNS
from skewbridge.errors import InputError
from skewbridge.files.digests import provenance
from skewbridge.files.tables import stamp, write_frame
from skewbridge.files.text import merged, read_mapping
from skewbridge.report.methods import REFERENCES, methods_of
from skewbridge.study import analyses, inputs, processes, progress
from skewbridge.study.config import load_config, parse_config, store_configuration
from skewbridge.study.folder import write_starter
from skewbridge.study.task import run_key
from study_parts import in_journal, row_of

BASE = ROOT / "config/config.yaml"
#: Two motions without the blocks, bands and orientations of the default study.
PLAIN = "motions: {suites: [near], count: 2, incidence_deg: [0.0], blocks: null, bands: null}\n"
SOURCE = "BSD-3-Clause; synthetic: model of Dabaghi and Der Kiureghian (2018)"
# Studies whose processor time was measured from the start of Snakemake to the page, on two
# processors at loads of 1 to 15.
SMOKE = read_mapping(ROOT / "config/smoke.yaml")
compared = partial(answer, "compare")
FOUR = {"grid": {"bridge": ["osb1"], "skew_deg": [30]}, "motions": {"count": 4}}
pytestmark = pytest.mark.usefixtures("in_the_repository")


def test_plan_counts_the_analyses_and_the_doctor_finds_a_working_environment() -> None:
    plan = answer("plan")
    # 32 motions x 2 orientations in two cells of 2 bridges x 3 skews
    assert (plan["variants"], plan["analyses"]) == (24, 32 * 2 * 2 * 6)
    assert plan["done"] + plan["left"] == plan["analyses"]
    assert plan["disk_mb"] == pytest.approx(38.0, rel=0.1)  # measured: results of this study
    report = answer("doctor")
    assert (report["ok"], report["self_test"]) == (True, "passed")


def test_a_bad_or_missing_configuration_ends_with_2_and_one_message(tmp_path) -> None:
    path, words = tmp_path / "bad.yaml", "model.bakfill: unknown key (did you mean model.backfill?)"
    assert "bad.yaml" in answer("plan", "--config", path, code=2)["message"]
    path.write_text("model: {bakfill: sdc}")
    assert words in answer("plan", "--config", path, code=2)["message"]


def test_failures_are_forgotten(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(f"results: {tmp_path}/results\n")
    path = tmp_path / "results" / "journal" / "v.jsonl"
    row = {"variant": "v", "motion_id": "m"}
    in_journal(path, *(row | {"run_key": key, "status": key} for key in ("ok", "crash")))
    config = ("--study", str(tmp_path / "mine.yaml"))
    retried = answer("study", "retry", *config)
    assert retried["analyses"] == [{"variant": "v", "motion": "m", "status": "crash"}]
    assert answer("study", "retry", *config)["forgotten"] == 0
    assert "one of failed, num" in answer("study", "retry", "--status", "ok", code=2)["message"]
    assert "no folder x" in answer("study", "retry", "--study", "x", code=2)["message"]


def test_a_study_is_named_by_its_folder_or_its_configuration(tmp_path, monkeypatch):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("motions: {count: 2}")
    (tmp_path / "config/mine.yaml").write_text("results: results/mine\ngrid: {skew_deg: [30]}")
    (tmp_path / "config/states.yaml").write_text("- not a configuration")
    monkeypatch.chdir(tmp_path)
    mine = Path("config/mine.yaml")
    assert config_of(None) == config_of(Path("results")) == Path("config/config.yaml")
    assert config_of(mine) == config_of(Path("results/mine/")) == mine
    assert folder_of(None) == Path("results")
    assert folder_of(mine) == folder_of(Path("results/mine")) == Path("results/mine")
    with pytest.raises(InputError, match="elsewhere does not exist: no file in config/"):
        config_of(Path("elsewhere"))
    (tmp_path / "config/copy.yaml").write_text("results: results/mine")
    with pytest.raises(InputError, match="2 files in config/"):
        config_of(Path("results/mine"))
    Path("results/mine").mkdir(parents=True)
    Path("results/mine/configuration.json").write_text('{"files": ["config/mine.yaml"]}')
    (tmp_path / "config/broken.yaml").write_text("states: {slight: 1,0}")  # of another study
    assert config_of(Path("results/mine")) == mine
    with pytest.raises(InputError, match=r"broken\.yaml, line 1: not valid YAML"):
        config_of(Path("results/broken"))


def test_new_gap_repeats_no_finished_analysis(tmp_path: Path) -> None:
    axes = "skew_deg: [0], gap_mm: [25], friction: [0.5]"
    grid = f"grid: {{bridge: [osb1], abutment: [contact_friction], {axes}}}\n"
    config = tmp_path / "mine.yaml"
    config.write_text(f"results: {tmp_path}/results\n{grid}{PLAIN}")
    study, slug = load_config(config, base=BASE), "osb1_cf_skew00_gap025_mu050"
    inputs.prepare_motions(study)
    tasks = analyses.StudySetup.of(study).tasks(slug)
    keys = dict(zip(map(run_key, tasks), ("ok", "timeout"), strict=True))
    same = dict.fromkeys(column.name for column in COLUMNS) | {"variant": slug, "motion_id": "m"}
    same |= {"cpu_s": 2.0, "recovery_rung": 0, "collapse_criterion": "budget"}
    rows = (same | {"run_key": key, "status": status} for key, status in keys.items())
    in_journal(tmp_path / "results/journal/v.jsonl", *rows)
    config.write_text(config.read_text().replace("[25]", "[25, 51]"))
    found = answer("status", "--config", str(config))
    counts = {"variants": 2, "analyses": 4, "done": 2, "failed": 1, "left": 2}
    assert {name: found[name] for name in counts} == counts
    last = found["last_failure"]
    assert (last["variant"], last["status"], last["reason"]) == (slug, "timeout", "budget")
    (failed,) = answer("status", "--failed", "--config", str(config))["analyses"]
    key = list(keys)[1]
    assert failed["command"].endswith(f"run --row {key} --out row_{key} --study {study.results}")
    answer("study", "retry", "--study", config)
    assert "0 of 1 finished analyses" in invoke("status", "--failed", "--config", config).output


@pytest.fixture(name="study")
def _study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_starter(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config/bridges/mine.yaml").write_text("extends: base\n")
    (tmp_path / "config/bridges/base.yaml").write_text("extends: osb1\n")
    (tmp_path / "own.yaml").write_text("results: results/own\ngrid:\n  bridge: [mine]\n")
    folder = tmp_path / "results/own"
    origin = provenance(config_digest="c", suite_digest="s")
    for name in ("demands", "fragility/curves", "fragility/effects"):
        write_frame(synthetic_demands(skews=(0,), gaps=(51,)), folder / f"{name}.parquet", origin)
    suite = pd.DataFrame({"motion_id": ["m00", "m01"], "sha256": ["a", "b"], "source": SOURCE})
    suite["accel_1_mps2"] = suite["accel_2_mps2"] = [np.zeros(3)] * 2
    write_frame(suite, folder / "motions/suite.parquet", origin)
    return tmp_path


def archived(out: str) -> dict:
    options = ("--study", "own.yaml", "--out", out, "--author", "A. Engineer")
    return answer("study", "archive", *options)


def test_archive_is_a_crate_of_all_inputs_and_methods_are_those_of_the_configuration(study) -> None:
    found, crate = archived("a.zip"), ROCrate(study / "a.zip")
    with zipfile.ZipFile(study / "a.zip") as packed:
        content = {name: packed.read(name) for name in packed.namelist()}
    described = {entity.id: entity for entity in crate.data_entities if entity.type != "Dataset"}
    assert sorted(described) == found["files"]
    assert set(content) - set(described) == {"ro-crate-metadata.json"}
    expected = {f"config/{name}.yaml" for name in ("bridges/mine", "bridges/base", "config")}
    expected |= {"own.yaml", "config/limit_states.yaml", "motions.csv", "METHODS.md"}
    expected |= {f"results/{name}.parquet" for name in ("demands", "fragility/curves")}
    assert expected | {"workflow/Snakefile"} <= set(content)
    for name, entity in described.items():
        assert hashlib.sha256(content[name]).hexdigest() == entity["sha256"]
    assert crate.root_dataset["author"]["name"] == "A. Engineer"
    assert b"openseespy==" in content["requirements.txt"]
    assert b"accel" not in content["motions.csv"]
    assert SOURCE.encode() in content["motions.csv"]
    words = "the joint gap 25 mm, 51 mm; friction 0, 0.5: 12 variants"
    assert words in invoke("study", "methods", "--study", "own.yaml").stdout


@pytest.mark.exports
def test_the_validator_of_crates_has_no_finding(study: Path) -> None:
    python = ROOT / ".exports/rocrate/bin/python"
    if not python.exists():
        pytest.skip("the validator is not installed: make test-exports")
    archived("a.zip")
    context = files("rocrate") / "data/ro-crate.jsonld"
    asked = json.dumps({"files": [str(study / "a.zip")], "context": str(context)})
    given = [python, ROOT / "tests/exports/read_rocrate.py"]
    done = subprocess.run(given, input=asked, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == {"issues": []}


def test_an_archive_has_the_configuration_of_the_study_and_reports_other_origins(study) -> None:
    path = study / "results/own/fragility/effects.parquet"
    write_frame(pd.read_parquet(path), path, provenance(config_digest="x", suite_digest="s"))
    assert any("different versions" in doubt for doubt in archived("a.zip")["doubts"])
    with zipfile.ZipFile(study / "a.zip") as packed:
        (study / "whole.yaml").write_bytes(packed.read("whole_config.yaml"))
    assert load_config(Path("whole.yaml")) == load_config(Path("own.yaml"), base=BASE)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["results/own"], "no file in config/ with `results: results/own`"),
        (["other.yaml"], "finish the study first"),
        (["own.yaml", "--out", "a.tar"], "must end with .zip"),
    ],
)
def test_unfinished_study_is_refused(study: Path, arguments: list[str], message: str) -> None:
    (study / "other.yaml").write_text("results: results\n")
    result = invoke("study", "archive", "--study", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")


@pytest.mark.parametrize(
    ("section", "choice", "expected"),
    [
        ("analysis", {"scheme": "paper"}, "Houbolt 1950|distributed plasticity|committed"),
        ("motions", {"design": "stripes"}, "scaled to 0.1, 0.2|one model of each demand|Laird and"),
        ("motions", {"design": "ida"}, "Vamvatsikos and Cornell 2002|column_drift_ratio"),
        ("motions", {"blocks": {"cells_per_motion": 2, "complete_share": 0.0}},
         "values of skew at two combinations of the values of|within skew_deg; cells_per_motion"),
        ("grid", {"abutment": ["roller"]}, "modelled on rollers"),
        ("grid", {"bridge": [f"{ROOT}/tests/data/drawings/one_span.yaml"]},
         "per span. Rayleigh damping of the deck is 5 % of critical at two periods.\n|"
         "as collapse when the deck moves|or did not converge a demand|"
         "skew 35° at the left end and 35° at the right end; "),
        ("model", {"backfill": "sdc", "damping_factor": 0.6}, "(Caltrans 2019)|3 % of critical"),
    ],
)  # fmt: skip
def test_methods_follow_the_choices_and_list_the_works_that_they_cite(section, choice, expected):
    text, _, listed = methods_of(parse_config({section: choice})).markdown().partition("## Ref")
    assert all(words in text for words in expected.split("|")), text
    assert ("`column_drift_ratio`" in text) == ("one_span" not in str(choice))
    for key, work in REFERENCES.items():
        own = text.replace(f"{key} 2023", "") if key == "Rahman and Mackie" else text
        assert (work in listed) == (key in own), key


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Return a function that writes a program in place of Slurm's, the only ones that are found."""
    (folder := tmp_path / "bin").mkdir()
    monkeypatch.setenv("PATH", f"{folder}:/bin:/usr/bin")

    def write(name: str, text: str) -> None:
        (folder / name).write_text(f"#!/bin/sh\n{text}\n")
        (folder / name).chmod(0o755)

    return write


def profile() -> dict[str, Any]:
    with (ROOT / "workflow/profiles/slurm/config.yaml").open() as text:
        found = yte.process_yaml(text, require_use_yte=True)
    # a misspelt rule would be passed over, and its job would ask for the default
    rules = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    named = {*found["groups"], *found["set-threads"]}
    assert [name for name in sorted(named) if f"rule {name}:" not in rules] == []
    return found


def test_status_of_jobs_comes_from_the_accounting(program, monkeypatch):
    # An account is named only where there is accounting, or the executor would look it up.
    monkeypatch.setenv("SBATCH_ACCOUNT", "mine")
    program("sacct", "echo 'Slurm accounting storage is disabled' >&2; exit 1")
    assert profile()["slurm-status-command"] == "squeue"
    assert "slurm_account" not in profile()["default-resources"]
    program("sacct", "exit 0")
    assert profile()["slurm-status-command"] == "sacct"
    assert profile()["default-resources"]["slurm_account"] == "mine"


@pytest.mark.parametrize(("raw", "measured_s"), [(SMOKE, 35.0), (FOUR, 73.0)])
def test_the_processor_time_of_a_whole_study_is_forecast(tmp_path, raw, measured_s) -> None:
    over = {"results": str(tmp_path), **raw}
    found = progress.forecast_study(parse_config(merged(read_mapping(BASE), over))).summary
    assert measured_s / 1.5 < 3600 * found["core_hours"] < measured_s * 1.5
    assert 3600 * found["core_hours"] == pytest.approx(sum(found["cpu_s"].values()), abs=0.2)


def test_a_forecast_follows_lengths_contacts_steps_and_finished_analyses(tmp_path) -> None:
    (folder := tmp_path / "records").mkdir()  # recorded pairs have no index with their lengths
    for name, seconds in (("a", 20.0), ("b", 60.0)):
        for azimuth in (0, 90):
            values_g = shaken_g(azimuth, round(seconds / 0.01))
            (folder / f"{name}_{azimuth:03d}.AT2").write_text(at2_text(values_g, azimuth=azimuth))
    base = {"results": str(tmp_path / "r"), "motions": {"folder": str(folder), "count": 2}}
    base |= {"grid": {"bridge": ["osb1"], "skew_deg": [30], "gap_mm": [25]}}

    def forecast(**sections) -> dict[str, float]:
        return progress.forecast_study(parse_config(merged(base, sections))).summary["cpu_s"]

    def cost_s(**sections) -> float:
        return forecast(**sections)["analyses"]

    each_s = [analyses.forecast_s(s, "contact_friction", AnalysisSettings()) for s in (20.0, 60.0)]
    assert cost_s() == pytest.approx(2 * sum(each_s), abs=0.1)
    assert cost_s(motions={"count": 1}) == pytest.approx(2 * each_s[0], abs=0.1)
    assert cost_s(analysis={"duration_s": 5.0}) == pytest.approx(2 * 2 * 5.0 * 0.1, abs=0.1)
    assert cost_s(motions={"incidence_deg": [0.0, 45.0]}) == pytest.approx(2 * cost_s(), abs=0.2)
    assert cost_s(grid={"abutment": ["roller"]}) < 0.7 * cost_s() / 2
    assert cost_s(accuracy="reference") > 20 * cost_s()
    # finished analyses that took three times as long: so does the rest
    before, config = forecast(), parse_config(base)
    inputs.prepare_motions(config)
    assert forecast() == before
    setup = analyses.StudySetup.of(config)
    task = setup.tasks("osb1_cf_skew30_gap025_mu000")[1]
    row = row_of(task, cpu_s=3 * each_s[1]) | {"duration_s": 60.0}
    in_journal(setup.folder.journal("done"), row)
    assert forecast() == {name: pytest.approx(3 * s, abs=0.2) for name, s in before.items()}
    # a lost journal: the table of a variant counts as long as its rule would leave it
    setup.folder.journal("done").rename(tmp_path / "lost")
    table = setup.folder.variant_demands("osb1_cf_skew30_gap025_mu000")
    current = progress.rule_digest(progress.made_from(config)["analyse"])
    for digest, done in ((current, 1), ("of others", 0)):
        write_frame(pd.DataFrame([row]), table, {"rule_digest": digest})
        assert progress.forecast_study(config).summary["done"] == done
    (tmp_path / "lost").rename(setup.folder.journal("done"))
    stamp(setup.folder.suite, {"rule_digest": "of other motions"})
    found = progress.forecast_study(config)
    assert (found.summary["done"], "motions are new or changed" in found.notes[0]) == (0, True)


@pytest.mark.parametrize("grid", [
    {"bridge": ["osb1"], "skew_deg": [30], "gap_mm": [25]}, {"bridge": ["osb1"], "skew_deg": [30]},
    {"bridge": ["osb1"], "friction": [0.5]}, {"abutment": ["roller"], "skew_deg": [0, 60]}, {},
])  # fmt: skip
@pytest.mark.parametrize("sections", [
    {}, {"analysis": {"duration_s": 10.0}},
    {"accuracy": "reference"}, {"analysis": {"scheme": "paper"}},
    {"design": {"until": "decided", "first": 6}},
])  # fmt: skip
def test_numerical_checks_cost_less_than_a_quarter_of_the_analyses(grid, sections) -> None:
    numbers = []
    for count in (1, 2, 4, 12, 32, 64):
        lengths_s = [25.0, 90.0] * count
        study = parse_config({"grid": grid, **sections})
        rows, cost_s = analyses.check_plan(study, lengths_s)
        counted = lengths_s[:6] if study.design.until else lengths_s
        # the strongest parts of motions took up to 1.35 times as long as forecast
        assert 1.35 * cost_s < 0.25 * analyses.analyses_s(study, counted)
        assert 0 <= rows <= 4
        numbers.append(rows)
    assert numbers == sorted(numbers)
    if not grid and "design" not in sections:  # the default grid: as configured
        assert numbers[-1] == (0 if study.analysis.scheme == "paper" else 4)


def test_only_jobs_of_this_tree_are_cancelled(program, tmp_path: Path) -> None:
    cancelled = tmp_path / "cancelled"
    listed = "11 skewbridge-aa_1\\n12 skewbridge-bb_2\\n13 a job of mine\\n14 skewbridge-aa_3"
    program("scancel", f'echo "$@" >> {cancelled}')
    for listing in (f"printf '{listed}\\n'", "true"):  # then none is left
        program("squeue", listing)
        processes.cancel_left_behind("skewbridge-aa")
        assert cancelled.read_text() == "11 14\n"


def write_study(folder: Path, demands: pd.DataFrame) -> str:
    (folder / "motions").mkdir(parents=True)
    write_frame(demands, folder / "demands.parquet", {})
    names = sorted(demands["motion_id"].unique())
    suite = pd.DataFrame({"motion_id": names, "sha256": names})
    write_frame(suite, folder / "motions" / "suite.parquet", {})
    return str(folder)


def test_a_known_change_is_found_in_demands_and_medians(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,))
    # a table of another program has the ratio of one failure mode, but not that of any
    table["drift_over_capacity"] = table["column_drift_ratio"] / 0.02
    noise = np.exp(0.05 * np.random.default_rng(3).normal(size=len(table)))
    changed = table.assign(deck_disp_m=table["deck_disp_m"] * 0.8 * noise)
    found = compared(write_study(tmp_path / "a", table), write_study(tmp_path / "b", changed))
    pooled = {row["demand"]: row for row in found["demands"] if row["scope"] == "pooled"}
    row = pooled["deck_disp_m"]
    assert row["ratio"] == pytest.approx(0.8, rel=0.02)
    assert row["ci_low"] < 0.8 < row["ci_high"]
    assert (row["verdict"], row["axis"], row["n_cells"]) == ("lower", "study", 6)
    # ln demand has slope 1 in ln im: the median moves by the inverse of the demand
    states = {row["demand"]: row for row in found["medians_by_state"]}
    slight = states["deck_displacement/slight"]
    assert slight["ratio"] == pytest.approx(1 / 0.8, rel=0.03)
    assert (slight["n_cells"], slight["direction"]) == (6, 1)
    assert states["column_failure/any"]["ratio"] == pytest.approx(1.0)
    assert pooled["column_drift_ratio"]["ratio"] == 1.0
    assert states["column_drift/slight"]["ratio"] == pytest.approx(1.0)


def test_medians_without_a_curve_in_both_studies_have_no_ratio(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    weak = table[IM] > table[IM].quantile(0.6)  # small peaks of runs that ended early
    table.loc[weak, "deck_disp_m"] *= 0.3
    table.loc[weak, ["status", "complete"]] = "timeout", False
    other = table.assign(deck_disp_m=0.8 * table["deck_disp_m"])
    found = compared(write_study(tmp_path / "a", table), write_study(tmp_path / "b", other))
    states = {row["demand"]: row for row in found["medians_by_state"]}
    row = states["deck_displacement/slight"]
    assert (row["status"], row["ratio"]) == ("no_curve", None)
    assert states["bearing/slight"]["ratio"] == pytest.approx(1.0)


def test_only_common_runs_are_paired_and_the_rest_is_counted(tmp_path: Path) -> None:
    first = synthetic_demands(gaps=(51,), skews=(0, 30))
    second = synthetic_demands(gaps=(51,), skews=(30, 45))
    second = second[second["motion_id"] < "m12"]
    found = compared(write_study(tmp_path / "a", first), write_study(tmp_path / "b", second))
    common = {"pairs": 24, "variants": 2, "motions": 12, "equal_pairs": 0}
    assert found["counts"] == common | {"only_first": 64 - 24, "only_second": 48 - 24}
    assert {row["skew_deg"] for row in found["demands"]} == {None, 30}


def test_a_study_equals_itself_but_for_motions_of_one_name_and_other_files(tmp_path: Path) -> None:
    table = synthetic_demands(gaps=(51,), skews=(0,))
    path, out = tmp_path / "demands.csv", tmp_path / "rows.csv"
    table.drop(columns=["run_key"]).to_csv(path, index=False)
    first, second = write_study(tmp_path / "a", table), write_study(tmp_path / "b", table)
    found = compared(first, str(path), "--out", str(out))
    assert found["counts"]["pairs"] == len(table)
    assert all(row["ratio"] == pytest.approx(1.0) for row in found["demands"])
    assert len(pd.read_csv(out)) == len(found["demands"]) + len(found["medians"])
    # the first study has its own limit states
    fits = {"limit_states": f"{BASE.parent}/limit_states_template.yaml"}
    settings = {"results": first, "fragility": fits}
    store_configuration(parse_config(settings), [], settings)
    states = {row["demand"] for row in compared(first, second)["medians_by_state"]}
    assert {"shear_key/yield", "bearing/slight"} & states == {"shear_key/yield"}
    (tmp_path / "a/configuration.json").unlink()
    # the printed answer counts medians outside the motions
    printed = invoke("compare", first, second)
    assert printed.exit_code == 0
    lines = [line for line in printed.stdout.splitlines() if "deck_displacement" in line]
    assert [" of 4 medians" in line for line in lines] == [False, True]
    suite = pd.read_parquet(tmp_path / "b/motions/suite.parquet")
    suite.loc[suite["motion_id"] == "m03", "sha256"] = "another"
    write_frame(suite, tmp_path / "b/motions/suite.parquet", {})
    found = compared(first, second)
    assert (found["other_motions"], found["counts"]["motions"]) == (["m03"], 15)


@pytest.mark.parametrize(
    ("other", "options", "message"),
    [
        ("a", ["--out", "x.parquet"], "--out must end with .csv"),
        ("", [], "has no demands.parquet"),
        ("scaled", [], "2 variants, 6 motions, 0 motions with the same scale"),
        ("other", [], "choose with --hazard, in `statistics` also with --im, one of im_pgv_mps"),
    ],
)
def test_bad_input_and_studies_without_a_common_run_are_refused(tmp_path, other, options, message):
    for name, scale, im in (("a", 1.0, IM), ("scaled", 2.0, IM), ("other", 1.0, "im_pgv_mps")):
        rows = synthetic_demands(gaps=(51,), skews=(0,), motions=6, scales=(scale,))
        write_study(tmp_path / name, rows.rename(columns={IM: im}))
    found = answer("compare", tmp_path / "a", tmp_path / other, *options, code=2)
    assert message in found["message"]
