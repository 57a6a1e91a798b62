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

from skewbridge.analysis.pushover import PushCurve, push_abutment
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.abutment.backfill import wall_backfill
from skewbridge.bridge.abutment.elements import NORMAL_OVER_NEIGHBOUR
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant, parse_slug

PADS_N_PER_M = 5 * 2208e3
PADS_YIELD_N = 5 * 55.2e3
LADDER = ["simplified", "spring", "contact", "contact_friction"]


def push(
    abutment: str,
    *,
    angle_deg: float = 0.0,
    skew_deg: int = 0,
    max_disp_m: float = 0.15,
    options: ModelOptions | None = None,
    steps: int = 300,
) -> PushCurve:
    variant = Variant(
        bridge="osb1", abutment=abutment, skew_deg=skew_deg, gap_mm=51, friction_pct=50
    )
    curve = push_abutment(
        variant, options or ModelOptions(), angle_deg=angle_deg, max_disp_m=max_disp_m, steps=steps
    )
    assert curve.is_complete
    return curve


def force_at(curve: PushCurve, disp_m: float) -> float:
    return float(np.interp(disp_m, curve.disp_m, curve.force_n))


def pads_at(disp_m: float) -> float:
    """Bilinear pads: k until the yield of the plastic part, 0.1 k beyond."""
    return 0.1 * PADS_N_PER_M * disp_m + min(0.9 * PADS_N_PER_M * disp_m, PADS_YIELD_N)


@pytest.mark.parametrize("abutment", ["spring", "contact", "contact_friction"])
@pytest.mark.parametrize(("skew_deg", "force_kn"), [(0, 6_662), (30, 3_420), (60, 1_756)])
def test_a_push_normal_to_the_wall_reaches_the_bilinear_passive_force(
    abutment: str, skew_deg: int, force_kn: float
) -> None:
    curve = push(
        abutment,
        angle_deg=skew_deg,
        skew_deg=skew_deg,
        max_disp_m=0.09,
        # a push normal to the wall never meets keys square to it: backfill and pads alone
        options=ModelOptions(backfill="sdc", key_frame="skewed"),
    )
    passive_kn = (force_at(curve, 0.085) - pads_at(0.085)) / 1e3
    assert passive_kn == pytest.approx(force_kn, rel=0.005)


@pytest.mark.parametrize("abutment", ["spring", "contact"])
@pytest.mark.parametrize(("closure_m", "force_kn"), [(0.025, 3_872), (0.05, 5_126), (0.076, 5_306)])
def test_the_hyperbolic_backbone_is_met_behind_the_gap(
    abutment: str, closure_m: float, force_kn: float
) -> None:
    curve = push(abutment)
    soil = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", 0.0)
    penalty_kn_per_m = NORMAL_OVER_NEIGHBOUR * soil.stiffness_n_per_m / 1e3
    penetration_m = force_kn / penalty_kn_per_m if abutment == "contact" else 0.0
    disp_m = 0.051 + closure_m + penetration_m
    assert (force_at(curve, disp_m) - pads_at(disp_m)) / 1e3 == pytest.approx(force_kn, rel=0.005)


@pytest.mark.parametrize("abutment", LADDER)
def test_only_the_pads_act_until_the_gap_closes(abutment: str) -> None:
    curve = push(abutment, max_disp_m=0.05)
    has_pads = abutment != "simplified"
    for disp_m in (0.01, 0.03, 0.05):
        expected = pads_at(disp_m) if has_pads else 0.0
        assert force_at(curve, disp_m) == pytest.approx(expected, rel=1e-4, abs=1.0)


@pytest.mark.parametrize("abutment", ["spring", "contact"])
def test_only_the_pads_act_away_from_the_backfill(abutment: str) -> None:
    curve = push(abutment, angle_deg=180.0)
    assert force_at(curve, 0.14) == pytest.approx(pads_at(0.14), rel=1e-3)


def test_a_key_follows_its_backbone_behind_the_transverse_gap() -> None:
    curve = push("contact", angle_deg=90.0, steps=1500)
    key = load_bridge("osb1").abutment.sacrificial_key
    penalty_kn_per_mm = NORMAL_OVER_NEIGHBOUR * key.force_kn[0] / key.displacement_mm[0]
    for force_kn, disp_mm in zip(key.force_kn, key.displacement_mm, strict=True):
        disp_m = 0.0064 + 1e-3 * (disp_mm + force_kn / penalty_kn_per_mm)
        found_kn = (force_at(curve, disp_m) - pads_at(disp_m)) / 1e3
        assert found_kn == pytest.approx(force_kn, rel=0.005)


def test_friction_has_no_effect_in_a_push_along_a_principal_axis() -> None:
    for angle_deg in (0.0, 90.0):
        plain = push("contact", angle_deg=angle_deg)
        rubbing = push("contact_friction", angle_deg=angle_deg)
        np.testing.assert_allclose(rubbing.force_n, plain.force_n, rtol=1e-6, atol=1.0)


def test_friction_resists_an_oblique_push() -> None:
    options = ModelOptions(backfill="sdc")
    plain = push("contact", angle_deg=45.0, max_disp_m=0.1, options=options)
    rubbing = push("contact_friction", angle_deg=45.0, max_disp_m=0.1, options=options)
    assert force_at(rubbing, 0.1) > 1.1 * force_at(plain, 0.1)


def test_non_uniform_backfill_keeps_the_total_and_is_stronger_at_the_acute_corner() -> None:
    uniform = push("contact", skew_deg=40, angle_deg=40.0)
    varied = push(
        "contact", skew_deg=40, angle_deg=40.0, options=ModelOptions(backfill_variation=0.3)
    )
    assert varied.force_n[-1] == pytest.approx(uniform.force_n[-1], rel=0.01)


def test_monolithic_keys_are_stronger() -> None:
    weak = push("contact", angle_deg=90.0)
    strong = push("contact", angle_deg=90.0, options=ModelOptions(keys="monolithic"))
    assert strong.peak_n > 2 * weak.peak_n


def test_the_reduced_hyperbola_keeps_its_shape() -> None:
    data = load_bridge("osb1").abutment
    straight = wall_backfill(data, "hyperbolic", 0.0)
    skewed = wall_backfill(data, "hyperbolic", np.radians(-45.0))
    assert skewed.force_n(0.05) / straight.force_n(0.05) == pytest.approx(np.exp(-1.0))


@pytest.mark.parametrize(
    ("name", "k50_mn_per_m", "ultimate_kn"),
    [("bridge_a", 169.8, 2_014), ("bridge_b", 598.7, 9_471), ("bridge_c", 761.8, 12_178)],
)
def test_the_hyperbola_of_kavianis_bridges_passes_its_two_points(
    name: str, k50_mn_per_m: float, ultimate_kn: float
) -> None:
    data = load_bridge(name).abutment
    passive = wall_backfill(data, "hyperbolic", 0.0)
    half_m = ultimate_kn / 2 / k50_mn_per_m / 1e3
    assert float(passive.force_n(half_m)) / 1e3 == pytest.approx(ultimate_kn / 2, rel=1e-6)
    end_m = 0.05 * data.wall_height_m
    assert float(passive.force_n(end_m)) / 1e3 == pytest.approx(ultimate_kn, rel=1e-6)


def test_the_spring_model_yields_in_series_with_its_wing_walls() -> None:
    spring = push("spring", angle_deg=90.0)
    contact = push("contact", angle_deg=90.0)
    assert spring.peak_n == pytest.approx(contact.peak_n, rel=0.02)
    later_m = spring.disp_at_peak_m - contact.disp_at_peak_m
    assert later_m == pytest.approx(1765e3 / 129.3e6, rel=0.1)  # key strength over wing stiffness


def dashpots_n_s_per_m(options: ModelOptions, monkeypatch: pytest.MonkeyPatch) -> float:
    """Return the sum of all dashpots behind the walls and keys of both abutments of OSB1."""
    found: list[float] = []
    create = ops.uniaxialMaterial

    def noted(kind: str, tag: int, *values: float) -> None:
        if kind == "Elastic" and len(values) > 1:
            found.append(values[1])
        create(kind, tag, *values)

    monkeypatch.setattr(ops, "uniaxialMaterial", noted)
    with domain():
        build(parse_slug("osb1_cf_skew60_gap051_mu050"), options)
    return sum(found)


def test_waves_that_leave_a_wall_damp_it_with_density_velocity_and_area(monkeypatch) -> None:
    """Two walls of 14.33 m x 1.8288 m, each with wing walls worth 0.2963 of it; keys the same."""
    slow, fast = (
        dashpots_n_s_per_m(ModelOptions(backfill_vs_mps=vs), monkeypatch) for vs in (100.0, 250.0)
    )
    area_m2 = 2 * 14.33 * 1.8288 * (1.0 + 0.3333 * 1.3333 * 0.6667)
    assert fast - slow == pytest.approx(1760.0 * 150.0 * area_m2, rel=1e-9)
    keys = dashpots_n_s_per_m(ModelOptions(backfill_vs_mps=0.0), monkeypatch)
    assert keys == pytest.approx(slow - 1760.0 * 100.0 * area_m2, rel=1e-9)
    by_mass = dashpots_n_s_per_m(ModelOptions(backfill_vs_mps=None), monkeypatch)
    assert keys < by_mass < slow


def test_the_scheme_of_the_paper_has_no_radiation() -> None:
    assert AnalysisSettings(scheme="paper").model_options(ModelOptions()).backfill_vs_mps is None
