"""A failed attempt at a step leaves nothing behind in the response of a whole bridge."""

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion

SETTINGS = AnalysisSettings(duration_s=3.0, tolerance_j=1e-10, energy=False)
FAILING = (150, 300, 301, 420, 600)  # attempts: free, about to close, in contact


def response(monkeypatch: pytest.MonkeyPatch, failing: tuple[int, ...]) -> AnalysisResult:
    """Analyse OSB1 with some attempts made impossible: one iteration, no tolerance."""
    analyze, attempts = ops.analyze, 0

    def sometimes(count: int, *step: float) -> int:
        nonlocal attempts
        attempts += 1
        if not step or attempts not in failing:
            return int(analyze(count, *step))
        ops.test("EnergyIncr", -1.0, 2)
        ended = int(analyze(count, *step))
        ops.test("EnergyIncr", SETTINGS.tolerance_j, SETTINGS.max_iterations)
        return ended

    monkeypatch.setattr(ops, "analyze", sometimes)
    result = analyse(
        Variant(
            bridge="osb1", abutment="contact_friction", skew_deg=30, gap_mm=25, friction_pct=50
        ),
        Excitation(motion=strong_motion()),
        SETTINGS,
        ModelOptions(),
    )
    monkeypatch.undo()
    return result


def test_a_retry_goes_on_as_if_nothing_had_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    smooth, rough = response(monkeypatch, ()), response(monkeypatch, FAILING)
    assert smooth.failed_attempts == 0
    assert rough.failed_attempts == len(FAILING)
    assert smooth.demands["contact_closures"] > 10
    for name in ("column_drift_ratio", "deck_rotation_rad", "unseating_m", "slip_work_kj"):
        # both converge to the tolerance by different iterations: 1e-4 of a demand at most
        assert rough.demands[name] == pytest.approx(smooth.demands[name], rel=1e-4)
