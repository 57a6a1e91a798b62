"""`skewbridge run`: one analysis from the command line, its files and its exit codes."""

import json

import pandas as pd
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.cli import build_app
from skewbridge.demands.columns import COLUMNS
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.demands.tables import write_demands
from skewbridge.study.analyses import StudySetup
from skewbridge.study.batch import row_of_task
from skewbridge.study.config import load_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import outcome_of, run_key
from skewbridge.units import G_MPS2
from strong_motion import DT_S, strong_motion

runner = CliRunner()


def write_at2(path, accel_mps2, dt_s=DT_S):
    values = "\n".join(f"{value / G_MPS2:.8E}" for value in accel_mps2)
    head = f"PEER style file\nmade in the test\nACCELERATION IN UNITS OF G\nNPTS= {len(accel_mps2)}"
    path.write_text(f"{head}, DT= {dt_s:.4f} SEC\n{values}\n", encoding="utf-8")
    return path


@pytest.fixture
def pair(tmp_path):
    motion = strong_motion(duration_s=3.0)
    return [
        str(write_at2(tmp_path / "strong090.AT2", motion.accel_1_mps2)),
        str(write_at2(tmp_path / "strong180.AT2", motion.accel_2_mps2)),
    ]


def run(pair, out, *options):
    return runner.invoke(build_app(), ["run", "--motion", *pair, "--out", str(out), *options])


def test_a_run_leaves_its_row_histories_figures_and_replay(pair, tmp_path):
    out = tmp_path / "out"
    done = run(pair, out, "--skew-deg", "30", "--abutment", "contact-friction", "--json")
    assert done.exit_code == 0, done.stderr
    row = json.loads(done.stdout)
    assert row["status"] == "ok"
    assert row["variant"] == "osb1_cf_skew30_gap051_mu050"
    assert row["deck_disp_m"] > 0.1
    table = pq.read_table(out / "demands.parquet")
    assert table.column_names == [column.name for column in COLUMNS]
    assert table.num_rows == 1
    histories = pd.read_parquet(out / "histories.parquet")
    for name in ("t_s", "deck_ux_m", "deck_uy_m", "deck_rot_rad", "column_shear_kn"):
        assert name in histories
    for side in ("left", "right"):
        for axis in ("x", "y"):
            assert f"abutment_{side}_{axis}_m" in histories
            assert f"abutment_{side}_{axis}_kn" in histories
    # the pads act alone as long as no contact of the abutment is closed
    apart = histories.filter(regex="contact_left_.*_normal_kn").sum(axis=1) == 0.0
    assert 0 < apart.sum() < len(histories)
    for axis in ("x", "y"):
        other = (
            histories[f"abutment_left_{axis}_kn"] - histories[f"abutment_left_pads_{axis}_kn"]
        ).abs()
        assert other[apart].max() < 1e-9
        assert other[~apart].max() > 10.0
    # histories are read at the regular steps, demands at all
    assert histories["column_shear_kn"].max() == pytest.approx(row["column_shear_kn"], rel=1e-3)
    assert histories["t_s"].iloc[-1] == pytest.approx(row["time_reached_s"])
    for name in ("displacements", "hysteresis", "columns", "contacts"):
        assert (out / f"{name}.png").stat().st_size > 10_000
    page = (out / "contact_replay.html").read_text(encoding="utf-8")
    assert "Contacts closed" in page
    assert 'src="http' not in page


def test_a_row_says_what_speaks_against_it(pair, tmp_path):
    """Two iterations are too few for most steps; the sound run has hardly any such step."""
    cut = ["--duration-s", "3", "--no-figures", "--json"]
    done = run(pair, tmp_path / "sound", *cut)
    sound = json.loads(done.stdout)
    assert sound["loosened_ratio"] < 0.01  # the limit of a suspect row
    assert int(sound["steps_by_rung"].split()[0]) >= 3.0 / AnalysisSettings().dt_s
    assert sound["contact_energy_ratio"] > -1e-3
    assert 0.0 < sound["contact_force_ratio"] < 0.5

    changes = ["--set", "max_iterations=2", "--set", "tolerance_j=1.0e-14"]
    changes += ["--set", "reuse_tangent=false"]
    done = run(pair, tmp_path / "poor", *changes, *cut)
    poor = json.loads(done.stdout)
    assert poor["loosened_ratio"] > 0.5
    assert "loosened test, share of the steps" in poor["suspect"]
    assert f"suspect: {poor['suspect']}" in done.stderr.replace("\n", " ")


def test_a_roller_has_no_contacts_to_draw(pair, tmp_path):
    done = run(pair, tmp_path / "out", "--abutment", "roller", "--duration-s", "0.5", "--json")
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["variant"] == "osb1_ro_skew00_gap000_mu000"
    assert not (tmp_path / "out" / "contact_replay.html").exists()


def test_the_printed_answer_is_result_limits_and_files(pair, tmp_path):
    done = run(pair, tmp_path / "out", "--duration-s", "1", "--no-figures", "--units", "us")
    result, limits, files = done.stdout.strip().splitlines()
    assert result.startswith("osb1_cf_skew00_gap051_mu050 under ")
    assert " ok; column shear 0." in result
    assert result.endswith(" in.")
    assert limits == "No failure; all limits of validity are met."
    assert files.endswith("demands.parquet, histories.parquet.")


def test_a_collapse_is_a_result(pair, tmp_path):
    done = run(pair, tmp_path / "out", "--scale", "4", "--no-figures", "--json")
    assert done.exit_code == 0, done.stderr
    row = json.loads(done.stdout)
    assert (row["status"], row["collapse_criterion"]) == ("collapse", "column_drift_ratio")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--skew-deg", "75"], "skew_deg must be within -60..60, got 75"),
        (["--gap-mm", "-5"], "gap_mm"),
        (["--friction", "-0.1"], "friction"),
        (["--friction", "0.1234567"], "friction must have at most 5 decimals, got 0.1234567"),
        (["--abutment", "magic"], "abutment must be one of"),
        (["--bridge", "nowhere"], "nowhere"),
        (["--scheme", "best"], "'best' is not one of 'default', 'paper'"),
        (["--dt-s", "0.5"], "dt_s: must be less than or equal to 0.02, got 0.5"),
        (["--scale", "0"], "scale must be a positive number"),
        (["--set", "arrays=soft"], "arrays: must be 'rigid' or 'corotational', got 'soft'"),
        (["--set", "transverse_gap_mm=-1"], "transverse_gap_mm: must be greater than"),
        (["--set", "max_iterations=1"], "max_iterations: must be greater than"),
        (["--set", "array=rigid"], "array: unknown key"),
        (["--set", "rigid"], "--set takes KEY=VALUE, got 'rigid'"),
    ],
)
def test_bad_options_exit_with_2_and_name_the_limit(pair, tmp_path, options, words):
    done = run(pair, tmp_path / "out", *options, "--json")
    assert done.exit_code == 2
    answer = json.loads(done.stdout)
    assert answer["status"] == "error"
    assert words in answer["message"]


def test_unwritable_folder_is_reported_before_the_analysis(pair, tmp_path):
    taken = tmp_path / "taken"
    taken.write_text("a file", encoding="utf-8")
    done = run(pair, taken, "--json")
    assert done.exit_code == 2
    assert "taken" in json.loads(done.stdout)["message"]


def test_a_row_of_a_study_is_repeated_by_its_key(pair, tmp_path, monkeypatch):
    study = tmp_path / "study"
    (study / "config").mkdir(parents=True)
    config = {"motions": {"folder": str(tmp_path), "count": 1}, "analysis": {"duration_s": 0.5}}
    config["results"] = "elsewhere"
    (study / "config" / "config.yaml").write_text(json.dumps(config), encoding="utf-8")
    monkeypatch.chdir(study)
    parsed = load_config(study / "config" / "config.yaml")
    folder = StudyFolder(study / "elsewhere")
    prepare_motions(parsed)
    task = StudySetup.of(parsed).tasks("osb1_cf_skew30_gap051_mu050")[0]
    result = analyse(task.variant, task.excitation, task.settings, task.options)
    rest = {"wall_s": 0.0, "cpu_s": 0.0, "suspect": ""}
    row = row_of_task(outcome_of(result) | rest, task, run_key(task))
    write_demands([row], folder.demands, {})

    done = runner.invoke(
        build_app(),
        ["run", "--row", row["run_key"], "--out", str(tmp_path / "out"), "--no-figures", "--json"],
    )
    assert done.exit_code == 0, done.stderr
    again = json.loads(done.stdout)
    for column in DEMAND_COLUMNS:
        assert again[column.name] == row[column.name], column.name
    assert again["run_key"] == row["run_key"]

    unknown = runner.invoke(build_app(), ["run", "--row", "f00", "--out", str(tmp_path), "--json"])
    assert unknown.exit_code == 2
    assert "no such run_key" in json.loads(unknown.stdout)["message"]
