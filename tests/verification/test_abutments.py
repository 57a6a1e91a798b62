"""Abutments: static response against formulas, backfill, keys and pads alone.

Figures from the project's reference page on bridge data, sections 3 and 8: passive force by
Caltrans SDC 2.0 with its skew reduction, the UCSD hyperbola up to its ultimate force (at 56 mm),
pads alone until the gap closes. Hyperbola: K = 20.3 x 14.33 x 1.8288/1.68 MN/m, F = 326 x 14.33 x
(1.8288/1.68)^1.5 kN.
Tolerance 0.5 % (penalty in series and weak restoring spring included).
"""

from itertools import pairwise, product
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, seated_bridges, variant
from skewbridge.analysis import transient
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge import springs
from skewbridge.bridge.abutments import Joint
from skewbridge.bridge.backfill import skew_reduction, wall_backfill
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.weights import deck_reactions_n
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import run_study
from strong_motion import strong_motion

PADS_N_PER_M = 5 * 2208e3
PADS_YIELD_N = 5 * 55.2e3
LAST_TWO = ("contact", "contact_friction")


def push(abutment, *, angle_deg=0.0, skew_deg=0, max_disp_m=0.15, steps=300, **options):
    given = {"angle_deg": angle_deg, "max_disp_m": max_disp_m, "steps": steps}
    curve = push_abutment(variant(skew_deg, abutment), ModelOptions(**options), **given)
    assert curve.is_complete
    return curve


def pads_at(disp_m):
    """Bilinear pads: k until the yield of the plastic part, 0.1 k beyond."""
    return 0.1 * PADS_N_PER_M * disp_m + min(0.9 * PADS_N_PER_M * disp_m, PADS_YIELD_N)


def force_at(curve, disp_m):
    return float(np.interp(disp_m, curve.disp_m, curve.force_n))


def beside_pads_kn(curve, disp_m):
    return (force_at(curve, disp_m) - pads_at(disp_m)) / 1e3


@pytest.mark.parametrize("abutment", ["spring", "contact", "contact_friction"])
@pytest.mark.parametrize(
    ("skew_deg", "force_kn"), [(0, 6_662), (30, 3_420), (60, 1_756), (66, 1_537)]
)
def test_a_push_normal_to_the_wall_reaches_the_bilinear_force(abutment, skew_deg, force_kn):
    # a push normal to the wall never meets keys square to it: backfill and pads alone
    options = {"backfill": "sdc", "key_frame": "skewed"}
    curve = push(abutment, angle_deg=skew_deg, skew_deg=skew_deg, max_disp_m=0.09, **options)
    assert beside_pads_kn(curve, 0.085) == pytest.approx(force_kn, rel=0.005)


@pytest.mark.parametrize("abutment", ["spring", "contact"])
@pytest.mark.parametrize(("closure_m", "force_kn"), [(0.025, 3_872), (0.05, 5_126), (0.076, 5_306)])
def test_the_hyperbolic_backbone_is_met_behind_the_gap(abutment, closure_m, force_kn):
    soil = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", 0.0)
    penalty_kn_per_m = springs.NORMAL_OVER_NEIGHBOUR * soil.stiffness_n_per_m / 1e3
    penetration_m = force_kn / penalty_kn_per_m if abutment == "contact" else 0.0
    found_kn = beside_pads_kn(push(abutment), 0.051 + closure_m + penetration_m)
    assert found_kn == pytest.approx(force_kn, rel=0.005)


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact", "contact_friction"])
def test_only_the_pads_act_until_the_gap_closes_and_away_from_the_backfill(abutment):
    towards, away = push(abutment, max_disp_m=0.05), push(abutment, angle_deg=180.0)
    for curve, disp_m in ((towards, 0.01), (towards, 0.03), (towards, 0.05), (away, 0.14)):
        expected = 0.0 if abutment == "simplified" else pads_at(disp_m)
        tolerance = 1e-3 if curve is away else 1e-4
        assert force_at(curve, disp_m) == pytest.approx(expected, rel=tolerance, abs=1.0)


def test_a_key_follows_its_backbone_and_the_spring_model_yields_in_series_with_its_wing_walls():
    curve = push("contact", angle_deg=90.0, steps=1500)
    key = load_bridge("osb1").abutment.sacrificial_key
    penalty_kn_per_mm = springs.NORMAL_OVER_NEIGHBOUR * key.force_kn[0] / key.displacement_mm[0]
    for force_kn, disp_mm in zip(key.force_kn, key.displacement_mm, strict=True):
        disp_m = 0.0064 + 1e-3 * (disp_mm + force_kn / penalty_kn_per_mm)
        assert beside_pads_kn(curve, disp_m) == pytest.approx(force_kn, rel=0.005)
    spring, contact = (push(name, angle_deg=90.0) for name in ("spring", "contact"))
    assert spring.peak_n == pytest.approx(contact.peak_n, rel=0.02)
    assert push("contact", angle_deg=90.0, keys="monolithic").peak_n > 2 * contact.peak_n
    later_m = spring.disp_at_peak_m - contact.disp_at_peak_m
    assert later_m == pytest.approx(1765e3 / 129.3e6, rel=0.1)  # key strength over wing stiffness


def test_friction_acts_in_an_oblique_push_only():
    for angle_deg in (0.0, 90.0):
        plain, rubbing = (push(name, angle_deg=angle_deg) for name in LAST_TWO)
        np.testing.assert_allclose(rubbing.force_n, plain.force_n, rtol=1e-6, atol=1.0)
    oblique = {"angle_deg": 45.0, "max_disp_m": 0.1, "backfill": "sdc"}
    plain, rubbing = (push(name, **oblique) for name in LAST_TWO)
    assert force_at(rubbing, 0.1) > 1.1 * force_at(plain, 0.1)


def test_the_hyperbola_of_kavianis_bridges_passes_its_two_points():
    for name, k50_mn_per_m, ultimate_kn in (
        ("bridge_a", 169.8, 2_014), ("bridge_b", 598.7, 9_471), ("bridge_c", 761.8, 12_178),
    ):  # fmt: skip
        data = load_bridge(name).abutment
        closures_m = [ultimate_kn / 2 / k50_mn_per_m / 1e3, 0.05 * data.wall_height_m]
        found_kn = wall_backfill(data, "hyperbolic", 0.0).force_n(closures_m) / 1e3
        assert found_kn == pytest.approx([ultimate_kn / 2, ultimate_kn], rel=1e-6), name


# --- skew: strength by the rule of SDC, stiffness and closure at full strength as in tests


def test_pushed_walls_agree_with_the_tests_of_skewed_walls():
    study = run_study("skew-passive")
    assert [row["quantity"] for row in study.comparisons if not row["pass"]] == []
    judged = [row for row in study.comparisons if np.isfinite(row["tolerance"] or np.nan)]
    # five measured strengths, three stiffnesses for each curve; four closures for the hyperbola
    assert len(judged) == 2 * (5 + 3) + 4
    assert {row["source"].split()[0] for row in judged} >= {"Franke", "Smith", "Jessee", "Rollins,"}


@pytest.mark.parametrize("bridge", seated_bridges())
@pytest.mark.parametrize("skew_deg", [15, -45, 60])
def test_skew_keeps_the_stiffness_and_the_closure_at_full_strength(bridge, skew_deg):
    data, skew_rad = load_bridge(bridge).abutment, np.radians(skew_deg)
    straight, skewed = (wall_backfill(data, "hyperbolic", angle) for angle in (0.0, skew_rad))
    reduction = np.exp(-abs(skew_deg) / 45.0)
    end_m = straight.ultimate_n / straight.stiffness_n_per_m / (1.0 - straight.failure_ratio)
    found_n = skewed.force_n([1e-9, end_m * (1 - 1e-6), end_m, 2 * end_m])
    assert found_n[0] == pytest.approx(1e-9 * straight.stiffness_n_per_m, rel=1e-6)
    assert found_n[1] < found_n[2] * (1 - 1e-9)  # not yet at full strength
    assert found_n[2:] == pytest.approx(reduction * straight.ultimate_n, rel=1e-9)
    if (bridge, skew_deg) == ("osb1", -45):
        assert skewed.failure_ratio == pytest.approx(0.89, abs=0.005)


@pytest.mark.parametrize("kind", ["hyperbolic", "sdc"])
def test_skew_that_reduces_the_stiffness_as_well_multiplies_all_forces(kind):
    data, rule = load_bridge("osb1").abutment, "strength_and_stiffness"
    straight = wall_backfill(data, kind, 0.0)
    for skew_deg in (0.0, 30.0, -60.0):
        skew_rad = np.radians(skew_deg)
        skewed = wall_backfill(data, kind, skew_rad, skew_rule=rule)
        assert skewed == straight.scaled(skew_reduction(skew_rad))  # to the last bit
    assert wall_backfill(data, kind, 0.0, skew_rule=rule) == straight
    assert AnalysisSettings(scheme="paper").model_options(ModelOptions()).backfill_skew == rule


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact"])
def test_every_abutment_with_backfill_follows_the_skew_option(abutment):
    """Initial stiffness at skew 60 over that at 0: 1 or exp(-60/45); pads add the same to both."""
    case = {"max_disp_m": 1e-4, "steps": 2, "key_frame": "skewed"}
    ratios = {}
    for rule in ("strength", "strength_and_stiffness"):
        stiffness = []
        for skew_deg in (0, 60):
            given = {"angle_deg": skew_deg, **case}
            options = {"backfill_skew": rule, "gap_offset_mm": -51.0}
            pushed = push(abutment, skew_deg=skew_deg, **given, **options)
            pads = 0.0 if abutment == "simplified" else PADS_N_PER_M
            stiffness.append(pushed.initial_stiffness_n_per_m - pads)
        ratios[rule] = stiffness[1] / stiffness[0]
    assert ratios["strength"] == pytest.approx(1.0, abs=0.02)
    assert ratios["strength_and_stiffness"] == pytest.approx(np.exp(-60 / 45), abs=0.01)


def test_the_body_of_the_spring_abutment_has_the_same_stiffness_at_any_skew(monkeypatch):
    """Its spring across the wall stands for soil at zero skew, whatever skew does to the soil."""
    found = set()
    for rule, skew_deg in product(["strength", "strength_and_stiffness"], [0, 60]):
        create = Mock(wraps=ops.uniaxialMaterial)
        monkeypatch.setattr(ops, "uniaxialMaterial", create)
        with domain():
            build(variant(skew_deg, "spring"), ModelOptions(backfill_skew=rule))
        monkeypatch.undo()
        given = [call.args for call in create.call_args_list if call.args[0] == "Elastic"]
        found.add(round(max(args[2] for args in given if args[2] < STIFFNESS) / STIFFNESS, 9))
    assert len(found) == 1
    assert 0.1 < found.pop() < 0.5  # the share of the first wall point


def dashpots_n_s_per_m(vs_mps, monkeypatch):
    """Return the sum of all dashpots behind the walls and keys of both abutments of OSB1."""
    create = Mock(wraps=ops.uniaxialMaterial)
    monkeypatch.setattr(ops, "uniaxialMaterial", create)
    with domain():
        build(variant(60), ModelOptions(backfill_vs_mps=vs_mps))
    monkeypatch.undo()
    given = [call.args for call in create.call_args_list]
    return sum(args[3] for args in given if args[0] == "Elastic" and len(args) > 3)


def test_waves_that_leave_a_wall_damp_it_with_density_velocity_and_area(monkeypatch):
    """Two walls of 14.33 m x 1.8288 m, each with wing walls worth 0.2963 of it; keys the same."""
    slow, fast, keys, by_mass = (
        dashpots_n_s_per_m(vs_mps, monkeypatch) for vs_mps in (100.0, 250.0, 0.0, None)
    )
    area_m2 = 2 * 14.33 * 1.8288 * (1.0 + 0.3333 * 1.3333 * 0.6667)
    assert fast - slow == pytest.approx(1760.0 * 150.0 * area_m2, rel=1e-9)
    assert keys == pytest.approx(slow - 1760.0 * 100.0 * area_m2, rel=1e-9)
    assert keys < by_mass < slow
    # the scheme of the paper has no radiation
    assert AnalysisSettings(scheme="paper").model_options(ModelOptions()).backfill_vs_mps is None


# --- one backfill spring on paths: capped hyperbola, unloading, gap behind the wall, reloading
# Limits: 0.5 % of the force on first loading (the polygon misses 0.1 %), 2 micrometres where a gap
# closes, and no force to speak of while a gap is open.


OSB1 = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", 0.0)
STIFFNESS = OSB1.stiffness_n_per_m
CLOSES_M = 2.0e-6
STIFF = 1.0e6  # of the driver over the spring: it gives way by a hundredth of a micrometre


def spring_in_series(spring, driver, values, step):
    """Push two springs in a row along a path of prescribed closures, ready for static steps."""
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, 2, 3):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    ops.element("zeroLength", 1, 1, 2, "-mat", *spring, "-dir", *[1] * len(spring))
    ops.element("zeroLength", 2, 2, 3, "-mat", driver, "-dir", 1)
    moves = [-float(value) for value in values]
    ops.timeSeries("Path", 1, "-dt", 1.0, "-values", *moves, "-useLast")
    ops.pattern("Plain", 1, 1)
    ops.sp(3, 1, 1.0)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("ProfileSPD")
    ops.algorithm("Newton")
    ops.integrator("LoadControl", step)


def forces(closures_m, *, gap_m=0.0, passive=OSB1):
    """Return the compressive force of the spring at successive closures, driven step by step."""
    tags, out = TagAllocator(), []
    with domain():
        spring = springs.passive_material(passive, gap_m, tags)
        driver = springs.elastic_material(STIFF * passive.stiffness_n_per_m, tags)
        spring_in_series([spring], driver, [0.0, *closures_m], 1.0)
        ops.test("NormDispIncr", 1.0e-12, 50)
        ops.analysis("Static", "-noWarnings")
        for _ in closures_m:
            assert ops.analyze(1) == 0
            out.append(-ops.basicForce(1)[0])
    return np.array(out)


def path(*turns_m, steps=100):
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise((0.0, *turns_m))])


@pytest.mark.parametrize("bridge", ["osb1", "bridge_a", "bridge_b", "bridge_c"])
def test_first_loading_is_the_hyperbola_and_ends_at_the_ultimate_force(bridge):
    passive = wall_backfill(load_bridge(bridge).abutment, "hyperbolic", 0.0)
    closures = np.geomspace(1e-3, 1.0, 200)
    for gap_m in (0.0, 0.025, 0.051):
        found = forces(gap_m + closures, gap_m=gap_m, passive=passive)
        np.testing.assert_allclose(found, passive.force_n(closures), rtol=0.005)
        assert found.max() == pytest.approx(passive.ultimate_n, rel=0.002)


@pytest.mark.parametrize(
    ("reached_m", "away_m"),
    [(0.005, 0.0), (0.02, 0.0), (0.05, 0.0), (0.3, 0.0), (0.04, 0.01), (0.04, 0.0), (0.04, -0.1)],
)
def test_unloading_is_stiff_and_opens_a_gap_and_reloading_meets_the_curve(reached_m, away_m):
    back, again = np.linspace(reached_m, away_m, 200), np.linspace(away_m, 0.3, 400)
    loaded, unloaded, reloaded = np.split(forces([*path(reached_m), *back, *again]), (100, 300))
    peak_n = loaded[-1]
    starts_m = reached_m - peak_n / STIFFNESS
    expected = np.maximum(peak_n - STIFFNESS * (reached_m - back), 0.0)
    np.testing.assert_allclose(unloaded, expected, atol=CLOSES_M * STIFFNESS)
    beyond = np.abs(unloaded[back < starts_m - CLOSES_M])
    assert beyond.max(initial=0.0) < 1e-5 * OSB1.ultimate_n
    peak_n = float(OSB1.force_n(reached_m))
    reload = np.clip(STIFFNESS * (again - starts_m), 0.0, None)
    expected = np.where(again < reached_m, np.minimum(reload, peak_n), OSB1.force_n(again))
    np.testing.assert_allclose(reloaded, expected, rtol=0.005, atol=0.002 * peak_n)


def test_a_massless_node_that_a_contact_pushes_is_solved_through_all_branches():
    with domain():
        tags = TagAllocator()
        weak = springs.elastic_material(1e-4 * STIFFNESS, tags)
        contact = springs.gap_material(10 * STIFFNESS, 0.02, tags)
        spring = springs.passive_material(OSB1, 0.0, tags)
        turns_m = 0.15 * np.array([0, 1, 0, -0.2, 1.2, 0, 0.9, 0])
        spring_in_series([spring, weak], contact, turns_m, 0.01)
        ops.test("EnergyIncr", 1e-8, 10)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(700) == 0
        assert ops.nodeDisp(2, 1) == pytest.approx(0.0, abs=1e-3)


# --- the force of a shear key is that of its backbone, never that of the penalty before it


def test_a_key_that_breaks_has_given_its_strength_and_no_more():
    key = load_bridge("osb1").abutment.sacrificial_key
    for abutment in ("spring", "contact"):
        case = variant(abutment=abutment, gap_mm=25, friction_pct=0)
        found = analysed(case, strong_motion(peak_g=1.6), duration_s=3.0).demands
        assert found["shear_key_disp_m"] > key.displacement_mm[1] / 1e3
        assert found["shear_key_force_kn"] == pytest.approx(max(key.force_kn), rel=0.02)


@pytest.mark.parametrize("option", ["backbone", "elastic"])
def test_a_key_pushed_along_its_face_has_no_more_than_its_strength(option):
    """50 mm along the face: beyond the strength, 69 MN/m times 50 mm without a limit."""
    key, tags = load_bridge("osb1").abutment.sacrificial_key, TagAllocator()
    options = ModelOptions(key_along_face=option)
    context = SimpleNamespace(key=key, key_mass_kg=6.0e3, options=options, tags=tags)
    with domain():
        nodes = springs.grounded_node((0.0,) * 3, tags), springs.plane_node((0.0,) * 3, 0.0, tags)
        Joint.key_spring(context, nodes, (0.0, 1.0))
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        ops.load(nodes[1], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        ops.integrator("DisplacementControl", nodes[1], 1, 0.001)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(50) == 0
        force_kn = ops.getLoadFactor(1) / 1e3
    expected = elastic_kn = 50.0 * key.force_kn[0] / key.displacement_mm[0]
    if option == "backbone":
        expected = key.force_kn[1] + springs.KEY_FACE_HARDENING * (elastic_kn - key.force_kn[1])
        assert key.force_kn[1] < expected < 1.01 * key.force_kn[1]
    assert force_kn == pytest.approx(expected, rel=1e-6)


# --- pads and supports lift: no tension in any bridge, and the opening is a demand


@pytest.mark.parametrize(
    ("bridge", "skew_deg", "pads"),
    [*product(seated_bridges(), [0, 60], ["two"]), ("osb1", 60, "each"), ("bridge_a", 60, "each")],
)
def test_no_pad_pulls_at_the_deck_and_a_deck_that_lifts_opens_its_bearings(
    monkeypatch, bridge, skew_deg, pads
):
    """Under a pulse of 1.6 g, bridge A at skew 60 would need 2 MN of tension; OSB1 lifts less."""
    forces_n = []  # of each bearing on the deck downwards, step by step: tension is positive

    class Watch(transient.Watch):
        def __init__(self, model, settings, **options):
            super().__init__(model, settings, **options)
            self.pads = [pad.element for end in model.abutments for pad in end.bearings]
            forces_n.append(self.of_pads())

        def of_pads(self):
            return [ops.eleForce(element)[8] for element in self.pads]

        def collapsed(self):
            forces_n.append(self.of_pads())
            return super().collapsed()

    monkeypatch.setattr(transient, "Watch", Watch)
    case, motion = variant(skew_deg, bridge=bridge, gap_mm=25), strong_motion(peak_g=1.6)
    # bars that break within a step are a jump, which the work of end forces does not follow
    options = ModelOptions(pads=pads, fiber_end="none")
    found = analysed(case, motion, options, duration_s=4.0).whole_history
    # a skewed bearing line holds the deck against torsion and carries more than a straight one
    first, *_, last = deck_reactions_n(load_bridge(bridge))
    assert 0.95 < -sum(forces_n[0]) / (first + last) < 1.25
    assert np.max(forces_n) < 1.0e3
    assert abs(found["energy_residual_ratio"]) < 3.0e-3
    if (bridge, skew_deg) == ("bridge_a", 60):
        assert found["bearing_uplift_m"] > 0.01
    if (bridge, skew_deg) == ("osb1", 60):
        # the torsion of a skewed deck on a skewed bent lifts one end of the bearing line
        assert found["bearing_uplift_m"] < {"two": 0.015, "each": 0.005}[pads]
