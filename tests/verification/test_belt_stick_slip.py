"""A mass on a belt: Popp and Stelter (1990), Phil. Trans. A 332. Case B8 of docs/theory."""

import pytest

from skewbridge.verification.references.closed_forms import belt_stick_slip
from skewbridge.verification.studies.oscillators import belt_period, belt_ride


def test_stick_slip_repeats_with_the_period_of_the_closed_form():
    exact = belt_stick_slip(1000.0, 4e4, 0.4 * 9810.0, 0.3 * 9810.0, 0.1)
    assert exact.slip_s == pytest.approx(0.6778152947400278)
    assert exact.stick_s == pytest.approx(0.4905)
    # 2 %: the closed form lets friction fall at once, the law within 0.2 mm/s of slip.
    assert belt_period(belt_ride(4.0)) == pytest.approx(exact.period_s, rel=0.02)
