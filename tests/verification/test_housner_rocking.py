"""A rigid block that rocks, tips or slides: Housner (1963), BSSA 53. Case B9 of docs/theory."""

import numpy as np
import pytest

from skewbridge.verification.references.blocks import UprightBlock, run_upright
from skewbridge.verification.references.closed_forms import RockingBlock

CASES = [(0.25, 1.0, 0.24498, 2.67167, 0.493803), (0.5, 1.5, 0.32175, 2.15715, 0.612367)]


def upright(b, h, **changes):
    fields = {
        "half_width_m": b,
        "half_height_m": h,
        "mass_kg": 1000.0,
        "friction": 1.0,
        "penalty_n_per_m": 1e9,
        "gravity_mps2": 9.81,
    }
    return UprightBlock(**(fields | changes))


@pytest.mark.parametrize(("b", "h", "slenderness", "frequency", "quarter"), CASES)
def test_a_released_block_is_upright_after_the_quarter_period(
    b, h, slenderness, frequency, quarter
):
    exact = RockingBlock(half_width_m=b, half_height_m=h, gravity_mps2=9.81)
    assert exact.slenderness_rad == pytest.approx(slenderness, abs=1e-5)
    assert exact.frequency_rad_per_s == pytest.approx(frequency, abs=1e-5)
    angle = 0.5 * exact.slenderness_rad
    assert exact.quarter_period_s(angle) == pytest.approx(quarter, abs=1e-6)
    # Linear in the angle, from half the slenderness: acosh(2) / p.
    assert np.arccosh(2.0) / exact.frequency_rad_per_s == pytest.approx(quarter, rel=4e-3)
    history = run_upright(upright(b, h, angle_rad=angle), 5e-4, 0.7)
    passed = history.t_s[np.flatnonzero(history.angle_rad <= 0.0)[0]]
    # 0.5 %: the corner sinks into the penalty, the step is 0.1 %.
    assert passed == pytest.approx(quarter, rel=5e-3)


@pytest.mark.parametrize(("b", "h"), [(0.25, 1.0), (0.5, 1.5)])
@pytest.mark.parametrize("friction", [1.0, 0.2])
def test_a_pushed_block_tips_or_slides(b, h, friction):
    rate, g = 1.2, 9.81
    history = run_upright(
        upright(b, h, friction=friction),
        1e-3,
        4.0,
        base_mps2=lambda t: rate * np.maximum(0.0, t - 1.0),
    )
    lifted = np.flatnonzero((history.t_s > 1.0) & (history.openings_m.max(axis=1) > 0.0))
    if friction > b / h:
        start = rate * (history.t_s[lifted[0]] - 1.0)
        assert start == pytest.approx(g * b / h, rel=0.02)
    else:
        assert len(lifted) == 0
        # From friction x g on, the excess of the acceleration grows linearly.
        sliding_s = 3.0 - friction * g / rate
        slid = abs(history.feet_m[-1, 0])
        assert slid == pytest.approx(rate * sliding_s**3 / 6.0, rel=0.02)
