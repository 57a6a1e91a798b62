"""The force of a shear key is that of its backbone, never that of the penalty before it."""

import pytest

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion


@pytest.mark.parametrize("abutment", ["spring", "contact"])
def test_a_key_that_breaks_has_given_its_strength_and_no_more(abutment):
    variant = Variant(bridge="osb1", abutment=abutment, skew_deg=30, gap_mm=25, friction_pct=0)
    excitation = Excitation(motion=strong_motion(peak_g=1.6))
    settings = AnalysisSettings(duration_s=3.0)
    found = analyse(variant, excitation, settings, ModelOptions()).demands
    key = load_bridge("osb1").abutment.sacrificial_key
    assert found["shear_key_disp_m"] > key.displacement_mm[1] / 1e3
    assert found["shear_key_force_kn"] == pytest.approx(max(key.force_kn), rel=0.02)
