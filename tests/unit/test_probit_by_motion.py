"""A probit without each motion is what a new fit without it gives."""

import numpy as np
import pytest

from skewbridge.fragility.old_joint.probit import fit_probit, refitted_without_motions

MOTIONS, VARIANTS = 24, 6


@pytest.fixture
def runs():
    rng = np.random.default_rng(5)
    motion = np.repeat(np.arange(MOTIONS), VARIANTS)
    ln_im = np.linspace(-1.5, 1.5, MOTIONS)[motion]
    axis = np.tile(np.linspace(0.0, 1.0, VARIANTS), MOTIONS)
    own = rng.normal(size=MOTIONS)[motion]
    y = 2.0 * ln_im + 0.5 * axis + own + 0.4 * rng.normal(size=motion.size)
    return np.column_stack([np.ones(motion.size), ln_im, axis]), (y > 0.0).astype(float), motion


def test_without_each_motion_as_by_a_new_fit(runs):
    design, exceed, motion = runs
    fit = fit_probit(design, exceed, motion)
    found, scatter = refitted_without_motions(fit, design, exceed, motion).one_left_out()
    single, _ = fit.sums.one_left_out()
    anew = np.array(
        [
            fit_probit(
                design[motion != one],
                exceed[motion != one],
                np.unique(motion[motion != one], return_inverse=True)[1],
            ).sums.params
            for one in range(MOTIONS)
        ]
    )
    spread = np.sqrt(np.diag(np.linalg.inv(np.sum(fit.sums.information, axis=0))))
    # motions kept at one step move the estimate by less than 0.1 standard errors
    assert np.max(np.abs(found - anew) / spread) < 0.02
    assert np.max(np.abs(single - anew) / spread) > 0.1
    assert np.all(scatter == 1.0)
