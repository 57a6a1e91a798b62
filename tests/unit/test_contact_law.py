"""Friction cone, return mapping and contact frames as pure functions."""

from math import cos, hypot, radians, sin

import pytest

from skewbridge.contact import ContactLaw
from skewbridge.contact.element import contact_frame, cross
from skewbridge.contact.law import (
    advance_pair,
    yields_by_direction,
    yields_on_cone,
)
from skewbridge.contact.state import UnitLedger
from skewbridge.errors import InputError

LAW = ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3, cohesion_n=1500.0)


def test_slip_moves_the_stick_point_and_stick_leaves_it():
    slipped = advance_pair(LAW, (0.0, 0.0), (0.3, 0.4), -0.1)
    assert slipped.is_slipping
    assert hypot(0.3 - slipped.stick_1_m, 0.4 - slipped.stick_2_m) == pytest.approx(0.045)
    stuck = advance_pair(LAW, (0.0, 0.0), (0.01, 0.02), -0.1)
    assert not stuck.is_slipping
    assert (stuck.stick_1_m, stuck.stick_2_m) == (0.0, 0.0)


def test_the_stick_point_of_an_open_pair_follows_the_node():
    opened = advance_pair(LAW, (0.0, 0.0), (0.3, 0.4), 0.01)
    assert not opened.is_closed
    assert (opened.force_1_n, opened.force_2_n) == (0.0, 0.0)
    assert (opened.stick_1_m, opened.stick_2_m) == (0.3, 0.4)


def test_yields_hold_a_sticking_trial_with_equal_slack_and_stay_on_the_cone():
    first, second = yields_on_cone(-1000.0, 0.0, 4500.0)
    assert hypot(first, second) == pytest.approx(4500.0)
    assert first - 1000.0 == pytest.approx(second)


def test_yields_of_a_slipping_trial_are_its_radial_return():
    assert yields_on_cone(-30e3, 40e3, 4500.0) == pytest.approx((2700.0, 3600.0))
    assert yields_by_direction(-3.0, 4.0, 4500.0) == pytest.approx((2700.0, 3600.0))


def test_yields_without_a_direction_share_the_limit():
    assert yields_by_direction(0.0, 0.0, 1.0) == pytest.approx((0.5**0.5, 0.5**0.5))
    assert yields_on_cone(0.0, 0.0, 1.0) == pytest.approx((0.5**0.5, 0.5**0.5))
    assert yields_on_cone(0.0, 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("ndm", [2, 3])
def test_a_frame_is_orthonormal_and_right_handed(ndm):
    normal = (cos(radians(30)), -sin(radians(30)), 0.4)[:ndm]
    frame = contact_frame(normal, None, ndm)
    for i, a in enumerate(frame):
        for j, b in enumerate(frame):
            product = sum(x * y for x, y in zip(a, b, strict=True))
            assert product == pytest.approx(float(i == j), abs=1e-12)
    if ndm == 3:
        assert cross(frame[0], frame[1]) == pytest.approx(frame[2])
        assert frame[1][2] == pytest.approx(0.0)  # t1 is horizontal


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_vertical_normal_gets_a_horizontal_tangent(sign):
    frame = contact_frame((0.0, 0.0, sign), None, 3)
    assert frame[1] == pytest.approx((1.0, 0.0, 0.0))


def test_a_nearly_perpendicular_tangent_is_straightened_and_an_oblique_one_refused():
    frame = contact_frame((0.0, 0.0, 1.0), (1.0, 0.0, 1e-6), 3)
    assert frame[1] == pytest.approx((1.0, 0.0, 0.0))
    with pytest.raises(InputError, match="perpendicular"):
        contact_frame((0.0, 0.0, 1.0), (1.0, 0.0, 0.1), 3)


def test_other_dimensions_are_refused():
    with pytest.raises(InputError, match="ndm"):
        contact_frame((1.0,), None, 1)


def test_a_ledger_without_friction_has_no_violation():
    assert UnitLedger(name="pair", normal_potential_j=0.0).cone_violation_ratio == 0.0
