"""Ends that differ from two equal seats, and joints inside the bridge.

Integral end: its stiffness is the sum of fill, wing walls and piles, by formulas written here.
"""

from math import cos, isnan, radians, sin

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.bridge.backfill import wall_backfill, wing_wall
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.drawing import end_reaction_kn
from skewbridge.bridge.frame import Blueprint, End
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.joints import KINDS
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.structures import deck_ends
from skewbridge.bridge.weights import column_axial_n, deck_reactions_n
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion

MIXED = """extends: osb1
title: one integral end
abutments:
  left: {type: integral}
  right: {type: seat, skew_deg: {v: 15, src: "d: own"}, gap_mm: {v: 40, src: "d: own"}}
"""
#: The same stiffness and strength at rest, with a dashpot on the elastic part of the piles.
WITH_DASHPOTS = MIXED.replace(
    "{type: integral}", "{type: integral, piles: {dashpot_s: {v: 0.5, src: 'd: own'}}}"
)


def reactions_of(bridge, skew_deg, options, moved):
    """Return the reactions (N, Nm) of the left end to displacements of its node."""
    with domain():
        tags = TagAllocator()
        plan = deck_ends(bridge, skew_deg)[0]
        node, height_m = tags.node(), bridge.deck.centroid_above_soffit_m
        ops.node(node, *plan.middle_m, height_m)
        case = variant(skew_deg, bridge=bridge.name)
        blueprint = Blueprint(variant=case, options=options, tags=tags, contacts=None)
        kind = KINDS[bridge.ends["left"].type]
        kind.build(kind.support(End(node=node, plan=plan, abutment=bridge.ends["left"]), blueprint))
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        for dof, value in enumerate(moved, start=1):
            ops.sp(node, dof, value)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("FullGeneral")
        ops.test("NormDispIncr", 1e-14, 50)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(1) == 0
        ops.reactions()
        return np.array([ops.nodeReaction(node, dof) for dof in range(1, 7)])


@pytest.mark.parametrize(
    ("skew_deg", "text"), [(0, MIXED), (30, MIXED), (-45, MIXED), (30, WITH_DASHPOTS)]
)
def test_an_integral_end_has_the_stiffness_of_its_fill_wings_and_piles(written, skew_deg, text):
    bridge = load_bridge(written(text))
    data, plan = bridge.ends["left"], deck_ends(bridge, skew_deg)[0]
    # the restoring spring of walls is not part of the formulas
    options = ModelOptions(wall_restoring_n_per_m=1.0)
    # secant at 20 um: the hyperbola has lost up to 0.4 % of its stiffness
    fill = float(wall_backfill(data, "hyperbolic", radians(skew_deg)).force_n(2e-5)) / 2e-5
    wing, count = wing_wall(data).stiffness_n_per_m * 50 / 51, data.piles.count
    piles = count * data.piles.lateral_kn_per_m * 1e3
    assert (data.wall_width_m, data.wall_height_m, count) == (14.33, 1.829, 6)
    normal, tangent = np.array(plan.normal), np.array(plan.tangent)

    def plan_force(direction, small):
        moved = (*(small * np.array(direction)), 0.0, 0.0, 0.0, 0.0)
        return reactions_of(bridge, skew_deg, options, moved)[:2] / small

    # the wing is behind a tie 50 times as stiff; an opening spring keeps 1e-6 of its strength
    assert plan_force(normal, 2e-5) == pytest.approx((fill + piles) * normal, rel=3e-3, abs=1e4)
    assert plan_force(-normal, 1e-3) == pytest.approx(-piles * normal, rel=1e-3, abs=1e4)
    assert plan_force(tangent, 1e-4) == pytest.approx((wing + piles) * tangent, rel=1e-3, abs=1e4)
    # in plan: of three points with 1/6, 2/3 and 1/6 of the wall, those that move into the fill
    half = 14.33 / cos(radians(skew_deg)) / 2
    out = 0.915 / 2 / cos(radians(skew_deg))
    face = out * np.array(plan.outward)
    turn = wing * (face @ normal) ** 2
    for share, along in ((1 / 6, -half), (2 / 3, 0.0), (1 / 6, half)):
        lever = face @ tangent + along
        turn += share * fill * lever**2 if lever < -1e-9 else 0.0
    spread = (np.arange(count) - (count - 1) / 2) * data.piles.spacing_m / cos(radians(skew_deg))
    turn += piles / count * (spread @ spread)
    moment = reactions_of(bridge, skew_deg, options, (0.0, 0.0, 0.0, 0.0, 0.0, 5e-6))[5] / 5e-6
    assert moment == pytest.approx(turn, rel=5e-3)
    # vertical, and about the face: the heads of the piles and their vertical springs
    up = reactions_of(bridge, skew_deg, options, (0.0, 0.0, 1e-4, 0.0, 0.0, 0.0))[2] / 1e-4
    assert up == pytest.approx(count * 167e6, rel=2e-4)  # arms in series


@pytest.mark.parametrize("text", [MIXED, WITH_DASHPOTS])
def test_the_piles_yield_and_the_fill_is_limited_by_its_strength(written, text):
    bridge = load_bridge(written(text))
    fill = wall_backfill(bridge.ends["left"], "hyperbolic", 0.0).ultimate_n
    pushed = reactions_of(bridge, 0, ModelOptions(), (-0.5, 0.0, 0.0, 0.0, 0.0, 0.0))
    pulled = reactions_of(bridge, 0, ModelOptions(), (0.5, 0.0, 0.0, 0.0, 0.0, 0.0))
    weak = 0.5 * ModelOptions().wall_restoring_n_per_m
    assert -pushed[0] == pytest.approx(fill + 6 * 177.9e3 + weak, rel=2e-3)
    assert pulled[0] == pytest.approx(6 * 177.9e3 + weak, rel=2e-3)


def test_dashpots_of_piles_damp_a_small_motion(tmp_path):
    found = []
    for name, text in (("without", MIXED), ("with", WITH_DASHPOTS)):
        path = tmp_path / f"{name}.yaml"
        path.write_text(text)
        found.append(analysed(variant(0, bridge=str(path)), strong_motion(peak_g=0.1)).demands)
    assert found[1]["deck_disp_y_m"] < 0.97 * found[0]["deck_disp_y_m"]
    assert abs(found[1]["energy_residual_ratio"]) < 0.01


def test_the_force_of_an_integral_end_includes_its_piles(written):
    bridge = written(MIXED)
    result = analysed(variant(30, bridge=bridge), strong_motion(duration_s=4.0, peak_g=0.1))
    table, piles = result.histories, load_bridge(bridge).ends["left"].piles
    force_kn, disp_m = (
        -(cos(radians(30)) * table[f"{end}_x_{unit}"] + sin(radians(30)) * table[f"{end}_y_{unit}"])
        for end, unit in (("abutment_left", "kn"), ("abutment_left", "m"))
    )
    yield_m = piles.lateral_strength_kn / piles.lateral_kn_per_m
    apart = (disp_m < -0.1 * yield_m) & (table["abutment_left_backfill_kn"] < 1e-3)
    assert apart.sum() > 20
    assert np.abs(disp_m).max() < yield_m
    # away from the fill only the elastic piles act; dashpots of walls add 5 % out of phase
    work = (force_kn - force_kn[0])[apart] @ disp_m[apart]
    stiffness_kn_per_m = work / (disp_m[apart] @ disp_m[apart])
    assert stiffness_kn_per_m == pytest.approx(piles.count * piles.lateral_kn_per_m, rel=0.01)


def test_one_end_integral_and_one_seat_unseats_at_the_seat_only(written):
    case = variant(30, bridge=written(MIXED), gap_mm=25)
    with domain():
        model = build(case, ModelOptions())
        model.contacts.start_from_rest()
        left, right = model.abutments
        # own skew and gap of the seat; the skew of the variant acts on the other end
        assert [seat.side for seat in model.seats] == ["right"]
        assert right.normal == pytest.approx((cos(radians(15)), sin(radians(15))))
        assert left.normal == pytest.approx((-cos(radians(30)), -sin(radians(30))))
        openings = [model.contacts.openings_m[unit] for unit in right.wall_units]
        assert openings == pytest.approx([0.040] * 3, abs=5e-5)
        for spring in left.wall_springs:
            force = ops.basicForce(spring.element)[spring.component]
            assert force == pytest.approx(0.0, abs=1.0)
    result = analysed(case, strong_motion(duration_s=4.0))
    found, histories = result.whole_history, result.histories
    assert result.status == "ok"
    assert found["unseating_m"] == pytest.approx(
        histories["abutment_right_unseating_m"].max(), rel=1e-3
    )
    assert "abutment_left_unseating_m" not in histories
    assert abs(found["energy_residual_ratio"]) < 1e-3
    fill_m = -(
        cos(radians(30)) * histories["abutment_left_acute_x_m"]
        + sin(radians(30)) * histories["abutment_left_acute_y_m"]
    )
    assert found["abutment_passive_m"] >= 0.99 * fill_m.max() > 0.0
    assert result.support_length_m == pytest.approx(0.914 - 0.040)


@pytest.mark.parametrize("kinds", [("fixed", "roller"), ("integral", "integral")])
def test_a_bridge_without_seats_has_no_unseating(written, kinds):
    left, right = kinds
    ends = f"abutments: {{left: {{type: {left}}}, right: {{type: {right}}}}}\n"
    case = variant(30, bridge=written(f"extends: osb1\ntitle: no seat\n{ends}"))
    result = analysed(case, strong_motion(duration_s=2.0))
    assert result.status == "ok"
    assert isnan(result.demands["unseating_m"])
    assert isnan(result.support_length_m)
    assert (result.demands["abutment_passive_m"] > 0.0) == (left == "integral")
    assert abs(result.demands["energy_residual_ratio"]) < 1e-3
    modes = modal_properties(case)
    reactions = sum(modes.abutment_reaction_kn) + sum(modes.column_axial_kn)
    assert reactions == pytest.approx(modes.weight_kn, rel=1e-6)
    # both are stiffer than pads
    assert modes.period_s("x") < 0.8 * modal_properties(variant(30)).period_s("x")


@pytest.mark.parametrize("left", ["fixed", "integral, piles: {rotational_mnm_per_rad: 3000.0}"])
def test_hand_values_of_dead_load_include_the_restraint_of_an_end(written, left):
    ends = f"{{left: {{type: {left}}}, right: {{type: seat}}}}"
    name = written(f"{{extends: osb1, source: own, title: stiff end, abutments: {ends}}}")
    bridge, modes = load_bridge(name), modal_properties(variant(0, bridge=name))
    # as on two simple supports, but for the stiffness of columns and pads
    assert np.mean(modes.column_axial_kn) == pytest.approx(
        column_axial_n(bridge, 0) / 1e3, rel=0.01
    )
    first, _, last = deck_reactions_n(bridge)
    assert modes.abutment_reaction_kn == pytest.approx((first / 1e3, last / 1e3), rel=0.03)
    # the keys of the seat are not designed for the reaction of the other end
    assert end_reaction_kn(bridge) == last / 1e3


def test_an_end_of_another_type_starts_anew_and_the_other_end_is_inherited(written):
    bridge = load_bridge(written("extends: osb1\ntitle: x\nabutments: {left: {type: integral}}\n"))
    left, seat = bridge.ends["left"], load_bridge("osb1").abutment
    assert (left.type, bridge.ends["right"], bridge.seats) == ("integral", seat, {"right": seat})
    assert bridge.sources["abutments.left.wall_width_m"] == "d: deck width"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("abutments: {left: {type: box}, right: {type: fixed}}", "abutments.left: .*'integral'"),
        (
            "abutments: {left: {type: integral, piles: {count: {v: 0, src: 'd: x'}}}, "
            "right: {type: fixed}}",
            r"abutments\.left\.piles\.count: must be",
        ),
        (
            "abutment: {key_mass_t: {v: 1, src: 'd: x'}}\nabutments: {left: {type: fixed}}",
            "only one",
        ),
    ],
)
def test_bad_ends_are_refused_with_their_key(written, text, message):
    with pytest.raises(InputError, match=message):
        load_bridge(written(f"extends: bridge_a\ntitle: bad\n{text}\n"))
