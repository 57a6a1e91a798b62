"""OSB1 against hand values and this project's earlier model of the same data.

The figures are those of the project's reference page on bridge data, section 8 (engineering rules
applied by hand, and a trial OpenSees model, which tells only whether the model has changed); the
section state of each period is named; that model's deck load enters in the middle of the cap.
Tolerances: 1 % on weight and axial force, 5 % on periods
and pushover strength.
"""

from typing import Literal

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.pushover import push_bridge
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


def variant(abutment: str, skew_deg: int = 0, bridge: str = "osb1") -> Variant:
    return Variant(bridge=bridge, abutment=abutment, skew_deg=skew_deg, gap_mm=51, friction_pct=50)


ELASTIC = ModelOptions(elastic_columns=True)
HINGE = ModelOptions(cap_load="middle")
LOBATTO = ModelOptions(column_integration="lobatto5", cap_load="middle")


def test_weight_and_dead_load_forces_agree_with_hand_values() -> None:
    result = modal_properties(variant("contact_friction"), HINGE)
    assert result.weight_kn == pytest.approx(19_054, rel=0.01)
    assert result.column_axial_kn == pytest.approx([5_997, 5_997], rel=0.01)
    assert result.abutment_reaction_kn == pytest.approx([3_530, 3_530], rel=0.01)


def test_reactions_and_axial_forces_add_up_to_the_weight() -> None:
    result = modal_properties(variant("contact_friction", skew_deg=45), HINGE)
    total = sum(result.column_axial_kn) + sum(result.abutment_reaction_kn)
    assert total == pytest.approx(result.weight_kn, rel=1e-6)  # statics


@pytest.mark.parametrize(
    ("options", "abutment", "direction", "period_s"),
    [
        (ELASTIC, "roller", "x", 0.937),
        (ELASTIC, "roller", "y", 0.778),
        (HINGE, "roller", "x", 0.893),
        (HINGE, "roller", "y", 0.745),
        (LOBATTO, "roller", "x", 0.839),
        (LOBATTO, "roller", "y", 0.679),
        (LOBATTO, "contact_friction", "x", 0.788),
        (LOBATTO, "contact_friction", "y", 0.622),
        (LOBATTO, "contact_friction", "rz", 1.024),
        (HINGE, "roller", "z", 0.388),
    ],
)
def test_periods_agree_at_the_same_section_state(
    options: ModelOptions, abutment: str, direction: str, period_s: float
) -> None:
    result = modal_properties(variant(abutment), options)
    assert result.period_s(direction) == pytest.approx(period_s, rel=0.05)


@pytest.mark.parametrize(
    ("bridge", "cap_load", "thrust_kn"),
    [
        # turns of the cap over a column: w (6 a^2 L - L^3)/24 spread, w b L^2/16 in the middle:
        # 0.128 of it, the other way, with span L, overhang a and deck width b
        ("osb1", "spread", 67.0),
        ("osb1", "middle", 524.0),
    ],
)
def test_the_thrust_of_a_two_column_bent_at_rest_is_that_of_a_spread_deck(
    bridge: str, cap_load: Literal["spread", "middle"], thrust_kn: float
) -> None:
    options = ModelOptions(cap_load=cap_load, elastic_columns=True)
    with domain():
        model = build(variant("roller", bridge=bridge), options)
        thrusts_n = [ops.eleResponse(column.element, "force")[1] for column in model.columns]
    assert thrusts_n[0] == pytest.approx(-thrusts_n[1], rel=1e-6)
    assert abs(thrusts_n[0]) / 1e3 == pytest.approx(thrust_kn, rel=0.1)


def test_the_load_of_the_cap_leaves_strength_and_base_forces() -> None:
    spread, middle = ModelOptions(), HINGE
    peaks = [
        push_bridge(variant("roller"), options, angle_deg=0.0, max_disp_m=0.2, steps=60).peak_n
        for options in (spread, middle)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=0.01)
    axial = modal_properties(variant("contact_friction"), spread).column_axial_kn
    assert axial == pytest.approx([5_997, 5_997], rel=0.01)


def test_a_roller_bridge_is_nearly_free_to_turn() -> None:
    result = modal_properties(variant("roller"), HINGE)
    assert 3.4 < result.period_s("rz") < 4.5  # column torsion only


@pytest.mark.parametrize(("angle_deg", "strength_kn"), [(0.0, 5_786), (90.0, 5_730)])
def test_pushover_strength_agrees_with_the_plastic_hinge_model(
    angle_deg: float, strength_kn: float
) -> None:
    curve = push_bridge(variant("roller"), HINGE, angle_deg=angle_deg, max_disp_m=0.2, steps=60)
    assert curve.is_complete
    assert curve.peak_n / 1e3 == pytest.approx(strength_kn, rel=0.05)


def test_lobatto_pushover_meets_the_sum_of_plastic_moments_before_the_core_crushes() -> None:
    # 2 Mp / H by hand is 6031 kN; beyond 2.5 % drift the two models' crushed concrete differs
    curve = push_bridge(variant("roller"), LOBATTO, angle_deg=0.0, max_disp_m=0.14, steps=60)
    assert curve.peak_n / 1e3 == pytest.approx(6_031, rel=0.05)


def test_a_fixed_base_stiffens_and_strengthens_the_bent() -> None:
    curve = push_bridge(
        variant("roller", bridge="osb1_fixed"), HINGE, angle_deg=0.0, max_disp_m=0.12, steps=60
    )
    assert curve.peak_n / 1e3 == pytest.approx(12_100, rel=0.05)  # 12.0 to 12.3 MN
    assert load_bridge("osb1_fixed").base == "fixed"
