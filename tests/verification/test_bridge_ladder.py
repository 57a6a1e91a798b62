"""Every abutment model on every bridge and skew carries its weight and survives motions."""

import math
from itertools import product

import pytest

from bridge_motions import pulse_motion
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.modal import modal_properties
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.gravity import total_weight_n
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion

BRIDGES = ("osb1", "osb2s", "bridge_a", "bridge_b", "bridge_c")
SKEWS = (0, 20, 40, 60)
ALL = [
    Variant(bridge=bridge, abutment=abutment, skew_deg=skew, gap_mm=51, friction_pct=50)
    for bridge, abutment, skew in product(BRIDGES, ABUTMENTS, SKEWS)
]
SAMPLE = [variant for number, variant in enumerate(ALL) if number % 7 == 0]


def check_model(variant: Variant) -> None:
    result = modal_properties(variant)
    bridge = load_bridge(variant.bridge)
    assert result.weight_kn == pytest.approx(total_weight_n(bridge) / 1e3, rel=1e-6)
    carried = sum(result.column_axial_kn) + sum(result.abutment_reaction_kn)
    assert carried == pytest.approx(result.weight_kn, rel=1e-6)
    assert all(force > 0.0 for force in (*result.column_axial_kn, *result.abutment_reaction_kn))
    for direction in ("x", "y", "rz"):
        assert 0.2 < result.period_s(direction) < 6.0, direction
    assert all(math.isfinite(mode.period_s) for mode in result.modes)
    for total in zip(*((m.mass_x, m.mass_y, m.mass_rz) for m in result.modes), strict=True):
        assert sum(total) <= 1.0 + 1e-6


def check_run(variant: Variant, motion: GroundMotion, duration_s: float | None) -> None:
    settings = AnalysisSettings(duration_s=duration_s)
    result = analyse(variant, Excitation(motion=motion), settings, ModelOptions())
    assert result.status in ("ok", "collapse"), result.messages
    assert (result.status == "collapse") == bool(result.collapse_criterion)
    assert all(math.isfinite(value) for value in result.demands.values())
    assert abs(result.demands["energy_residual_ratio"]) < 0.005


@pytest.mark.parametrize("variant", ALL, ids=lambda variant: variant.slug)
def test_every_variant_carries_its_weight_and_has_sane_modes(variant: Variant) -> None:
    check_model(variant)


@pytest.mark.parametrize("variant", SAMPLE, ids=lambda variant: variant.slug)
def test_a_sample_of_variants_survives_strong_pulses(variant: Variant) -> None:
    check_run(variant, pulse_motion(duration_s=3.0), None)


@pytest.mark.slow
@pytest.mark.parametrize("variant", ALL, ids=lambda variant: variant.slug)
def test_every_variant_survives_a_strong_motion(variant: Variant) -> None:
    check_run(variant, strong_motion(duration_s=10.0), 10.0)


def test_every_shear_model_has_its_column_and_none_changes_the_analysis() -> None:
    variant = Variant(bridge="osb1_era1", abutment="contact", skew_deg=0, gap_mm=51, friction_pct=0)
    models = ("kowalsky_priestley", "sdc_expected", "sdc_nominal")
    whole: dict[str, dict[str, float]] = {}
    for model in models:
        result = analyse(
            variant,
            Excitation(motion=pulse_motion(duration_s=3.0)),
            AnalysisSettings(),
            ModelOptions(shear_model=model),
        )
        whole[model] = result.whole_history
        own = f"column_shear_dcr_{model}"
        assert result.whole_history["column_shear_dcr"] == result.whole_history[own]
        # over the whole history, also after a failure
        assert result.demands[own] == result.whole_history[own] > 0.0
    ratios = [whole[models[0]][f"column_shear_dcr_{model}"] for model in models]
    assert ratios == sorted(set(ratios))
    for model in models:
        assert ratios == [whole[model][f"column_shear_dcr_{name}"] for name in models]
