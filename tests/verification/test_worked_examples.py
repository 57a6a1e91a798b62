"""The examples of docs/theory/examples.md, with the functions of the package."""

from math import log, radians

import numpy as np
import pytest
from scipy.stats import norm

from skewbridge.bridge.abutment.backfill import skew_reduction
from skewbridge.bridge.abutment.elements import normal_penalty
from skewbridge.contact.law import ContactLaw, advance_pair
from skewbridge.fragility.fits import fit_cloud
from skewbridge.motions.levels import block_targets
from skewbridge.variant.options import ModelOptions


def test_one_step_of_radial_return():
    law = ContactLaw(kn_n_per_m=1e9, kt_n_per_m=2e8, friction=0.5)
    state = advance_pair(law, (0.0, 0.0), (0.30e-3, 0.40e-3), -1e-4)  # 100 kN of compression
    assert (state.force_1_n, state.force_2_n) == pytest.approx((30e3, 40e3))
    assert (state.stick_1_m, state.stick_2_m) == pytest.approx((0.15e-3, 0.20e-3))


def test_a_skewed_backfill_and_the_softness_of_the_penalty():
    forces = [6662 * skew_reduction(radians(skew)) for skew in (30, 60)]
    assert forces == pytest.approx([3420, 1756], abs=0.5)
    penalty = normal_penalty(1e8, 0.0, ModelOptions())
    assert 1 / (1 / 1e8 + 1 / penalty) / 1e8 == pytest.approx(50 / 51)


def test_targets_of_a_block():
    targets = block_targets(0, 8, (0.07, 2.25))
    assert (targets[0], targets[-1]) == pytest.approx((0.087, 1.811), abs=5e-4)
    assert pytest.approx(0.29) == 0.087 / 0.30


def test_a_cloud():
    """Runs that lie on the line of the example with its scatter."""
    x = np.repeat(np.geomspace(0.1, 2.0, 20), 2)
    size = 0.30 * np.sqrt((x.size - 2) / x.size)
    demand = 0.04 * x**1.1 * np.exp(np.tile([size, -size], 20))
    alone = fit_cloud(x, demand, 0.025)
    total = fit_cloud(x, demand, 0.025, capacity_dispersion=0.35)
    assert (alone.theta, alone.beta, total.beta) == pytest.approx((0.652, 0.273, 0.419), abs=5e-4)
    assert total.theta == alone.theta
    assert norm.cdf(log(0.5 / total.theta) / total.beta) == pytest.approx(0.263, abs=5e-4)
