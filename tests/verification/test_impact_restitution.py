"""Impacts on penalties with and without damping. Cases B4 and B5 of docs/theory.

Schwager and Poeschel (2007), Granular Matter 9; Hunt and Crossley (1975), Journal of Applied
Mechanics 42; Goldsmith (1960), Impact; Johnson (1985), Contact Mechanics.
"""

import pytest

from skewbridge.contact.drives import (
    approach_stiffness_drive,
    hunt_crossley_drive,
    kelvin_voigt_drive,
    power_law_drive,
)
from skewbridge.contact.restitution import (
    hunt_crossley_damping,
    kelvin_voigt_damping_ratio,
    kelvin_voigt_restitution,
)
from skewbridge.errors import InputError
from skewbridge.verification.references.blocks import Block, run_block
from skewbridge.verification.references.closed_forms import (
    falling_mass_impact,
    power_law_penetration,
)
from skewbridge.verification.studies.oscillators import bounce

MASS_KG, KN = 1000.0, 1e7
# Restitution, textbook damping ratio, what it gives when clipped, the ratio needed.
TABLE = [
    (0.45, 0.24634, 0.5107, 0.30096),
    (0.5, 0.21545, 0.5503, 0.25528),
    (0.6, 0.16049, 0.6323, 0.18086),
    (0.65, 0.13585, 0.6748, 0.14994),
    (0.71, 0.10838, 0.7270, 0.11701),
    (0.8, 0.07085, 0.8081, 0.07436),
    (0.9, 0.03352, 0.9020, 0.03427),
]


@pytest.mark.parametrize(("restitution", "textbook", "clipped", "needed"), TABLE)
def test_the_table_of_clipped_restitution(restitution, textbook, clipped, needed):
    assert kelvin_voigt_restitution(textbook) == pytest.approx(clipped, abs=1e-4)
    assert kelvin_voigt_damping_ratio(restitution) == pytest.approx(needed, abs=1e-5)


@pytest.mark.parametrize(
    ("restitution", "damping"), [(0.45, 1.72667), (0.6, 0.97487), (0.71, 0.60561), (0.9, 0.16648)]
)
def test_the_table_of_hunt_crossley(restitution, damping):
    assert hunt_crossley_damping(restitution) == pytest.approx(damping, abs=1e-5)


def test_overdamped_contacts_rebound_little_and_continuously():
    near = [kelvin_voigt_restitution(z) for z in (0.9999, 1.0, 1.0001)]
    assert near[0] == pytest.approx(near[1], abs=1e-3)
    assert near[2] == pytest.approx(near[1], abs=1e-3)
    assert kelvin_voigt_damping_ratio(0.1) > 1.0
    assert kelvin_voigt_restitution(kelvin_voigt_damping_ratio(0.1)) == pytest.approx(0.1)


@pytest.mark.parametrize("restitution", [0.0, -0.1, 1.1])
def test_restitution_out_of_range_is_refused(restitution):
    with pytest.raises(InputError, match="restitution"):
        kelvin_voigt_damping_ratio(restitution)


# Step x contact frequency is 0.05, for which 0.01 is asked.
@pytest.mark.parametrize("restitution", [0.45, 0.6, 0.71, 0.9])
def test_clipped_kelvin_voigt_in_a_live_unit(restitution):
    dashpot = 2.0 * kelvin_voigt_damping_ratio(restitution) * (KN * MASS_KG) ** 0.5
    history = bounce(kelvin_voigt_drive(kn_n_per_m=KN, dashpot_n_s_per_m=dashpot))
    assert history.velocity_mps[-1, 1] == pytest.approx(restitution, abs=0.01)
    assert history.normal_n.min() >= -1e-6  # no tension
    lost = 0.5 * MASS_KG * (1.0 - history.velocity_mps[-1, 1] ** 2)
    # The work on the normal spring is what the mass lost; trapezoid at 60 steps per contact.
    assert history.ledger.normal_work_j == pytest.approx(lost, rel=0.02)


@pytest.mark.parametrize("restitution", [0.45, 0.6, 0.71, 0.9])
@pytest.mark.parametrize(("stiffness", "exponent"), [(1e7, 1.0), (3e8, 1.5)])
def test_hunt_crossley_in_a_live_unit(restitution, stiffness, exponent):
    drive = hunt_crossley_drive(
        stiffness_n_per_m_p=stiffness,
        exponent=exponent,
        damping=hunt_crossley_damping(restitution),
    )
    assert bounce(drive).velocity_mps[-1, 1] == pytest.approx(restitution, abs=0.01)


def test_hertz_contact_reaches_the_depth_of_its_energy():
    history = bounce(power_law_drive(stiffness_n_per_m_p=1e9, exponent=1.5), dt_s=1e-4)
    exact = power_law_penetration(MASS_KG, 1e9, 1.5, 1.0)
    assert history.ledger.max_penetration_m == pytest.approx(exact, rel=5e-3)
    assert history.velocity_mps[-1, 1] == pytest.approx(1.0, rel=5e-3)
    # Johnson (1985): duration 2.9432 depth / speed.
    assert history.ledger.contact_time_s == pytest.approx(2.9432 * exact, rel=0.02)


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_stiffness_by_approach_speed(speed):
    drive = approach_stiffness_drive(kn_n_per_m=KN, reference_speed_mps=1.0, exponent=0.4)
    history = bounce(drive, speed_mps=speed, dt_s=2e-4)
    exact = speed * (MASS_KG / (KN * speed**0.4)) ** 0.5
    assert history.ledger.max_penetration_m == pytest.approx(exact, rel=5e-3)


def test_ball_on_a_penalty_under_gravity():
    exact = falling_mass_impact(MASS_KG, KN, 1.0, 9.81)
    assert exact.penetration_m == pytest.approx(0.01102900283638495, rel=1e-12)
    assert exact.contact_s == pytest.approx(0.03337166878868257, rel=1e-12)
    ball = Block(
        mass_kg=MASS_KG,
        kn_n_per_m=KN,
        kt_n_per_m=KN,
        normal_load_n=MASS_KG * 9.81,
        v0_mps=(0.0, -1.0),
        bounces=True,
    )
    history = run_block(ball, 1e-4, 0.05)
    assert -history.position_m[:, 1].min() == pytest.approx(exact.penetration_m, rel=5e-3)
    assert history.normal_n.max() == pytest.approx(110290.0, rel=5e-3)
