"""The catalogue's bridges against hand values, PyPBEE and this project's earlier models.

The study `bridges` has the weights, axial forces, periods and strengths with their sources and
tolerances (1 % on weight and axial force, 5 % on periods and pushover strength). The deck load of
the earlier models enters in the middle of the cap.
"""

import math

import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.pushover import push_bridge
from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.bridge.gravity import (
    abutment_reactions_n,
    column_axial_n,
    continuous_reactions_n,
    total_weight_n,
)
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import run_study

ROLLER = variant(0, "roller")


def test_study_of_hand_values_agrees():
    study = run_study("bridges")
    assert len(study.comparisons) == 57
    assert [row.quantity for row in study.comparisons if not row.is_passed] == []


def test_reactions_of_two_equal_spans_are_three_eighths_and_ten_eighths():
    assert continuous_reactions_n((8.0, 8.0), 1.0) == pytest.approx([3.0, 10.0, 3.0])
    assert continuous_reactions_n((5.0,), 2.0) == pytest.approx([5.0, 5.0])
    assert sum(continuous_reactions_n((3.0, 4.0, 6.0), 7.0)) == pytest.approx(7.0 * 13.0)


@pytest.mark.parametrize("name", bridge_names())
def test_dead_load_and_conditioning_period_of_every_bridge(name):
    bridge = load_bridge(name)
    result = modal_properties(variant(0, bridge=name))
    assert result.weight_kn == pytest.approx(total_weight_n(bridge) / 1e3, rel=1e-6)
    start = 0
    for number, bent in enumerate(bridge.bents):
        axial = result.column_axial_kn[start : start + bent.columns]
        start += bent.columns
        expected = column_axial_n(bridge, number) / 1e3
        assert sum(axial) / bent.columns == pytest.approx(expected, rel=0.01)
    # the rigid-bent reactions of the end spans ignore column stiffness and pad compression
    reactions = [reaction / 1e3 for reaction in abutment_reactions_n(bridge)]
    assert result.abutment_reaction_kn == pytest.approx(reactions, rel=0.03)
    # The conditioning period is that of the model with open gaps.
    period_s = math.sqrt(result.period_s("x") * result.period_s("y"))
    assert bridge.t1_s == pytest.approx(period_s, rel=0.002)


@pytest.mark.parametrize(("cap_load", "thrust_kn"), [("spread", 67.0), ("middle", 524.0)])
def test_thrust_of_a_two_column_bent_at_rest_depends_on_the_cap_load(cap_load, thrust_kn):
    # turns of the cap over a column: w (6 a^2 L - L^3)/24 spread, w b L^2/16 in the middle:
    # 0.128 of it, the other way, with span L, overhang a and deck width b
    with domain():
        model = build(ROLLER, ModelOptions(cap_load=cap_load, elastic_columns=True))
        thrusts_n = [ops.eleResponse(column.element, "force")[1] for column in model.columns]
    assert thrusts_n[0] == pytest.approx(-thrusts_n[1], rel=1e-6)
    assert abs(thrusts_n[0]) / 1e3 == pytest.approx(thrust_kn, rel=0.1)


def test_cap_load_does_not_change_strength_and_base_forces():
    spread, middle = ModelOptions(), ModelOptions(cap_load="middle")
    push = {"angle_deg": 0.0, "max_disp_m": 0.2, "steps": 60}
    curves = [push_bridge(ROLLER, options, **push) for options in (spread, middle)]
    assert all(curve.is_complete for curve in curves)
    assert curves[0].peak_n == pytest.approx(curves[1].peak_n, rel=0.01)
    axial = modal_properties(variant(0), spread).column_axial_kn
    assert axial == pytest.approx([5_997, 5_997], rel=0.01)
    # on rollers only the torsion of the columns resists a turn
    assert 3.4 < modal_properties(ROLLER, middle).period_s("rz") < 4.5


def test_fine_section_mesh_keeps_the_periods_of_bridge_b():
    # The thrust of this cap load opens columns of distributed plasticity at rest; where they crack,
    # and so their state, takes a fine mesh (1.4 % of the period along x).
    fine = ModelOptions(column_integration="lobatto5", cap_load="middle", column_fibers=(12, 32, 3))
    result = modal_properties(variant(0, "roller", "bridge_b"), fine)
    assert [result.period_s(axis) for axis in "xy"] == pytest.approx([1.04, 1.04], rel=0.05)
