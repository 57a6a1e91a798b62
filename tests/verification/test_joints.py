"""Ends that differ from two equal seats, and joints inside the bridge.

Integral end: its stiffness is the sum of fill, wing walls and piles, by formulas written here.
Decks that meet, simple spans on caps, hinges and restrainers: against explicit integration, statics
and hand values."""

from math import cos, inf, isnan, radians, sin
from pathlib import Path

import numpy as np
import openseespy.opensees as ops
import pandas as pd
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.bridge import assembly, backfill, handles, joints, weights
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import JointData
from skewbridge.bridge.catalogue.drawing import cap_areas, end_reaction_kn, pads_reaction_kn
from skewbridge.bridge.column import bent_capacity
from skewbridge.bridge.frame import Blueprint, End, InnerJoint
from skewbridge.bridge.library import load_structure
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.plan import DeckEnd
from skewbridge.bridge.structures import built_bridge, deck_ends
from skewbridge.bridge.weights import continuous_reactions_n
from skewbridge.contact import ContactSet, element
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.references import live_model as live
from strong_motion import strong_motion

CABLES = "{count: 8, stiffness_kn_per_m: 5000.0, yield_kn: 170.0, slack_mm: 20.0}"
EXAMPLES = Path(__file__).parents[2] / "docs" / "bridges"
RESTRAINED = f"at: bent 2, gap_mm: 30.0, restrainers: {CABLES},"
FOUR_SPANS = (EXAMPLES / "simple_spans.yaml").read_text().replace("at: bent 2,", RESTRAINED)
BENT, PADS = (", ".join(FOUR_SPANS.split(anchor)[1].split("\n- ")[0].strip().splitlines())
              for anchor in ("&bent", "&pads"))  # fmt: skip
HINGED = f"""extends: osb1
title: a hinge in the second span
source: "d: made for this test"
base: fixed
spans_m: [40.0, 50.0, 40.0]
bents: [{BENT}, {BENT}]
deck: {{soffit_height_m: 5.6}}
joints: [{{from_left_m: 50.0, ledge: left, seat_width_m: 0.6, pads: {{{PADS}}}}}]
"""
MIRRORED = HINGED.replace("50.0, ledge: left", "80.0, ledge: right")
MASSES_KG, LEVERS_M, SKEW_DEG = (4.0e5, 3.0e5), (10.0, 8.0), 30.0
INERTIAS = tuple(m * (4 * x**2 + 12.0**2) / 12 for m, x in zip(MASSES_KG, LEVERS_M, strict=True))
GAP_M, AXIAL_N_PER_M, FRICTION = 0.02, 1.2e7, 0.4
# the penalty is 50 times the axial stiffness of a share of the decks, the tangential a fifth
KN = 50.0 * AXIAL_N_PER_M * np.array([1 / 6, 2 / 3, 1 / 6])
KT = KN / 5.0
STIFFNESS = 4.0e5 * (2 * np.pi / 1.2) ** 2, 3.0e5 * (2 * np.pi / 0.8) ** 2
SPEEDS = ((0.7, 0.3, 0.0), (-0.4, -0.2, 0.01))
DURATION_S = 1.0
NORMAL = np.array([cos(radians(SKEW_DEG)), sin(radians(SKEW_DEG))])
TANGENT = np.array([-NORMAL[1], NORMAL[0]])


def explicit(dt_s=1e-5):
    """Return q (ux, uy, turn) of both bodies each ms, by velocity Verlet and radial return."""
    half, rows = 6.0 / cos(radians(SKEW_DEG)), []  # of opening and slip for q, (3, 6) each
    for direction in (NORMAL, TANGENT):
        for place in (along * TANGENT for along in (-half, 0.0, half)):
            first, second = (place + np.array([x, 0.0]) for x in (LEVERS_M[0], -LEVERS_M[1]))
            turns = [direction @ (-arm[1], arm[0]) for arm in (first, second)]
            rows.append([*-direction, -turns[0], *direction, turns[1]])
    openings, slips = np.split(np.array(rows), 2)
    mass = np.array([v for m, i in zip(MASSES_KG, INERTIAS, strict=True) for v in (m, m, i)])
    spring = np.array([v for k in STIFFNESS for v in (k, k, 50 * k)])
    q, velocity, stick = np.zeros(6), np.concatenate(SPEEDS), np.zeros(3)

    def acceleration():
        nonlocal stick
        normal_n = np.maximum(-KN * (GAP_M + openings @ q), 0.0)
        slip = slips @ q
        friction_n = np.clip(KT * (slip - stick), -FRICTION * normal_n, FRICTION * normal_n)
        stick = slip - friction_n / KT
        return (openings.T @ normal_n - slips.T @ friction_n - spring * q) / mass

    rows, accel = [q.copy()], acceleration()
    for step in range(1, round(DURATION_S / dt_s) + 1):
        velocity += 0.5 * dt_s * accel
        q = q + dt_s * velocity
        accel = acceleration()
        velocity += 0.5 * dt_s * accel
        if step % round(1e-3 / dt_s) == 0:
            rows.append(q)
    return np.array(rows)


def test_two_decks_over_a_joint_agree_with_explicit_integration_of_two_bodies():
    with domain():
        tags = handles.TagAllocator()
        bodies = zip((-LEVERS_M[0], LEVERS_M[1]), MASSES_KG, INERTIAS, STIFFNESS, strict=True)
        nodes = []
        for x, mass, inertia, k in bodies:
            ground, node = tags.node(), tags.node()
            for each, fixed in ((ground, (1,) * 6), (node, (0, 0, 1, 1, 1, 0))):
                ops.node(each, x, 0.0, 0.0)
                ops.fix(each, *fixed)
            ops.mass(node, mass, mass, 0.0, 0.0, 0.0, inertia)
            springs = [element.uniaxial(tags, "Elastic", stiffness) for stiffness in (k, k, 50 * k)]
            given = ("-mat", *springs, "-dir", 1, 2, 6)
            ops.element("zeroLength", tags.element(), ground, node, *given)
            nodes.append(node)
        back = 0.5 / cos(radians(SKEW_DEG))
        ends = (DeckEnd("left", (-back, 0.0), (1.0, 0.0), SKEW_DEG, 12.0, 1.0),
                DeckEnd("right", (back, 0.0), (-1.0, 0.0), SKEW_DEG, 12.0, 1.0))  # fmt: skip
        data = JointData(at="bent 1", seat_width_m=0.6, pads=load_bridge("osb1").abutment.pads)
        given = {"nodes": tuple(nodes), "holders": (None, None), "axial_n_per_m": AXIAL_N_PER_M}
        inner = InnerJoint(name="joint 1", ends=ends, data=data, **given)
        contacts, case = ContactSet(tags), variant(30, gap_mm=20, friction_pct=40)
        parts = Blueprint(variant=case, options=ModelOptions(), tags=tags, contacts=contacts)
        handle = joints.support_joint(inner, parts)()
        assert (handle.gap_m, len(handle.units)) == (GAP_M, 3)
        for node, speeds in zip(nodes, SPEEDS, strict=True):
            for dof, speed in zip((1, 2, 6), speeds, strict=True):
                ops.setNodeVel(node, dof, speed, "-commit")
        live.prepare_analysis(tolerance_m=1e-11, system="BandGeneral", numberer="RCM")
        times, signs = live.even_times(DURATION_S, 1e-3), [1.0] * len(handle.units)
        moved = live.record(contacts, times, 1e-3, nodes, signs, parts_on_change=4).q
        found = moved[:, [0, 1, 5, 6, 7, 11]]
        closures = sum(unit.closures for unit in contacts.ledger())
    errors = [live.rms(a - b) / live.rms(b) for a, b in zip(found.T, explicit().T, strict=True)]
    assert closures >= 5
    assert max(errors) < 0.02, errors


def test_hand_reactions_without_and_with_hinges():
    assert continuous_reactions_n((8.0, 8.0), 1.0) == pytest.approx([3.0, 10.0, 3.0])
    assert continuous_reactions_n((5.0,), 2.0) == pytest.approx([5.0, 5.0])
    assert sum(continuous_reactions_n((3.0, 4.0, 6.0), 7.0)) == pytest.approx(7.0 * 13.0)
    # two simple spans; a cantilever with a suspended span: statically determinate by hand
    assert continuous_reactions_n((8.0, 6.0), 1.0, [8.0]) == pytest.approx([4.0, 7.0, 3.0])
    # hinge 2 m beyond the support: 6 m of span 2 hang on it and load it with 3
    gerber = continuous_reactions_n((8.0, 8.0), 1.0, [10.0])
    left = (8.0 * 4.0 - 2.0 * 1.0 - 3.0 * 2.0) / 8.0
    assert gerber == pytest.approx([left, 16.0 - 3.0 - left, 3.0])
    plain = continuous_reactions_n((8.0, 8.0, 8.0), 1.0)
    # clamped at the left end: 5/8 and 3/8; a spring there with 6 E I / k = 2 L halves the moment
    assert continuous_reactions_n((8.0,), 1.0, [], (0.0, inf)) == pytest.approx([5.0, 3.0])
    assert continuous_reactions_n((8.0,), 1.0, [], (16.0, inf)) == pytest.approx([4.5, 3.5])
    # where the moment is zero a hinge changes nothing: x = 2 R / w in the first span
    assert continuous_reactions_n((8.0, 8.0, 8.0), 1.0, [2 * plain[0]]) == pytest.approx(plain)


@pytest.mark.parametrize("text", [FOUR_SPANS, HINGED, MIRRORED])
@pytest.mark.parametrize("skew_deg", [0, 30])
def test_reactions_weight_and_gaps_at_rest(written, text, skew_deg):
    name = written(text)
    bridge = built_bridge(load_bridge(name), ModelOptions(), skew_deg)  # with longer diaphragms
    modes = modal_properties(variant(skew_deg, bridge=name, gap_mm=25))
    hand = weights.deck_reactions_n(bridge)
    assert modes.abutment_reaction_kn == pytest.approx([hand[0] / 1e3, hand[-1] / 1e3], rel=0.03)
    held = sum(modes.abutment_reaction_kn) + sum(modes.column_axial_kn)
    assert held == pytest.approx(modes.weight_kn, rel=1e-6)
    if skew_deg == 0:
        assert modes.weight_kn == pytest.approx(weights.total_weight_n(bridge) / 1e3, rel=1e-6)
    with domain():
        model = build(variant(skew_deg, bridge=name, gap_mm=25), ModelOptions())
        model.contacts.start_from_rest()
        about = load_structure(name).description
        lengths_m = about.support_lengths_m(about.gaps_m(model.variant, ModelOptions()))
        for joint in model.joints:
            gap_m = 0.030 if joint.name == "joint 2" else 0.025
            opened = [model.contacts.openings_m[unit] for unit in joint.units]
            assert opened == pytest.approx([gap_m] * 3, abs=5e-5)
            assert joint.gap_m == gap_m
            width = 0.6 - gap_m / (2 if "simple" in bridge.title else 1)
            assert joint.seats[0].support_length_m == lengths_m[joint.name] == pytest.approx(width)
            # a pad compresses: its bottom is on the cap or ledge, which moves with the columns
            for bearing in joint.bearings:
                drop = ops.nodeDisp(bearing.deck_node, 3) - ops.nodeDisp(bearing.seat_node, 3)
                assert -0.002 < drop < 0.0


def test_both_end_diaphragms_of_a_joint_are_above_its_bent_and_move_the_mass_centre(written):
    text = FOUR_SPANS.replace("[28.0, 30.0, 30.0, 28.0]", "[28.0, 30.0, 30.0, 40.0]")
    name = written(text.replace("- {at: bent 2", "#").replace("- {at: bent 3", "#"))
    bridge = load_bridge(name)
    assert len(bridge.joints) == 1
    # without a weight in the file, a cap below bearings is a beam as long as the deck is wide
    text = Path(name).read_text(encoding="utf-8").replace(", cap_weight_kn: 950.0", "")
    below, *integral = (bent.cap_weight_kn for bent in load_bridge(written(text)).bents)
    assert below == pytest.approx(14.33 * 1.5 * 2.0 * 23.56)
    assert integral == pytest.approx([886.6] * 2, rel=1e-4)  # between the plates of the box
    line, diaphragm, cap = 140e3, 321e3, 950e3
    column = 23.56e3 * np.pi / 4 * 1.676**2 * 5.6
    # a simple span of 28 m and a beam of three spans (three-moment equation)
    beam = continuous_reactions_n((30.0, 30.0, 40.0), line)
    assert weights.deck_reactions_n(bridge) == pytest.approx(
        [line * 14 + diaphragm, line * 14 + 2 * diaphragm + beam[0], *beam[1:3],
         beam[3] + diaphragm], rel=1e-9,
    )  # fmt: skip
    # moments about the middle, at 64 m; half of the three columns moves with each cap
    bents_n, joint_n = cap + 1.5 * column, 2 * diaphragm
    moment = bents_n * (-36 - 6 + 24) + joint_n * -36
    total = line * 128 + 2 * diaphragm + 3 * bents_n + joint_n
    assert weights.mass_centre_m(bridge) == pytest.approx(moment / total, rel=1e-9)
    with domain():
        masses = build(variant(0, bridge=name), ModelOptions()).frame.loads.masses_kg
        # Gregory's weights of the masses along a span are exact for linear functions
        centre = sum(kg * ops.nodeCoord(node, 1) for node, kg in masses.items())
    assert centre / sum(masses.values()) == pytest.approx(moment / total, abs=1e-6)


def test_simple_spans_have_open_joints_and_their_analysis_reports_each(written):
    """Longitudinally, each deck moves on its own pads: far softer than the continuous deck."""
    modes = modal_properties(variant(0, bridge=written(FOUR_SPANS)))
    # deck 2 on the pads of two caps (2 x 6 pads), rigid columns: an upper bound of its frequency
    mass = (140.0 * 30.0 + 2 * 321.0) * 1e3 / 9.81
    period_s = 2 * np.pi * np.sqrt(mass / (12 * 1500e3))
    along = [mode.period_s for mode in modes.modes if mode.mass_x > 0.1]
    assert period_s < max(along) < 1.3 * period_s
    case = variant(30, bridge=written(FOUR_SPANS), gap_mm=25)
    result = analysed(case, strong_motion(duration_s=5.0))
    found, table = result.whole_history, pd.DataFrame(result.histories)
    assert result.status == "ok"
    assert abs(found["energy_residual_ratio"]) < 1e-3
    worst = [found[f"joint{i}_unseating_m"] for i in (1, 2, 3)]
    assert found["joint_unseating_m"] == max(worst) > 0.02
    for i, peak in enumerate(worst, start=1):
        assert table[f"joint{i}_unseating_m"].max() == pytest.approx(peak, rel=1e-2)
        assert found[f"joint{i}_closures"] > 0
    assert found["contact_closures"] >= sum(found[f"joint{i}_closures"] for i in (1, 2, 3))


def test_a_column_below_a_joint_is_a_cantilever_normal_to_its_bent(written):
    bridge_file = written(FOUR_SPANS)
    bridge = load_bridge(bridge_file)
    normal, along = (bent_capacity(bridge, 1, direction=side) for side in (0, 1))
    assert (normal.direction, along.direction) == ("normal", "along")
    # 5.6 m of column below a cap of 1.5 m, or two cantilevers of half the column
    assert (normal.shear_span_m, along.shear_span_m) == pytest.approx((7.1, 2.8))
    curve, heights = normal.curve, np.linspace(0.0, 5.6, 100_001)
    strength_nm = curve.plastic_moment_nm
    assert strength_nm == along.curve.plastic_moment_nm == pytest.approx(15.3e6, rel=0.01)
    # twice integrated by trapezoids: a curvature that is zero at the bearings, 7.1 m above the base
    yields = curve.yield_curvature_per_m * (1.0 - heights / 7.1)
    bent_m = np.trapezoid(yields * (5.6 - heights), heights)
    assert normal.yield_disp_m == pytest.approx(bent_m, rel=1e-6)
    plastic = curve.ultimate_curvature_per_m - curve.yield_curvature_per_m
    hinge = 0.08 * 7.1 + 0.022 * 469.0 * 0.0358
    assert normal.hinge_length_m == pytest.approx(hinge, rel=1e-6)
    assert normal.capacity_m - bent_m == pytest.approx(plastic * hinge * (5.6 - hinge / 2))
    assert along.yield_disp_m == pytest.approx(2 * curve.yield_curvature_per_m * 2.8**2 / 3)
    with domain():
        column = build(variant(0, bridge=bridge_file), ModelOptions()).columns[0]
    # along the bent, the lower limit of the rule governs: 0.739 m
    ratios = [capacity.hinge_ratio for capacity in column.capacities]
    assert ratios == pytest.approx([1.0, hinge / (2 * 0.022 * 469.0 * 0.0358)])


def on_single_columns(written, torsion_m4, spans, joints=""):
    bent = BENT.replace("columns: 3, column_spacing_m: 4.5", "columns: 1, base: fixed")
    return written(f"""extends: osb1
title: spans on single columns
source: "d: made for this test"
spans_m: {[28.0, 30.0, 28.0][:spans]}
deck: {{soffit_height_m: 7.6, torsion_constant_m4: {torsion_m4}}}
bents: [{", ".join([bent] * (spans - 1))}]
joints: [{joints}]
""")


@pytest.mark.parametrize(
    ("torsion_m4", "spans"),
    # a cantilever up to the centroid, a deck of weak torsion, the top yields, pads lift off
    [(1e-3, 3), (0.5, 3), (2.0, 2), (5.0, 3)],
)
def test_zero_moment_along_a_single_column_is_where_the_model_has_it(written, torsion_m4, spans):
    name = on_single_columns(written, torsion_m4, spans)
    column = bent_capacity(load_bridge(name), 0, direction=1)
    with domain():
        model = build(variant(0, "contact", name), ModelOptions(foundation="fixed"))
        at_rest = np.array(ops.eleResponse(model.columns[0].element, "localForce"))
        assembly.open_linear_pattern(model.tags)
        for node, mass_kg in model.frame.loads.masses_kg.items():
            ops.load(node, 0.0, mass_kg, 0.0, 0.0, 0.0, 0.0)
        static_steps(1, "UmfPack", 1e-6)
        ops.algorithm("NewtonLineSearch")
        push = model.columns[0].top.node, 2, column.capacity_m / 300
        ops.integrator("DisplacementControl", *push)
        assert ops.analyze(330) == 0  # to the ultimate curvature at the base of the model
        force = np.array(ops.eleResponse(model.columns[0].element, "localForce")) - at_rest
    shear_n, moment_nm = np.hypot(*force[1:3]), np.hypot(*force[4:6])
    # hinges of the model harden, and its tops yield gradually
    assert moment_nm / shear_n == pytest.approx(column.shear_span_m, rel=0.1)


def test_the_shear_span_of_a_single_column_is_known_in_limits(written):
    joint = f"{{at: bent 1, seat_width_m: 0.6, pads: {{{PADS}}}}}"
    for torsion_m4, spans, joints_text, span_m in (
        (1e-3, 3, "", 5.6 + 1.01),  # without torsion: the load is at the centroid
        (1e-3, 2, joint, 5.6 + 2.51),  # below a cap of 1.5 m
        (0.5, 2, joint, 4.66),  # 4.66 m in a push of the model
    ):
        bridge = load_bridge(on_single_columns(written, torsion_m4, spans, joints_text))
        assert bent_capacity(bridge, 0, direction=1).shear_span_m == pytest.approx(span_m, rel=0.01)


@pytest.mark.parametrize("pads", ["two", "each"])
def test_a_deck_that_runs_over_a_bent_on_bearings_moves_on_them(written, pads):
    """Statics: 5 pads on each of 2 caps, whose columns are cantilevers of 7.1 m."""
    name = written((EXAMPLES / "continuous_on_bearings.yaml").read_text())
    options = ModelOptions(elastic_columns=True, foundation="fixed", pads=pads)
    with domain():
        model = build(variant(0, "roller", name), options)
        columns = [column.element for column in model.columns]
        at_rest = np.array([ops.eleResponse(column, "force") for column in columns])
        bridge = load_bridge(name)
        deck_kn = pads_reaction_kn(bridge, bridge.bents[1].pads.model_dump())
        assert deck_kn * 1e3 == weights.deck_reactions_n(bridge)[2]
        # below bearings, the whole cap of 1.5 m x 12 m; `pads: null` is an integral cap
        caps = [{"cap_depth_m": 1.5, "pads": pads} for pads in (bridge.bents[0].pads, None)]
        assert cap_areas(caps, 3.0, 12.0) == [18.0, 3.0]
        assert at_rest[:, 2] == pytest.approx(weights.column_axial_n(bridge, 0), rel=5e-3)
        assembly.open_linear_pattern(model.tags)
        for line in model.frame.bearing_lines:
            ops.load(line.node, 60e3, 0.0, 0.0, 0.0, 0.0, 0.0)
        static_steps(1, "UmfPack", 1e-9)
        change = np.array([ops.eleResponse(column, "force") for column in columns]) - at_rest
        pairs = [(line.node, line.cap) for line in model.frame.bearing_lines]
        pads_m = [ops.nodeDisp(deck, 1) - ops.nodeDisp(cap, 1) for deck, cap in pairs]
        # the soffit of the cap, 1.44 m below the bottom of the pads
        tops_m = [ops.nodeDisp(cap, 1) - 1.44 * ops.nodeDisp(cap, 5) for _, cap in pairs]
    change, at_rest = change.reshape(2, 3, 12), at_rest.reshape(2, 3, 12)
    assert change[:, :, 0].sum(axis=1) == pytest.approx(-60e3, rel=1e-6)
    # about the bearings, including the moment of the dead load on columns that have moved; the ends
    # of pads of a height of 60 mm do not turn
    moment_nm = change[:, :, 4].sum(axis=1) + at_rest[:, :, 2].sum(axis=1) * tops_m
    assert np.abs(moment_nm) == pytest.approx(7.1 * 60e3, rel=2e-3)
    assert np.array(pads_m) == pytest.approx(60e3 / (5 * 1500e3), rel=3e-3)


def test_restrainers_pull_after_their_slack_up_to_their_strength(written, monkeypatch):
    made = []
    keep = lambda *given: made.append(element.uniaxial(*given)) or made[-1]  # noqa: E731
    monkeypatch.setattr(joints, "uniaxial", keep)
    with domain():
        model = build(variant(0, bridge=written(FOUR_SPANS), gap_mm=25), ModelOptions())
        assert [len(joint.restrainers) for joint in model.joints] == [0, 2, 0]
        ops.testUniaxialMaterial(made[0])
        forces = []
        for opened_m in (-0.01, 0.019, 0.030, 0.30):
            ops.setStrain(opened_m)
            forces.append(ops.getStress())
    # half of 8 cables at each end of the joint: 4 x 5000 kN/m after 20 mm, at most 4 x 170 kN
    assert forces == pytest.approx([0.0, 0.0, 0.010 * 20e6, 680e3], rel=1e-6, abs=1.0)


@pytest.mark.parametrize(
    ("text", "abutment", "message"),
    [
        (HINGED.replace("ledge: left", "ledge: right"), "contact", "joint 1: a deck lifts off"),
        (FOUR_SPANS, "roller", "because abutment model roller"),
        *((FOUR_SPANS.replace(*change), "contact", message) for *change, message in (
            ("at: bent 3", "at: bent 4", r"joints.2.at: must be one of the 3 bents"),
            ("base: fixed", "base: pinned", r"bents.0: a bent with bearings .* needs base: fixed"),
            ("at: bent 1\n  ", "", r"joints.0: give either at or from_left_m"),
            ("at: bent 3", "from_left_m: 28.2", r"each support \(0, 28, 58, 88, 116 m\)"),
            ("cap_weight", f"pads: {{{PADS}}}, cap_weight", "the joint at this bent has the pads"),
            ("seat_width_m: 0.6", "seat_width_m: 1.2", "half of bents.0.cap_width_m = 2, got 1.2"),
            ("7.6", "6.6", r"bents.\d: clear_height_m \+ cap_depth_m = .* must be at most"),
        )),
        *((f"extends: bridge_a\ntitle: bad\n{text}\n", "contact", message) for text, message in (
            ("abutments: {left: {type: box}, right: {type: fixed}}",
             "abutments.left.type: must be one of .*'integral"),
            ("abutments: {left: {type: integral, piles: {count: {v: 0, src: 'd: x'}}}, "
             "right: {type: fixed}}", r"abutments\.left\.piles\.count: must be"),
            ("abutment: {key_mass_t: {v: 1, src: 'd: x'}}\nabutments: {left: {type: fixed}}",
             "not both"),
        )),
    ],
)  # fmt: skip
def test_bad_joints_and_ends_are_refused_with_their_key(written, text, abutment, message):
    with domain(), pytest.raises(InputError, match=message):
        build(variant(0, abutment, written(text)), ModelOptions())


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
    with domain():
        tags = handles.TagAllocator()
        plan = deck_ends(bridge, skew_deg)[0]
        node, height_m = tags.node(), bridge.deck.centroid_above_soffit_m
        ops.node(node, *plan.middle_m, height_m)
        case = variant(skew_deg, bridge=bridge.name)
        blueprint = Blueprint(variant=case, options=options, tags=tags, contacts=None)
        kind = joints.KINDS[bridge.ends["left"].type]
        kind(End(node=node, plan=plan, abutment=bridge.ends["left"]), blueprint)()
        assembly.open_linear_pattern(tags)
        for dof, value in enumerate(moved, start=1):
            ops.sp(node, dof, value)
        static_steps(1, "FullGeneral", 1e-14)
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
    fill = float(backfill.wall_backfill(data, "hyperbolic", radians(skew_deg)).force_n(2e-5)) / 2e-5
    wing, count = backfill.wing_wall(data).stiffness_n_per_m * 50 / 51, data.piles.count
    piles = count * data.piles.lateral_kn_per_m * 1e3
    assert (data.wall_width_m, data.wall_height_m, count) == (14.33, 1.829, 6)
    normal, tangent = np.array(plan.normal), np.array(plan.tangent)

    def stiffness(*moved):
        """Return the reactions of a displacement over its size."""
        moved = np.pad(moved, (0, 6 - len(moved)))
        return reactions_of(bridge, skew_deg, options, moved) / np.linalg.norm(moved)

    # the wing is behind a tie 50 times as stiff; an opening spring keeps 1e-6 of its strength
    for moved, expected, error in (
        (2e-5 * normal, (fill + piles) * normal, 3e-3),
        (-1e-3 * normal, -piles * normal, 1e-3),
        (1e-4 * tangent, (wing + piles) * tangent, 1e-3),
    ):
        assert stiffness(*moved)[:2] == pytest.approx(expected, rel=error, abs=1e4)
    # in plan: of three points with 1/6, 2/3 and 1/6 of the wall, those that move into the fill
    half = 14.33 / cos(radians(skew_deg)) / 2
    face = 0.915 / 2 / cos(radians(skew_deg)) * np.array(plan.outward)
    turn = wing * (face @ normal) ** 2
    for share, along in ((1 / 6, -half), (2 / 3, 0.0), (1 / 6, half)):
        lever = face @ tangent + along
        turn += share * fill * lever**2 if lever < -1e-9 else 0.0
    spread = (np.arange(count) - (count - 1) / 2) * data.piles.spacing_m / cos(radians(skew_deg))
    turn += piles / count * (spread @ spread)
    assert stiffness(0.0, 0.0, 0.0, 0.0, 0.0, 5e-6)[5] == pytest.approx(turn, rel=5e-3)
    # vertical, and about the face: the heads of the piles and their vertical springs
    assert stiffness(0.0, 0.0, 1e-4)[2] == pytest.approx(count * 167e6, rel=2e-4)  # arms in series


@pytest.mark.parametrize("text", [MIXED, WITH_DASHPOTS])
def test_the_piles_yield_and_the_fill_is_limited_by_its_strength(written, text):
    bridge = load_bridge(written(text))
    fill = backfill.wall_backfill(bridge.ends["left"], "hyperbolic", 0.0).ultimate_n
    pushed, pulled = (reactions_of(bridge, 0, ModelOptions(), (moved_m, 0.0, 0.0, 0.0, 0.0, 0.0))[0]
                      for moved_m in (-0.5, 0.5))  # fmt: skip
    weak = 0.5 * ModelOptions().wall_restoring_n_per_m
    expected = (fill + 6 * 177.9e3 + weak, 6 * 177.9e3 + weak)
    assert (-pushed, pulled) == pytest.approx(expected, rel=2e-3)


def test_piles_are_in_the_force_of_an_integral_end_and_their_dashpots_damp(written):
    motion, texts = strong_motion(duration_s=4.0, peak_g=0.1), (MIXED, WITH_DASHPOTS)
    result, damped = (analysed(variant(30, bridge=written(text)), motion) for text in texts)
    assert damped.demands["deck_disp_y_m"] < 0.97 * result.demands["deck_disp_y_m"]
    assert abs(damped.demands["energy_residual_ratio"]) < 0.01
    table, piles = result.histories, load_bridge(written(MIXED)).ends["left"].piles
    x, y = cos(radians(30)), sin(radians(30))
    force_kn, disp_m = (-x * table[f"abutment_left_x_{unit}"] - y * table[f"abutment_left_y_{unit}"]
                        for unit in ("kn", "m"))  # fmt: skip
    yield_m = piles.lateral_strength_kn / piles.lateral_kn_per_m
    apart = (disp_m < -0.1 * yield_m) & (table["abutment_left_backfill_kn"] < 1e-3)
    assert apart.sum() > 20
    assert np.abs(disp_m).max() < yield_m
    # away from the fill only the elastic piles act; dashpots of walls add 5 % out of phase
    work = (force_kn - force_kn[0])[apart] @ disp_m[apart]
    found_kn_per_m = work / (disp_m[apart] @ disp_m[apart])
    assert found_kn_per_m == pytest.approx(piles.count * piles.lateral_kn_per_m, rel=0.01)


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
            assert ops.basicForce(spring.element)[spring.component] == pytest.approx(0.0, abs=1.0)
    result = analysed(case, strong_motion(duration_s=4.0))
    found, histories = result.whole_history, result.histories
    assert result.status == "ok"
    unseating_m = histories["abutment_right_unseating_m"].max()
    assert found["unseating_m"] == pytest.approx(unseating_m, rel=1e-3)
    assert "abutment_left_unseating_m" not in histories
    assert abs(found["energy_residual_ratio"]) < 1e-3
    along, across = (histories[f"abutment_left_acute_{axis}_m"] for axis in "xy")
    fill_m = np.max(-cos(radians(30)) * along - sin(radians(30)) * across)
    assert found["abutment_passive_m"] >= 0.99 * fill_m > 0.0
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
    # both are stiffer than pads
    assert modal_properties(case).period_s("x") < 0.8 * modal_properties(variant(30)).period_s("x")


@pytest.mark.parametrize("left", ["fixed", "integral, piles: {rotational_mnm_per_rad: 3000.0}"])
def test_hand_values_of_dead_load_include_the_restraint_of_an_end(written, left):
    ends = f"{{left: {{type: {left}}}, right: {{type: seat}}}}"
    name = written(f"{{extends: osb1, source: own, title: stiff end, abutments: {ends}}}")
    bridge, modes = load_bridge(name), modal_properties(variant(0, bridge=name))
    # as on two simple supports, but for the stiffness of columns and pads
    columns_kn = np.mean(modes.column_axial_kn)
    assert columns_kn == pytest.approx(weights.column_axial_n(bridge, 0) / 1e3, rel=0.01)
    first, _, last = weights.deck_reactions_n(bridge)
    assert modes.abutment_reaction_kn == pytest.approx((first / 1e3, last / 1e3), rel=0.03)
    # the keys of the seat are not designed for the reaction of the other end
    assert end_reaction_kn(bridge) == last / 1e3
