"""Pads and supports lift: no tension in any bridge, and the opening is a demand."""

import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.analysis import transient
from skewbridge.bridge.catalogue import bridge_names
from skewbridge.bridge.gravity import abutment_reactions_n
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion


class Forces(transient.Watch):
    """Keeps the vertical forces of all bearings at rest and the largest tension."""

    def __init__(self, model, settings):
        super().__init__(model, settings)
        ends = model.abutments
        self.elements = [pad.element for end in ends for pad in end.bearings]
        type(self).at_rest_n = sum(self.forces_n())
        type(self).dead_n = sum(abutment_reactions_n(model.bridge))
        type(self).tension_n = 0.0

    def forces_n(self) -> list[float]:
        """Force of each bearing on the deck downwards: tension is positive."""
        return [ops.eleForce(element)[8] for element in self.elements]

    def collapsed(self) -> str:
        type(self).tension_n = max(type(self).tension_n, *self.forces_n())
        return super().collapsed()


def strongest(monkeypatch, bridge, skew_deg, **options):
    """Return the demands under a pulse of 1.6 g."""
    monkeypatch.setattr(transient, "Watch", Forces)
    case = variant(skew_deg, bridge=bridge, gap_mm=25)
    motion = strong_motion(peak_g=1.6)
    return analysed(case, motion, ModelOptions(**options), duration_s=4.0).whole_history


@pytest.mark.parametrize("skew_deg", [0, 60])
@pytest.mark.parametrize("bridge", bridge_names())
def test_no_pad_pulls_at_the_deck(monkeypatch, bridge, skew_deg):
    found = strongest(monkeypatch, bridge, skew_deg)
    # a skewed bearing line holds the deck against torsion and carries more than a straight one
    assert 0.95 < -Forces.at_rest_n / Forces.dead_n < 1.25
    assert Forces.tension_n < 1.0e3
    assert abs(found["energy_residual_ratio"]) < 3.0e-3


@pytest.mark.parametrize("pads", ["two", "each"])
def test_a_deck_that_lifts_opens_its_bearings(monkeypatch, pads):
    """Bridge A at skew 60 would need 2 MN of tension; OSB1 stays on its pads."""
    assert strongest(monkeypatch, "bridge_a", 60, pads=pads)["bearing_uplift_m"] > 0.01
    assert Forces.tension_n < 1.0e3
    assert strongest(monkeypatch, "osb1", 60, pads=pads)["bearing_uplift_m"] < 1e-4
