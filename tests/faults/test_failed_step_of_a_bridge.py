"""A failed attempt at a step does not change the response of a whole bridge."""

from collections.abc import Set
from dataclasses import replace

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.recovery import LADDER, Stepper
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import AnalysisResult, Watch, analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion

SETTINGS = AnalysisSettings(
    duration_s=3.0, dt_s=0.005, tolerance_j=1e-12, reuse_tangent=False, energy=False
)
# A step in parts is a more exact one: the steps are so short that this does not matter.
FINE = replace(SETTINGS, dt_s=0.000625, contact_dt_s=None, event_dt_s=None)
HOUBOLT = replace(FINE, integrator=("Houbolt",))
# Looser tests on higher rungs are a difference of their own.
STRICT = tuple(replace(attempt, tolerance_j=0.0) for attempt in LADDER)
# Attempts while free, about to close and in contact; none of them is the second attempt of a step.
FAILING = {150, 310, 311, 430, 610}
# With the two attempts after the first one, so that sub-steps must do it; one of these fails, too.
WITH_SUBSTEPS = {150, 151, 152, 400, 401, 402, 700, 701, 702, 704}


def response(
    monkeypatch: pytest.MonkeyPatch,
    settings: AnalysisSettings,
    options: ModelOptions,
    failing: Set[int],
) -> AnalysisResult:
    """Analyse OSB1 with some attempts made impossible: one iteration, no tolerance.

    No state is read that has not met the test of its own attempt.
    """
    analyze, test, diverged = ops.analyze, ops.test, Watch.diverged
    attempts, tolerance_j, ended = 0, settings.tolerance_j, 0

    def note_test(name: str, limit: float, iterations: int) -> None:
        nonlocal tolerance_j
        tolerance_j = limit
        test(name, limit, iterations)

    def sometimes(count: int, *step: float) -> int:
        nonlocal attempts, ended
        attempts += 1
        fails = bool(step) and attempts in failing
        if fails:
            test("EnergyIncr", -1.0, 2)
        ended = int(analyze(count, *step))
        if fails:
            test("EnergyIncr", tolerance_j, settings.max_iterations)
        return ended

    def after_convergence(self: Watch) -> str:
        assert ended == 0
        assert 0.0 <= ops.testNorms()[ops.testIter() - 1] <= tolerance_j
        return diverged(self)

    monkeypatch.setattr(ops, "analyze", sometimes)
    monkeypatch.setattr(ops, "test", note_test)
    monkeypatch.setattr(Watch, "diverged", after_convergence)
    monkeypatch.setitem(Stepper.__init__.__kwdefaults__, "ladder", STRICT)
    result = analyse(
        Variant(
            bridge="osb1", abutment="contact_friction", skew_deg=30, gap_mm=25, friction_pct=50
        ),
        Excitation(motion=strong_motion()),
        settings,
        options,
    )
    monkeypatch.undo()
    return result


@pytest.mark.parametrize(
    ("settings", "options", "failing", "tolerance"),
    [
        # both converge to the tolerance by different iterations
        (SETTINGS, ModelOptions(), FAILING, 1e-8),
        # three of the steps are made in quarters
        (FINE, ModelOptions(), WITH_SUBSTEPS, 1e-4),
        # Houbolt starts anew at each failure, by the trapezoidal rule for two steps;
        # under yielding columns it has failures of its own
        (HOUBOLT, ModelOptions(elastic_columns=True), WITH_SUBSTEPS, 1e-3),
    ],
)
def test_a_retry_does_not_change_the_response(
    monkeypatch: pytest.MonkeyPatch,
    settings: AnalysisSettings,
    options: ModelOptions,
    failing: Set[int],
    tolerance: float,
) -> None:
    smooth = response(monkeypatch, settings, options, frozenset())
    rough = response(monkeypatch, settings, options, failing)
    assert rough.failed_attempts - smooth.failed_attempts == len(failing)
    assert smooth.demands["contact_closures"] > 10
    for name in ("column_drift_ratio", "deck_rotation_rad", "unseating_m", "slip_work_kj"):
        assert rough.demands[name] == pytest.approx(smooth.demands[name], rel=tolerance)
