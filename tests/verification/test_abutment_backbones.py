"""Static response of one OSB1 abutment against the formulas of its springs.

Figures from the project's reference page on bridge data, sections 3 and 8: passive force by
Caltrans SDC 2.0 with its skew reduction, the UCSD hyperbola up to its ultimate force (at 56 mm),
pads alone until the gap closes. Hyperbola: K = 20.3 x 14.33 x 1.8288/1.68 MN/m, F = 326 x 14.33 x
(1.8288/1.68)^1.5 kN.
Tolerance 0.5 % (penalty in series and weak restoring spring included).
"""

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.abutment.backfill import wall_backfill
from skewbridge.bridge.abutment.elements import NORMAL_OVER_NEIGHBOUR
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions

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
@pytest.mark.parametrize(("skew_deg", "force_kn"), [(0, 6_662), (30, 3_420), (60, 1_756)])
def test_a_push_normal_to_the_wall_reaches_the_bilinear_force(abutment, skew_deg, force_kn):
    # a push normal to the wall never meets keys square to it: backfill and pads alone
    options = {"backfill": "sdc", "key_frame": "skewed"}
    curve = push(abutment, angle_deg=skew_deg, skew_deg=skew_deg, max_disp_m=0.09, **options)
    assert beside_pads_kn(curve, 0.085) == pytest.approx(force_kn, rel=0.005)


@pytest.mark.parametrize("abutment", ["spring", "contact"])
@pytest.mark.parametrize(("closure_m", "force_kn"), [(0.025, 3_872), (0.05, 5_126), (0.076, 5_306)])
def test_the_hyperbolic_backbone_is_met_behind_the_gap(abutment, closure_m, force_kn):
    soil = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", 0.0)
    penalty_kn_per_m = NORMAL_OVER_NEIGHBOUR * soil.stiffness_n_per_m / 1e3
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


def test_a_key_follows_its_backbone_behind_the_transverse_gap():
    curve = push("contact", angle_deg=90.0, steps=1500)
    key = load_bridge("osb1").abutment.sacrificial_key
    penalty_kn_per_mm = NORMAL_OVER_NEIGHBOUR * key.force_kn[0] / key.displacement_mm[0]
    for force_kn, disp_mm in zip(key.force_kn, key.displacement_mm, strict=True):
        disp_m = 0.0064 + 1e-3 * (disp_mm + force_kn / penalty_kn_per_mm)
        assert beside_pads_kn(curve, disp_m) == pytest.approx(force_kn, rel=0.005)


def test_friction_acts_in_an_oblique_push_only():
    for angle_deg in (0.0, 90.0):
        plain, rubbing = (push(name, angle_deg=angle_deg) for name in LAST_TWO)
        np.testing.assert_allclose(rubbing.force_n, plain.force_n, rtol=1e-6, atol=1.0)
    oblique = {"angle_deg": 45.0, "max_disp_m": 0.1, "backfill": "sdc"}
    plain, rubbing = (push(name, **oblique) for name in LAST_TWO)
    assert force_at(rubbing, 0.1) > 1.1 * force_at(plain, 0.1)


@pytest.mark.parametrize(
    ("name", "k50_mn_per_m", "ultimate_kn"),
    [("bridge_a", 169.8, 2_014), ("bridge_b", 598.7, 9_471), ("bridge_c", 761.8, 12_178)],
)
def test_the_hyperbola_of_kavianis_bridges_passes_its_two_points(name, k50_mn_per_m, ultimate_kn):
    data = load_bridge(name).abutment
    passive = wall_backfill(data, "hyperbolic", 0.0)
    closures_m = [ultimate_kn / 2 / k50_mn_per_m / 1e3, 0.05 * data.wall_height_m]
    found_kn = passive.force_n(closures_m) / 1e3
    assert found_kn == pytest.approx([ultimate_kn / 2, ultimate_kn], rel=1e-6)


def test_the_spring_model_yields_in_series_with_its_wing_walls():
    spring, contact = (push(name, angle_deg=90.0) for name in ("spring", "contact"))
    assert spring.peak_n == pytest.approx(contact.peak_n, rel=0.02)
    assert push("contact", angle_deg=90.0, keys="monolithic").peak_n > 2 * contact.peak_n
    later_m = spring.disp_at_peak_m - contact.disp_at_peak_m
    assert later_m == pytest.approx(1765e3 / 129.3e6, rel=0.1)  # key strength over wing stiffness


def dashpots_n_s_per_m(vs_mps, monkeypatch):
    """Return the sum of all dashpots behind the walls and keys of both abutments of OSB1."""
    found, create = [], ops.uniaxialMaterial

    def noted(kind, tag, *values):
        if kind == "Elastic" and len(values) > 1:
            found.append(values[1])
        create(kind, tag, *values)

    monkeypatch.setattr(ops, "uniaxialMaterial", noted)
    with domain():
        build(variant(60), ModelOptions(backfill_vs_mps=vs_mps))
    return sum(found)


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
