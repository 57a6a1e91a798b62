"""Oscillators with Coulomb friction.

Den Hartog (1956), Mechanical Vibrations; Den Hartog (1931), Transactions ASME 53;
Shaw (1986), Journal of Sound and Vibration 108. Numbers of case B1 and B2 of docs/theory.
"""

import pytest

from skewbridge.verification.references.closed_forms import (
    forced_amplitude,
    free_decay_turning_points,
)
from skewbridge.verification.studies.oscillators import (
    forced_response,
    free_decay,
    turning_points,
)

SLIP_M = 1962.0 / 4.0e4


def test_closed_form_loses_four_friction_over_stiffness_per_cycle():
    points = free_decay_turning_points(0.5, SLIP_M)
    assert points == pytest.approx([0.5, -0.4019, 0.3038, -0.2057, 0.1076, -0.0095])


def test_the_mass_turns_where_the_closed_form_says_and_stops():
    history = free_decay()
    found = turning_points(history)[:5]
    # 0.5 mm of 0.5 m: elastic slip of the penalty and the time step at the turning points.
    assert found == pytest.approx([-0.4019, 0.3038, -0.2057, 0.1076, -0.0095], abs=5e-4)
    assert history.position_m[-1, 0] == pytest.approx(-0.0095, abs=5e-4)
    assert history.ledger.cone_violation_ratio < 1e-9


def test_the_period_does_not_depend_on_friction():
    history = free_decay()
    v = history.velocity_mps[:, 0]
    first = history.t_s[:-1][(v[1:] > 0.0) & (v[:-1] < 0.0)][0]
    assert first == pytest.approx(0.99345882657961 / 2.0, rel=2e-3)


@pytest.mark.parametrize(
    ("ratio", "friction_ratio", "amplitude"),
    [
        (0.6, 0.2, 0.38028535011194636),
        (0.7, 0.3, 0.30831192554273057),
        (0.8, 0.4, 0.3067817389078955),
        (1.2, 0.4, 0.233236203057724),
        (1.5, 0.3, 0.11790152670767248),
        (2.0, 0.2, 0.0779845297158353),
    ],
)
def test_closed_form_of_forced_motion_gives_the_tabulated_amplitudes(
    ratio, friction_ratio, amplitude
):
    static = 1962.0 / friction_ratio / 4.0e4
    assert static * forced_amplitude(ratio, friction_ratio) == pytest.approx(amplitude, rel=1e-12)


@pytest.mark.parametrize(("ratio", "friction_ratio"), [(0.7, 0.3), (2.0, 0.2)])
def test_forced_motion_settles_to_the_closed_form(ratio, friction_ratio):
    found, exact = forced_response(ratio, friction_ratio, cycles=20)
    # 0.5 %: friction reverses between steps, first order in the step.
    assert found == pytest.approx(exact, rel=5e-3)
