"""Demands of hand-made histories, records of OpenSees to the bit, the demands table."""

import errno
import math
from dataclasses import fields, replace
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import openseespy.opensees as ops
import pandas as pd
import pytest

from hand_made_column import SECTION
from skewbridge.analysis import peaks, transient
from skewbridge.analysis.peaks import ModelEnd
from skewbridge.analysis.recovery import Effort
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.trace import Recorder, ResponseTrace
from skewbridge.analysis.transient import AnalysisResult, Watch
from skewbridge.bridge import handles
from skewbridge.bridge.handles import Point, SpringHandle
from skewbridge.bridge.model import domain
from skewbridge.bridge.section import shear_strength
from skewbridge.demands import validity
from skewbridge.demands.columns import COLUMNS, DEMAND_COLUMNS, key_values
from skewbridge.demands.tables import demands_schema, to_table
from skewbridge.study import task
from skewbridge.study.batch import row_of_task
from skewbridge.study.task import no_result, outcome_of
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from skewbridge.verification.references.live_model import prepare_analysis
from study_parts import task_of

CENTRE, TOP, BASE, CORNER_1, CORNER_2, WALL = 1, 2, 3, 4, 5, 6
COLUMN, SPRING, GAP_M, STEPS = 10, 20, 0.05, 4
# springs of a wall, along x, and of a key, along y
WALL_SPRING, KEY_SPRING = (
    SpringHandle(element=SPRING, component=number, direction=direction, nodes=(BASE, CENTRE))
    for number, direction in enumerate([(-1.0, 0.0), (0.0, 1.0)])
)
CAPACITY = handles.ColumnCapacity(yield_curvature_per_m=0.0034, yield_drift_ratio=0.01,
                                  drift_capacity_ratio=0.04, shear=SECTION)  # fmt: skip
COLUMN_HANDLE = handles.ColumnHandle(
    element=COLUMN, base_node=BASE, top=Point(TOP), clear_height_m=5.0, hinge_sections=(6,),
    capacities=(CAPACITY, CAPACITY),
)  # fmt: skip
VALUES = {"text": "x", "integer": 1, "number": 1.0, "boolean": True}
ROW = {column.name: VALUES[column.kind] for column in COLUMNS} | {"status": "ok"}


@pytest.fixture
def trace():
    return ResponseTrace(
        time_s=np.arange(STEPS) * 0.1, centre_accel_mps2=np.zeros((STEPS, 2)), bearings={},
        nodes={tag: np.zeros((STEPS, 6)) for tag in (CENTRE, TOP, CORNER_1, CORNER_2, WALL)},
        columns={COLUMN: np.zeros((STEPS, 12))}, sections={(COLUMN, 6): np.zeros((STEPS, 4))},
        springs={SPRING: np.zeros((STEPS, 2))},
        normals_n=np.zeros((STEPS, 2)), tangentials_n=np.zeros((STEPS, 2, 2)),
    )  # fmt: skip


def abutment(**changes):
    corners = (
        handles.CornerHandle(node=node, side="right", kind=kind, plan_m=(0.0, along_m))
        for node, kind, along_m in ((CORNER_1, "acute", 7.0), (CORNER_2, "obtuse", -7.0))
    )
    handle = handles.AbutmentHandle(
        side="right", normal=(1.0, 0.0), tangent=(0.0, 1.0), gap_m=GAP_M,
        seat_width_m=0.9, centre=Point(CENTRE), corners=tuple(corners), pads=(Point(CENTRE),),
        bearings=(handles.BearingHandle(element=30, seat_node=BASE, deck_node=CORNER_1),),
        wall_units=[0, 1], wall_nodes=[WALL],
    )  # fmt: skip
    return replace(handle, **changes)


def test_displacements_count_from_gravity_and_drift_excludes_the_rotation_of_a_foundation(trace):
    trace.nodes[CENTRE][:, 0] = [0.01, 0.03, -0.04, 0.01]
    np.testing.assert_allclose(trace.disp(CENTRE)[:, 0], [0.0, 0.02, -0.05, 0.0])
    assert not trace.disp(BASE).any(), "a node that is not read is fixed"
    trace.nodes[TOP][1, :2] = 0.3, 0.4
    drift = [0.0, 0.1, 0.0, 0.0]
    assert peaks.column_drift(COLUMN_HANDLE, trace).tolist() == pytest.approx(drift)
    trace = trace.at(slice(None))  # displacements are computed once
    trace.nodes[BASE] = np.zeros((STEPS, 6))
    trace.nodes[BASE][1] = 0.01, 0.0, 0.0, -0.002, 0.003, 0.0  # moves by 10 mm and turns
    trace.nodes[TOP][1, :2] = 0.01 + 5.0 * 0.003 + 0.3, 5.0 * 0.002 + 0.4
    assert peaks.column_drift(COLUMN_HANDLE, trace).tolist() == pytest.approx(drift)
    # a pinned column turns about its base without deformation of a foundation
    drift = [0.0, np.hypot(0.315, 0.41) / 5.0, 0.0, 0.0]
    pinned = replace(COLUMN_HANDLE, is_pinned=True)
    assert peaks.column_drift(pinned, trace).tolist() == pytest.approx(drift)


def test_the_axial_force_adds_to_the_shear_of_a_leaning_column(trace):
    trace.columns[COLUMN][:, 0] = -2.0e6  # the base pushes back a top that has moved to +x
    trace.columns[COLUMN][:, 2] = 6.0e6
    trace.nodes[TOP][1:, 0] = 0.25
    shear = peaks.column_shear_n(COLUMN_HANDLE, trace)
    assert shear[:, 0].tolist() == pytest.approx([-2.0e6, -2.3e6, -2.3e6, -2.3e6])
    assert peaks.column_base_shear_n(COLUMN_HANDLE, trace)[:, 0].tolist() == [-2.0e6] * STEPS


WEAK = replace(
    CAPACITY, yield_curvature_per_m=0.0017, drift_capacity_ratio=0.02,
    shear=replace(SECTION, hoop_area_m2=SECTION.hoop_area_m2 / 4),
)  # fmt: skip
NORMAL = np.array([np.cos(np.radians(30)), np.sin(np.radians(30))])
ALONG = np.array([-NORMAL[1], NORMAL[0]])
TURNED = replace(COLUMN_HANDLE, capacities=(WEAK, CAPACITY), normal=tuple(NORMAL))


def test_drift_and_curvature_over_capacity_follow_an_ellipse_in_the_axes_of_a_bent(trace):
    # of 0.10 m normal to the bent and 0.20 m along it
    trace.nodes[TOP][1:, :2] = 0.05 * NORMAL, 0.15 * ALONG, 0.03 * NORMAL + 0.16 * ALONG
    expected = [0.0, 0.5, 0.75, np.hypot(0.3, 0.8)]
    assert peaks.drift_over_capacity(TURNED, trace).tolist() == pytest.approx(expected)
    # curvature about z moves the column along the bent, about y normal to it
    trace.sections[COLUMN, 6][1, 1:3] = 0.0034 * 3.0, 0.0
    trace.sections[COLUMN, 6][2, 1:3] = 0.0034 * 3.0, 0.0017 * 4.0
    assert peaks.curvature_ductility(TURNED, trace).tolist() == pytest.approx([0.0, 3.0, 5.0, 0.0])
    # along the bent the hinge is 0.8 as long as in the model: 2 of 3, and 4 of 5 parts are plastic
    shorter = replace(TURNED, capacities=(WEAK, replace(CAPACITY, hinge_ratio=1.25)))
    expected = [0.0, 1.0 + 1.25 * 2.0, np.hypot(3.0 * (0.2 + 1.25 * 0.8), 4.0), 0.0]
    assert peaks.curvature_ductility(shorter, trace).tolist() == pytest.approx(expected)


def test_shear_over_capacity_follows_an_ellipse_in_the_axes_of_a_bent(trace):
    weak_n, strong_n = (shear_strength(each.shear, TURNED.shear_model, 0.0, 0.0, 0.0)
                        for each in (WEAK, CAPACITY))  # fmt: skip
    assert weak_n < 0.5 * strong_n
    weak, strong = weak_n * NORMAL, strong_n * ALONG
    trace.columns[COLUMN][1:, :2] = 0.6 * weak, 0.3 * strong, 0.6 * weak + 0.8 * strong
    assert peaks.column_shear_dcr(TURNED, trace).tolist() == pytest.approx([0.0, 0.6, 0.3, 1.0])


@pytest.mark.parametrize("model", ["ucsd_tests", "sdc_expected"])
def test_shear_capacity_follows_the_largest_ductility_and_the_axial_force(trace, model):
    trace.columns[COLUMN][:, 0] = 2.0e6, 2.3e6, 2.0e6, 2.0e6  # the section's is 2 MN throughout
    trace.columns[COLUMN][:, 2] = 6.0e6, 6.0e6, 6.0e6, -1.0e5
    trace.nodes[TOP][1, 0] = 0.25  # drift 0.05, five times yield
    states = ((6.0e6, 1.0), (6.0e6, 5.0), (6.0e6, 5.0), (-1.0e5, 5.0))
    expected = [2.0e6 / shear_strength(SECTION, model, *state, 0.0) for state in states]
    column = replace(COLUMN_HANDLE, shear_model=model)
    assert peaks.column_shear_dcr(column, trace).tolist() == pytest.approx(expected)
    assert expected == sorted(expected)


@pytest.mark.parametrize(
    ("drift", "shear_n", "changes", "mode", "row"),
    [
        ([0.0, 0.03, 0.05, 0.02], [0.0] * 4, {}, "flexure", 2),
        ([0.0, 0.0, 0.0, 0.05], [0.0, 9.0e6, 0.0, 0.0], {}, "shear", 1),
        ([0.0, 0.05, 0.0, 0.0], [0.0, -9.0e6, 0.0, 0.0], {}, "shear", 1),  # the brittle one
        ([0.0] * 3 + [0.05], [0.0, 9e6, 0.0, 0.0], {"loses_shear_strength": True}, "flexure", 3),
        ([0.0, 0.05, 0.0, 0.0], [0.0, 9.0e6, 0.0, 0.0], {"is_elastic": True}, "", None),
        ([0.0, 0.03, 0.0, 0.0], [0.0, 1.0e6, 0.0, 0.0], {}, "", None),
    ],
)
def test_the_first_column_failure_ends_the_model(trace, drift, shear_n, changes, mode, row):
    trace.nodes[TOP][:, 0] = np.multiply(drift, 5.0)
    trace.columns[COLUMN][:, 0] = shear_n
    end = peaks.model_end([replace(COLUMN_HANDLE, **changes)], trace)
    assert (end.mode, end.rows) == (mode, STEPS if row is None else row + 1)
    assert end.time_s == pytest.approx(np.nan if row is None else 0.1 * row, nan_ok=True)
    peaks_so_far = peaks.column_demands([COLUMN_HANDLE], trace.at(slice(end.rows)))
    assert peaks_so_far["column_residual_drift_ratio"] == pytest.approx(drift[end.rows - 1])


def test_unseating_is_positive_away_from_the_backwall_and_normal_to_the_seat(trace):
    trace.nodes[CORNER_1][1, 0] = -0.2
    trace.nodes[CORNER_2][2, 0] = -0.3
    trace.nodes[CORNER_1][3, 0] = 0.4  # towards the backwall: nobody falls
    assert peaks.unseating_m(abutment(), trace).tolist() == pytest.approx([0.0, 0.2, 0.3, 0.0])
    acute = peaks.unseating_m(abutment(), trace, "acute").tolist()
    assert acute == pytest.approx([0.0, 0.2, 0.0, -0.4])
    trace.nodes[CORNER_1][1, 1] = 0.1
    skewed = abutment(normal=(np.cos(0.5), -np.sin(0.5)))
    # a new trace, because displacements are computed once
    moved_m = peaks.unseating_m(skewed, trace.at(slice(None)), "acute")[1]
    assert moved_m == pytest.approx(0.2 * np.cos(0.5) + 0.1 * np.sin(0.5))


def test_passive_is_into_the_fill_and_active_is_out_of_it(trace):
    """The right wall has its fill at +x: 30 mm into it, 20 mm out of it."""

    def movements_m(handle):
        model = SimpleNamespace(abutments=(handle,), seats=(handle,), joints=(), inner_pads=())
        found = peaks._abutment_demands(model, trace)
        return [found[f"abutment_{name}_m"] for name in ("passive", "active")]

    trace.nodes[WALL][:, 0] = [0.0, 0.03, -0.01, 0.0]
    trace.nodes[CORNER_2][:, 0] = [0.0, 0.01, -0.02, 0.0]
    both, left = {"wall_nodes": (WALL, CORNER_2)}, {"side": "left", "normal": (-1.0, 0.0)}
    assert movements_m(abutment(**both)) == pytest.approx([0.03, 0.02])
    assert movements_m(abutment(**both, **left)) == pytest.approx([0.02, 0.03])
    # without wall nodes the fill is pushed beyond the gap and never pulled
    trace.nodes[CENTRE][:, 0] = [0.0, 0.04, 0.08, -0.3]
    trace.nodes[CENTRE][:, 1] = [0.0, 0.003, -0.004, 0.0]
    sprung = abutment(wall_units=(), wall_nodes=(), wall_springs=(WALL_SPRING,))
    assert movements_m(sprung) == pytest.approx([0.03, 0.0])
    # the transverse springs of `simplified` have no gap
    simplified = abutment(wall_units=(), wall_nodes=(), key_springs=(KEY_SPRING,))
    assert peaks._transverse_m(simplified, trace).max() == pytest.approx(0.004)
    assert peaks._key_deformations_m(simplified, trace)[0].max() == pytest.approx(0.004)


def test_forces_on_an_end_are_those_of_its_springs_and_contacts_and_of_their_friction(trace):
    # two points: 300 kN apart cancel, 400 kN along the wall add up to 800 kN
    trace.tangentials_n[1] = [[3e5, 4e5], [-3e5, 4e5]]
    trace.tangentials_n[2] = [[0.0, -5e5], [0.0, 0.0]]
    model = SimpleNamespace(abutments=(abutment(bearings=()),), weight_n=1e7)
    assert peaks._force_demands(model, trace)["friction_force_kn"] == pytest.approx(800.0)
    trace.springs[SPRING][1, 0] = -5.0e5
    trace.normals_n[2] = 1.0e5, 2.0e5
    handle = abutment(wall_units=(), wall_nodes=(), wall_springs=(WALL_SPRING,))
    assert peaks.wall_force_n(handle, trace).max() == pytest.approx(5.0e5)
    assert peaks.wall_force_n(abutment(), trace).max() == 3.0e5
    # the wing walls of `spring` are in series with its keys
    end = abutment(wall_units=(), key_springs=(KEY_SPRING,), wing_springs=(KEY_SPRING,))
    trace.springs[SPRING][2, 1] = 4.0e5
    joint_n = peaks._joint_force_n(SimpleNamespace(contacts=None), end, trace, np.zeros((STEPS, 2)))
    assert joint_n[2].tolist() == [0.0, 4.0e5]
    # forces of backfill and key count while the deck touches
    trace.springs[SPRING][:, 0] = -1.0e5  # the wall leans on the soil all the time
    trace.springs[SPRING][:, 1] = 3.0e5, -2.0e5, 1.0e5, 0.0
    trace.normals_n[1] = 0.0, 5.0
    trace.normals_n[2] = 1.0, 0.0
    end = abutment(wall_units=(0,), wall_springs=(WALL_SPRING,), key_units=(1,),
                   key_springs=(KEY_SPRING,))  # fmt: skip
    assert peaks.backfill_force_n(end, trace).tolist() == [0.0, 0.0, 1.0e5, 0.0]
    (key_n,) = peaks.key_forces_n(end, trace)
    assert key_n.tolist() == [0.0, 2.0e5, 0.0, 0.0]


def watched(monkeypatch, moved, **changes):
    frame, ends = SimpleNamespace(centre_node=CENTRE), (abutment(holders=(BASE,), **changes),)
    parts = {"columns": (), "abutments": ends, "seats": ends, "joints": (), "contacts": None}
    model = SimpleNamespace(weight_n=1e7, frame=frame, options=ModelOptions(), **parts)
    monkeypatch.setattr(transient.ops, "nodeDisp", lambda n, dof: moved.get(n, 0.0) * (dof == 1))
    return Watch(model, AnalysisSettings())


@pytest.mark.parametrize(("move_m", "expected"), [(0.849, ""), (0.851, "unseating_m")])
def test_a_corner_leaves_its_seat_after_the_seat_less_the_gap(monkeypatch, move_m, expected):
    moved = {CORNER_1: 0.01}  # under gravity
    watch = watched(monkeypatch, moved)
    monkeypatch.setattr(transient.ops, "getTime", lambda: 1.0)
    assert watch.diverged() == watch.collapsed() == ""
    monkeypatch.setattr(transient.ops, "getTime", lambda: 1.1)
    moved[CORNER_1] -= move_m
    assert (watch.diverged(), watch.collapsed()) == ("", expected)


def test_records_have_the_values_of_every_step_to_the_bit() -> None:
    with domain():
        for tag in (1, 2):
            ops.node(tag, 0.0, 0.0, 0.0)
            ops.fix(tag, int(tag == 1), 1, 1, 1, 1, 1)
        ops.mass(2, *[1.0] * 6)
        ops.uniaxialMaterial("Elastic", 1, 40.0)
        ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
        ops.timeSeries("Trig", 1, 0.0, 10.0, 0.5)
        ops.pattern("Plain", 1, 1)
        ops.load(2, 10.0, *[0.0] * 5)
        prepare_analysis(constraints="Plain", algorithm="Newton")
        recorder = Recorder()
        recorder.nodes((2,), "disp")
        recorder.elements((1,), "basicForce")
        recorder.elements((), "force")
        recorder.start()
        rows = [[0.0] * 8]
        for size_s in [0.01, 0.0025] * 10:
            assert ops.analyze(1, size_s) == 0
            rows.append([ops.getTime(), *ops.nodeDisp(2), *ops.basicForce(1)])
        rows = np.array(rows)
        with pytest.raises(ValueError, match=r"element 1 has no response \('rayleighForce',\)"):
            recorder.elements((1,), "rayleighForce")
        time_s, moves = recorder.read("Node", "disp")
        np.testing.assert_array_equal(time_s, rows[:, 0])
        np.testing.assert_array_equal(moves[2], rows[:, 1:7])
        np.testing.assert_array_equal(recorder.read("Element", "basicForce")[1][1], rows[:, 7:])
        assert not recorder.read("Element", "force")[1]
        assert np.abs(moves[2]).max() > 1e-3


def test_a_full_disk_stops_a_study_and_leaves_no_row(tmp_path) -> None:
    full = Mock(**{"analyse.side_effect": OSError(errno.ENOSPC, "no space left")})
    with pytest.raises(OSError, match="no space left"):
        task.analyse_task(full, tmp_path / "log", lambda _time_s, _duration_s: None)


def test_a_table_has_units_and_descriptions_and_rows_sorted_by_their_key() -> None:
    assert all(f.metadata[b"unit"] and f.metadata[b"description"] for f in demands_schema())
    suffixes = {"_kn": "kN", "_m": "m", "_s": "s", "_g": "g", "_rad": "rad", "_mps2": "m/s2"}
    units = {column.name: column.unit for column in COLUMNS}
    for suffix, unit in suffixes.items():
        assert {units[name] for name in units if name.endswith(suffix)} == {unit}
    # a missing demand stays unknown
    lost = ROW | {column.name: math.nan for column in DEMAND_COLUMNS} | {"status": "crash"}
    table = to_table([ROW | {"motion_id": "c"}, lost | {"motion_id": "a"}], {})
    assert table["motion_id"].to_pylist() == ["a", "c"]
    assert math.isnan(table["column_shear_kn"][0].as_py())


def test_a_row_that_breaks_the_contract_is_named() -> None:
    for rows, words in (
        ([ROW, ROW], "appears twice"),
        ([ROW | {"x": 1}], "missing or unknown columns"),
        ([ROW | {"status": "fine"}], "unknown status 'fine'"),
    ):
        with pytest.raises(ValueError, match=words):
            to_table(rows, {"commit": "x"})


def test_axes_and_completeness_keep_their_values_types_and_order() -> None:
    core = {"skew_deg": 30, "gap_mm": 51, "friction": 0.5}
    odd = {"skew_deg": 22.5, "gap_mm": 25.4, "friction": 0.375}
    more = core | {"backwall_points": 9, "transverse_gap_mm": 25.4}
    fine, plain, other = (
        key_values(Variant.at("osb1", "contact_friction", values), "syn001", 1.0, 0.0)
        for values in (odd, core, more)
    )
    table = to_table([ROW | plain | {"complete": False}, ROW | fine], {}).to_pandas()
    expected = {"skew_deg": [22.5, 30.0], "gap_mm": [25.4, 51.0], "friction": [0.375, 0.5]}
    expected = pd.DataFrame(expected | {"complete": [True, False]})
    pd.testing.assert_frame_equal(table[[*expected]], expected)
    options = to_table([ROW | other], {})
    place = options.column_names.index("friction")
    assert options.column_names[place + 1 : place + 3] == ["transverse_gap_mm", "backwall_points"]
    row = options.to_pylist()[0]
    assert (row["transverse_gap_mm"], row["backwall_points"]) == (25.4, 9)
    assert options.schema.field("transverse_gap_mm").metadata[b"unit"] == b"mm"


RUNS = pd.DataFrame(
    {
        "status": ["ok", "ok", "ok", "collapse", "collapse", "numerical_failure", "crash"],
        "beyond_model": ["", "shear", "flexure", "", "flexure", "", None],
        "column_shear_dcr": [0.5, 1.1, 0.7, 0.4, np.nan, np.nan, np.nan],
        "drift_over_capacity": [0.2, 0.6, 1.2, np.nan, 1.3, np.nan, np.nan],
    }
)
RATIOS = [0.5, 1.1, 1.2, 0.4, 1.3, np.nan, np.nan]


def test_only_a_finished_run_without_column_failure_is_complete() -> None:
    is_complete = validity.is_complete
    assert is_complete(RUNS).tolist() == [True, *[False] * 6]
    kinds = validity.failure_kinds(RUNS).tolist()
    assert kinds == ["", "shear", "flexure", "", "flexure", "", ""]
    assert validity.is_beyond_model(RUNS).tolist() == [kind != "" for kind in kinds]
    # demands of another program, of whole motions
    foreign = RUNS.drop(columns="beyond_model")
    assert validity.failed_modes(foreign).tolist() == validity.failed_modes(RUNS).tolist() == kinds
    by_status = is_complete(foreign)
    assert (by_status.dtype, by_status.tolist()) == (np.bool_, [True] * 3 + [False] * 4)
    for dtype in (object, float):  # as its table says
        given = pd.Series([0, 1, 1, 1, 1, 1, 1], dtype=dtype)
        assert not is_complete(RUNS.assign(complete=given)).any()
    unknown = pd.Series([None] * len(RUNS), dtype="boolean")
    assert is_complete(RUNS.assign(complete=unknown)).tolist() == is_complete(RUNS).tolist()
    # columns that an older table lacks are derived, with the larger known ratio
    derived = validity.with_derived_columns
    table = derived(RUNS)
    assert table["complete"].dtype == bool
    assert table["complete"].tolist() == validity.is_complete(RUNS).tolist()
    np.testing.assert_array_equal(table["column_failure_ratio"], RATIOS)
    assert "complete" not in RUNS
    given = RUNS.assign(complete=False, column_failure_ratio=2.0)
    pd.testing.assert_frame_equal(derived(given), given)
    assert "column_failure_ratio" not in derived(RUNS[["status"]])
    alone = derived(RUNS.drop(columns="column_shear_dcr"))["column_failure_ratio"]
    np.testing.assert_array_equal(alone, RUNS["drift_over_capacity"])


@pytest.mark.parametrize(
    ("status", "mode", "complete"),
    [("ok", "", True), ("ok", "flexure", False), ("collapse", "", False), ("timeout", "", False)],
)
def test_a_row_of_an_analysis_says_whether_it_is_complete(status, mode, complete) -> None:
    values = dict.fromkeys((field.name for field in fields(AnalysisResult)), 0)
    values |= {"status": status, "collapse_criterion": "", "effort": Effort(), "messages": ()}
    values |= {"demands": {"column_shear_dcr": 0.9, "drift_over_capacity": 1.25}, "energy_kj": {}}
    values |= {"model_end": ModelEnd(mode=mode, time_s=0.5, rows=2), "whole_history": {}}
    row = row_of_task(outcome_of(AnalysisResult(**values)), task_of(), "key")
    assert row["complete"] is complete
    assert row_of_task(no_result("crash", "it ended"), task_of(), "key")["complete"] is False
