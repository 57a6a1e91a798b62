"""Contacts, particle and rigid deck: closed forms B1 to B9 (docs/theory/verification.md), figures.

The studies compare OpenSees with exact values; the tests below check the closed forms by tabulated
values, and what the studies leave out.

B1, B2: Den Hartog (1956), Mechanical Vibrations, and (1931), Transactions ASME 53; Shaw (1986),
Journal of Sound and Vibration 108. B3: Newmark (1965), Geotechnique 15. B4, B5: Schwager and
Poeschel (2007), Granular Matter 9; Goldsmith (1960), Impact; Johnson (1985), Contact Mechanics.
B6, B7: steady radial return. B8: Popp and Stelter (1990), Phil. Trans. A 332. B9: Housner (1963),
BSSA 53."""

from math import atan

import native
import numpy as np
import pytest
from scipy.integrate import quad

from reference_data import reference_table
from skewbridge.contact import ContactSet, drives
from skewbridge.contact import law as contact_law
from skewbridge.errors import InputError
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import SCALE_M, deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck, run_opensees
from skewbridge.verification.registry import TABULATED, run_study
from skewbridge.verification.studies import blocks, rigid_bodies

MASS_KG, KN = 1000.0, 1e7


# Tolerances of the studies: 0.5 % for depths, slips and periods (elastic slip of the penalty, first
# order in the step), 0.01 for restitution, 2 % for uplift and for the belt, whose closed form lets
# friction fall at once where the law takes 0.2 mm/s of slip; in space, forces within 1 % of the
# limit and works within 0.2 %. Elastic springs whose stick point lags a step exceed the limit by
# 1.2 and 3.7 %.
@pytest.mark.parametrize(
    ("name", "count", "disagreeing"),
    [
        ("closed-forms", 16, set()), ("fig1", 21, set()), ("fig4", 19, set()),
        ("fig3", 36, {"elastic, extrapolated", "elastic, lagged"}), ("bridges", 57, set()),
        ("restitution", 18, set()),
    ],
)  # fmt: skip
def test_studies_of_closed_forms_exact_forces_and_hand_values_agree(name, count, disagreeing):
    study = run_study(name)
    assert len(study.comparisons) == count
    assert [row["quantity"] for row in study.comparisons if not row["pass"]] == []
    rows = study.statement_rows()
    assert {row["case"] for row in rows if row["outcome"] != "agrees"} == disagreeing


def test_b3_sine_pulse():
    def base_mps2(t):
        return np.where(t <= 0.5, 0.5 * blocks.TABLE_G_MPS2 * np.sin(4 * np.pi * t), 0.0)

    # Friction, start and end of the first slip, its length, and the final slip of an independent
    # event-driven integration.
    for friction, start, end, slip, final in (
        (0.1, 0.016023554212243735, 0.38014831801740473, -0.11143104347381744, -0.05928),
        (0.2, 0.03274747010861366, 0.32730603263410313, -0.05833153167471515, -0.0051064),
        (0.3, 0.05120819117478336, 0.2803876325106701, -0.024487843156247094, 0.00042046),
        (0.4, 0.07379180882521665, 0.22974047118111543, -0.005833137378280437, 0.0),
    ):
        # Newmark: the block slips from the limit until its speed is that of the base again
        w, limit = 4.0 * np.pi, friction * blocks.TABLE_G_MPS2
        amplitude, duration = 0.5 * blocks.TABLE_G_MPS2, end - start
        assert amplitude * np.sin(w * start) == pytest.approx(limit)
        turn = np.cos(w * end) - np.cos(w * start)
        assert limit * duration + amplitude / w * turn == pytest.approx(0.0, abs=1e-12)
        wave = (np.sin(w * end) - np.sin(w * start)) / w - np.cos(w * start) * duration
        assert limit * duration**2 / 2.0 + amplitude / w * wave == pytest.approx(slip, rel=1e-9)
        name = f"sliding block, sine pulse, friction {friction}: slip (m)"
        assert float(TABULATED["fig1", name]["reference"]) == pytest.approx(slip, rel=1e-9)
        history = blocks.run_block(blocks.sliding_block(friction), 2e-4, 1.0, base_mps2=base_mps2)
        # The way back starts from rest under a small excess: 0.5 mm for the elastic slip.
        assert history.q[-1, 0] == pytest.approx(final, abs=5e-4)
        # Kinetic energy is zero at both ends, so friction took what the base gave.
        assert history.ledgers[0].slip_work_j > 0.0


def test_b4_clipped_restitution_is_tabulated_and_takes_the_energy_that_the_mass_loses():
    # Restitution, textbook damping ratio, restitution of that ratio when clipped, the ratio needed.
    for restitution, textbook, clipped, needed in (
        (0.45, 0.24634, 0.5107, 0.30096), (0.5, 0.21545, 0.5503, 0.25528),
        (0.6, 0.16049, 0.6323, 0.18086), (0.65, 0.13585, 0.6748, 0.14994),
        (0.71, 0.10838, 0.7270, 0.11701), (0.8, 0.07085, 0.8081, 0.07436),
        (0.9, 0.03352, 0.9020, 0.03427),
    ):  # fmt: skip
        assert drives.kelvin_voigt_restitution(textbook) == pytest.approx(clipped, abs=1e-4)
        assert drives.kelvin_voigt_damping_ratio(restitution) == pytest.approx(needed, abs=1e-5)
    near = [drives.kelvin_voigt_restitution(z) for z in (0.9999, 1.0, 1.0001)]
    assert near == pytest.approx([near[1]] * 3, abs=1e-3)
    large = drives.kelvin_voigt_damping_ratio(0.1)
    assert large > 1.0
    assert drives.kelvin_voigt_restitution(large) == pytest.approx(0.1)
    for restitution in (0.0, -0.1, 1.1):
        with pytest.raises(InputError, match="restitution"):
            drives.kelvin_voigt_damping_ratio(restitution)
    dashpot = 2.0 * drives.kelvin_voigt_damping_ratio(0.45) * (KN * MASS_KG) ** 0.5
    history = blocks.bounce(drives.kelvin_voigt_drive(kn_n_per_m=KN, dashpot_n_s_per_m=dashpot))
    lost = 0.5 * MASS_KG * (1.0 - history.v[-1, 1] ** 2)
    # trapezoid at 60 steps per contact
    assert history.ledgers[0].normal_work_j == pytest.approx(lost, rel=0.02)


def test_b6_only_componentwise_lagged_yields_stay_wrong_at_small_steps():
    path = unit.circle(0.2, rows_per_loop=4000)
    turned = 2 * np.pi * path[:, 0] / 4.0
    for scheme, coupling, lag, tolerance in (
        ("vector", "extrapolated", 13.0, 0.2),
        ("vector", "lagged", 13.0, 0.2),
        ("elastic", "extrapolated", 13.0, 0.2),
        ("componentwise", "lagged", 25.4, 0.6),  # varies around the circle; the others are steady
    ):
        options = {"substeps": 1, "scheme": scheme, "coupling": coupling}
        forces = unit.drive_unit(unit.PAPER_LAW, path, **options).forces_n
        # of the force behind the velocity, whose direction is known, in the last loop
        found = turned - np.unwrap(np.arctan2(forces[:, 1], forces[:, 0]))
        found_deg = np.degrees(np.median(np.angle(np.exp(1j * found[len(path) // 2 :]))))
        assert found_deg == pytest.approx(lag, abs=tolerance), scheme


@pytest.mark.parametrize(("b", "h"), [(0.25, 1.0), (0.5, 1.5)])
def test_b9_quarter_period_is_the_fall_of_the_energy_equation(b, h):
    alpha = atan(b / h)
    rate2 = 1.5 * blocks.TABLE_G_MPS2 / np.hypot(b, h)

    def slowness(s):  # angle = alpha / 2 sin(s) removes the singularity of 1 / speed
        fall = np.cos(alpha / 2.0) - np.cos(alpha - alpha / 2.0 * np.sin(s))
        return alpha / 2.0 * np.cos(s) / np.sqrt(rate2 * fall)

    name = f"block {b} x {h} m: quarter period of rocking (s)"
    exact_s, _ = quad(slowness, 0.0, np.pi / 2.0)
    assert float(TABULATED["fig1", name]["reference"]) == pytest.approx(exact_s, rel=1e-6)


def test_b9_pushed_block_slides_by_the_excess_of_the_acceleration():
    rate, friction = 1.2, 0.2

    def push_mps2(t):
        return rate * np.maximum(0.0, t - 1.0)

    history = blocks.run_upright((0.25, 1.0), 1e-3, 4.0, friction=friction, base_mps2=push_mps2)
    # From friction x g on, the excess of the acceleration grows linearly.
    sliding_s = 3.0 - friction * blocks.TABLE_G_MPS2 / rate
    assert abs(history.q[-1, 3]) == pytest.approx(rate * sliding_s**3 / 6.0, rel=0.02)


def test_contact_checks_fail_with_a_fault_in_friction(monkeypatch):
    """That they pass without one is in `faults/test_bad_files.py`, as a command."""
    prepared, limit_n = ContactSet.__init__, contact_law.friction_limit_n
    half = (contact_law, "friction_limit_n", lambda *given: 0.5 * limit_n(*given))
    late = (ContactSet, "__init__", lambda *a, **k: prepared(*a, **k | {"update": False}))
    for fault, words in ((half, ("",)), (late, ("lag", "work"))):
        with monkeypatch.context() as patch:
            patch.setattr(*fault)
            failed = run_study("gate").table().query("not `pass`")["quantity"]
        assert any(word in quantity for quantity in failed for word in words)


def test_native_element_converges_to_our_frictional_deck():
    """Its friction is of first order in the step: the difference halves with it."""
    ours = run_deck(deck_case("C5", duration_s=0.5))
    errors = []
    for dt_s in (4e-4, 1e-4):
        t_s, q = native.run_native_deck("C5", native.IMPLICIT, dt_s)
        errors.append(np.abs(np.interp(ours.t_s, t_s, q[:, 1]) - ours.q[:, 1]).max())
    assert errors[1] < 0.45 * errors[0]
    assert errors[1] < 0.05 * np.abs(ours.q[:, 1]).max()


def test_newmark_gains_and_loses_energy_at_impact_as_without_opensees():
    # mean, least and largest restitution of an integration without OpenSees
    for step, mean, ends in ((1.0, 1.0056, (0.9037, 1.1076)), (2.0, 1.0, (1.0, 1.0))):
        found = blocks.integrator_restitution("newmark", step)
        assert found.mean() == pytest.approx(mean, abs=1e-3)
        assert (found.min(), found.max()) == pytest.approx(ends, abs=0.02)


# the rigid skew deck of Dimitrakopoulos (2011), Engineering Structures 33: cases C1 to C5
def tabulated(start, names):
    return [float(TABULATED["fig5-6", f"{start}: {name}"]["reference"]) for name in names]


def elastic_peaks(name):
    names = ("ux_m", "uy_m", "theta_rad", "penetration_m")
    return tabulated(f"{name} elastic, OpenSees", [f"peak {key}" for key in names])


def assert_peaks(history, exact, displacement, rotation):
    *moves_m, theta_rad, _ = history.peaks().values()
    assert moves_m == pytest.approx(exact[:2], rel=displacement)
    assert theta_rad == pytest.approx(exact[2], rel=rotation)


def history_error(history, name, solver, end_s):
    """Largest difference of ux and uy from the tabulated histories up to a time, over the scale."""
    table = reference_table("deck_histories").query("t_s <= @end_s")
    moved = [np.interp(table["t_s"], history.t_s, column) for column in history.q.T[:2]]
    expected = table[[f"{name}_{solver}_{label}" for label in ("ux_m", "uy_m")]].to_numpy().T
    return np.abs(moved - expected).max() / SCALE_M


# 1 % for displacements and 2 % for the rotation: two integrations of the same equations, the peaks
# of an elastic contact depend on the phase of its impacts.
@pytest.mark.parametrize("solver", ["opensees", "penalty"])
def test_penalty_peaks_are_tabulated(solver):
    for name in ("C1", "C3"):
        history = run_deck(deck_case(name, solver=solver, duration_s=1.5))
        exact = elastic_peaks(name)
        assert_peaks(history, exact, 0.01, 0.02)
        assert history.peaks()["penetration_m"] == pytest.approx(exact[3], rel=0.01)
        assert history.first_contact_s() == pytest.approx(0.036500, abs=1e-4)
        assert abs(history.energy_residual_ratio) < 1e-4
        if name == "C1":
            assert history_error(history, name, "penalty", 1.5) <= 0.01
    history = run_deck(deck_case("C1", solver=solver, restitution=0.6, duration_s=1.0))
    # Reference with 25577.5 N s/m per corner.
    assert_peaks(history, (20.624e-3, 33.027e-3, 2.6011e-4), 0.01, 0.02)


def test_other_integrators_and_beams_give_the_same_peaks_and_opposite_skews_mirror_them():
    # Houbolt and HHT at w_c dt = 0.014: 1.5 % for what they damp themselves.
    ux_m, _, theta_rad, _ = elastic_peaks("C1")
    for integrator in ("houbolt", "hht"):
        found = run_deck(deck_case("C1", integrator=integrator, duration_s=0.7)).peaks()
        assert found["ux_m"] == pytest.approx(ux_m, rel=0.015), integrator
        assert found["theta_rad"] == pytest.approx(theta_rad, rel=0.015), integrator
    case = deck_case("C3", duration_s=0.6)
    left = run_deck(case)
    beams = run_opensees(case, pulse_of(case), connect=rigid_bodies.perimeter_beams).peaks()
    assert beams == pytest.approx(left.peaks(), rel=2e-3)
    right = run_deck(deck_case("C3", skew_deg=-30.0, duration_s=0.6))
    assert right.q * [1, -1, -1] == pytest.approx(left.q, abs=1e-9)
    assert right.normals_n == pytest.approx(left.normals_n, abs=1e-3)


@pytest.mark.parametrize("name", ["C2", "C5"])
def test_frictional_decks_agree_with_the_penalty_equation(name):
    # tan(skew) exceeds the friction by 0.38 or more; step x contact frequency is 0.014.
    exact = run_deck(deck_case(name, solver="penalty", duration_s=1.0)).peaks()
    assert_peaks(run_deck(deck_case(name, duration_s=1.0)), [*exact.values()], 0.01, 0.02)


@pytest.mark.parametrize(
    ("name", "restitution"),
    [("C1", 0.6), ("C1", 0.45), ("C2", 0.6), ("C3", 0.6), ("C4", 0.6), ("C5", 0.6)],
)
def test_moreau_jean_meets_the_tabulated_peaks_and_histories(name, restitution):
    history = run_deck(deck_case(name, solver="lcp", restitution=restitution, duration_s=1.2))
    over_scale = np.array([*history.peaks().values()])[:3] * (1.0, 1.0, 30.0) / SCALE_M
    names = [f"peak {name} over scale" for name in ("ux", "uy", "theta x length")]
    exact = tabulated(f"{name} LCP, restitution {restitution:g}", names)
    assert over_scale == pytest.approx(exact, rel=1e-3, abs=1e-9)
    assert abs(history.energy_residual_ratio) < 1e-9
    if restitution == 0.6 and name != "C4":  # first order in the step: 0.2 %
        assert history_error(history, name, "lcp", 1.0) <= 2e-3


def test_a_damped_penalty_deck_that_cannot_rotate_converges_to_the_rigid_one():
    table = rigid_bodies.locked_rotation((1e3, 1e4))
    # Reference values 0.0490 and 0.0136: the rate is that of the penalty, not of the step.
    assert table["rms_ratio"].to_numpy() == pytest.approx([0.049, 0.0136], rel=0.1)
    assert table["first_contact_s"].to_numpy() == pytest.approx(0.0365, abs=1e-3)


def test_moreau_jean_always_finds_a_contact_state_that_conserves_energy():
    names = ("gap_normal_m", "friction", "cohesion_n", "restitution")
    for values in (
        (0.0, 0.8, 0.0, 0.5), (0.0, 0.05, 200.0, 0.9), (1e-3, 0.65, 0.0, 0.3),
        (7e-5, 0.97, 0.0, 0.6), (3e-4, 0.001, 200.0, 0.8),
    ):  # fmt: skip
        given = dict(zip(names, values, strict=True))
        history = run_deck(deck_case("C3", solver="lcp", duration_s=0.15, **given))
        assert abs(history.energy_residual_ratio) < 1e-9, given
        assert history.openings_m.min() > -1e-5, given
        assert history.first_contact_s() <= history.t_s[np.argmax(history.normals_n.any(axis=1))]
        limit = given["friction"] * history.normals_n.sum(axis=1) + 4.0 * given["cohesion_n"]
        assert (np.abs(history.tangentials_n.sum(axis=1)) <= limit * (1 + 1e-6) + 1e-6).all()
