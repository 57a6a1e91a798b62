"""Every abutment model on every bridge and skew carries its weight and survives motions."""

import math
from itertools import product

import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis.modal import modal_properties
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.gravity import total_weight_n
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import ModelOptions
from strong_motion import pulse_motion, strong_motion

BRIDGES = ("osb1", "osb2s", "bridge_a", "bridge_b", "bridge_c")
ALL = [
    variant(skew, abutment, bridge)
    for bridge, abutment, skew in product(BRIDGES, ABUTMENTS, (0, 20, 40, 60))
]


@pytest.mark.parametrize("case", ALL[::3], ids=lambda case: case.slug)
def test_every_variant_carries_its_weight_and_has_sane_modes(case):
    result = modal_properties(case)
    bridge = load_bridge(case.bridge)
    assert result.weight_kn == pytest.approx(total_weight_n(bridge) / 1e3, rel=1e-6)
    carried = sum(result.column_axial_kn) + sum(result.abutment_reaction_kn)
    assert carried == pytest.approx(result.weight_kn, rel=1e-6)
    assert all(force > 0.0 for force in (*result.column_axial_kn, *result.abutment_reaction_kn))
    for direction in ("x", "y", "rz"):
        assert 0.2 < result.period_s(direction) < 6.0, direction
    assert all(math.isfinite(mode.period_s) for mode in result.modes)
    for total in zip(*((m.mass_x, m.mass_y, m.mass_rz) for m in result.modes), strict=True):
        assert sum(total) <= 1.0 + 1e-6


def check_run(case, motion, **settings):
    result = analysed(case, motion, **settings)
    assert result.status in ("ok", "collapse"), result.messages
    assert (result.status == "collapse") == bool(result.collapse_criterion)
    assert all(math.isfinite(value) for value in result.demands.values())
    assert abs(result.demands["energy_residual_ratio"]) < 0.005


@pytest.mark.parametrize("case", ALL[::7], ids=lambda case: case.slug)
def test_a_sample_of_variants_survives_strong_pulses(case):
    check_run(case, pulse_motion(duration_s=3.0))


@pytest.mark.slow
@pytest.mark.parametrize("case", ALL, ids=lambda case: case.slug)
def test_every_variant_survives_a_strong_motion(case):
    check_run(case, strong_motion(duration_s=10.0), duration_s=10.0)


def test_every_shear_model_has_its_column_and_none_changes_the_analysis():
    case = variant(0, "contact", "osb1_era1", friction_pct=0)
    models = ("kowalsky_priestley", "sdc_expected", "sdc_nominal")
    names = [f"column_shear_dcr_{model}" for model in models]
    ratios = []
    for model, own in zip(models, names, strict=True):
        result = analysed(case, pulse_motion(duration_s=3.0), ModelOptions(shear_model=model))
        assert result.whole_history["column_shear_dcr"] == result.whole_history[own]
        # over the whole history, also after a failure
        assert result.demands[own] == result.whole_history[own] > 0.0
        ratios.append([result.whole_history[name] for name in names])
    assert ratios[0] == sorted(set(ratios[0]))
    assert ratios == [ratios[0]] * 3
