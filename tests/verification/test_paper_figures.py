"""Figures 4 to 6 of the paper: particle between two lines, skew deck."""

import numpy as np
import pytest

from reference_data import reference_table
from skewbridge.verification.references.cases import SCALE_M, deck_case
from skewbridge.verification.references.deck_solvers import pulse_of, run_deck, run_opensees
from skewbridge.verification.registry import TABULATED, Study
from skewbridge.verification.studies import rigid_bodies


def tabulated(study, start, names):
    """References of quantities that begin alike."""
    return [float(TABULATED[study, f"{start}: {name}"]["reference"]) for name in names]


def elastic_peaks(name):
    names = ("ux_m", "uy_m", "theta_rad", "penetration_m")
    return tabulated("fig5-6", f"{name} elastic, OpenSees", [f"peak {key}" for key in names])


@pytest.mark.parametrize("restitution", [0.0, 0.6])
def test_a_particle_meets_the_tabulated_peaks_and_histories(restitution):
    history = rigid_bodies.run_particle_lcp(restitution, 5e-5, 3.0 if restitution else 2.0)
    # First order in h: 2e-3 at 5e-5 s.
    names = [f"peak {key} (m)" for key in ("ux", "uy", "ut")]
    exact = tabulated("fig4", f"LCP, restitution {restitution:g}", names)
    assert [*rigid_bodies.peaks_m(history.q).values()] == pytest.approx(exact, rel=2e-3)
    impulses = (np.abs(values).sum() for values in (history.tangentials_n, history.normals_n))
    assert np.divide(*impulses) == pytest.approx(0.1, rel=1e-6)
    if not restitution:
        return
    reference = reference_table("particle_history")
    found = np.interp(reference["t_s"], history.t_s, history.q @ rigid_bodies.NORMAL)
    error = np.sqrt(np.mean((found - reference["un_m"].to_numpy()) ** 2))
    assert error <= 0.01 * 0.0268
    outside = np.flatnonzero(history.normals_n.sum(axis=1) > 0.0)[0]
    first_s = tabulated("fig4", "OpenSees", ["first contact (s)"])
    assert history.t_s[outside] == pytest.approx(*first_s, abs=1e-4)
    # the penalty particle stays between the lines and near the rigid one
    study = Study("fig4")
    rigid_bodies.compare_with_lcp(study, rigid_bodies.run_particle(5e-5, 2.0), history)
    assert [row["quantity"] for row in study.comparisons if not row["pass"]] == []


# --- the rigid skew deck of Dimitrakopoulos (2011), Engineering Structures 33: cases C1 to C5
def assert_peaks(history, exact, displacement, rotation):
    """Compare the peaks ux, uy, theta with relative tolerances."""
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
    exact = tabulated("fig5-6", f"{name} LCP, restitution {restitution:g}", names)
    assert over_scale == pytest.approx(exact, rel=1e-3, abs=1e-9)
    assert abs(history.energy_residual_ratio) < 1e-9
    if restitution == 0.6 and name != "C4":  # first order in the step: 0.2 %
        assert history_error(history, name, "lcp", 1.0) <= 2e-3


def test_a_damped_penalty_deck_that_cannot_rotate_converges_to_the_rigid_one():
    table = rigid_bodies.locked_rotation((1e3, 1e4))
    # Reference values 0.0490 and 0.0136: the rate is that of the penalty, not of the step.
    assert table["rms_ratio"].to_numpy() == pytest.approx([0.049, 0.0136], rel=0.1)
    assert table["first_contact_s"].to_numpy() == pytest.approx(0.0365, abs=1e-3)


def test_moreau_jean_always_finds_a_contact_state():
    """Sticking, chattering and both ends at once: the balance of energy closes."""
    names = ("gap_normal_m", "friction", "cohesion_n", "restitution")
    for values in (
        (0.0, 0.8, 0.0, 0.5), (0.0, 0.05, 200.0, 0.9), (1e-3, 0.65, 0.0, 0.3),
        (7e-5, 0.97, 0.0, 0.6), (3e-4, 0.001, 200.0, 0.8),
    ):  # fmt: skip
        given = dict(zip(names, values, strict=True))
        history = run_deck(deck_case("C3", solver="lcp", duration_s=0.15, **given))
        assert abs(history.energy_residual_ratio) < 1e-9, given
        assert history.openings_m.min() > -1e-5, given
        limit = given["friction"] * history.normals_n.sum(axis=1) + 4.0 * given["cohesion_n"]
        assert (np.abs(history.tangentials_n.sum(axis=1)) <= limit * (1 + 1e-6) + 1e-6).all()
