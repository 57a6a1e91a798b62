"""Displacements of nodes that follow others rigidly are computed, not read."""

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.trace import Monitor
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion


@pytest.mark.parametrize("abutment", ["contact_friction", "simplified"])
def test_followers_have_the_displacements_of_opensees(
    monkeypatch: pytest.MonkeyPatch, abutment: str
) -> None:
    plain, errors, sizes = Monitor.read, list[float](), list[float]()

    def read_and_compare(self: Monitor, time_s: float) -> list[float]:
        row = plain(self, time_s)
        layout = self.layout
        assert len(layout.followers) >= 6
        assert not set(layout.followers) & set(layout.nodes)
        for node in layout.followers:
            (found,), there = layout.disp(np.array([row]), node), ops.nodeDisp(node)
            errors.append(float(np.abs(found - there).max()))
            sizes.append(float(np.abs(there).max()))
        return row

    monkeypatch.setattr(Monitor, "read", read_and_compare)
    case = Variant(bridge="osb1", abutment=abutment, skew_deg=30, gap_mm=25, friction_pct=50)
    settings = AnalysisSettings(duration_s=2.0, energy=False)
    analyse(case.normalised(), Excitation(motion=strong_motion()), settings, ModelOptions())
    assert max(sizes) > 0.05
    assert max(errors) < 1e-12 * max(sizes)


def test_soft_arrays_have_no_followers(monkeypatch: pytest.MonkeyPatch) -> None:
    found, plain = list[int](), Monitor.read
    monkeypatch.setattr(
        Monitor,
        "read",
        lambda self, time_s: found.append(len(self.layout.followers)) or plain(self, time_s),
    )
    excitation = Excitation(motion=strong_motion())
    options = ModelOptions(arrays="corotational")
    analyse(variant(), excitation, AnalysisSettings(duration_s=0.05), options)
    assert found
    assert not any(found)
