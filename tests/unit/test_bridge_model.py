"""Parts of a built model: arrays, contacts, penalties, mesh, masses, damping, pads, its script."""

import json
import subprocess
import sys
from itertools import chain
from math import cos, hypot, pi, radians, sin, sqrt

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.analysis import modal
from skewbridge.analysis.model_script import model_script, recording
from skewbridge.bridge.abutments import bearing_stations, build_arms, build_bearings
from skewbridge.bridge.assembly import open_linear_pattern
from skewbridge.bridge.backfill import Passive, variation_factors
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.column import bent_capacities
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import DomainError, build, domain
from skewbridge.bridge.plan import DeckEnd, tributary_shares
from skewbridge.bridge.springs import NORMAL_OVER_TANGENT, penalties
from skewbridge.bridge.weights import lumping_shares, mass_centre_m, spine_points_m
from skewbridge.units import G_MPS2
from skewbridge.variant.options import ModelOptions

PADS = load_bridge("osb1").abutment.pads
YIELD_M = PADS.yield_force_kn / PADS.shear_stiffness_kn_per_m


@pytest.mark.parametrize("arrays", ["rigid", "corotational"])
def test_the_points_of_a_joint_move_rigidly_with_the_deck_end(arrays: str) -> None:
    with domain():
        # no key closes: plain Newton does not always follow one that the deck pushes and rubs
        model = build(variant(30), ModelOptions(arrays=arrays, transverse_gap_mm=1000.0))
        open_linear_pattern(model.tags)
        ops.load(model.frame.ends[-1].node, 1.0e5, 1.0e6, 0.0, 0.0, 0.0, 1.0e7)
        static_steps(1, "UmfPack", 1e-9)
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
        assert sorted(chain(*model.energy_elements.values())) == sorted(ops.getEleTags())


@pytest.mark.parametrize("skew_deg", [0, 30, 60, 45, -45])
@pytest.mark.parametrize("key_frame", ["skewed", "deck_edge"])
def test_walls_and_keys_follow_the_skew_and_face_the_deck(skew_deg, key_frame):
    bridge, turn = load_bridge("osb1"), radians(skew_deg)
    half_m, thickness_m = bridge.deck.width_m / 2, bridge.deck.diaphragm_thickness_m
    with domain():
        model = build(variant(skew_deg), ModelOptions(key_frame=key_frame, backwall_points=5))
        units = model.contacts.units
        for abutment, sign in zip(model.abutments, (-1.0, 1.0), strict=True):
            outward = np.array([sign * cos(turn), sign * sin(turn)])
            assert abutment.normal == pytest.approx(outward)
            walls = np.array([ops.nodeCoord(node)[:2] for node in abutment.wall_nodes])
            assert (walls[-1] - walls[0]) @ outward == pytest.approx(0.0, abs=1e-12)
            assert np.ptp(walls[:, 1]) == pytest.approx(2 * half_m)
            assert (len(abutment.wall_units), len(abutment.key_units)) == (5, 2)
            for unit in (units[index] for index in abutment.wall_units):
                assert (*unit.normal, unit.gap_m) == pytest.approx((*-outward, 0.0, 0.051))
            for index, node in zip(abutment.key_units, abutment.key_nodes, strict=True):
                unit, (x, y) = units[index], ops.nodeCoord(node)[:2]
                end_m = sign * (bridge.length_m + thickness_m / cos(turn)) / 2
                assert (x, abs(y)) == pytest.approx((end_m - y * np.tan(turn), half_m))
                assert ops.nodeCoord(unit.node_j) == pytest.approx((x, y, 0.0))
                across = [-np.sin(turn), np.cos(turn)] if key_frame == "skewed" else [0.0, 1.0]
                inward = -np.sign(y) * np.array(across)
                assert (*unit.normal, unit.gap_m) == pytest.approx((*inward, 0.0, 0.0064))
                assert unit.name == f"{abutment.side} key {'+' if y > 0 else '-'}y"


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact_friction"])
def test_the_modes_leave_the_model_as_it_was(abutment, monkeypatch: pytest.MonkeyPatch) -> None:
    def with_modes(*arguments):
        model = build(*arguments)
        fixed = {node: ops.getFixedDOFs(node) for node in ops.getNodeTags()}
        modal.modes_of(model, 6)
        assert {node: ops.getFixedDOFs(node) for node in ops.getNodeTags()} == fixed
        return model

    usual = analysed(variant(30, abutment), duration_s=2.0)
    monkeypatch.setattr("skewbridge.analysis.transient.build", with_modes)
    after_modes = analysed(variant(30, abutment), duration_s=2.0)
    assert usual.demands["shear_key_force_kn"] > 100.0
    assert after_modes.demands == usual.demands


@pytest.mark.parametrize("abutment", ["spring", "contact_friction"])
@pytest.mark.parametrize("sides_m", [{"+y": [7.165], "-y": [-7.165]}, {"none": [], "+y": [7.165]}])
def test_an_abutment_with_one_or_no_key_has_it_at_its_side(written, abutment, sides_m):
    left, right = sides_m
    ends = f"{{left: {{type: seat, keys_at: {left}}}, right: {{type: seat, keys_at: {right}}}}}"
    name = written(f"extends: osb1\ntitle: one key\nsource: 'd: test'\nabutments: {ends}\n")
    with domain():
        model = build(variant(30, abutment, name), ModelOptions())
        for end, y_m in zip(model.abutments, sides_m.values(), strict=True):
            assert [ops.nodeCoord(key, 2) for key in end.key_nodes] == pytest.approx(y_m)
            assert len(end.key_springs) == len(y_m)
            assert len(end.key_units) == len(y_m) * (abutment != "spring")


@pytest.mark.parametrize("count", [3, 4, 5, 9, 41])
def test_shares_of_wall_and_deck_keep_their_moments_of_inertia(count: int) -> None:
    shares, stations = np.array(tributary_shares(count)), np.linspace(-0.5, 0.5, count)
    assert shares.sum() == pytest.approx(1.0)
    assert shares @ stations**2 == pytest.approx(1 / 12)
    masses, places = np.array(lumping_shares(count)), np.arange(count + 1) - count / 2
    assert masses.sum() == pytest.approx(count)
    assert masses @ places**2 == pytest.approx(count**3 / 12)
    assert min(*shares, *masses) > 0.0
    assert shares == pytest.approx(shares[::-1])
    assert lumping_shares(1) == pytest.approx([0.5, 0.5])


def test_backfill_never_pulls_and_is_largest_at_the_acute_corner_of_either_sign() -> None:
    for skew_deg in (60, -60):
        end = DeckEnd("left", (-45.0, 0.0), (-1.0, 0.0), skew_deg, 14.0, 0.9)
        factors = variation_factors(end, end.wall_stations(5), 0.3)
        assert max(factors) == pytest.approx(1.3)
        assert sum(factors) == pytest.approx(5.0)
        assert (factors[0] > factors[-1]) == (end.acute_sign < 0)
    straight = DeckEnd("left", (-45.0, 0.0), (-1.0, 0.0), 0.0, 14.0, 0.9)
    assert variation_factors(straight, [-1.0, 1.0], 0.3) == [1.0, 1.0]
    soil = Passive(stiffness_n_per_m=1e8, ultimate_n=1e6, failure_ratio=0.7)
    assert soil.force_n([-0.01, 0.0]).tolist() == [0.0, 0.0]


def test_penalties_are_bounded_by_softening_and_by_the_step() -> None:
    options = ModelOptions()
    assert penalties(1.0e7, 1e9, options)[0] == pytest.approx(50 * 1.0e7)  # 2 % softer in series
    kn, kt = penalties(1.0e9, 4000.0, options)
    assert 0.005 * (kn / 4000.0) ** 0.5 == pytest.approx(3.0)  # rad per step of 5 ms
    assert kt == pytest.approx(kn / NORMAL_OVER_TANGENT)
    changed = ModelOptions(normal_stiffness_factor=2.0, tangent_stiffness_factor=3.0)
    assert penalties(1.0e9, 4000.0, changed) == pytest.approx((2 * kn, 3 * kt))


def test_four_elements_per_span_give_the_periods_of_sixteen() -> None:
    coarse, fine = (modal.modal_properties(variant(30), ModelOptions(deck_elements_per_span=count))
                    for count in (4, 16))  # fmt: skip
    periods_s = [[each.period_s(way) for way in ("x", "y", "rz", "z")] for each in (coarse, fine)]
    assert periods_s[0] == pytest.approx(periods_s[1], rel=0.002)


@pytest.mark.parametrize("name", ["osb2s", "osb1_fixed"])
def test_each_bent_has_hinges_of_its_own_length(name: str) -> None:
    bridge = load_bridge(name)
    bents = zip(bridge.bents, bent_capacities(bridge), strict=True)
    lengths_m = [bent.hinge_length_m for data, bent in bents for _ in range(data.columns)]
    with domain():
        columns = build(variant(bridge=name), ModelOptions()).columns
        found = [ops.sectionWeight(each.element, each.hinge_sections[-1]) for each in columns]
    assert found == pytest.approx(lengths_m, abs=1e-4)


@pytest.mark.parametrize("shift_m", [0.02, 0.055, 0.2])
def test_a_spine_node_is_within_5_cm_of_the_mass_centre(shift_m: float) -> None:
    bridge = load_bridge("osb1")
    first, *others, last = bridge.spans_m
    moved = bridge.model_copy(update={"spans_m": (first + shift_m, *others, last - shift_m)})
    (points,) = spine_points_m(moved, 8)
    assert min(abs(x - mass_centre_m(moved)) for x in points) <= 0.05


def test_masses_and_loads_add_up() -> None:
    with domain():
        model = build(variant(30), ModelOptions())
        columns_n = 2 * 23.56e3 * np.pi * 1.676**2 / 4 * 5.64
        # the ground carries the lower half of every column
        deck_n = sum(ops.nodeMass(node, 1) for node in model.frame.loads.masses_kg) * G_MPS2
        assert deck_n == pytest.approx(model.weight_n - columns_n / 2)
        deck = load_bridge("osb1").deck
        node = model.frame.ends[0].node + 2  # in a span, away from caps and diaphragms
        # rotational inertia of a box; in plan of a strip along the skew of 30 degrees
        square_m2 = [deck.width_m**2 + deck.depth_m**2, deck.depth_m**2, deck.width_m**2 / 0.75]
        found = [ops.nodeMass(node, dof) for dof in (4, 5, 6)]
        assert found == pytest.approx([ops.nodeMass(node, 1) * each / 12 for each in square_m2])


def test_rayleigh_damping_of_deck_and_columns_meets_its_ratio_at_both_periods() -> None:
    file = load_bridge("osb1").damping
    a0, a1 = modal.rayleigh_factors(file, file.ratio)
    assert (a0, a1) == pytest.approx((0.487, 0.00406), rel=0.01)
    for period_s in (0.94, 0.35):
        omega = 2 * np.pi / period_s
        assert a0 / (2 * omega) + a1 * omega / 2 == pytest.approx(0.05)
    with domain():
        model = build(variant(30), ModelOptions(damping_factor=0.4))
        assert modal.apply_rayleigh(model) == pytest.approx((0.4 * a0, 0.4 * a1))
        groups = model.energy_elements
        assert set(model.frame.damping.elements) == {*groups["deck"], *groups["columns"]}


@pytest.mark.parametrize(
    ("abutment", "option", "least_kg"),
    # slopes of 1:2: 0.7 (7.5 x 14.33 / 2)^0.5 x 7.5 (14.33 + 2 x 7.5) m3 of 1760 kg/m3
    [("spring", "embankment_mass", 1.986e6), ("spring", "wall_mass", 1e3),
     ("contact_friction", "wall_mass", 1e3)],
)  # fmt: skip
def test_abutments_have_mass_only_on_request(abutment: str, option: str, least_kg: float) -> None:
    for options in (ModelOptions(), ModelOptions(**{option: True})):
        with domain():
            model = build(variant(0, abutment), options)
            assert sorted(chain(*model.energy_elements.values())) == sorted(ops.getEleTags())
            ends = model.abutments
            nodes = [node for end in ends for node in end.key_nodes]
            nodes += [spring.nodes[1] for end in ends for spring in end.wing_springs]
            largest_kg = max(ops.nodeMass(node, 1) for node in nodes)
        assert largest_kg > least_kg if getattr(options, option) else largest_kg == 0.0


VARIANT = variant()
# periods as the script advises: without friction springs
ASK = """
import json
print(json.dumps([[n, *ops.nodeDisp(n)] for n in ops.getNodeTags()] + [ops.getEleTags()]))
for number in (number for contact in CONTACTS for number in contact["moduli"]):
    ops.updateParameter(number, 1.0)
print(json.dumps(ops.eigen(6)))
"""


def test_script_repeats_the_model_to_the_bit_and_recording_leaves_the_commands(tmp_path) -> None:
    script = tmp_path / "model.py"
    text = model_script(VARIANT, ModelOptions())
    script.write_text(text + ASK, encoding="utf-8")
    assert "skewbridge." not in text.replace("skewbridge.contact.", "")  # named in the docstring
    answer = subprocess.check_output([sys.executable, "-I", str(script)], text=True)
    with domain():
        build(VARIANT, ModelOptions())
        expected = [[n, *ops.nodeDisp(n)] for n in ops.getNodeTags()]
        expected.append(ops.getEleTags())
    state, squares = map(json.loads, answer.strip().split("\n")[-2:])
    assert state == expected
    periods_s = [mode.period_s for mode in modal.modal_properties(VARIANT).modes[:6]]
    assert [2 * pi / sqrt(square) for square in squares] == pytest.approx(periods_s, rel=1e-6)
    before = ops.node
    with recording():
        assert ops.node is not before
    assert ops.node is before
    with domain():
        build(VARIANT, ModelOptions())
        with pytest.raises(DomainError):  # a fresh domain is needed
            build(VARIANT, ModelOptions())
    assert not ops.getNodeTags()


def pad_reactions(options: ModelOptions, motion: dict[int, float], pads: PadData = PADS):
    """Return forces and moments of the ground under the pads of a deck end that is moved. Motion of
    the middle of the bearing line: displacement by degree of freedom, 1 to 6."""
    with domain():
        tags = TagAllocator()
        end = DeckEnd("right", (45.0, 0.0), (1.0, 0.0), 30.0, 14.0, 0.9)
        deck = tags.node()
        ops.node(deck, *end.point("bearing", 0.0)[:2], 1.0)
        stations = bearing_stations(pads, end, options)
        points, _ = build_arms(end, deck, stations, [], options, tags)
        bearings = build_bearings(end, points, pads, options, tags)
        open_linear_pattern(tags)
        for dof in range(1, 7):
            # the deck node is 1 m above the middle of the bearing line, which moves
            lean = {1: motion.get(5, 0.0), 2: -motion.get(4, 0.0)}.get(dof, 0.0)
            ops.sp(deck, dof, motion.get(dof, 0.0) + lean)
        static_steps(20, "UmfPack", 1e-9)
        ops.reactions()
        total, middle = np.zeros(6), np.array((*ops.nodeCoord(deck)[:2], 0.0))
        for bearing in bearings:
            reaction = np.array(ops.nodeReaction(bearing.seat_node))
            arm = np.array(ops.nodeCoord(bearing.seat_node)) - middle
            reaction[3:] += np.cross(arm, reaction[:3])
            total += reaction
        return total


@pytest.mark.parametrize(
    "motion", [{1: 0.2 * YIELD_M}, {2: 0.2 * YIELD_M}, {3: -1e-3}, {4: 1e-5}, {5: 1e-5}, {6: 1e-5}]
)
def test_two_pads_are_as_stiff_as_all_of_them(motion: dict[int, float]) -> None:
    # pressed down first: pads take no tension
    moved = {3: -1e-3} | motion
    two, each = (pad_reactions(ModelOptions(pads=pads), moved) for pads in ("two", "each"))
    assert np.abs(each).max() > 100.0
    # the two have no height, which a bearing element multiplies with its shear, and no bending
    lever_nm = PADS.height_m * np.abs(each).max()
    # under a vertical force the arms to the pads bend by 0.02 % of the settlement
    assert two[:3] == pytest.approx(each[:3], rel=3e-4, abs=1e-5 * np.abs(each).max())
    assert two[3:] == pytest.approx(each[3:], rel=1e-4, abs=lever_nm)


@pytest.mark.parametrize("pads", ["two", "each"])
@pytest.mark.parametrize("factor", [0.5, 1.0])
def test_pads_yield_together_at_their_strength_in_every_direction(pads, factor: float) -> None:
    scaled = PADS.model_copy(update={"yield_force_kn": factor * PADS.yield_force_kn})
    ux, uy = 3 * YIELD_M, -4 * YIELD_M
    fx, fy = pad_reactions(ModelOptions(pads=pads), {1: ux, 2: uy}, scaled)[:2] / PADS.count / 1e3
    # the arms above the pads bend by a ten-millionth of the displacement
    hardening_kn = PADS.hardening_ratio * PADS.shear_stiffness_kn_per_m * hypot(ux, uy)
    assert hypot(fx, fy) - hardening_kn == pytest.approx(factor * PADS.yield_force_kn, rel=1e-7)
    assert fx / fy == pytest.approx(ux / uy)
