"""`skewbridge run` and the analyses of a process: files, exit codes, memory."""

import json
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import pytest

from cli_json import answer, invoke
from cli_json import run as run_json
from motions_files import at2_text
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.structures import built_bridge
from skewbridge.demands.columns import COLUMNS, DEMAND_COLUMNS
from skewbridge.demands.tables import to_table
from skewbridge.files.tables import write_table
from skewbridge.study.analyses import StudySetup
from skewbridge.study.batch import row_of_task
from skewbridge.study.config import load_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import outcome_of, run_key
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from strong_motion import DT_S, strong_motion


@pytest.fixture
def pair(tmp_path):
    motion = strong_motion(duration_s=3.0)
    paths = [tmp_path / f"strong{azimuth}.AT2" for azimuth in ("090", "180")]
    for path, accel_mps2 in zip(paths, motion.components, strict=True):
        path.write_text(at2_text(accel_mps2 / G_MPS2, DT_S))
    return list(map(str, paths))


def run(pair, out, *options):
    """Return the exit code and the answer of an analysis under a pair of components."""
    return run_json("run", "--motion", *pair, "--out", out, *options)


def test_a_run_leaves_its_row_histories_and_figures(pair, tmp_path):
    out = tmp_path / "out"
    code, row = run(pair, out, "--skew-deg", "30", "--abutment", "contact-friction")
    assert code == 0, row
    assert (row["status"], row["variant"]) == ("ok", "osb1_cf_skew30_gap051_mu050")
    assert row["deck_disp_m"] > 0.1
    assert row["loosened_ratio"] < 0.01  # the limit of a suspect row
    assert int(row["steps_by_rung"].split()[0]) >= 3.0 / AnalysisSettings().dt_s
    assert row["contact_energy_ratio"] > -1e-3
    assert 0.0 < row["contact_force_ratio"] < 0.5
    table = pq.read_table(out / "demands.parquet")
    assert table.column_names == [column.name for column in COLUMNS]
    assert table.num_rows == 1
    histories = pd.read_parquet(out / "histories.parquet")
    names = {"t_s", "deck_ux_m", "deck_uy_m", "deck_rot_rad", "column_shear_kn"}
    names |= {f"abutment_right_{axis}_{unit}" for axis in "xy" for unit in ("m", "kn")}
    assert names <= set(histories)
    # the pads act alone as long as no contact of the abutment is closed
    apart = histories.filter(regex="contact_left_.*_normal_kn").sum(axis=1) == 0.0
    assert 0 < apart.sum() < len(histories)
    for axis in "xy":
        whole, pads = (histories[f"abutment_left_{part}{axis}_kn"] for part in ("", "pads_"))
        assert (whole - pads)[apart].abs().max() < 1e-9
        assert (whole - pads)[~apart].abs().max() > 10.0
    # histories are read at the regular steps, demands at all
    assert histories["column_shear_kn"].max() == pytest.approx(row["column_shear_kn"], rel=1e-3)
    assert histories["t_s"].iloc[-1] == pytest.approx(row["time_reached_s"])
    for name in ("displacements", "hysteresis", "columns", "contacts"):
        assert (out / f"{name}.png").stat().st_size > 10_000


def test_the_printed_answer_has_suspect_properties_and_the_units_asked_for(pair, tmp_path):
    """Two iterations are too few for most steps."""
    changes = ("max_iterations=2", "tolerance_j=1.0e-14", "reuse_tangent=false")
    options = [text for change in changes for text in ("--set", change)]
    out = ("--out", tmp_path / "out", "--units", "us", "--duration-s", "1", "--no-figures")
    printed = invoke("run", "--motion", *pair, *out, *options)
    assert {"status", "suspect", "column_shear_dcr", "deck_disp_in"} <= set(printed.stdout.split())
    assert "osb1_cf_skew00_gap051_mu050" in printed.stdout
    assert f"written to {tmp_path}/out" in printed.stderr
    (row,) = pq.read_table(tmp_path / "out/demands.parquet").to_pylist()
    assert row["loosened_ratio"] > 0.5
    assert "share of steps with looser test" in row["suspect"]


def test_a_roller_has_no_contacts_to_draw_and_a_collapse_is_a_result(pair, tmp_path):
    code, row = run(pair, tmp_path / "out", "--abutment", "roller", "--duration-s", "0.5")
    assert (code, row["variant"]) == (0, "osb1_ro_skew00_gap000_mu000")
    assert not (tmp_path / "out" / "contacts.png").exists()
    code, row = run(pair, tmp_path / "out", "--scale", "4", "--no-figures")
    assert code == 0
    assert (row["status"], row["collapse_criterion"]) == ("collapse", "column_drift_ratio")


@pytest.mark.parametrize(
    ("bridge", "changes"),
    [
        ("osb1", {"gap_offset_mm": 10}), ("osb1", {"gap_offset_mm": -60}),  # the gap is at least 0
        ("osb1", {"gap_measured": "longitudinal"}), ("osb2s", {"deck_mass_factor": 1.3}),
        ("osb1_fixed", {"hinge_rule": "paulay_priestley"}),
        ("osb2s", {"steel_strength_factor": 0.8, "concrete_strength_factor": 1.2}),
    ],
)  # fmt: skip
def test_the_design_criteria_have_the_capacities_of_the_model(pair, tmp_path, bridge, changes):
    texts = [text for key, value in changes.items() for text in ("--set", f"{key}={value}")]
    case = ("--bridge", bridge, "--skew-deg", "60", "--gap-mm", "51", "--duration-s", "0.05")
    code, row = run(pair, tmp_path, *case, *texts, "--no-figures")
    assert code == 0, row
    options = ModelOptions(**changes)
    narrowing = 0.5 if options.gap_measured == "longitudinal" else 1.0  # cos(60)
    support_m = 0.914 - max(0.051 * narrowing + 1e-3 * options.gap_offset_mm, 0.0)
    scaled = built_bridge(load_bridge(bridge), options, 60.0)
    bents = [bent_capacity(scaled, at, options.hinge_rule) for at in range(len(scaled.bents))]
    assert row["support_length_m"] == pytest.approx(support_m)
    checks = answer("bridge", "sdc", tmp_path)["checks"]
    seats = [check["capacity"] for check in checks if "seat" in check["check"]]
    assert seats == pytest.approx([support_m] * 5)
    found = {check["check"]: check for check in checks}
    for number, bent in enumerate(bents, start=1):
        name = f"bent {number} displacement, hinge {bent.hinge_length_m:.3f} m by rule (m)"
        assert found[name]["capacity"] == pytest.approx(bent.capacity_m)
        ratio = found[f"bent {number} P-Delta ratio"]["demand"]
        height_m = load_structure(bridge).description.bent_heights_m[number - 1]
        disp_m = row["column_drift_ratio"] * height_m
        assert ratio == pytest.approx(bent.p_delta_ratio(disp_m))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--skew-deg 75", "skew_deg must be within -66..66, got 75"),
        ("--bridge nowhere", "nowhere"),
        ("--scheme best", "'best' is not one of 'default', 'paper'"),
        ("--dt-s 0.5", "dt_s: must be less than or equal to 0.02, got 0.5"),
        ("--scale 0", "scale must be a positive number"),
        ("--set arrays=soft", "arrays: must be 'rigid' or 'corotational', got 'soft'"),
        ("--set transverse_gap_mm=-1", "transverse_gap_mm: must be greater than"),
        ("--set array=rigid", "array: unknown key"),
        ("--set rigid", "--set takes KEY=VALUE, got 'rigid'"),
        ("--out {taken}", "taken"),  # a file in place of the folder
    ],
)
def test_bad_options_exit_with_2_and_name_the_limit(pair, tmp_path, options, words):
    (tmp_path / "taken").write_text("a file", encoding="utf-8")
    given = options.format(taken=tmp_path / "taken").split()
    code, answer = run(pair, tmp_path / "out", *given)
    assert (code, answer["status"]) == (2, "error")
    assert words in answer["message"]


def test_a_row_of_a_study_is_repeated_by_its_key(pair, tmp_path, monkeypatch):
    config = {"motions": {"folder": str(tmp_path), "count": 1}, "analysis": {"duration_s": 0.5}}
    path = tmp_path / "study" / "config" / "config.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(config | {"results": "elsewhere"}), encoding="utf-8")
    monkeypatch.chdir(tmp_path / "study")
    parsed, folder = load_config(path), StudyFolder(tmp_path / "study" / "elsewhere")
    prepare_motions(parsed)
    task = StudySetup.of(parsed).tasks("osb1_cf_skew30_gap051_mu050")[0]
    result = outcome_of(task.analyse()) | {"wall_s": 0.0, "cpu_s": 0.0, "suspect": ""}
    row = row_of_task(result, task, run_key(task))
    write_table(to_table([row], {}), folder.demands)
    options = ("--out", tmp_path / "out", "--no-figures")
    again = answer("run", "--row", row["run_key"], *options)
    names = ["run_key", *(column.name for column in DEMAND_COLUMNS)]
    assert {name: again[name] for name in names} == {name: row[name] for name in names}
    unknown = answer("run", "--row", "f00", *options, code=2)
    assert "no such run_key" in unknown["message"]


TESTS = Path(__file__).parents[1]
MAX_MB = 400.0
MAX_GROWTH_MB = 4.0  # a thread's arena that the allocator takes late; a leak would be far more

SCRIPT = """
import psutil
from strong_motion import strong_motion
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

motion, settings = strong_motion(), AnalysisSettings(duration_s=0.05)
for number in range(100):
    case = Variant(bridge="osb1", abutment="contact_friction", skew_deg=15 * (number % 4),
                   gap_mm=51, friction_pct=50)
    analyse(case, Excitation(motion=motion), settings, ModelOptions(), histories=True)
    if number in (19, 99):
        print(psutil.Process().memory_info().rss / 2**20)
"""


def test_a_hundred_analyses_in_one_process_keep_its_memory_flat():
    command = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(command, cwd=TESTS, capture_output=True, text=True, check=True)
    early_mb, late_mb = (float(line) for line in done.stdout.split())
    assert late_mb < MAX_MB
    assert late_mb - early_mb < MAX_GROWTH_MB
