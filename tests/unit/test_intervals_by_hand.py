"""Doubts about motions and the contact law against closed forms."""

from pathlib import Path

import numpy as np
import pytest

from skewbridge.contact.law import ContactLaw
from skewbridge.motions.read import doubts
from skewbridge.motions.trace import Trace


@pytest.mark.parametrize(("offset", "is_told"), [(0.03, True), (-0.03, True), (0.01, False)])
def test_offset_of_either_sign_gets_a_warning(offset, is_told):
    wave = np.tile([1.0, -1.0], 500)
    trace = Trace(
        path=Path("a.csv"), format="csv", accel_mps2=wave + offset, dt_s=0.01, unit="m/s2"
    )
    assert any("mean is" in doubt for doubt in doubts(trace)) is is_told


def test_a_contact_of_which_nothing_is_said_has_no_friction_no_cohesion_and_no_gap():
    law = ContactLaw(kn_n_per_m=1e9, kt_n_per_m=1e9)
    assert (law.friction, law.cohesion_n, law.gap_m, law.gap_closing_m) == (0.0, 0.0, 0.0, 0.0)
