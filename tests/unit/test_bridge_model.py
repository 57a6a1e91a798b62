"""Parts of a built model: arrays, pads, contacts, penalties, mesh."""

from math import cos, radians, sin
from pathlib import Path

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import configure_solver
from skewbridge.bridge.abutment.backfill import variation_factors
from skewbridge.bridge.abutment.elements import (
    NORMAL_OVER_TANGENT,
    normal_penalty,
    tangent_penalty,
)
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.deck import deck_end, mass_centre_m, spine_points_m, tributary_shares
from skewbridge.bridge.gravity import (
    column_axial_forces_n,
    open_linear_pattern,
    support_reactions_n,
)
from skewbridge.bridge.model import build, domain
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions


@pytest.mark.parametrize("arrays", ["rigid", "corotational"])
def test_the_points_of_a_joint_move_rigidly_with_the_deck_end(arrays: str) -> None:
    with domain():
        # no key closes: plain Newton does not always follow one that the deck pushes and rubs
        options = ModelOptions(arrays=arrays, transverse_gap_mm=1000.0)
        model = build(variant(30), options)
        open_linear_pattern(model.tags)
        ops.load(model.deck_nodes[-1], 1.0e5, 1.0e6, 0.0, 0.0, 0.0, 1.0e7)
        configure_solver(AnalysisSettings())
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(1) == 0
        right = model.abutments[1]
        node, (x, y, z) = right.centre.node, ops.nodeCoord(right.centre.node)
        disp = np.array(ops.nodeDisp(node))
        for point in (*(c.node for c in right.corners), *(b.deck_node for b in right.bearings)):
            arm_m = np.array(ops.nodeCoord(point)) - (x, y, z)
            moved = disp[:3] + np.cross(disp[3:], arm_m)
            second_order_m = np.linalg.norm(arm_m) * np.linalg.norm(disp[3:]) ** 2
            assert ops.nodeDisp(point)[:3] == pytest.approx(moved, abs=second_order_m + 1e-7)
        assert right.centre.arm_m == pytest.approx((0.0, 0.0, -z))
        assert abs(disp[5]) > 1e-5


@pytest.mark.parametrize(("pads", "count"), [("each", 5), ("two", 2)])
def test_pads_are_under_the_deck_nodes(pads, count: int) -> None:
    with domain():
        model = build(variant(30), ModelOptions(pads=pads))
        for abutment in model.abutments:
            assert len(abutment.bearings) == count
            assert len(abutment.pads) == 5
            for bearing in abutment.bearings:
                # bearing elements have the height of a pad
                x, y, z = ops.nodeCoord(bearing.deck_node)
                height_m = model.bridge.abutment.pads.height_m if pads == "each" else 0.0
                assert ops.nodeCoord(bearing.seat_node) == pytest.approx([x, y, z - height_m])


@pytest.mark.parametrize("skew_deg", [30, -30, 0, 60])
def test_contacts_face_the_deck_in_the_skewed_frame(skew_deg: int) -> None:
    with domain():
        model = build(variant(skew_deg), ModelOptions(key_frame="skewed", backwall_points=5))
        assert model.contacts is not None
        for abutment in model.abutments:
            sign = 1.0 if abutment.side == "right" else -1.0
            outward = (sign * cos(radians(skew_deg)), sign * sin(radians(skew_deg)))
            assert abutment.normal == pytest.approx(outward)
            for index in abutment.wall_units:
                unit = model.contacts.units[index]
                assert unit.normal == pytest.approx((-outward[0], -outward[1], 0.0))
                assert unit.gap_m == pytest.approx(0.051)
            for index in abutment.key_units:
                unit = model.contacts.units[index]
                along = np.dot(unit.normal[:2], abutment.tangent)
                assert abs(along) == pytest.approx(1.0)
                assert unit.gap_m == pytest.approx(0.0064)
            assert len(abutment.wall_units) == 5
            assert len(abutment.key_units) == 2


def test_keys_face_the_deck_edge() -> None:
    with domain():
        model = build(variant(30), ModelOptions())
        assert model.contacts is not None
        for abutment in model.abutments:
            for index, node in zip(abutment.key_units, abutment.key_nodes, strict=True):
                inward = -np.sign(ops.nodeCoord(node)[1])
                assert model.contacts.units[index].normal == pytest.approx((0.0, inward, 0.0))


@pytest.mark.parametrize(
    ("place", "at_walls", "at_keys"), [("all", 0.5, 0.5), ("walls", 0.5, 0.0), ("keys", 0.0, 0.5)]
)
def test_friction_can_act_at_walls_or_keys_only(place, at_walls: float, at_keys: float) -> None:
    with domain():
        model = build(variant(30), ModelOptions(friction_at=place))
        assert model.contacts is not None
        units = model.contacts.units
        for abutment in model.abutments:
            assert {units[index].friction for index in abutment.wall_units} == {at_walls}
            assert {units[index].friction for index in abutment.key_units} == {at_keys}


def test_the_acute_corners_lie_at_the_ends_of_the_longer_diagonal() -> None:
    with domain():
        model = build(variant(30), ModelOptions())
        places = {
            (abutment.side, corner.kind): np.array(corner.plan_m)
            for abutment in model.abutments
            for corner in abutment.corners
        }
    acute = np.linalg.norm(places["left", "acute"] - places["right", "acute"])
    obtuse = np.linalg.norm(places["left", "obtuse"] - places["right", "obtuse"])
    assert acute > obtuse


def one_span_bridge(tmp_path: Path) -> str:
    path = tmp_path / "single.yaml"
    path.write_text(
        'extends: osb1\nspans_m: {v: [40.0], src: "d: test"}\nbents: []\n', encoding="utf-8"
    )
    return str(path)


def test_a_single_span_needs_no_bent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    single = load_bridge(one_span_bridge(tmp_path))
    monkeypatch.setattr("skewbridge.bridge.model.load_bridge", lambda _: single)
    result = modal_properties(variant(20))
    assert result.column_axial_kn == ()
    assert sum(result.abutment_reaction_kn) == pytest.approx(result.weight_kn)


def test_foundation_springs_soften_the_bridge() -> None:
    stiff = modal_properties(variant(0, bridge="bridge_a"))
    soft = modal_properties(variant(0, bridge="bridge_a"), ModelOptions(foundation="springs"))
    assert soft.period_s("x") > 1.1 * stiff.period_s("x")
    with pytest.raises(InputError, match="osb1 has no foundation springs"):
        modal_properties(variant(0), ModelOptions(foundation="springs"))


def test_skewed_supports_load_the_obtuse_corner_more() -> None:
    with domain():
        model = build(variant(40), ModelOptions())
        ops.reactions()
        right = model.abutments[1]
        reactions = [ops.nodeReaction(bearing.seat_node, 3) for bearing in right.bearings]
        # pads run along the tangent; at positive skew the acute corner comes first
        assert right.corners[0].kind == "acute"
        assert reactions[-1] > 1.2 * reactions[0]
        assert sum(column_axial_forces_n(model)) + sum(support_reactions_n(model)) == pytest.approx(
            model.weight_n
        )


@pytest.mark.parametrize("count", [3, 4, 5, 9, 41])
def test_shares_of_the_wall_keep_its_rotational_stiffness(count: int) -> None:
    shares, stations = np.array(tributary_shares(count)), np.linspace(-0.5, 0.5, count)
    assert shares.sum() == pytest.approx(1.0)
    assert shares @ stations**2 == pytest.approx(1 / 12)
    assert (shares > 0.0).all()
    assert shares == pytest.approx(shares[::-1])
    assert tributary_shares(2) == [0.5, 0.5]


def test_non_uniform_backfill_is_largest_at_the_acute_corner_of_either_sign() -> None:
    for skew_deg in (60, -60):
        end = deck_end("left", 90.0, skew_deg, 14.0, 0.9)
        stations = end.wall_stations(5)
        factors = variation_factors(stations, end.skew_rad, 0.3, end.acute_sign)
        assert max(factors) == pytest.approx(1.3)
        assert sum(factors) == pytest.approx(5.0)
        acute_first = end.acute_sign < 0
        assert (factors[0] > factors[-1]) == acute_first
    assert variation_factors([-1.0, 1.0], 0.0, 0.3, 1.0) == [1.0, 1.0]


def test_penalties_are_bounded_by_softening_and_by_the_step() -> None:
    options = ModelOptions()
    assert normal_penalty(1.0e7, 1e9, options) == pytest.approx(50 * 1.0e7)  # 2 % softer in series
    kn = normal_penalty(1.0e9, 4000.0, options)
    assert 0.005 * (kn / 4000.0) ** 0.5 == pytest.approx(3.0)  # rad per step of 5 ms
    assert tangent_penalty(kn, options) == pytest.approx(kn / NORMAL_OVER_TANGENT)
    named = ModelOptions(normal_stiffness_n_per_m=7.0, tangent_stiffness_n_per_m=3.0)
    assert (normal_penalty(1.0, 1.0, named), tangent_penalty(1.0, named)) == (7.0, 3.0)


def test_four_elements_per_span_give_the_periods_of_sixteen() -> None:
    coarse = modal_properties(variant(30), ModelOptions(deck_elements_per_span=4))
    fine = modal_properties(variant(30), ModelOptions(deck_elements_per_span=16))
    for direction in ("x", "y", "rz", "z"):
        found, expected = coarse.period_s(direction), fine.period_s(direction)
        assert found == pytest.approx(expected, rel=0.002), direction


@pytest.mark.parametrize(
    ("name", "lengths_m"),
    [("osb2s", (1.5165, 1.5165, 1.5901, 1.5901)), ("osb1_fixed", (0.7388, 0.7388))],
)
def test_each_bent_has_hinges_of_its_own_length(name: str, lengths_m: tuple[float, ...]) -> None:
    with domain():
        model = build(variant(bridge=name), ModelOptions())
        found = [
            ops.sectionWeight(column.element, point)
            for column in model.columns
            for point in column.hinge_sections[-1:]
        ]
    assert found == pytest.approx(lengths_m, abs=1e-4)


@pytest.mark.parametrize("shift_m", [0.02, 0.055, 0.2])
def test_a_spine_node_is_within_5_cm_of_the_mass_centre(shift_m: float) -> None:
    bridge = load_bridge("osb1")
    first, *others, last = bridge.spans_m
    moved = bridge.model_copy(update={"spans_m": (first + shift_m, *others, last - shift_m)})
    points = spine_points_m(moved, 8)
    away = min(abs(x - mass_centre_m(moved)) for x in points)
    assert away <= 0.05
