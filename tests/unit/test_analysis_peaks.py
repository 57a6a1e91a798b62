"""Demands of hand-made histories agree with the data dictionary."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hand_made_column import SECTION
from skewbridge.analysis import peaks
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.trace import Layout, ResponseTrace
from skewbridge.analysis.transient import Watch
from skewbridge.bridge.handles import (
    AbutmentHandle,
    BearingHandle,
    ColumnHandle,
    CornerHandle,
    SpringHandle,
)
from skewbridge.bridge.shear_capacity import sdc_shear_strength
from skewbridge.errors import InputError

CENTRE, TOP, BASE, CORNER_1, CORNER_2, WALL = 1, 2, 3, 4, 5, 6
COLUMN = 10
SPRING = 20
GAP_M = 0.05
STEPS = 4


@pytest.fixture
def layout():
    return Layout(
        nodes=(CENTRE, TOP, CORNER_1, CORNER_2, WALL),
        columns=(COLUMN,),
        sections=((COLUMN, 6),),
        springs=((SPRING, 2),),
        bearings=(),
        units=2,
        centre_node=CENTRE,
    )


@pytest.fixture
def rows(layout):
    rows = np.zeros((STEPS, layout.width))
    rows[:, 0] = np.arange(STEPS) * 0.1
    return rows


@pytest.fixture
def trace(layout, rows):
    """The trace of `rows`, which a test may still change."""
    return ResponseTrace(layout=layout, rows=rows)


@pytest.fixture
def column():
    return ColumnHandle(
        element=COLUMN,
        base_node=BASE,
        top_node=TOP,
        clear_height_m=5.0,
        hinge_sections=(6,),
        yield_curvature_per_m=0.0034,
        yield_drift_ratio=0.01,
        drift_capacity_ratio=0.04,
        shear=SECTION,
    )


def abutment(**changes):
    handle = AbutmentHandle(
        side="right",
        normal=(1.0, 0.0),
        tangent=(0.0, 1.0),
        gap_m=GAP_M,
        transverse_gap_m=0.0064,
        seat_width_m=0.9,
        centre_node=CENTRE,
        corners=(
            CornerHandle(node=CORNER_1, kind="acute", plan_m=(0.0, 7.0)),
            CornerHandle(node=CORNER_2, kind="obtuse", plan_m=(0.0, -7.0)),
        ),
        bearings=(BearingHandle(element=30, seat_node=BASE, deck_node=CORNER_1),),
        pad_offsets_m=((0.0, 0.0),),
        wall_units=(0, 1),
        key_units=(),
        wall_nodes=(WALL,),
        key_nodes=(),
        wall_springs=(),
        key_springs=(),
        wing_springs=(),
        other_springs=(),
    )
    return replace(handle, **changes)


def test_displacements_count_from_the_state_under_gravity(layout, rows, trace):
    rows[:, layout.node(CENTRE)] = [0.01, 0.03, -0.04, 0.01]
    np.testing.assert_allclose(trace.disp(CENTRE)[:, 0], [0.0, 0.02, -0.05, 0.0])


def test_a_fixed_node_does_not_move(layout, rows, trace):
    assert not trace.disp(BASE).any()


def test_drift_is_the_resultant_over_the_clear_height(layout, rows, trace, column):
    rows[1, layout.node(TOP) : layout.node(TOP) + 2] = 0.3, 0.4
    assert peaks.column_drift(column, trace).tolist() == pytest.approx([0.0, 0.1, 0.0, 0.0])


def test_the_axial_force_adds_to_the_shear_of_a_leaning_column(layout, rows, trace, column):
    rows[:, layout.column(COLUMN)] = -2.0e6  # the base pushes back a top that has moved to +x
    rows[:, layout.column(COLUMN) + 2] = 6.0e6
    rows[1:, layout.node(TOP)] = 0.25
    shear = peaks.column_shear_n(column, trace)
    assert shear[:, 0].tolist() == pytest.approx([-2.0e6, -2.3e6, -2.3e6, -2.3e6])
    assert peaks.column_base_shear_n(column, trace)[:, 0].tolist() == [-2.0e6] * STEPS


def test_capacity_remembers_the_largest_ductility_so_far(layout, rows, trace, column):
    rows[:, layout.column(COLUMN)] = 2.0e6, 2.3e6, 2.0e6, 2.0e6  # the section's is 2 MN throughout
    rows[:, layout.column(COLUMN) + 2] = 6.0e6
    rows[1, layout.node(TOP)] = 0.25  # drift 0.05, five times yield
    ratio = peaks.column_shear_dcr(column, trace)
    undamaged, damaged = (2.0e6 / sdc_shear_strength(SECTION, 6.0e6, mu) for mu in (1.0, 5.0))
    assert ratio.tolist() == pytest.approx([undamaged, damaged, damaged, damaged])
    assert damaged > undamaged


def test_tension_lowers_the_shear_capacity(layout, rows, trace, column):
    rows[:, layout.column(COLUMN)] = 2.0e6
    rows[:, layout.column(COLUMN) + 2] = [6.0e6, -1.0e5, 6.0e6, 6.0e6]
    ratio = peaks.column_shear_dcr(column, trace)
    assert ratio[1] > ratio[0] == pytest.approx(ratio[2])


@pytest.mark.parametrize(
    ("drift", "shear_n", "changes", "mode", "row"),
    [
        ([0.0, 0.03, 0.05, 0.02], [0.0] * 4, {}, "flexure", 2),
        ([0.0] * 4, [0.0, 8.0e6, 0.0, 0.0], {}, "shear", 1),
        ([0.0, 0.0, 0.0, 0.05], [0.0, 8.0e6, 0.0, 0.0], {}, "shear", 1),
        ([0.0, 0.05, 0.0, 0.0], [0.0, -9.0e6, 0.0, 0.0], {}, "shear", 1),  # the brittle one
        (
            [0.0, 0.0, 0.0, 0.05],
            [0.0, 8.0e6, 0.0, 0.0],
            {"loses_shear_strength": True},
            "flexure",
            3,
        ),
        ([0.0, 0.05, 0.0, 0.0], [0.0, 8.0e6, 0.0, 0.0], {"is_elastic": True}, "", None),
        ([0.0, 0.03, 0.0, 0.0], [0.0, 1.0e6, 0.0, 0.0], {}, "", None),
    ],
)
def test_the_first_column_failure_ends_the_validity_of_the_model(
    layout, rows, trace, column, drift, shear_n, changes, mode, row
):
    rows[:, layout.node(TOP)] = np.multiply(drift, 5.0)
    rows[:, layout.column(COLUMN)] = shear_n
    end = peaks.model_end([replace(column, **changes)], trace)
    assert end.mode == mode
    if row is None:
        assert np.isnan(end.time_s)
        assert end.rows == STEPS
    else:
        assert end.time_s == pytest.approx(0.1 * row)
        assert end.rows == row + 1
        peaks_so_far = peaks.column_demands([column], trace.first(end.rows))
        assert peaks_so_far["column_residual_drift_ratio"] == pytest.approx(drift[row])


def test_curvature_ductility_is_the_resultant_over_yield(layout, rows, trace, column):
    start = layout.section(COLUMN, 6)
    rows[2, start + 1 : start + 3] = 0.003, -0.004
    ductility = peaks.curvature_ductility(column, trace)
    assert ductility.max() == pytest.approx(0.005 / 0.0034)


def test_unseating_is_positive_away_from_the_backwall(layout, rows, trace):
    rows[1, layout.node(CORNER_1)] = -0.2
    rows[2, layout.node(CORNER_2)] = -0.3
    rows[3, layout.node(CORNER_1)] = 0.4  # towards the backwall: nobody falls
    assert peaks.unseating_m(abutment(), trace).tolist() == pytest.approx([0.0, 0.2, 0.3, 0.0])
    acute = peaks.unseating_m(abutment(), trace, "acute").tolist()
    assert acute == pytest.approx([0.0, 0.2, 0.0, -0.4])


def test_unseating_is_normal_to_a_skewed_seat(layout, rows, trace):
    normal = (np.cos(0.5), -np.sin(0.5))
    rows[1, layout.node(CORNER_1) : layout.node(CORNER_1) + 2] = -0.2, 0.1
    move = peaks.unseating_m(abutment(normal=normal), trace)
    assert move.max() == pytest.approx(0.2 * np.cos(0.5) + 0.1 * np.sin(0.5))


def test_the_push_of_a_wall_is_that_of_its_nodes(layout, rows, trace):
    rows[:, layout.node(WALL)] = [0.0, 0.02, -0.01, 0.0]
    push = peaks.wall_push_m(abutment(), trace)
    assert push[:, 0].tolist() == pytest.approx([0.0, 0.02, -0.01, 0.0])


def test_without_wall_nodes_the_push_excludes_the_gap(layout, rows, trace):
    spring = SpringHandle(element=SPRING, component=0, direction=(-1.0, 0.0), nodes=(BASE, CENTRE))
    handle = abutment(wall_units=(), wall_nodes=(), wall_springs=(spring,))
    rows[:, layout.node(CENTRE)] = [0.0, 0.04, 0.08, -0.3]
    push = peaks.wall_push_m(handle, trace)
    assert push[:, 0].tolist() == pytest.approx([0.0, 0.0, 0.03, 0.0])


def test_the_force_on_a_wall_is_compression_for_either_spring_direction(layout, rows, trace):
    at = layout.spring(SpringHandle(element=SPRING, component=0, direction=(1, 0), nodes=(3, 1)))
    rows[1, at] = -5.0e5
    spring = SpringHandle(element=SPRING, component=0, direction=(-1.0, 0.0), nodes=(BASE, CENTRE))
    handle = abutment(wall_units=(), wall_nodes=(), wall_springs=(spring,))
    force = peaks.wall_force_n(handle, trace)
    assert force.max() == pytest.approx(5.0e5)


def test_the_force_on_a_wall_adds_its_contacts(layout, rows, trace):
    rows[2, layout.contacts("normals")] = 1.0e5, 2.0e5
    assert peaks.wall_force_n(abutment(), trace).max() == 3.0e5


def test_the_backfill_force_is_zero_while_the_deck_does_not_touch(layout, rows, trace):
    spring = SpringHandle(element=SPRING, component=0, direction=(-1.0, 0.0), nodes=(BASE, WALL))
    rows[:, layout.spring(spring)] = -1.0e5  # the wall leans on the soil all the time
    rows[2, layout.contacts("normals")] = 1.0, 0.0
    force = peaks.backfill_force_n(abutment(wall_springs=(spring,)), trace)
    assert force.tolist() == [0.0, 0.0, 1.0e5, 0.0]


def test_key_forces_count_while_the_deck_touches(layout, rows, trace):
    spring = SpringHandle(element=SPRING, component=1, direction=(0.0, 1.0), nodes=(BASE, WALL))
    rows[:, layout.spring(spring)] = 3.0e5, -2.0e5, 1.0e5, 0.0
    rows[1, layout.contacts("normals")] = 0.0, 5.0
    handle = abutment(key_springs=(spring,), key_units=(1,))
    (force,) = peaks.key_forces_n(handle, trace)
    assert force.tolist() == [0.0, 2.0e5, 0.0, 0.0]


@pytest.mark.parametrize(("move_m", "expected"), [(0.849, ""), (0.851, "unseating_m")])
def test_a_corner_leaves_its_seat_after_the_seat_less_the_gap(layout, rows, move_m, expected):
    model = SimpleNamespace(
        weight_n=1e7, deck_centre_node=CENTRE, columns=(), abutments=(abutment(),)
    )
    rows[0, layout.node(CORNER_1)] = 0.01  # under gravity
    rows[1, layout.node(CORNER_1)] = 0.01 - move_m
    watch = Watch(model, layout, rows[0], AnalysisSettings())
    assert watch.collapsed(rows[0]) == ""
    assert watch.collapsed(rows[1]) == expected


def test_a_gap_as_wide_as_the_seat_is_refused(layout, rows):
    model = SimpleNamespace(
        weight_n=1e7, deck_centre_node=CENTRE, columns=(), abutments=(abutment(gap_m=0.95),)
    )
    with pytest.raises(InputError, match=r"gap_mm must be below the seat width of 900 mm, got 950"):
        Watch(model, layout, rows[0], AnalysisSettings())
