"""Commands `bridge` and `run`: answers, files, exit codes; doubts about a bridge; memory."""

import json
import logging
import subprocess
import sys
from dataclasses import replace
from functools import partial
from itertools import product
from math import cos, radians
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from click.testing import Result
from reference_pages import ROOT

import cli_json
from bridge_variants import variant
from motions_files import at2_text
from reference_data import BAD
from skewbridge.analysis import bridge_check, modal, pushover
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacities, bent_capacity
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import model_geometry
from skewbridge.bridge.structures import built_bridge
from skewbridge.demands.columns import COLUMNS, DEMAND_COLUMNS
from skewbridge.demands.tables import to_table
from skewbridge.demands.validity import with_suspect
from skewbridge.files.tables import write_table
from skewbridge.fragility.rates import Decision
from skewbridge.report.appearance import shown_in
from skewbridge.report.bridge_figures import column_figure, model_figure, with_codes
from skewbridge.report.run_figures import run_figures
from skewbridge.study.analyses import StudySetup
from skewbridge.study.batch import row_of_task
from skewbridge.study.config import load_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import outcome_of, run_key
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions
from strong_motion import DT_S, strong_motion

bridge, answer = partial(cli_json.invoke, "bridge"), partial(cli_json.answer, "bridge")
SUPPORT = {"support_length_m": 0.863}  # of osb1 with the default options
SIDES, CORNERS = ("left", "right"), ("acute", "obtuse")
LONGER = 'extends: osb1\ntitle: longer\nspans_m: {v: [50.0, 50.0], src: "d: a test"}\n'
FAULTS = "deck: {width_m: -1.0}\ncolumn: {bar_count: 2}\n"
TURNED = "abutments: {left: {type: roller}, right: {skew_deg: 40, seat_width_m: 0.65}}\n"
NARROW = """abutment: {seat_width_m: 0.8}
base: fixed
joints: [{from_left_m: 40, ledge: right, gap_mm: 30, seat_width_m: 0.62,
          pads: {plan_mm: 400, rubber_mm: 50, count: 6}}]
"""
CABLES = "{count: 8, stiffness_kn_per_m: 5000, yield_kn: 170, slack_mm: 2.5}"
HEAVY = "base: fixed\ndeck: {line_load_kn_per_m: 560.0}\ncolumn: {hoop_spacing_mm: 600.0}\n"
VARIANT = variant()


def one_line(result: Result) -> str:
    return result.stderr.replace("\n", " ")


def test_modal_answers_weight_axial_forces_and_mass_ratios(tmp_path: Path) -> None:
    found = answer("modal", "--bridge", "osb1", "--skew-deg", "30", "--out", str(tmp_path))
    # the cap of a bent parallel to the abutments and both diaphragms are longer by 1 / cos
    longer_kn = (801.0 + 2 * 321.0) * (1.0 / cos(radians(30.0)) - 1.0)
    assert found["weight_kn"] == pytest.approx(19_055 + longer_kn, rel=1e-3)
    assert found["t1_s"] == pytest.approx(load_bridge("osb1").t1_s, rel=0.002)
    assert sum(mode["mass_x"] for mode in found["modes"]) == pytest.approx(1.0, abs=0.05)
    assert len(pd.read_parquet(tmp_path / "modal.parquet")) == len(found["modes"])


@pytest.mark.parametrize("command", ["pushover", "static"])
def test_a_push_writes_its_curve(tmp_path: Path, command: str) -> None:
    found = answer(command, "--direction", "y", "--max-disp-m", "0.1", "--out", str(tmp_path))
    curve = pd.read_parquet(tmp_path / "curve.parquet")
    assert curve["disp_m"].iloc[-1] == pytest.approx(0.1, rel=0.01)
    assert found["peak_kn"] == curve["force_kn"].max()
    assert found["disp_at_peak_m"] == curve["disp_m"][curve["force_kn"].idxmax()]
    first_kn, first_m = curve["force_kn"][1], curve["disp_m"][1]
    assert found["initial_stiffness_kn_per_m"] == pytest.approx(first_kn / first_m)


def test_a_push_that_stops_early_names_the_deck_that_moved_farthest(written, monkeypatch, tmp_path):
    def stopped(*case, push=pushover.push_bridge, **given):
        return replace(push(*case, steps=4, **given), is_complete=False)

    monkeypatch.setattr(pushover, "push_bridge", stopped)
    own = written(f"extends: osb1\nsource: own\n{NARROW}")  # the left deck has no column
    result = bridge("pushover", own, "--max-disp-m", "0.02", "--out", tmp_path)
    assert "; the deck from left end to joint 1 had moved farthest, 0.0" in one_line(result)
    assert one_line(result).count("a push stopped at last_disp_m") == 1


def test_models_and_columns_are_drawn_and_written(tmp_path) -> None:
    found = answer("model", "osb2s", "--skew-deg", "-30", "--out", str(tmp_path))
    assert found["variant"] == "osb2s_cf_skewm30_gap051_mu050"
    assert (tmp_path / "model.png").stat().st_size > 10_000
    assert "ops.element" in (tmp_path / "model.py").read_text(encoding="utf-8")
    found = answer("column", "osb2s", "--out", tmp_path)["columns"][1]
    assert (found["bent"], found["axial_kn"]) == (2, pytest.approx(7_412, rel=0.01))
    assert found["shear_strength_kn"] == answer("sdc", "osb2s")["bents"][1]["shear_strength_kn"]
    curve = pd.read_parquet(tmp_path / "moment_curvature_bent_2.parquet")
    assert curve["moment_knm"].max() > found["plastic_moment_knm"]
    assert (tmp_path / "column_bent_2.png").stat().st_size > 10_000


def test_figures_are_drawn_in_us_units() -> None:
    bent = bent_capacities(load_bridge("osb1"))[0]
    geometry = model_geometry(variant(skew_deg=0), ModelOptions())
    with shown_in("us"):
        bending, _ = column_figure(bent.curve, bent.shear, bent.axial_n, title="").axes
        plan = model_figure(geometry).axes[0]
    assert np.nanmax(plan.lines[1].get_xdata()) == pytest.approx(150.0)  # one span, ft
    assert plan.get_xlabel() == "x, longitudinal (ft)"
    assert bending.get_ylabel() == "moment (kip ft)"
    assert bending.lines[1].get_ydata()[-1] * 1355.818 == pytest.approx(
        bent.curve.plastic_moment_nm
    )


def test_the_whole_ladder_is_pushed_and_drawn(tmp_path: Path) -> None:
    found = answer("static", "--abutment", "all", "--max-disp-m", "0.08", "--out", str(tmp_path))
    assert pd.read_parquet(tmp_path / "curve.parquet")["abutment"].nunique() == 5
    peaks = {(row["abutment"], row["angle_deg"]): row["peak_kn"] for row in found["pushes"]}
    assert peaks["roller", 0.0] == 0.0
    assert peaks["contact", 0.0] == pytest.approx(peaks["spring", 0.0], rel=0.03)
    assert (tmp_path / "ladder.png").stat().st_size > 10_000


def test_a_wall_has_a_curve_and_a_row_of_capacities_in_each_direction(tmp_path, written) -> None:
    wall = "column: {shape: rectangular, width_m: 2.4, depth_m: 1.0, tie_legs: [4, 8]}"
    path = written(f"extends: osb1\nsource: 'd: a test'\n{wall}\n")
    normal, along = answer("column", "--bridge", path, "--out", tmp_path)["columns"]
    assert (normal["direction"], along["direction"]) == ("normal", "along")
    assert along["plastic_moment_knm"] > 2 * normal["plastic_moment_knm"]
    for end, row in (("_normal", normal), ("_along", along)):
        curve = pd.read_parquet(tmp_path / f"moment_curvature{end}.parquet")
        assert curve["curvature_per_m"].max() == pytest.approx(row["ultimate_curvature_per_m"])
        assert (tmp_path / f"column{end}.png").stat().st_size > 10_000
    found = answer("sdc", path)["bents"]
    assert [(row["bent"], row["direction"]) for row in found] == [(1, "normal"), (1, "along")]
    assert found[1]["capacity_m"] < found[0]["capacity_m"]


def corner_histories() -> dict[str, np.ndarray]:
    places = product(SIDES, CORNERS)
    unseating_m = {f"abutment_{side}_{kind}_unseating_m": np.zeros(2) for side, kind in places}
    return unseating_m | {f"column_{n}_drift_ratio": np.array([0.0, 0.02]) for n in (1, 2)}


def test_checks_of_a_run_need_the_file_of_an_own_bridge(tmp_path: Path, written) -> None:
    own = written("extends: osb1\nbase: fixed\n")
    row = {"variant": "made_cf_skew30_gap051_mu050", "bridge": "made", "column_drift_ratio": 0.02}
    row |= {"abutment": "contact_friction", "skew_deg": 30, "gap_mm": 51, "friction": 0.5} | SUPPORT
    bents = bridge_check.capacity_rows(bent_capacities(load_bridge(own)))
    tables = {"demands": [row], "capacities": bents, "histories": corner_histories()}
    for name, table in tables.items():
        pd.DataFrame(table).to_parquet(tmp_path / f"{name}.parquet")
    first = answer("sdc", tmp_path, "--bridge", own)["checks"][0]
    assert first["check"] == "bent 1 displacement, hinge by rule (m)"
    assert "bridge made is unknown: give its file" in one_line(bridge("sdc", tmp_path))
    assert "is a script: a bridge file" in one_line(bridge("sdc", ROOT / "docs/own_bridge.py"))


def test_a_bridge_gets_the_capacities_of_its_bents(written) -> None:
    bents = answer("sdc", "osb2s")["bents"]
    assert [bent["p_delta_ratio"] for bent in bents] == pytest.approx([0.39, 0.43], abs=0.01)
    # the file of a bridge may give the length of the hinges
    text = "extends: {}\ncolumn: {{hinge_length_m: {{v: {}, src: 'd: a test'}}}}\n"
    for parent, length_m, is_ok in (("osb1", 0.7, [True]), ("osb2s", 0.9, [False, False])):
        path = written(text.format(parent, length_m))
        own = pd.DataFrame(answer("sdc", path)["bents"])
        assert set(own["hinge_length_m"]) == {length_m}
        assert set(own["hinge_length_by"]) == {"file"}
        assert own["ok"].tolist() == is_ok
    # in double curvature the point of contraflexure moves half as far as the deck (SDC 1.7 4.2)
    (bent,) = answer("sdc", "osb1_fixed_era1")["bents"]
    moment_knm = bent["p_delta_ratio"] * bent["plastic_moment_knm"]
    assert moment_knm == pytest.approx(bent["axial_kn"] * bent["capacity_m"] / 2)
    assert not bent["ok"]  # brittle in shear
    shown = one_line(bridge("sdc", "osb1_fixed_era1"))
    assert "warning: bent 1: forecast: the plastic shear" in shown
    # design by SDC 1.7 3.6.1 and 4.3.1: 1.2 Mp / L against 0.9 Vn
    design = f"1.2 Mp/L = {1.2 * bent['plastic_shear_kn']:.0f} kN"
    assert f"{design}, is above 0.9 Vn = {0.9 * bent['shear_strength_kn']:.0f} kN" in shown


def test_an_axis_that_the_model_or_the_file_replaces_has_no_effect(tmp_path, monkeypatch):
    spring = bridge("model", "--abutment", "spring", "--friction", 0.3, "--out", tmp_path)
    assert "friction has no effect with abutment model spring" in one_line(spring)
    path = tmp_path / "own.yaml"
    path.write_text("{extends: osb1, title: own gap, source: plan, abutment: {gap_mm: 40}}")
    shown = bridge("model", "--bridge", path, "--gap-mm", 25, "--out", tmp_path)
    assert "40 mm at the left end, 40 mm at the right end; gap_mm has no effect" in one_line(shown)
    assert "own_cf_skew00_gap040_mu050" in shown.stdout
    draw = "skewbridge.cli.bridge._draw_model"
    monkeypatch.setattr(draw, lambda drawn, *_: sys.stdout.write(drawn.slug))
    assert "own_cf_skew30_gap040_mu050" in bridge("check", path, "--out", tmp_path).stdout
    lengths = {"seat_m": [0.325], "seat_m_low": [0.225], "hazus_m": [0.425]}
    table = pd.DataFrame({"skew_deg": [30.0], "gap_mm": [25.0], "sdc_demand_m": [0.9]} | lengths)
    (row,) = with_codes(Decision(table, 1e-3, {}, 0.95, []), str(path)).table.to_dict("records")
    assert row["gap_mm"] == pytest.approx(40.0)  # 15 mm more than that of the study
    found = [row[name] for name in (*lengths, "sdc_m")]
    assert found == pytest.approx([0.34, 0.24, 0.44, 0.9 + 0.1016 + 0.04572 + 0.04])
    # the seat with the larger gap needs the longer length, whether or not the file states it
    ends = "{left: {type: seat, gap_mm: 40}, right: {type: seat, skew_deg: 60}}"
    path = tmp_path / "one_end.yaml"
    path.write_text(f"{{extends: osb1, title: own gap, source: plan, abutments: {ends}}}")
    for of_study, more_m in ((table, 0.015), (table.assign(gap_mm=51.0), 0.0)):
        result = with_codes(Decision(of_study, 1e-3, {}, 0.95, []), str(path))
        (row,) = result.table.to_dict("records")
        assert row["gap_mm"] == of_study["gap_mm"].item()
        assert row["seat_m"] == pytest.approx(0.325 + more_m)
        gap_m = row["gap_mm"] / 1000.0 + more_m
        assert row["aashto_m"] == pytest.approx(0.85521 + gap_m)  # at skew 60


def test_bridges_are_listed_and_doubted_if_no_study_can_use_them(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (own := tmp_path / "config/bridges").mkdir(parents=True)
    (own / "half.yaml").write_text("title: [")
    assert "osb1" in [row["bridge"] for row in answer("list")["bridges"]]
    assert "half is left out" in one_line(bridge("list"))
    (own / "Mine-1.yaml").write_text("{extends: osb1, title: own}")
    assert "rename Mine-1: studies need" in answer("check", "Mine-1")["findings"][0]
    found = answer("check", "osb1", "--out", tmp_path)
    assert found["findings"] == []
    # 6014 kN over 35.85 MPa on a circle of 1.676 m
    (ratio,) = (bent["axial_load_ratio"] for bent in found["bents"])
    assert ratio == pytest.approx(6014 / 35.85e3 / 2.2061, rel=1e-3)


def test_changed_spans_are_reported_with_the_model_period(tmp_path, caplog, written):
    longer = written(LONGER)
    result = bridge("check", longer, "--out", tmp_path / "out")
    model_s = modal.conditioning_period_s(modal.standing_bridge(longer))
    assert result.exit_code == 0
    assert model_s > 1.06 * load_bridge(longer).t1_s
    assert f"T1 of its model, {model_s:.4g} s" in result.stderr
    assert "t1_s = 0.7192 s differs" in bridge("modal", "--bridge", longer).stderr
    with caplog.at_level(logging.WARNING):  # once per bridge
        modal.warn_of_periods(["osb1", longer, longer])
    assert [record.message.split(":")[0] for record in caplog.records] == ["made"]


def test_a_period_within_five_percent_is_accepted_and_shared_directions_reported(written) -> None:
    modes = modal.standing_bridge("osb1")
    for factor, change in ((1.049, ""), (0.951, ""), (1.051, "+5.1%"), (0.949, "-5.1%")):
        t1_s = factor * modal.conditioning_period_s(modes)
        path = written(f'extends: osb1\nt1_s: {{v: {t1_s:.6f}, src: "d: a test"}}\n')
        messages = modal.periods_of_file(path, modes)
        assert (change in messages[0]) if change else messages == []
    # long spans move vertically with the longitudinal motion of a pinned bent
    path = written(LONGER.replace("50.0", "55.0"))
    messages = modal.periods_of_file(path, modal.standing_bridge(path))
    assert "the longitudinal motion is shared by modes of" in " ".join(messages)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (HEAVY, 0, ("axial load ratio 0.2", "the plastic shear of a column")),
        (FAULTS, 2, ("deck.width_m", "column.bar_count")),  # all faults of a file
        # 1.5 x (8 + 0.02 x 300 + 0.08 x 18.5) x (1 + 0.000125 x 40^2) in
        (TURNED, 0, ("0.65 m less 51 mm of gap leaves 0.599 m, below 0.708 m by AASHTO",
                     "the bridge file sets the skew: 40 deg (right)")),
        # SDC: 24 in at a hinge, 30 in at an abutment
        (NARROW.replace("gap_mm", f"restrainers: {CABLES}, gap_mm"), 0,
         ("joints.0.restrainers.slack_mm = 2.5 is outside the usual 6 to 150",
          "right seat of 0.8 m less 51 mm of gap leaves 0.749 m, below 0.762 m by Calt",
          "joint 1 seat of 0.62 m less 30 mm of gap leaves 0.59 m, below 0.61 m by")),
    ],
)  # fmt: skip
def test_faults_of_columns_hoops_and_seats_are_reported(tmp_path, written, text, code, words):
    own = written(f"extends: osb1\nsource: 'd: a test'\n{text}")
    result = bridge("check", own, "--out", tmp_path)
    assert result.exit_code == code
    assert all(each in one_line(result) for each in words)


@pytest.mark.parametrize(
    ("name", "bent", "rule", "length_m"),
    [
        # 0.08 x 5640 + 0.022 x 469 x 35.8 = 451.2 + 369.4 mm (0.817 m in the inch form of the rule)
        ("osb1", 0, "sdc", 0.8206),
        # 0.08 x 2820 + 369.4 = 595.0 mm; the lower limit 0.044 x 469 x 35.8 = 738.8 mm governs
        *(("osb1_fixed", 0, "paulay_priestley", 0.5950), ("osb1_fixed", 0, "sdc", 0.7388)),
        # 0.08 x 13410 + 0.022 x 469 x 43.0 = 1072.8 + 443.7 mm
        ("osb2s", 0, "sdc", 1.5165),
    ],
)
def test_the_hinge_length_follows_from_height_and_base(name, bent, rule, length_m):
    found = bent_capacity(load_bridge(name), bent, rule)
    assert found.hinge_length_m == pytest.approx(length_m, abs=1e-4)


def test_yield_displacements_ductilities_and_seats_agree_with_the_hand_values() -> None:
    for name, yield_mm, ductility in (("osb1", 36.0, 5.8), ("osb2s", 179.0, 5.1)):
        bent = bent_capacities(load_bridge(name))[0]  # the study `bridges` has the capacity
        assert 1e3 * bent.yield_disp_m == pytest.approx(yield_mm, rel=0.05)
        assert bent.capacity_m / bent.yield_disp_m == pytest.approx(ductility, rel=0.05)
    osb1 = load_structure("osb1").description
    found_m = [bridge_check.seat_demand_aashto_m(osb1, "left", deg) for deg in (0, -30, 45, 60)]
    assert found_m == pytest.approx([0.59, 0.66, 0.74, 0.86], abs=0.006)
    held = replace(osb1, end_kinds={"left": "seat", "right": "integral"})
    cases = (osb1, 0.0), (osb1, 1.0), (held, 1.0)
    demands_m = [bridge_check.seat_demand_sdc_m(bridge, moved_m) for bridge, moved_m in cases]
    assert demands_m == pytest.approx([0.762, 1.1016 + 0.04572, 1.1016 + 0.09144])  # minimum first
    # each seat has the length and the columns of its own deck; a hinge those of both sides
    spans = load_structure(ROOT / "docs/bridges/simple_spans.yaml").description
    spans = replace(spans, bent_heights_m=(4.0, 6.0, 9.0))
    hinge = replace(spans, joints_m={"40 m from the left": -18.0})
    cases = {"left": (28, 4), "joint 1": (30, 4), "joint 3": (30, 9), "right": (28, 9)}
    hinge_cases = {"left": (40, 4), "joint 1": (116, 5), "right": (76, 7.5)}
    for bridge_of, seats in ((spans, cases), (hinge, hinge_cases)):
        for seat, (length_m, height_m) in seats.items():
            least_m = 1.5 * (8 + (0.02 * length_m + 0.08 * height_m) / 0.3048) * 0.0254
            assert bridge_check.seat_demand_aashto_m(bridge_of, seat, 0.0) == pytest.approx(least_m)


def test_each_corner_is_compared_with_its_own_seat(written) -> None:
    left, right = "{seat_width_m: 0.65, gap_mm: 20}", "{seat_width_m: 0.9, skew_deg: 60}"
    own = written(f"extends: osb1\nsource: own\nabutments: {{left: {left}, right: {right}}}\n")
    histories = corner_histories()
    histories["abutment_right_acute_unseating_m"][1] = 0.3
    case = replace(VARIANT, bridge=str(own), skew_deg=0)
    about, run = load_structure(own).description, {"column_drift_ratio": 0.0} | SUPPORT
    assert bridge_check.corner_moves_m(about, histories, 0.63)["right acute"] == (0.3, 0.63)
    for end, gap_m in (("left", 0.02), ("right", 0.05)):
        histories[f"contact_{end}_backwall_1_opening_m"] = np.array([gap_m, 0.0])
    rows = bridge_check.sdc_rows(case, run, [], histories)
    assert [row["capacity"] for row in rows] == pytest.approx([0.63, 0.63, 0.85, 0.85, 0.85])
    assert rows[-1]["demand"] == pytest.approx(0.86, abs=0.006)  # at skew 60
    assert [row["ok"] for row in rows] == [False, False, True, True, False]


@pytest.mark.parametrize(("at", "lost"), [("at: bent 1", 0.5), ("from_left_m: 40.0", 1.0)])
def test_the_seats_of_an_inner_joint_are_checked(written, at: str, lost: float) -> None:
    pads = "{plan_mm: 400, rubber_mm: 50, count: 6}"
    joint = f"{{{at}, skew_deg: 15, seat_width_m: 0.6, pads: {pads}}}"
    ends = "abutments: {left: {type: integral}, right: {type: roller}}"
    deck = f"base: fixed\ndeck: {{soffit_height_m: 8.0}}\n{ends}\njoints: [{joint}]\n"
    variant = replace(VARIANT, bridge=written(f"extends: osb1\nsource: own\n{deck}"))
    histories = {"joint1_unseating_m": np.array([0.0, 0.3, 0.1]),
                 "contact_joint_1_1_opening_m": np.array([0.04, 0.34, 0.0])}  # fmt: skip
    run = {"column_drift_ratio": 0.02, "support_length_m": float("nan")}
    sdc, aashto = bridge_check.sdc_rows(variant, run, [], histories)
    assert [row["check"][:15] for row in (sdc, aashto)] == ["joint 1 seat, S", "joint 1 seat, A"]
    assert sdc["capacity"] == aashto["capacity"] == pytest.approx(0.6 - lost * 0.04)
    deck_m = 45.72 if at.startswith("at") else 91.44
    assert sdc["demand"] == pytest.approx(max(0.3 + 0.1016 + deck_m / 2000, 0.6096))  # 7.2.5.4
    bridge = load_structure(variant.bridge).description
    assert aashto["demand"] == bridge_check.seat_demand_aashto_m(bridge, "joint 1", 0)


@pytest.fixture
def pair(tmp_path):
    motion = strong_motion(duration_s=3.0)
    paths = [tmp_path / f"strong{azimuth}.AT2" for azimuth in ("090", "180")]
    for path, accel_mps2 in zip(paths, motion.components, strict=True):
        path.write_text(at2_text(accel_mps2 / G_MPS2, DT_S))
    return list(map(str, paths))


def run(pair, out, *options):
    return cli_json.run("run", "--motion", *pair, "--out", out, *options)


def test_a_run_leaves_its_row_histories_and_figures(pair, tmp_path):
    out = tmp_path / "out"
    code, row = run(pair, out, "--skew-deg", "30", "--abutment", "contact-friction")
    assert (code, row["status"], row["variant"]) == (0, "ok", "osb1_cf_skew30_gap051_mu050")
    assert int(row["steps_by_rung"].split()[0]) >= 3.0 / AnalysisSettings().dt_s
    table = pq.read_table(out / "demands.parquet")
    assert (table.column_names, table.num_rows) == ([column.name for column in COLUMNS], 1)
    histories = pd.read_parquet(out / "histories.parquet")
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
    assert "contacts" not in run_figures(0.0 * histories, title="none closes")


@pytest.fixture
def no_figures(monkeypatch):
    monkeypatch.setattr("skewbridge.report.run_figures.run_figures", lambda *_, **__: {})


def test_a_roller_has_no_contacts_to_draw_and_a_collapse_is_a_result(pair, tmp_path, written):
    code, row = run(pair, tmp_path / "out", "--abutment", "roller", "--duration-s", "0.5")
    assert (code, row["variant"]) == (0, "osb1_ro_skew00_gap000_mu000")
    assert row["support_length_m"] == pytest.approx(0.914)  # no gap
    assert not (tmp_path / "out" / "contacts.png").exists()
    seat = written("extends: osb1\nabutment: {seat_width_m: {v: 36.0, src: 'd: inches'}}\n")
    given = ("--motion", *pair, "--out", tmp_path, "--scale", "4", "--json")
    result = cli_json.invoke("run", *given, "--bridge", seat)
    for text in ("at right angles", "seat_width_m = 36 is outside the usual", "fails in flexure"):
        assert (result.exit_code, text in one_line(result)) == (0, True)
    assert json.loads(result.stdout)["collapse_criterion"] == "column_drift_ratio"
    assert "fails in" in one_line(cli_json.invoke("bridge", "sdc", tmp_path, "--bridge", seat))


@pytest.mark.parametrize(
    ("bridge", "changes"),
    [
        ("osb1", {"gap_offset_mm": 10}), ("osb1", {"gap_offset_mm": -60}),  # the gap is at least 0
        ("osb1", {"gap_measured": "longitudinal"}), ("osb2s", {"deck_mass_factor": 1.3}),
        ("osb1_fixed", {"hinge_rule": "paulay_priestley"}),
        ("osb2s", {"steel_strength_factor": 0.8, "concrete_strength_factor": 1.2}),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("no_figures")
def test_the_design_criteria_have_the_capacities_of_the_model(pair, tmp_path, bridge, changes):
    texts = [text for key, value in changes.items() for text in ("--set", f"{key}={value}")]
    case = ("--bridge", bridge, "--skew-deg", "60", "--gap-mm", "51", "--duration-s", "0.05")
    code, row = run(pair, tmp_path, *case, *texts)
    assert code == 0, row
    options = ModelOptions(**changes)
    narrowing = 0.5 if options.gap_measured == "longitudinal" else 1.0  # cos(60)
    support_m = 0.914 - max(0.051 * narrowing + 1e-3 * options.gap_offset_mm, 0.0)
    scaled = built_bridge(load_bridge(bridge), options, 60.0)
    bents = [bent_capacity(scaled, at, options.hinge_rule) for at in range(len(scaled.bents))]
    checks = answer("sdc", tmp_path)["checks"]
    seats = [check["capacity"] for check in checks if "seat" in check["check"]]
    assert [row["support_length_m"], *seats] == pytest.approx([support_m] * 6)
    found = {check["check"]: check for check in checks}
    histories = pd.read_parquet(tmp_path / "histories.parquet")
    drifts = histories.filter(regex=r"column_\d_drift_ratio").max().to_numpy()  # two at each bent
    for number, bent in enumerate(bents, start=1):
        found_m = found[f"bent {number} displacement, hinge by rule (m)"]
        assert found_m["capacity"] == pytest.approx(bent.capacity_m)
        ratio = found[f"bent {number} P-Delta ratio"]["demand"]
        shear_kn = found[f"bent {number} column shear, 1.2 Mp/L, 0.9 Vn (kN)"]["demand"]
        assert shear_kn == pytest.approx(1.2e-3 * bent.curve.plastic_moment_nm / bent.shear_span_m)
        height_m = load_structure(bridge).description.bent_heights_m[number - 1]
        share_m = row["drift_over_capacity"] * bent.capacity_m
        drift = min(row["column_drift_ratio"], drifts[2 * number - 2 : 2 * number].max())
        assert ratio == pytest.approx(bent.p_delta_ratio(min(drift * height_m, share_m)))


@pytest.mark.parametrize(("arguments", "message"), BAD["commands"])
def test_bad_input_is_named_and_exits_with_2(pair, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    motion = f"--motion {' '.join(pair)} --out out"
    found = cli_json.answer(*arguments.format(motion).split(), code=2)
    assert (found["status"], message in found["message"]) == ("error", True), found


@pytest.mark.usefixtures("no_figures")
def test_a_row_of_a_study_is_repeated_by_its_key(pair, tmp_path, monkeypatch):
    config = {"motions": {"folder": str(tmp_path), "count": 1}, "analysis": {"duration_s": 0.5}}
    path = tmp_path / "study" / "config" / "config.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(config | {"results": "elsewhere"}), encoding="utf-8")
    monkeypatch.chdir(tmp_path / "study")
    parsed, folder = load_config(path), StudyFolder(tmp_path / "study" / "elsewhere")
    prepare_motions(parsed)
    task = StudySetup.of(parsed).tasks("osb1_cf_skew30_gap051_mu050")[0]
    result = outcome_of(task.analyse()) | {"wall_s": 0.0, "cpu_s": 0.0}
    row = with_suspect(row_of_task(result, task, run_key(task)))
    write_table(to_table([row], {}), folder.demands)
    options = ("--out", tmp_path / "out", "--row")
    again = cli_json.answer("run", *options, row["run_key"])
    names = ["run_key", *(column.name for column in DEMAND_COLUMNS)]
    assert {name: again[name] for name in names} == {name: row[name] for name in names}
    assert "no such run_key" in cli_json.answer("run", *options, "f00", code=2)["message"]


SCRIPT = """
import psutil
from bridge_variants import analysed, variant

for number in range(100):
    analysed(variant(15 * (number % 4)), duration_s=0.05)
    if number in (19, 99):
        print(psutil.Process().memory_info().rss / 2**20)
"""


def test_a_hundred_analyses_in_one_process_keep_its_memory_flat():
    shown = subprocess.check_output([sys.executable, "-c", SCRIPT], cwd=ROOT / "tests", text=True)
    early_mb, late_mb = map(float, shown.split())
    # a thread's arena that the allocator takes late; a leak would be far more
    assert late_mb - early_mb < 4.0
