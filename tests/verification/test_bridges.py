"""Bridges against hand values, PyPBEE and earlier models; every abutment on every bridge.

The study `bridges` has the weights, axial forces, periods and strengths with their sources and
tolerances (1 % on weight and axial force, 5 % on periods and pushover strength). The deck load of
the earlier models enters in the middle of the cap.
"""

import math
from itertools import product

import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.pushover import push_bridge
from skewbridge.bridge import weights
from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.structures import built_bridge
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS
from skewbridge.verification.registry import run_study
from strong_motion import pulse_motion, strong_motion

ROLLER = variant(0, "roller")


def test_study_of_hand_values_agrees_and_reactions_of_two_spans_are_3_and_10_eighths():
    study = run_study("bridges")
    assert len(study.comparisons) == 57
    assert [row["quantity"] for row in study.comparisons if not row["pass"]] == []
    assert weights.continuous_reactions_n((8.0, 8.0), 1.0) == pytest.approx([3.0, 10.0, 3.0])
    assert weights.continuous_reactions_n((5.0,), 2.0) == pytest.approx([5.0, 5.0])
    assert sum(weights.continuous_reactions_n((3.0, 4.0, 6.0), 7.0)) == pytest.approx(7.0 * 13.0)


@pytest.mark.parametrize("name", bridge_names())
def test_dead_load_and_conditioning_period_of_every_bridge(name):
    bridge = load_bridge(name)
    rigid, result = (
        modal_properties(variant(0, bridge=name), ModelOptions(foundation=foundation))
        for foundation in ("fixed", "springs")
    )
    # the hand values are for supports that do not settle
    axial_kn = iter(rigid.column_axial_kn)
    for number, bent in enumerate(bridge.bents):
        mean_kn = sum(next(axial_kn) for _ in range(bent.columns)) / bent.columns
        assert mean_kn == pytest.approx(weights.column_axial_n(bridge, number) / 1e3, rel=0.01)
    # the rigid-bent reactions of the end spans ignore column stiffness and pad compression
    first, *_, last = weights.deck_reactions_n(bridge)
    assert rigid.abutment_reaction_kn == pytest.approx((first / 1e3, last / 1e3), rel=0.03)
    # The conditioning period is that of the model with open gaps.
    period_s = math.sqrt(result.period_s("x") * result.period_s("y"))
    assert bridge.t1_s == pytest.approx(period_s, rel=0.002)


def test_cap_load_changes_the_thrust_of_a_bent_at_rest_but_not_strength_and_base_forces():
    # turns of the cap over a column: w (6 a^2 L - L^3)/24 spread, w b L^2/16 in the middle:
    # 0.128 of it, the other way, with span L, overhang a and deck width b
    for cap_load, thrust_kn in (("spread", 67.0), ("middle", 524.0)):
        with domain():
            model = build(ROLLER, ModelOptions(cap_load=cap_load, elastic_columns=True))
            thrusts_n = [ops.eleResponse(column.element, "force")[1] for column in model.columns]
        assert thrusts_n[0] == pytest.approx(-thrusts_n[1], rel=1e-6)
        assert abs(thrusts_n[0]) / 1e3 == pytest.approx(thrust_kn, rel=0.1)
    spread, middle = ModelOptions(), ModelOptions(cap_load="middle")
    push = {"angle_deg": 0.0, "max_disp_m": 0.2, "steps": 60}
    curves = [push_bridge(ROLLER, options, **push) for options in (spread, middle)]
    assert all(curve.is_complete for curve in curves)
    assert curves[0].peak_n == pytest.approx(curves[1].peak_n, rel=0.01)
    axial = modal_properties(variant(0), spread).column_axial_kn
    assert axial == pytest.approx([5_997, 5_997], rel=0.01)
    # on rollers only the torsion of the columns resists a turn
    assert 3.4 < modal_properties(ROLLER, middle).period_s("rz") < 4.5
    # The thrust of this cap load opens columns of distributed plasticity at rest; where they crack,
    # and so their state, takes a fine mesh (1.4 % of the period along x).
    fine = ModelOptions(column_integration="lobatto5", cap_load="middle", column_fibers=(12, 32, 3))
    result = modal_properties(variant(0, "roller", "bridge_b"), fine)
    assert [result.period_s(axis) for axis in "xy"] == pytest.approx([1.04, 1.04], rel=0.05)


# --- every abutment model on every bridge and skew carries its weight and survives motions
BRIDGES = ("osb1", "osb2s", "bridge_a", "bridge_b", "bridge_c")
ALL = [
    variant(skew, abutment, bridge)
    for bridge, abutment, skew in product(BRIDGES, ABUTMENTS, (0, 20, 40, 60))
]
CARRYING = [*ALL[::3], variant(0, bridge="osb1_era1"), variant(0, bridge="osb1_fixed")]


@pytest.mark.parametrize("case", CARRYING, ids=lambda case: case.slug)
def test_every_variant_carries_its_weight_and_has_sane_modes(case):
    result = modal_properties(case)
    bridge = built_bridge(load_bridge(case.bridge), ModelOptions(), case.skew_deg)
    weight_kn = weights.total_weight_n(bridge) / 1e3
    assert result.weight_kn == pytest.approx(weight_kn, rel=1e-6)
    carried = sum(result.column_axial_kn) + sum(result.abutment_reaction_kn)
    assert carried == pytest.approx(result.weight_kn, rel=1e-6)
    assert all(force > 0.0 for force in (*result.column_axial_kn, *result.abutment_reaction_kn))
    for direction in ("x", "y", "rz"):
        assert 0.2 < result.period_s(direction) < 6.0, direction
    assert all(math.isfinite(mode.period_s) for mode in result.modes)
    for total in zip(*((m.mass_x, m.mass_y, m.mass_rz) for m in result.modes), strict=True):
        assert sum(total) <= 1.0 + 1e-6


def check_run(case, motion, **settings):
    result = analysed(case, motion, **settings)
    assert result.status in ("ok", "collapse"), result.messages
    assert (result.status == "collapse") == bool(result.collapse_criterion)
    assert all(math.isfinite(value) for value in result.demands.values())
    assert abs(result.demands["energy_residual_ratio"]) < 0.005


@pytest.mark.parametrize("case", ALL[::7], ids=lambda case: case.slug)
def test_a_sample_of_variants_survives_strong_pulses(case):
    check_run(case, pulse_motion(duration_s=3.0))


@pytest.mark.slow
@pytest.mark.parametrize("case", ALL, ids=lambda case: case.slug)
def test_every_variant_survives_a_strong_motion(case):
    check_run(case, strong_motion(duration_s=10.0), duration_s=10.0)


def test_every_shear_model_has_its_column_and_none_changes_the_analysis():
    case = variant(0, "contact", "osb1_era1", friction_pct=0)
    models = ("kowalsky_priestley", "ucsd_tests", "sdc_expected", "sdc_nominal")
    names = [f"column_shear_dcr_{model}" for model in models]
    ratios = []
    for model, own in zip(models, names, strict=True):
        result = analysed(case, pulse_motion(duration_s=3.0), ModelOptions(shear_model=model))
        assert result.whole_history["column_shear_dcr"] == result.whole_history[own]
        # over the whole history, also after a failure
        assert result.demands[own] == result.whole_history[own] > 0.0
        ratios.append([result.whole_history[name] for name in names])
    assert ratios[0] == sorted(set(ratios[0]))
    assert ratios == [ratios[0]] * 4
