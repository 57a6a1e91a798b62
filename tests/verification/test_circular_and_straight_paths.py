"""Steady radial return on a circle and on a line. Cases B6 and B7 of docs/theory."""

from math import degrees

import numpy as np
import pytest

from skewbridge.contact import ContactLaw
from skewbridge.verification.references.closed_forms import (
    circular_path_lag_rad,
    circular_path_work_j,
    straight_loop_work_j,
)
from skewbridge.verification.references.driven_unit import (
    circle,
    drive_unit,
    path_work_j,
    straight_loop,
)

LAW = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3, cohesion_n=1500.0)
SLIP_M = 0.045


def steady_lag_deg(path, forces):
    """Angle of the force behind the velocity in the last loop, which is known exactly."""
    turned = 2 * np.pi * path[:, 0] / 4.0
    lag = turned - np.unwrap(np.arctan2(forces[:, 1], forces[:, 0]))
    return degrees(float(np.median(np.angle(np.exp(1j * lag[len(path) // 2 :])))))


@pytest.mark.parametrize(("radius", "angle"), [(1.0, 2.5792), (0.2, 13.0029), (0.1, 26.7437)])
def test_friction_lags_the_velocity_on_a_circle(radius, angle):
    assert degrees(circular_path_lag_rad(radius, SLIP_M)) == pytest.approx(angle, abs=1e-4)
    path = circle(radius, period_s=4.0, loops=3, rows_per_loop=1000, opening_m=-0.1)
    forces = drive_unit(LAW, path, substeps=10).forces_n
    # Radial return in steps of a loop / 10,000 lags by half a step more.
    assert steady_lag_deg(path, forces) == pytest.approx(angle, abs=0.06)
    assert np.hypot(*forces[1000:, :2].T) == pytest.approx(4500.0, rel=1e-9)
    last = slice(2000, None)
    exact = circular_path_work_j(radius, SLIP_M, 4500.0)
    assert path_work_j(path[last], forces[last]) == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize(
    ("scheme", "coupling", "lag"),
    [
        ("vector", "extrapolated", 13.0),
        ("vector", "lagged", 13.0),
        ("elastic", "extrapolated", 13.0),
        ("componentwise", "lagged", 25.4),
    ],
)
def test_only_componentwise_lagged_yields_stay_wrong_at_small_steps(scheme, coupling, lag):
    path = circle(0.2, period_s=4.0, loops=2, rows_per_loop=4000, opening_m=-0.1)
    forces = drive_unit(LAW, path, substeps=1, scheme=scheme, coupling=coupling).forces_n
    # The componentwise lag varies around the circle; the others are steady.
    assert steady_lag_deg(path, forces) == pytest.approx(lag, abs=0.6 if lag > 20.0 else 0.2)


def test_a_straight_loop_loses_the_work_of_friction():
    assert straight_loop_work_j(0.5, SLIP_M, 4500.0) == pytest.approx(8190.0)
    path = straight_loop(0.5, rows=400, opening_m=-0.1)
    result = drive_unit(LAW, path)
    second = slice(400, None)
    work = path_work_j(path[second], result.forces_n[second])
    assert work == pytest.approx(8190.0, rel=5e-3)
    assert result.ledger is not None
    stored = 4500.0**2 / 2e5
    total = path_work_j(path, result.forces_n)
    assert result.ledger.slip_work_j == pytest.approx(total - stored, rel=5e-3)
