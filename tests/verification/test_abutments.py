"""Abutments: static response against formulas, gaps at rest, backfill, keys and pads alone.

Figures from the project's reference page on bridge data, sections 3 and 8: passive force by
Caltrans SDC 2.0 with its skew reduction, the UCSD hyperbola up to its ultimate force (at 56 mm),
pads alone until the gap closes. Hyperbola: K = 20.3 x 14.33 x 1.8288/1.68 MN/m, F = 326 x 14.33 x
(1.8288/1.68)^1.5 kN. Tolerance 0.5 % (penalty in series and weak restoring spring included)."""

from itertools import product
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, seated_bridges, variant
from skewbridge.analysis import pushover, transient
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge import abutments, assembly, handles, springs, weights
from skewbridge.bridge.backfill import skew_reduction, wall_backfill
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.structures import built_bridge
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.registry import run_study
from skewbridge.verification.studies.paper_runs import strongest_motions
from strong_motion import strong_motion

PADS_N_PER_M, PADS_YIELD_N = 5 * 2208e3, 5 * 55.2e3
SEAT = load_bridge("osb1").abutment
KEY = SEAT.sacrificial_key
OSB1 = wall_backfill(SEAT, "hyperbolic", 0.0)
STIFFNESS = OSB1.stiffness_n_per_m
TOLERANCE_M = 5e-5  # a thousandth of the larger gap: far below any effect under study
GAP_MM, KEY_GAP_M = 25, 0.0064
# Limits: 0.5 % of the force on first loading (the polygon misses 0.1 %), 2 micrometres where a gap
# closes, and no force to speak of while a gap is open.
CLOSES_M = 2.0e-6
STIFF = 1.0e6  # of the driver over the spring: it gives way by a hundredth of a micrometre


def push(abutment, skew_deg=0, *, gap_mm=51, angle_deg=0.0, max_disp_m=0.15, steps=300, **options):
    given = {"angle_deg": angle_deg, "max_disp_m": max_disp_m, "steps": steps}
    case = variant(skew_deg, abutment, gap_mm=gap_mm)
    curve = pushover.push_abutment(case, ModelOptions(**options), **given)
    assert curve.is_complete
    return curve


def pads_at(disp_m):
    """Bilinear pads: k until the yield of the plastic part, 0.1 k beyond."""
    return 0.1 * PADS_N_PER_M * disp_m + min(0.9 * PADS_N_PER_M * disp_m, PADS_YIELD_N)


def force_at(curve, disp_m):
    return float(np.interp(disp_m, curve.disp_m, curve.force_n))


@pytest.mark.parametrize("abutment", ["spring", "contact", "contact_friction"])
@pytest.mark.parametrize(
    ("backfill", "skew_deg", "closures_m", "forces_kn"),
    [
        *(("sdc", *case) for case in (
            (0, [0.034], [6_662]), (30, [0.034], [3_420]), (60, [0.034], [1_756]),
            (66, [0.034], [1_537]),
        )),
        ("hyperbolic", 0, [0.025, 0.05, 0.076], [3_872, 5_126, 5_306]),
    ],
)  # fmt: skip
def test_a_push_meets_the_backbone(abutment, backfill, skew_deg, closures_m, forces_kn):
    """Normal to the wall, behind the gap, without keys: backfill and pads alone."""
    options = {"backfill": backfill, "key_frame": "skewed"}
    curve = push(abutment, skew_deg, angle_deg=skew_deg, **options)
    penalty_kn_per_m = springs.NORMAL_OVER_NEIGHBOUR * STIFFNESS / 1e3
    for closure_m, force_kn in zip(closures_m, forces_kn, strict=True):
        penetration_m = 0.0 if abutment == "spring" else force_kn / penalty_kn_per_m
        disp_m = 0.051 + closure_m + penetration_m
        found_kn = (force_at(curve, disp_m) - pads_at(disp_m)) / 1e3
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
    penalty_kn_per_mm = springs.NORMAL_OVER_NEIGHBOUR * KEY.force_kn[0] / KEY.displacement_mm[0]
    for force_kn, disp_mm in zip(KEY.force_kn, KEY.displacement_mm, strict=True):
        disp_m = 0.0064 + 1e-3 * (disp_mm + force_kn / penalty_kn_per_mm)
        found_kn = (force_at(curve, disp_m) - pads_at(disp_m)) / 1e3
        assert found_kn == pytest.approx(force_kn, rel=0.005)
    spring, contact = (push(name, angle_deg=90.0) for name in ("spring", "contact"))
    assert spring.peak_n == pytest.approx(contact.peak_n, rel=0.02)
    assert push("contact", angle_deg=90.0, keys="monolithic").peak_n > 2 * contact.peak_n
    later_m = spring.disp_at_peak_m - contact.disp_at_peak_m
    assert later_m == pytest.approx(1765e3 / 129.3e6, rel=0.1)  # key strength over wing stiffness


def test_friction_acts_in_an_oblique_push_only():
    def both(**given):
        return (push(name, **given) for name in ("contact", "contact_friction"))

    for angle_deg in (0.0, 90.0):
        plain, rubbing = both(angle_deg=angle_deg)
        np.testing.assert_allclose(rubbing.force_n, plain.force_n, rtol=1e-6, atol=1.0)
    plain, rubbing = both(angle_deg=45.0, max_disp_m=0.1, backfill="sdc")
    assert force_at(rubbing, 0.1) > 1.1 * force_at(plain, 0.1)


@pytest.mark.parametrize(
    ("bridge", "k50_mn_per_m", "ultimate_kn"),
    [("bridge_a", 169.8, 2_014), ("bridge_b", 598.7, 9_471), ("bridge_c", 761.8, 12_178)],
)
def test_the_hyperbola_of_kavianis_bridges_passes_its_two_points(bridge, k50_mn_per_m, ultimate_kn):
    data = load_bridge(bridge).abutment
    closures_m = [ultimate_kn / 2 / k50_mn_per_m / 1e3, 0.05 * data.wall_height_m]
    found_kn = wall_backfill(data, "hyperbolic", 0.0).force_n(closures_m) / 1e3
    assert found_kn == pytest.approx([ultimate_kn / 2, ultimate_kn], rel=1e-6)


@pytest.mark.parametrize("bridge", seated_bridges())
@pytest.mark.parametrize("abutment", ["contact", "contact_friction", "spring", "simplified"])
@pytest.mark.parametrize("skew_deg", [0, 60, -30])
def test_gaps_are_open_by_their_width_under_dead_load(bridge, abutment, skew_deg):
    has_contacts = "contact" in abutment
    with domain():
        model = build(variant(skew_deg, abutment, bridge, GAP_MM).normalised(), ModelOptions())
        if model.contacts is not None:
            model.contacts.start_from_rest()
        for side in model.abutments:
            for spring in (*side.wall_springs, *side.key_springs):
                moved = ops.basicDeformation(spring.element)[spring.component]
                assert moved == pytest.approx(0.0, abs=TOLERANCE_M)
            for units, gap_m in ((side.wall_units, GAP_MM / 1000), (side.key_units, KEY_GAP_M)):
                for unit in units:
                    assert model.contacts.openings_m[unit] == pytest.approx(gap_m, abs=TOLERANCE_M)
            assert len(side.wall_units) == has_contacts * ModelOptions().backwall_points
            assert len(side.key_units) + len(side.key_springs) + len(side.wall_springs) > 0
        # the deck has turned at its ends: an opening counted from the undeformed model differs
        end = model.abutments[0].corners[0].node
        assert not has_contacts or abs(ops.nodeDisp(end, 1)) > 2 * TOLERANCE_M


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
    rule, straight = "strength_and_stiffness", wall_backfill(SEAT, kind, 0.0)
    for skew_rad in np.radians([0.0, -60.0]):
        skewed = wall_backfill(SEAT, kind, skew_rad, skew_rule=rule)
        assert skewed == straight.scaled(skew_reduction(skew_rad))  # to the last bit
    paper = AnalysisSettings(scheme="paper").model_options(ModelOptions())
    # nor has the scheme of the paper radiation
    assert (paper.backfill_skew, paper.backfill_vs_mps) == (rule, None)


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact"])
@pytest.mark.parametrize(
    ("rule", "ratio", "error"),
    [("strength", 1.0, 0.02), ("strength_and_stiffness", np.exp(-60 / 45), 0.01)],
)
def test_every_abutment_with_backfill_follows_the_skew_option(abutment, rule, ratio, error):
    """Initial stiffness at skew 60 over that at 0; pads add the same to both."""
    options = {"backfill_skew": rule, "gap_offset_mm": -51.0, "key_frame": "skewed"}
    pads = 0.0 if abutment == "simplified" else PADS_N_PER_M
    curves = (push(abutment, skew_deg, angle_deg=skew_deg, max_disp_m=1e-4, steps=2, **options)
              for skew_deg in (0, 60))  # fmt: skip
    straight, skewed = (curve.initial_stiffness_n_per_m - pads for curve in curves)
    assert skewed / straight == pytest.approx(ratio, abs=error)


def elastic_materials(case, monkeypatch, **options):
    create = Mock(wraps=ops.uniaxialMaterial)
    with domain(), monkeypatch.context() as patch:
        patch.setattr(ops, "uniaxialMaterial", create)
        build(case, ModelOptions(**options))
    return [call.args for call in create.call_args_list if call.args[0] == "Elastic"]


def test_the_spring_body_has_one_stiffness_and_waves_that_leave_a_wall_damp_it(monkeypatch):
    """Its spring across the wall is the soil of the wall at zero skew for any number of points."""
    for rule, skew_deg, points in product(["strength", "strength_and_stiffness"], [0, 60], [3, 9]):
        options = {"backfill_skew": rule, "backwall_points": points}
        given = elastic_materials(variant(skew_deg, "spring"), monkeypatch, **options)
        assert sum(args[2] == pytest.approx(STIFFNESS) for args in given) == 2
    # two walls of 14.33 m x 1.8288 m, each with wing walls worth 0.2963 of it; keys the same
    materials = (elastic_materials(variant(60), monkeypatch, backfill_vs_mps=vs_mps)
                 for vs_mps in (100.0, 250.0, 0.0, None))  # fmt: skip
    slow, fast, keys, by_mass = (sum(row[3] for row in rows if len(row) > 3) for rows in materials)
    area_m2 = 2 * 14.33 * 1.8288 * (1.0 + 0.3333 * 1.3333 * 0.6667)
    assert fast - slow == pytest.approx(1760.0 * 150.0 * area_m2, rel=1e-9)
    assert keys == pytest.approx(slow - 1760.0 * 100.0 * area_m2, rel=1e-9)
    assert keys < by_mass < slow


@pytest.mark.parametrize("skew_deg", [0, 60])
def test_a_wall_never_exceeds_the_strength_of_its_soil_and_never_pulls(skew_deg):
    motion = cut_to_strongest(strongest_motions(4, 1.2)[3], 5.0, 0.0)
    forces_kn = []
    for kind in ("parallel", "series"):
        options = ModelOptions(backfill_dashpot=kind)
        histories = analysed(variant(skew_deg), motion, options).histories
        walls = (f"contact_{side}_backwall_{{}}_normal_kn" for side in ("left", "right"))
        sums_kn = [sum(histories[wall.format(i)] for i in (1, 2, 3)) for wall in walls]
        forces_kn.append(np.array(sums_kn))
    parallel, series = forces_kn
    strength_kn = wall_backfill(SEAT, "hyperbolic", np.radians(skew_deg)).ultimate_n / 1e3
    assert parallel.max() > 1.1 * strength_kn
    assert 0.98 * strength_kn < series.max() < 1.02 * strength_kn
    assert series.min() >= 0.0


def forces(closures_m, *, gap_m=0.0, passive=OSB1):
    tags, out = handles.TagAllocator(), []
    with domain():
        spring = springs.passive_material(passive, gap_m, tags)
        driver = springs.elastic_material(STIFF * passive.stiffness_n_per_m, tags)
        # both in a row, along a path of prescribed closures
        ops.model("basic", "-ndm", 1, "-ndf", 1)
        for node in (1, 2, 3):
            ops.node(node, 0.0)
        ops.fix(1, 1)
        ops.element("zeroLength", 1, 1, 2, "-mat", spring, "-dir", 1)
        ops.element("zeroLength", 2, 2, 3, "-mat", driver, "-dir", 1)
        moves = [0.0, *(-float(closure_m) for closure_m in closures_m)]
        ops.timeSeries("Path", 1, "-dt", 1.0, "-values", *moves, "-useLast")
        ops.pattern("Plain", 1, 1)
        ops.sp(3, 1, 1.0)
        ops.constraints("Transformation")
        ops.numberer("Plain")
        ops.system("ProfileSPD")
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0)
        ops.test("NormDispIncr", 1.0e-12, 50)
        ops.analysis("Static", "-noWarnings")
        for _ in closures_m:
            assert ops.analyze(1) == 0
            out.append(-ops.basicForce(1)[0])
    return np.array(out)


@pytest.mark.parametrize("bridge", ["osb1", "bridge_a", "bridge_b", "bridge_c"])
@pytest.mark.parametrize("gap_m", [0.0, 0.025, 0.051])
def test_first_loading_is_the_hyperbola_and_ends_at_the_ultimate_force(bridge, gap_m):
    passive = wall_backfill(load_bridge(bridge).abutment, "hyperbolic", 0.0)
    closures = np.geomspace(1e-3, 1.0, 200)
    found = forces(gap_m + closures, gap_m=gap_m, passive=passive)
    np.testing.assert_allclose(found, passive.force_n(closures), rtol=0.005)
    assert found.max() == pytest.approx(passive.ultimate_n, rel=0.002)


@pytest.mark.parametrize(
    ("reached_m", "away_m"),
    [(0.005, 0.0), (0.02, 0.0), (0.05, 0.0), (0.3, 0.0), (0.04, 0.01), (0.04, 0.0), (0.04, -0.1)],
)
def test_unloading_is_stiff_and_opens_a_gap_and_reloading_meets_the_curve(reached_m, away_m):
    there = np.linspace(0.0, reached_m, 101)[1:]
    back, again = np.linspace(reached_m, away_m, 200), np.linspace(away_m, 0.3, 400)
    loaded, unloaded, reloaded = np.split(forces([*there, *back, *again]), (100, 300))
    peak_n = loaded[-1]
    starts_m = reached_m - peak_n / STIFFNESS
    expected = np.maximum(peak_n - STIFFNESS * (reached_m - back), 0.0)
    np.testing.assert_allclose(unloaded, expected, atol=CLOSES_M * STIFFNESS)
    assert np.abs(unloaded[back < starts_m - CLOSES_M]).max(initial=0.0) < 1e-5 * OSB1.ultimate_n
    peak_n = float(OSB1.force_n(reached_m))
    reload = np.clip(STIFFNESS * (again - starts_m), 0.0, None)
    expected = np.where(again < reached_m, np.minimum(reload, peak_n), OSB1.force_n(again))
    np.testing.assert_allclose(reloaded, expected, rtol=0.005, atol=0.002 * peak_n)


@pytest.mark.parametrize("abutment", ["spring", "contact"])
def test_a_key_that_breaks_has_given_its_strength_and_no_more(abutment):
    case = variant(abutment=abutment, gap_mm=25, friction_pct=0)
    found = analysed(case, strong_motion(peak_g=1.6), duration_s=3.0).demands
    assert found["shear_key_disp_m"] > KEY.displacement_mm[1] / 1e3
    assert found["shear_key_force_kn"] == pytest.approx(max(KEY.force_kn), rel=0.02)


@pytest.mark.parametrize("option", ["backbone", "elastic"])
def test_a_key_pushed_along_its_face_has_no_more_than_its_strength(option):
    """50 mm along the face: beyond the strength, 69 MN/m times 50 mm without a limit."""
    tags, options = handles.TagAllocator(), ModelOptions(key_along_face=option)
    context = SimpleNamespace(key=KEY, key_mass_kg=6.0e3, options=options, tags=tags)
    with domain():
        nodes = springs.grounded_node((0.0,) * 3, tags), springs.plane_node((0.0,) * 3, 0.0, tags)
        abutments.Joint.key_spring(context, nodes, (0.0, 1.0))
        assembly.open_linear_pattern(tags)
        ops.load(nodes[1], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        ops.integrator("DisplacementControl", nodes[1], 1, 0.001)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(50) == 0
        force_kn = ops.getLoadFactor(1) / 1e3
    expected = elastic_kn = 50.0 * KEY.force_kn[0] / KEY.displacement_mm[0]
    if option == "backbone":
        expected = KEY.force_kn[1] + springs.KEY_FACE_HARDENING * (elastic_kn - KEY.force_kn[1])
        assert KEY.force_kn[1] < expected < 1.01 * KEY.force_kn[1]
    assert force_kn == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("bridge", "skew_deg", "pads"),
    [*product(seated_bridges(), [0, 60], ["two"]), ("osb1", 60, "each"), ("bridge_a", 60, "each")],
)
def test_no_pad_pulls_and_a_deck_that_lifts_opens_its_bearings(monkeypatch, bridge, skew_deg, pads):
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
    first, *_, last = weights.deck_reactions_n(built_bridge(load_bridge(bridge), options, skew_deg))
    assert 0.95 < -sum(forces_n[0]) / (first + last) < 1.25
    assert np.max(forces_n) < 1.0e3
    assert abs(found["energy_residual_ratio"]) < 3.0e-3
    if (bridge, skew_deg) == ("bridge_a", 60):
        assert found["bearing_uplift_m"] > 0.01
    if (bridge, skew_deg) == ("osb1", 60):
        # the torsion of a skewed deck on a skewed bent lifts one end of the bearing line
        assert found["bearing_uplift_m"] < {"two": 0.015, "each": 0.005}[pads]
