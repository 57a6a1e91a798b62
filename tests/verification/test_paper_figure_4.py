"""Figure 4 of the paper: the particle between two lines, rigid and with a penalty."""

import numpy as np
import pytest

from reference_data import reference_table
from skewbridge.verification.studies.comparison import Study
from skewbridge.verification.studies.particle_between_lines import (
    FIRST_CONTACT_S,
    LCP_PEAKS,
    Particle,
    compare_with_lcp,
    run_particle,
    run_particle_lcp,
)


@pytest.fixture(scope="module")
def rigid():
    return run_particle_lcp(Particle(), 5e-5, 3.0)


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_moreau_jean_meets_the_tabulated_peaks(restitution):
    particle = Particle(restitution=restitution)
    history = run_particle_lcp(particle, 5e-5, 2.0)
    ux, uy, ut, _ = LCP_PEAKS[restitution]
    peaks = (*np.abs(history.q).max(axis=0), np.abs(history.q @ np.array(particle.tangent)).max())
    # First order in h: 2e-3 at 5e-5 s.
    assert peaks == pytest.approx((ux, uy, ut), rel=2e-3)
    assert np.abs(history.tangent_impulses_ns).sum() == pytest.approx(
        0.1 * history.normal_impulses_ns.sum(), rel=1e-6
    )


def test_moreau_jean_follows_the_tabulated_history(rigid):
    reference = reference_table("particle_history")
    normal = rigid.q @ np.array(Particle().normal)
    found = np.interp(reference["t_s"], rigid.t_s, normal)
    error = np.sqrt(np.mean((found - reference["un_m"].to_numpy()) ** 2))
    assert error <= 0.01 * 0.0268


def test_free_flight_ends_at_the_exact_time(rigid):
    outside = np.flatnonzero(rigid.normal_impulses_ns.sum(axis=1) > 0.0)[0]
    assert rigid.t_s[outside] == pytest.approx(FIRST_CONTACT_S, abs=1e-4)


def test_the_penalty_particle_stays_between_the_lines_and_near_the_rigid_one(rigid):
    study = Study("fig4")
    particle = Particle(kn_n_per_m=1.0e9)
    history = run_particle(particle, 5e-5, 2.0, keep=lambda k: k % 10 == 0)
    compare_with_lcp(study, particle, history, rigid)
    assert [found.quantity for found in study.comparisons if not found.is_passed] == []
