"""Sliding blocks: Newmark (1965), Geotechnique 15. Case B3 of docs/theory."""

import numpy as np
import pytest

from skewbridge.verification.references.blocks import Block, run_block
from skewbridge.verification.references.closed_forms import (
    rectangular_pulse_slip,
    sine_pulse_first_slip,
)

G = 9.81
# Friction, start and end of the first slip, its length, and the final slip of an independent
# event-driven integration.
SINE = [
    (0.1, 0.016023554212243735, 0.38014831801740473, -0.11143104347381744, -0.05928),
    (0.2, 0.03274747010861366, 0.32730603263410313, -0.05833153167471515, -0.0051064),
    (0.3, 0.05120819117478336, 0.2803876325106701, -0.024487843156247094, 0.00042046),
    (0.4, 0.07379180882521665, 0.22974047118111543, -0.005833137378280437, 0.0),
]


def block(friction):
    return Block(
        mass_kg=1000.0,
        kn_n_per_m=1e9,
        kt_n_per_m=1e10,
        friction=friction,
        normal_load_n=1000.0 * G,
    )


@pytest.mark.parametrize(("friction", "start", "end", "slip", "final"), SINE)
def test_sine_pulse(friction, start, end, slip, final):
    exact = sine_pulse_first_slip(0.5 * G, 0.5, friction * G)
    assert (exact.start_s, exact.end_s) == pytest.approx((start, end), rel=1e-9)
    assert exact.slip_m == pytest.approx(slip, rel=1e-9)
    history = run_block(
        block(friction),
        2e-4,
        1.0,
        base_mps2=lambda t: np.where(t <= 0.5, 0.5 * G * np.sin(4 * np.pi * t), 0.0),
    )
    x = history.position_m[:, 0]
    assert x.min() == pytest.approx(slip, rel=5e-3)
    # The way back starts from rest under a small excess: 0.5 mm for the elastic slip.
    assert x[-1] == pytest.approx(final, abs=5e-4)
    # Kinetic energy is zero at both ends, so friction took what the base gave.
    assert history.ledger.slip_work_j > 0.0


@pytest.mark.parametrize(("friction", "slip"), [(0.1, 0.3924), (0.2, 0.14715), (0.3, 0.0654)])
def test_rectangular_pulse(friction, slip):
    assert rectangular_pulse_slip(0.5 * G, 0.2, friction * G) == pytest.approx(slip)
    history = run_block(
        block(friction),
        2e-4,
        1.3,
        base_mps2=lambda t: 0.25 * G * (np.sign(0.2 + 1e-9 - t) + np.sign(0.2 - 1e-9 - t) + 2) / 2,
    )
    assert -history.position_m[-1, 0] == pytest.approx(slip, rel=5e-3)
