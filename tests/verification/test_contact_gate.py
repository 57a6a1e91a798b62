"""The contact checks before every study, other contact elements, and integrators at impact."""

import native
import numpy as np
import openseespy.opensees as ops
import pytest

from skewbridge.contact import ContactSet
from skewbridge.contact import law as contact_law
from skewbridge.verification.references import driven_unit as unit
from skewbridge.verification.references.cases import deck_case
from skewbridge.verification.references.deck_solvers import run_deck
from skewbridge.verification.references.driven_unit import drive_unit, path_work_j
from skewbridge.verification.references.live_model import clean_domain
from skewbridge.verification.studies.blocks import (
    integrator_restitution,
    path_error,
    verify_contact_gate,
)

IMPLEX = 1  # integration of the native element


def test_contact_checks_pass():
    table = verify_contact_gate()
    assert table.loc[~table["pass"], "quantity"].tolist() == []
    assert len(table) >= 15


def test_contact_checks_fail_with_a_fault_in_friction(monkeypatch):
    prepared, limit_n = ContactSet.__init__, contact_law.friction_limit_n
    for place, name, fault, words in (
        (contact_law, "friction_limit_n", lambda *given: 0.5 * limit_n(*given), ("",)),
        (
            ContactSet,
            "__init__",
            lambda *a, **k: prepared(*a, **k | {"update": False}),
            ("lag", "work"),
        ),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(place, name, fault)
            failed = verify_contact_gate().query("not `pass`")["quantity"]
        assert any(word in quantity for quantity in failed for word in words)


def curved_path(rows_per_period):
    """A smooth path in space that opens and closes."""
    t = np.linspace(0.0, 2.0, 2 * rows_per_period + 1)
    x, y = 0.5 * np.sin(2.0 * np.pi * t), 0.4 * np.sin(4.0 * np.pi * t + 0.7) - 0.4 * np.sin(0.7)
    return np.column_stack([t, x, y, 0.03 - 0.08 * np.sin(np.pi * t + 0.4)])


def driven_native(law, path, integration, substeps):
    """Forces of the native element along a path, as in `PathResult`."""
    forces = np.zeros((len(path), 3))
    with clean_domain(3, 3):
        unit.support_nodes(law.gap_m)
        native.native_contact(2, (unit.SURFACE, unit.BODY), law, (0.0, 0.0, 1.0), integration)
        unit.drive_body(path, system="FullGeneral")
        ops.analyze(1)
        ops.integrator("LoadControl", 1.0 / substeps)
        for row in range(1, len(path)):
            ops.analyze(substeps)
            fx, fy, fz = ops.eleForce(2)[3:6]
            forces[row] = (fx, fy, -fz)
    return forces


@pytest.mark.parametrize("integration", [native.IMPLICIT, IMPLEX])
def test_native_element_gives_the_same_forces_on_a_path(integration):
    path = curved_path(400)
    law = contact_law.ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3)
    ours = drive_unit(law, path, substeps=10).forces_n
    theirs = driven_native(law, path, integration, substeps=10)
    limit = 0.3 * ours[:, 2].max()
    assert np.sqrt(np.mean(np.sum((ours - theirs) ** 2, axis=1))) <= 0.01 * limit
    assert path_work_j(path, ours) == pytest.approx(path_work_j(path, theirs), rel=2e-3)


def test_native_element_converges_to_our_frictional_deck():
    """Its friction is of first order in the step: the difference halves with it."""
    case = deck_case("C5", duration_s=0.5)
    ours = run_deck(case)
    errors = []
    for dt_s in (4e-4, 1e-4):
        t_s, q = native.run_native_deck("C5", native.IMPLICIT, dt_s)
        found = np.interp(ours.t_s, t_s, q[:, 1])
        errors.append(np.abs(found - ours.q[:, 1]).max())
    assert errors[1] < 0.45 * errors[0]
    assert errors[1] < 0.05 * np.abs(ours.q[:, 1]).max()


@pytest.mark.parametrize("coupling", ["extrapolated", "lagged"])
def test_both_couplings_are_of_first_order_on_a_path_that_stays_closed(coupling):
    errors = [path_error(rows, coupling, "closed") for rows in (250, 1000)]
    assert np.log(errors[0] / errors[1]) / np.log(4.0) >= 0.9
    if coupling == "extrapolated":
        assert errors[1] <= 0.012


def test_integrators_lose_energy_at_impact_as_without_opensees():
    # Means of Houbolt and Newmark, least and largest of Newmark: own integration without OpenSees.
    for step, houbolt_mean, newmark_mean, ends in (
        (0.1, 0.9984, 1.0000, (0.9988, 1.0012)),
        (0.5, 0.9255, 1.0004, (0.9712, 1.0286)),
        (1.0, 0.7947, 1.0056, (0.9037, 1.1076)),
        (2.0, 0.6525, 1.0000, (1.0000, 1.0000)),
    ):
        # Houbolt depends on how it is started before the impact: 0.01; Newmark is one-step.
        houbolt = integrator_restitution("houbolt", step)
        assert houbolt.mean() == pytest.approx(houbolt_mean, abs=0.01)
        newmark = integrator_restitution("newmark", step)
        assert newmark.mean() == pytest.approx(newmark_mean, abs=1e-3)
        assert (newmark.min(), newmark.max()) == pytest.approx(ends, abs=0.02)
