"""The other bridges of the catalogue against hand values, PyPBEE and earlier models.

Figures from the project's reference page on bridge data, sections 4 and 8; the condition of each
is named; their deck load enters in the middle of the caps.
Tolerances: 1 % on weight and axial force, 5 % on periods and pushover strength.
"""

import math

import pytest

from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.pushover import push_bridge
from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.bridge.gravity import (
    abutment_reactions_n,
    column_axial_n,
    continuous_reactions_n,
    total_weight_n,
)
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

ELASTIC = ModelOptions(elastic_columns=True)
HINGE = ModelOptions(cap_load="middle")
# The thrust of this cap load opens columns of distributed plasticity at rest; where they crack, and
# so their state, takes a fine mesh (bridge B along x: 1.4 % of the period).
LOBATTO = ModelOptions(column_integration="lobatto5", cap_load="middle", column_fibers=(12, 32, 3))


def variant(bridge: str, abutment: str = "roller") -> Variant:
    return Variant(bridge=bridge, abutment=abutment, skew_deg=0, gap_mm=51, friction_pct=50)


def test_reactions_of_two_equal_spans_are_three_eighths_and_ten_eighths() -> None:
    assert continuous_reactions_n((8.0, 8.0), 1.0) == pytest.approx([3.0, 10.0, 3.0])
    assert continuous_reactions_n((5.0,), 2.0) == pytest.approx([5.0, 5.0])
    assert sum(continuous_reactions_n((3.0, 4.0, 6.0), 7.0)) == pytest.approx(7.0 * 13.0)


@pytest.mark.parametrize("name", bridge_names())
def test_dead_load_of_every_bridge_agrees_with_hand_values(name: str) -> None:
    bridge = load_bridge(name)
    result = modal_properties(variant(name, "contact_friction"))
    assert result.weight_kn == pytest.approx(total_weight_n(bridge) / 1e3, rel=1e-6)
    start = 0
    for number, bent in enumerate(bridge.bents):
        axial = result.column_axial_kn[start : start + bent.columns]
        start += bent.columns
        expected = column_axial_n(bridge, number) / 1e3
        assert sum(axial) / bent.columns == pytest.approx(expected, rel=0.01)
    # the rigid-bent reactions of the end spans ignore column stiffness and pad compression
    expected = [reaction / 1e3 for reaction in abutment_reactions_n(bridge)]
    assert result.abutment_reaction_kn == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("name", bridge_names())
def test_the_conditioning_period_is_that_of_the_model_with_open_gaps(name: str) -> None:
    result = modal_properties(variant(name, "contact_friction"))
    found = math.sqrt(result.period_s("x") * result.period_s("y"))
    assert load_bridge(name).t1_s == pytest.approx(found, rel=0.002)


@pytest.mark.parametrize(
    ("name", "axial_kn"),
    [("osb2s", (7_513, 7_513, 7_362, 7_362)), ("bridge_a", (8_878,)), ("bridge_b", (8_769, 8_769))],
)
def test_base_axial_forces_agree_with_earlier_models_and_pypbee(
    name: str, axial_kn: tuple[float, ...]
) -> None:
    result = modal_properties(variant(name), HINGE)
    assert result.column_axial_kn == pytest.approx(axial_kn, rel=0.01)


def test_weight_of_osb2s_agrees_with_the_hand_value() -> None:
    assert modal_properties(variant("osb2s"), HINGE).weight_kn == pytest.approx(37_208, rel=0.01)


@pytest.mark.parametrize(
    ("name", "options", "abutment", "direction", "period_s"),
    [
        ("osb2s", ELASTIC, "roller", "x", 2.50),
        ("osb2s", ELASTIC, "roller", "y", 2.45),
        ("osb2s", HINGE, "roller", "x", 2.25),
        ("osb2s", HINGE, "roller", "y", 2.25),
        ("osb2s", LOBATTO, "roller", "x", 1.76),
        ("osb2s", LOBATTO, "roller", "y", 1.94),
        ("osb2s", LOBATTO, "contact_friction", "x", 1.50),
        ("osb2s", LOBATTO, "contact_friction", "y", 1.61),
        ("osb2s", LOBATTO, "contact_friction", "rz", 1.38),
        # bridge B: pinned base, fiber columns; roller, and with pads
        ("bridge_b", LOBATTO, "roller", "x", 1.04),
        ("bridge_b", LOBATTO, "roller", "y", 1.04),
        ("bridge_b", LOBATTO, "contact_friction", "x", 0.856),
        ("bridge_b", LOBATTO, "contact_friction", "y", 0.841),
        # bridge A: fixed base, fiber columns, pads; its keys act transversely only
        ("bridge_a", LOBATTO, "contact_friction", "x", 0.610),
        # OSB1 with a fixed base, cracked
        ("osb1_fixed", ELASTIC, "roller", "x", 0.368),
        ("osb1_fixed", ELASTIC, "roller", "y", 0.467),
    ],
)
def test_periods_agree_at_the_same_section_state(
    name: str, options: ModelOptions, abutment: str, direction: str, period_s: float
) -> None:
    result = modal_properties(variant(name, abutment), options)
    assert result.period_s(direction) == pytest.approx(period_s, rel=0.05)


@pytest.mark.parametrize(("angle_deg", "strength_kn"), [(0.0, 4_345), (90.0, 4_322)])
def test_pushover_strength_of_osb2s_agrees_with_the_earlier_model(
    angle_deg: float, strength_kn: float
) -> None:
    curve = push_bridge(variant("osb2s"), HINGE, angle_deg=angle_deg, max_disp_m=0.6, steps=60)
    assert curve.peak_n / 1e3 == pytest.approx(strength_kn, rel=0.05)
