"""The commands of the bridge package, from outside; doubts about a bridge file and its period."""

import logging
from dataclasses import replace
from functools import partial
from itertools import product
from math import cos, radians
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import Result
from reference_pages import ROOT

import cli_json
from bridge_variants import variant
from cli_json import invoke
from skewbridge.analysis import bridge_check, modal
from skewbridge.analysis.bridge_check import sdc_rows
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacities, bent_capacity
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, domain
from skewbridge.fragility.rates import Decision
from skewbridge.report.bridge_figures import with_codes
from skewbridge.variant.options import ModelOptions

bridge, answer = partial(invoke, "bridge"), partial(cli_json.answer, "bridge")


def one_line(result: Result) -> str:
    return result.stderr.replace("\n", " ")


def test_all_bridges_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    names = [row["bridge"] for row in answer("list")["bridges"]]
    assert {"osb1", "osb1_fixed_era1", "osb2s", "bridge_a", "painter", "template"} <= set(names)
    assert len(names) == 11


def test_modal_answers_weight_axial_forces_and_mass_ratios(tmp_path: Path) -> None:
    found = answer("modal", "--bridge", "osb1", "--skew-deg", "30", "--out", str(tmp_path))
    # the cap of a bent parallel to the abutments is longer by 1 / cos
    longer_kn = 801.0 * (1.0 / cos(radians(30.0)) - 1.0)
    assert found["weight_kn"] == pytest.approx(19_055 + longer_kn, rel=1e-3)
    assert found["t1_s"] == pytest.approx(load_bridge("osb1").t1_s, rel=0.002)
    assert len(found["column_axial_kn"]) == 2
    modes = found["modes"]
    assert {"period_s", "mass_x", "mass_y", "mass_rz"} <= set(modes[0])
    assert sum(mode["mass_x"] for mode in modes) == pytest.approx(1.0, abs=0.05)
    assert all(0.0 <= mode[k] <= 1.0 for mode in modes for k in ("mass_x", "mass_y", "mass_rz"))
    assert len(pd.read_parquet(tmp_path / "modal.parquet")) == len(modes)


@pytest.mark.parametrize("command", ["pushover", "static"])
def test_a_push_writes_its_curve(tmp_path: Path, command: str) -> None:
    found = answer(command, "--direction", "y", "--max-disp-m", "0.1", "--out", str(tmp_path))
    curve = pd.read_parquet(tmp_path / "curve.parquet")
    assert list(curve.columns) == ["disp_m", "force_kn"]
    assert curve["disp_m"].iloc[-1] == pytest.approx(0.1, rel=0.01)
    assert found["peak_kn"] == curve["force_kn"].max()
    assert found["disp_at_peak_m"] == curve["disp_m"][curve["force_kn"].idxmax()]
    first = curve["force_kn"][1] / curve["disp_m"][1]
    assert found["initial_stiffness_kn_per_m"] == pytest.approx(first)


def test_a_push_with_friction_passes_the_contact_with_the_wall(tmp_path: Path) -> None:
    options = ("--abutment", "contact-friction", "--skew-deg", 30, "--max-disp-m", 0.08)
    result = invoke("bridge", "pushover", *options, "--out", tmp_path)
    assert result.exit_code == 0
    curve = pd.read_parquet(tmp_path / "curve.parquet")
    assert curve["disp_m"].iloc[-1] == pytest.approx(0.08, rel=1e-5)
    # the wall resists after the contact
    before = np.interp(0.051 / cos(radians(30)), curve["disp_m"], curve["force_kn"])
    assert 1.2 * before < curve["force_kn"].max() < 2e4


def test_models_and_columns_are_drawn_and_written(tmp_path) -> None:
    found = answer("model", "--skew-deg", "-30", "--bridge", "osb2s", "--out", str(tmp_path))
    assert found["variant"] == "osb2s_cf_skewm30_gap051_mu050"
    assert (tmp_path / "model.png").stat().st_size > 10_000
    assert "ops.element" in (tmp_path / "model.py").read_text(encoding="utf-8")
    found = answer("column", "--bridge", "osb2s", "--bent", "2", "--out", tmp_path)
    assert found["axial_kn"] == pytest.approx(7_412, rel=0.01)
    curve = pd.read_parquet(tmp_path / "moment_curvature.parquet")
    assert curve["moment_knm"].max() > found["plastic_moment_knm"]
    assert (tmp_path / "column.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("modal --bridge osb9", "bridge must be one of"),
        ("modal --bridge osb1_fixd", "did you mean osb1_fixed?"),
        ("modal --skew-deg 75", "skew_deg must be within -66..66, got 75"),
        ("modal --set column_integration=simpson", "column_integration: must be 'hinge"),
        ("pushover --direction z --out .", "'z' is not one of 'x', 'y'"),
        ("static --max-disp-m -1 --out .", "max_disp_m must be within"),
        ("static --set backfill=clay --out .", "backfill: must be 'hyperbolic'"),
        ("column --bent 2 --out .", "bent must be between 1 and 1"),
        ("sdc nowhere", "nowhere"),
    ],
)
def test_bad_input_is_named_and_exits_with_2(arguments: str, message: str) -> None:
    result = bridge(*arguments.split())
    assert result.exit_code == 2
    assert message in one_line(result)


def test_the_whole_ladder_is_pushed_and_drawn(tmp_path: Path) -> None:
    found = answer("static", "--abutment", "all", "--max-disp-m", "0.08", "--out", str(tmp_path))
    curves = pd.read_parquet(tmp_path / "curve.parquet")
    assert curves["abutment"].nunique() == 5
    peaks = {(row["abutment"], row["angle_deg"]): row["peak_kn"] for row in found["pushes"]}
    assert peaks["roller", 0.0] == 0.0
    assert peaks["contact", 0.0] == pytest.approx(peaks["spring", 0.0], rel=0.03)
    assert (tmp_path / "ladder.png").stat().st_size > 10_000


WALL = """extends: osb1
column:
  shape: rectangular
  width_m: {v: 2.4, src: "d: a test"}
  depth_m: {v: 1.0, src: "d: a test"}
  tie_legs: {v: [4, 8], src: "d: a test"}
"""


def test_a_wall_has_a_curve_and_a_row_of_capacities_in_each_direction(tmp_path: Path) -> None:
    path = tmp_path / "wall.yaml"
    path.write_text(WALL, encoding="utf-8")
    normal, along = answer("column", "--bridge", path, "--out", tmp_path)["directions"]
    assert (normal["direction"], along["direction"]) == ("normal", "along")
    assert along["plastic_moment_knm"] > 2 * normal["plastic_moment_knm"]
    for row in (normal, along):
        end = f"_{row['direction']}"
        curve = pd.read_parquet(tmp_path / f"moment_curvature{end}.parquet")
        assert curve["curvature_per_m"].max() == pytest.approx(row["ultimate_curvature_per_m"])
        assert (tmp_path / f"column{end}.png").stat().st_size > 10_000
    found = answer("sdc", path)["bents"]
    assert [(row["bent"], row["direction"]) for row in found] == [(1, "normal"), (1, "along")]
    assert found[1]["capacity_m"] < found[0]["capacity_m"]


SUPPORT = {"support_length_m": 0.863}  # of osb1 with the default options
SIDES, CORNERS = ("left", "right"), ("acute", "obtuse")


def corner_histories() -> dict[str, np.ndarray]:
    """Return histories of the corners, which do not move in two steps."""
    places = product(SIDES, CORNERS, "xy")
    return {f"abutment_{side}_{kind}_{axis}_m": np.zeros(2) for side, kind, axis in places}


def test_checks_of_a_run_name_every_corner(tmp_path: Path) -> None:
    def checks(variant: str, *options: object) -> list[dict]:
        row = {"variant": f"{variant}_cf_skew30_gap051_mu050", "column_drift_ratio": 0.02}
        row |= {"bridge": variant, "abutment": "contact_friction"}
        row |= {"skew_deg": 30, "gap_mm": 51, "friction": 0.5}
        pd.DataFrame([row | SUPPORT]).to_parquet(tmp_path / "demands.parquet")
        bents = bridge_check.capacity_rows(
            bent_capacities(load_bridge(own if options else variant))
        )
        pd.DataFrame(bents).to_parquet(tmp_path / "capacities.parquet")
        return answer("sdc", tmp_path, *options)["checks"]

    pd.DataFrame(corner_histories()).to_parquet(tmp_path / "histories.parquet")
    own = tmp_path / "own.yaml"
    own.write_text("extends: osb1\nbase: fixed\n")
    found = checks("osb1")
    assert sum("seat, SDC" in check["check"] for check in found) == 4
    assert all(check["ok"] for check in found)
    first = checks("own", "--bridge", own)[0]
    assert first["check"] == "bent 1 displacement, hinge 0.739 m by rule (m)"
    assert "give the file of its bridge own: --bridge" in one_line(
        invoke("bridge", "sdc", tmp_path)
    )
    script = ROOT / "docs/own_bridge.py"
    assert "a script has no data" in one_line(invoke("bridge", "sdc", script))


def test_the_seat_of_a_simple_span_follows_from_its_own_length() -> None:
    spans = load_structure(ROOT / "docs/bridges/simple_spans.yaml").description
    length_ft, height_ft = 30.0 / 0.3048, 5.6 / 0.3048  # not the 116 m of the bridge
    least_m = 1.5 * (8 + 0.02 * length_ft + 0.08 * height_ft) * 0.0254
    assert bridge_check.seat_demand_aashto_m(spans, 0.0) == pytest.approx(least_m)


def test_a_bridge_gets_the_capacities_of_its_bents(tmp_path: Path) -> None:
    bents = answer("sdc", "osb2s")["bents"]
    assert [bent["p_delta_ratio"] for bent in bents] == pytest.approx([0.39, 0.43], abs=0.01)
    assert not any(bent["ok"] for bent in bents)
    path = tmp_path / "own.yaml"
    path.write_text('extends: osb2s\ncolumn:\n  hinge_length_m: {v: 0.9, src: "d: a test"}\n')
    own = answer("sdc", str(path))["bents"]
    lengths = {(bent["hinge_length_m"], bent["hinge_length_by"]) for bent in own}
    assert lengths == {(0.9, "file")}
    capacities_m = [bent_capacity(load_bridge(name), 0).capacity_m for name in (path, "osb2s")]
    assert capacities_m[0] < capacities_m[1]
    path = tmp_path / "other.yaml"
    path.write_text('extends: osb1\ncolumn:\n  hinge_length_m: {v: 0.7, src: "d: a test"}\n')
    (bent,) = answer("sdc", str(path))["bents"]
    assert (bent["hinge_length_m"], bent["hinge_length_by"], bent["ok"]) == (0.7, "file", True)


def test_the_gap_of_the_file_of_a_bridge_is_the_one_that_is_printed(tmp_path: Path) -> None:
    path = tmp_path / "own.yaml"
    path.write_text("{extends: osb1, title: own gap, source: plan, abutment: {gap_mm: 40}}")
    shown = invoke("bridge", "model", "--bridge", path, "--out", tmp_path)
    note = "40 mm at the left end, 40 mm at the right end; gap_mm has no effect"
    assert note in one_line(shown)
    assert "gap" not in one_line(invoke("bridge", "model", "--out", tmp_path))
    ends = "abutments: {left: {type: integral}, right: {type: fixed}}"
    (tmp_path / "stiff.yaml").write_text(f"{{extends: osb1, title: stiff, {ends}}}")
    shown = invoke("bridge", "model", "--bridge", tmp_path / "stiff.yaml", "--out", tmp_path)
    assert "gap_mm and friction have no effect" in one_line(shown)
    lengths = {"seat_m": [0.325], "seat_m_low": [0.225], "hazus_m": [0.425]}
    table = pd.DataFrame({"skew_deg": [30.0], "gap_mm": [25.0], "sdc_demand_m": [0.9]} | lengths)
    (row,) = with_codes(Decision(table, 1e-3, {}, 0.95), str(path)).table.to_dict("records")
    assert row["gap_mm"] == pytest.approx(40.0)  # 15 mm more than that of the study
    found = [row[name] for name in (*lengths, "sdc_m")]
    sdc_m = 0.9 + 0.1016 + 0.04572
    assert found == pytest.approx([0.34, 0.24, 0.44, sdc_m + 0.04])


# --- `bridge check` and the period in a file


LONGER = 'extends: osb1\ntitle: longer\nspans_m: {v: [50.0, 50.0], src: "d: a test"}\n'


def test_a_bridge_of_the_catalogue_raises_no_doubts(tmp_path: Path) -> None:
    found = answer("check", "osb1", "--out", tmp_path)
    assert found["findings"] == []
    assert found["weight_kn"] == pytest.approx(19_055, rel=1e-3)
    assert found["t1_of_the_model_s"] == pytest.approx(found["t1_of_the_file_s"], rel=0.002)
    (bent,) = found["bents"]
    # 6014 kN over 35.85 MPa on a circle of 1.676 m
    assert bent["axial_load_ratio"] == pytest.approx(6014 / 35.85e3 / 2.2061, rel=1e-3)
    assert bent["plastic_shear_kn"] < bent["shear_strength_kn"]
    assert (tmp_path / "model.png").stat().st_size > 10_000


def test_changed_spans_are_reported_with_the_model_period(tmp_path, caplog):
    longer = str(tmp_path / "longer.yaml")
    Path(longer).write_text(LONGER)
    result = bridge("check", longer, "--out", tmp_path / "out")
    model_s = modal.conditioning_period_s(modal.standing_bridge(longer))
    assert result.exit_code == 0
    assert model_s > 1.06 * load_bridge(longer).t1_s
    assert f"T1 of its model, {model_s:.4g} s" in result.stderr
    assert "t1_s = 0.7192 s differs" in bridge("modal", "--bridge", longer).stderr
    config = tmp_path / "own.yaml"
    config.write_text(f"results: {tmp_path}/results\ngrid:\n  bridge: [{longer}]\n")
    result = invoke("plan", "--config", config)
    assert result.exit_code == 0, result.stderr
    assert "warning: longer: t1_s = 0.7192 s" in result.stderr
    caplog.clear()
    with caplog.at_level(logging.WARNING):  # once per bridge
        modal.warn_of_periods(["osb1", longer, longer])
    assert [record.message.split(":")[0] for record in caplog.records] == ["longer"]


def test_a_period_within_five_percent_is_accepted_and_shared_directions_reported(tmp_path) -> None:
    modes = modal.standing_bridge("osb1")
    for factor, change in ((1.049, ""), (0.951, ""), (1.051, "+5.1%"), (0.949, "-5.1%")):
        t1_s = factor * modal.conditioning_period_s(modes)
        path = tmp_path / f"own_{factor:.3f}.yaml"
        path.write_text(f'extends: osb1\nt1_s: {{v: {t1_s:.6f}, src: "d: a test"}}\n')
        messages = modal.periods_of_file(str(path), modes)
        assert (change in messages[0]) if change else messages == []
    # long spans move vertically with the longitudinal motion of a pinned bent
    path = tmp_path / "long.yaml"
    path.write_text(LONGER.replace("50.0", "55.0"))
    messages = modal.periods_of_file(str(path), modal.standing_bridge(str(path)))
    assert "the longitudinal motion is shared by modes of" in " ".join(messages)


FAULTS = ('deck:\n  width_m: {v: -1.0, src: "d: a test"}\n'
          'column:\n  bar_count: {v: 2, src: "d: a test"}\n')  # fmt: skip
HEAVY = ('base: fixed\ndeck:\n  line_load_kn_per_m: {v: 560.0, src: "d: a test"}\n'
         'column:\n  hoop_spacing_mm: {v: 600.0, src: "d: a test"}\n')  # fmt: skip


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (HEAVY, 0, ("axial load ratio 0.2", "the plastic shear of a column")),
        (FAULTS, 2, ("deck.width_m", "column.bar_count")),  # all faults of a file
    ],
)
def test_heavy_columns_weak_hoops_and_faults_of_a_file_are_reported(tmp_path, text, code, words):
    path = tmp_path / "own.yaml"
    path.write_text(f"extends: osb1\n{text}")
    result = bridge("check", path, "--out", tmp_path)
    assert result.exit_code == code
    assert all(each in one_line(result) for each in words)


# --- design checks against hand values of the project's reference page, sections 1 and 6


VARIANT = variant()


@pytest.mark.parametrize(
    ("name", "yield_mm", "ductility"), [("osb1", 36.0, 5.8), ("osb2s", 179.0, 5.1)]
)
def test_yield_displacement_and_ductility_agree_with_the_hand_values(name, yield_mm, ductility):
    bent = bent_capacities(load_bridge(name))[0]  # the study `bridges` has the capacity
    assert 1e3 * bent.yield_disp_m == pytest.approx(yield_mm, rel=0.05)
    assert bent.capacity_m / bent.yield_disp_m == pytest.approx(ductility, rel=0.05)


@pytest.mark.parametrize(
    ("name", "bent", "rule", "length_m"),
    [
        # 0.08 x 5640 + 0.022 x 469 x 35.8 = 451.2 + 369.4 mm (0.817 m in the inch form of the rule)
        ("osb1", 0, "sdc", 0.8206),
        # 0.08 x 2820 + 369.4 = 595.0 mm; the lower limit 0.044 x 469 x 35.8 = 738.8 mm governs
        ("osb1_fixed", 0, "paulay_priestley", 0.5950),
        ("osb1_fixed", 0, "sdc", 0.7388),
        # bents of different height: 0.08 x 13410 or 14330 + 0.022 x 469 x 43.0 = 443.7 mm
        ("osb2s", 0, "sdc", 1.5165),
        ("osb2s", 1, "sdc", 1.5901),
    ],
)
def test_the_hinge_length_follows_from_height_and_base(name, bent, rule, length_m):
    found = bent_capacity(load_bridge(name), bent, rule)
    assert found.hinge_length_m == pytest.approx(length_m, abs=1e-4)


@pytest.mark.parametrize(("skew_deg", "seat_m"), [(0, 0.59), (30, 0.66), (45, 0.74), (60, 0.86)])
def test_seat_widths_agree_with_the_hand_values(skew_deg: int, seat_m: float) -> None:
    bridge = load_structure("osb1").description
    found = bridge_check.seat_demand_aashto_m(bridge, radians(skew_deg))
    assert found == pytest.approx(seat_m, abs=0.006)
    assert bridge_check.seat_demand_aashto_m(bridge, radians(-skew_deg)) == found
    demands_m = [bridge_check.seat_demand_sdc_m(bridge, moved_m) for moved_m in (0.0, 1.0)]
    assert demands_m == pytest.approx([0.762, 1.0 + 0.1016 + 0.04572])  # the minimum first


def test_the_table_names_what_fails() -> None:
    bents = bridge_check.capacity_rows(bent_capacities(load_bridge("osb1")))
    moves_m = {"left acute": 0.2, "right acute": 0.9}
    rows = sdc_rows(VARIANT, {"column_drift_ratio": 0.30 / 5.64} | SUPPORT, bents, moves_m, {})
    assert rows[0]["demand"] == pytest.approx(0.30)  # drift x clear height
    failed = {row["check"] for row in rows if not row["ok"]}
    assert failed == {"bent 1 displacement, hinge 0.821 m by rule (m)", "right acute seat, SDC (m)"}


def test_corner_moves_count_outward_normal_to_the_seat_only() -> None:
    histories = corner_histories()
    histories["abutment_right_acute_x_m"][1] = -0.1
    histories["abutment_right_obtuse_x_m"][1] = 0.1
    # along the wall: no move normal to the seat
    histories["abutment_left_acute_x_m"][1] = -0.1 * np.sin(radians(30))
    histories["abutment_left_acute_y_m"][1] = 0.1 * np.cos(radians(30))
    moves = bridge_check.corner_moves_m(VARIANT, histories)
    assert moves["right acute"] == pytest.approx(0.1 * np.cos(radians(30)))
    assert moves["right obtuse"] == 0.0
    assert moves["left acute"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("at", "lost"), [("at: bent 1", 0.5), ("from_left_m: 40.0", 1.0)])
def test_the_seats_of_an_inner_joint_are_checked(tmp_path: Path, at: str, lost: float) -> None:
    pads = "{plan_mm: 400, rubber_mm: 50, count: 6}"
    joint = f"{{{at}, skew_deg: 15, seat_width_m: 0.6, pads: {pads}}}"
    ends = "{left: {type: integral}, right: {type: roller}}"
    deck = "{soffit_height_m: 8.0}"
    text = f"{{extends: osb1, source: own, base: fixed, deck: {deck}, abutments: {ends}, "
    text += f"joints: [{joint}]}}"
    (tmp_path / "mine.yaml").write_text(text)
    variant = replace(VARIANT, bridge=str(tmp_path / "mine.yaml"))
    histories = {
        "joint1_unseating_m": np.array([0.0, 0.3, 0.1]),
        "contact_joint_1_1_opening_m": np.array([0.04, 0.34, 0.0]),
    }
    moves_m = bridge_check.joint_moves_m(variant, histories)
    run = {"column_drift_ratio": 0.02, "support_length_m": float("nan")}
    sdc, aashto = sdc_rows(variant, run, [], {}, moves_m)
    assert (sdc["check"], aashto["check"]) == (
        "joint 1 seat, SDC (m)",
        "joint 1 seat, AASHTO 1.5 N (m)",
    )
    assert sdc["capacity"] == aashto["capacity"] == pytest.approx(0.6 - lost * 0.04)
    deck_m = 45.72 if at.startswith("at") else 91.44
    # at least 24 in by SDC 7.2.5.4
    assert sdc["demand"] == pytest.approx(max(0.3 + 0.1016 + deck_m / 2000, 0.6096))
    bridge = load_structure(variant.bridge).description
    assert aashto["demand"] == bridge_check.seat_demand_aashto_m(bridge, radians(15))
    assert bridge_check.corner_moves_m(variant, histories) == {}


@pytest.mark.parametrize(
    ("abutment", "gap_mm", "support_m"),
    [("contact_friction", 25, 0.889), ("spring", 51, 0.863), ("roller", 51, 0.914)],
)
def test_the_support_at_rest_is_the_seat_less_the_gap(abutment, gap_mm, support_m) -> None:
    with domain():
        model = build(replace(VARIANT, abutment=abutment, gap_mm=gap_mm), ModelOptions())
    assert [end.support_length_m for end in model.seats] == pytest.approx([support_m] * 2)
    run = {"column_drift_ratio": 0.02, "support_length_m": support_m}
    rows = {row["check"]: row for row in sdc_rows(VARIANT, run, [], {"left acute": 0.2}, {})}
    assert rows["left acute seat, SDC (m)"]["capacity"] == support_m
    assert rows["seat, AASHTO 1.5 N (m)"]["capacity"] == support_m
