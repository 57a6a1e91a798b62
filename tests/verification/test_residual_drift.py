"""The residual drift is taken at rest, however long the quiet end of the motion is.

Limit: 5 % of the drift after 30 s of zeros. The way to rest is another than under the bridge's own
damping (critical in place of 5 %), so it is no rounding; found are 0.1 to 1 %.
"""

from dataclasses import replace

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.analysis import transient
from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.bent import build_integration
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_capacity
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.weights import column_axial_n
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion

CASE = variant(0, gap_mm=25)
NAME = "column_residual_drift_ratio"


def run(case=CASE, **settings):
    return analysed(case, strong_motion(peak_g=1.2), **settings)


def last_drift(result):
    return max(float(values[-1]) for name, values in result.histories.items() if "drift" in name)


@pytest.mark.parametrize("skew_deg", [0, 30])
def test_the_drift_at_rest_is_that_of_a_run_continued_with_zeros(skew_deg):
    case = replace(CASE, skew_deg=skew_deg)
    long = run(case, free_vibration_s=30.0)
    short = run(case, free_vibration_s=4.0)
    assert last_drift(long) == pytest.approx(long.demands[NAME], rel=0.01)
    assert short.demands[NAME] == pytest.approx(last_drift(long), rel=0.05)


def test_the_last_step_of_a_moving_bridge_is_not_its_residual_drift():
    moving, settled = run(), run(free_vibration_s=8.0)
    assert moving.status == "ok"
    target = settled.demands[NAME]
    assert abs(moving.demands[NAME] - target) < 0.5 * abs(last_drift(moving) - target)


def test_only_the_residual_drift_depends_on_the_release(monkeypatch):
    usual = run(duration_s=2.0).demands
    monkeypatch.setattr(transient, "MAX_PERIODS", 0)
    other = run(duration_s=2.0)
    assert other.demands | {NAME: 0.0} == usual | {NAME: 0.0}
    assert other.demands[NAME] == last_drift(other)
    assert other.messages == (
        "residual drift is taken from the last step: still moving after 0 periods",
    )


def test_a_failed_release_is_reported_and_a_collapse_keeps_the_drift_of_its_last_step(monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(transient, "_PARTS", ())
        result = run(duration_s=1.0)
    assert result.status == "ok"
    assert "a step of the release did not converge" in result.messages[0]
    result = run(collapse_drift_ratio=0.01)
    assert result.status == "collapse"
    assert result.demands[NAME] == pytest.approx(last_drift(result))
    assert not ops.getNodeTags()


def test_drifts_are_those_of_the_top_against_the_base():
    """A model at rest under gravity, whose bases stood elsewhere when the drifts began."""
    with domain():
        model = build(replace(CASE, abutment="roller"), ModelOptions())
        apply_rayleigh(model)
        leans = []
        for i, column in enumerate(model.columns):
            stood = ops.nodeDisp(column.base_node)[:2]
            for dof, move_m in enumerate((0.04, 0.03 + 0.01 * i), start=1):
                ops.setNodeDisp(column.base_node, dof, stood[dof - 1] + move_m, "-commit")
            leans.append(transient.Lean(column))
            for dof in (1, 2):
                ops.setNodeDisp(column.base_node, dof, stood[dof - 1], "-commit")
        found = transient.drifts_at_rest(model, AnalysisSettings(), leans)
    moves_m = [np.hypot(0.04, 0.03 + 0.01 * i) for i in range(len(leans))]
    heights_m = [column.clear_height_m for column in model.columns]
    assert found.drifts == pytest.approx(np.divide(moves_m, heights_m), rel=1e-6)


# --- what a column keeps of its peak without shaking
def kept_at_zero_force(ductility):
    """Return residual / peak of a fixed column after slow cycles, without P-Delta."""
    bridge, tags, steps = load_bridge("osb1_fixed"), TagAllocator(), 200
    capacity = bent_capacity(bridge, 0)
    peak_m = ductility * capacity.yield_disp_m
    with domain():
        integration, _ = build_integration((capacity, capacity), ModelOptions(), tags)
        ops.geomTransf("Linear", 1, 1.0, 0.0, 0.0)
        for node, height_m in ((1, 0.0), (2, capacity.clear_height_m)):
            ops.node(node, 0.0, 0.0, height_m)
        ops.fix(1, 1, 1, 1, 1, 1, 1)
        ops.fix(2, 0, 1, 0, 1, 1, 1)
        ops.element("forceBeamColumn", 1, 1, 2, 1, integration, "-iter", 10, 1e-2)
        for pattern, force_n in ((1, (0.0, -column_axial_n(bridge, 0))), (2, (1.0, 0.0))):
            ops.timeSeries("Linear", pattern)
            ops.pattern("Plain", pattern, pattern)
            ops.load(2, force_n[0], 0.0, force_n[1], 0.0, 0.0, 0.0)
            if pattern == 1:
                static_steps(1, "BandGeneral", 1e-9)
                ops.loadConst("-time", 0.0)
        for part_m in (peak_m, -2 * peak_m, 2 * peak_m, -peak_m):
            ops.integrator("DisplacementControl", 2, 1, part_m / steps)
            back = []  # displacement and force on the last way back
            for _ in range(steps):
                assert ops.analyze(1) == 0
                back.append((ops.getTime(), ops.nodeDisp(2, 1)))
    forces, moved = np.array(back[::-1]).T
    assert forces[0] < 0.0 < forces[-1]
    return float(np.interp(0.0, forces, moved)) / peak_m


@pytest.mark.parametrize("ductility", [2.0, 4.0, 6.0])
def test_a_column_keeps_as_much_of_its_peak_as_by_takedas_rule(ductility):
    """1 - ductility^(alpha - 1): the unloading exponent alpha is 0.3 (wide loops) to 0.5.

    So the loops do not cause the small residual drift of shaken bridges (docs/theory/bridge.md).
    """
    narrow, wide = (1.0 - ductility ** (alpha - 1.0) for alpha in (0.5, 0.3))
    assert narrow < kept_at_zero_force(ductility) < wide + 0.04
