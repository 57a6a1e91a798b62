"""Pushovers of skewed bridges with friction follow a slow ramp of the forces in time.

The ramp is a response history: implicit dynamics with masses, damping and steps of 10 to 0.3 ms, in
which friction is set from the predicted normal force. The pushover is static. Both agree to 0.2 %;
inertia and damping at the slow ramp are about 0.1 %."""

import numpy as np
import openseespy.opensees as ops
import pytest
from reference_pages import ROOT

from skewbridge.analysis.modal import apply_rayleigh
from skewbridge.analysis.pushover import push_bridge
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import StepLoop
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

OPTIONS = ModelOptions()
RAMP_S = 20.0


def slow_ramp(variant: Variant, dof: int, force_n: float) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements of the mass centre and forces, which grow linearly in `RAMP_S`."""
    settings, rows = AnalysisSettings(energy=False), []
    with domain():
        model = build(variant, OPTIONS)
        apply_rayleigh(model)
        series, centre = model.tags.series(), model.frame.centre_node
        ops.timeSeries("Linear", series, "-factor", force_n / RAMP_S)
        ops.pattern("Plain", model.tags.pattern(), series)
        masses = model.frame.loads.masses_kg
        for node, mass_kg in masses.items():
            share = [0.0] * 6
            share[dof - 1] = mass_kg / sum(masses.values())
            ops.load(node, *share)
        start_m = ops.nodeDisp(centre, dof)

        def read() -> None:
            disp_m = ops.nodeDisp(centre, dof) - start_m
            rows.append((disp_m, ops.getTime() / RAMP_S * force_n))

        loop = StepLoop(model.contacts, settings, longest_s=0.0)
        assert loop.run(round(RAMP_S / settings.dt_s), read).status == "ok"
    disp_m, forces_n = np.array(rows).T
    return disp_m, forces_n


@pytest.mark.parametrize(("skew_deg", "dof"), [(30.0, 1), (60.0, 2)])
def test_a_push_with_friction_agrees_with_a_slow_ramp(skew_deg, dof) -> None:
    values = {"skew_deg": skew_deg, "gap_mm": 25.0, "friction": 0.5}
    variant = Variant.at("osb1", "contact_friction", values)
    push = {"angle_deg": 90.0 * (dof - 1), "max_disp_m": 0.06, "steps": 80}
    curve = push_bridge(variant, OPTIONS, **push)
    assert curve.is_complete
    assert curve.disp_m[-1] == pytest.approx(0.06, rel=1e-3)
    assert curve.imbalance < 1e-6
    disp_m, forces_n = slow_ramp(variant, dof, 0.9 * curve.peak_n)
    # from the displacement at which the start of the ramp is forgotten
    compared_m = np.linspace(0.01, 0.95 * disp_m[-1], 20)
    expected_n = np.interp(compared_m, disp_m, forces_n)
    np.testing.assert_allclose(np.interp(compared_m, curve.disp_m, curve.force_n), expected_n, 0.02)
    if dof == 1:  # friction matters: without it, the force is far smaller
        smooth = Variant.at("osb1", "contact_friction", values | {"friction": 0.0})
        without = push_bridge(smooth, OPTIONS, **push)
        assert np.interp(compared_m[-1], without.disp_m, without.force_n) < 0.92 * expected_n[-1]


@pytest.mark.parametrize("bridge", ["osb2s", str(ROOT / "docs/own_bridge.py")])
def test_lever_and_displacement_control_agree_before_contact(bridge) -> None:
    """Osb2s has no mass at its centre; the script has rigid links. Little friction: no effect."""
    curves = [
        push_bridge(
            Variant.at(bridge, "contact_friction", {"skew_deg": 30, "gap_mm": 51, "friction": mu}),
            OPTIONS, angle_deg=40.0, max_disp_m=0.03, steps=30,
        )
        for mu in (0.0, 1.0e-3)
    ]  # fmt: skip
    # along the push, although the deck also moves across it
    assert [curve.disp_m[-1] for curve in curves] == pytest.approx([0.03] * 2, rel=3e-4)
    control, lever = (np.interp([0.01, 0.03], c.disp_m, c.force_n) for c in curves)
    assert lever == pytest.approx(control, rel=5e-4)
