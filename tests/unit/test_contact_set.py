"""A contact set on small live domains: one mass between fixed nodes."""

from math import cos, radians, sin

import openseespy.opensees as ops
import pytest

from skewbridge.contact import ContactError, ContactSet
from skewbridge.errors import InputError
from skewbridge.verification.references.live_model import Solver

MASS_KG = 1000.0
DT_S = 1e-3


@pytest.fixture(autouse=True)
def domain():
    ops.wipe()
    yield
    ops.wipe()


def sliding_mass(ndm, ndf, normal, velocity, mass_kg=MASS_KG, gap_m=0.0, **options):
    """A mass that touches a wall under a constant force and slides: deceleration mu N / m."""
    ops.model("basic", "-ndm", ndm, "-ndf", ndf)
    origin = [0.0] * ndm
    ops.node(1, *origin)
    ops.node(2, *origin)
    ops.fix(1, *[1] * ndf)
    rotations = ndf - ndm
    ops.fix(2, *[0] * ndm, *[1] * rotations)
    ops.mass(2, *[mass_kg] * ndm, *[0.0] * rotations)
    contacts = ContactSet(**options)
    contacts.add(1, 2, normal, gap_m, 0.2, kn=1e4 * mass_kg, kt=1e4 * mass_kg)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, *[-mass_kg * 9.81 * n for n in normal], *[0.0] * rotations)
    for dof, value in enumerate(velocity, start=1):
        ops.setNodeVel(2, dof, value, "-commit")
        # Start in equilibrium along the normal.
        ops.setNodeDisp(2, dof, -9.81 / 1e4 * normal[dof - 1], "-commit")
    Solver(constraints="Plain", algorithm="Newton").prepare()
    return contacts


def advance(contacts, steps, dt_s=DT_S):
    for _ in range(steps):
        assert ops.analyze(1, dt_s) == 0
        contacts.after_step(dt_s)


@pytest.mark.parametrize(
    ("ndm", "ndf", "normal", "velocity", "mass_kg"),
    [
        (2, 2, (0.0, 1.0), (1.0, 0.0), MASS_KG),
        (2, 3, (-sin(0.5), cos(0.5)), (cos(0.5), sin(0.5)), MASS_KG),
        (3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.0), 0.01),  # forces below 1 N
        (3, 6, (cos(0.3), sin(0.3), 0.0), (-0.6 * sin(0.3), 0.6 * cos(0.3), 0.8), MASS_KG),
    ],
)
def test_sliding_mass_stops_after_the_coulomb_distance(ndm, ndf, normal, velocity, mass_kg):
    contacts = sliding_mass(ndm, ndf, normal, velocity, mass_kg)
    advance(contacts, 1)
    contacts.start_from_rest()
    advance(contacts, 799)
    slid = sum(v * ops.nodeDisp(2, dof) for dof, v in enumerate(velocity, start=1))
    # v^2 / (2 mu g); the friction spring adds its elastic slip mu N / kt, the first step starts
    # without friction.
    assert slid == pytest.approx(1.0 / (2 * 0.2 * 9.81), rel=5e-3)
    ledger = contacts.ledger()[0]
    assert ledger.slip_work_j == pytest.approx(0.5 * mass_kg, rel=5e-3)
    assert ledger.cone_violation_ratio < 1e-9
    assert ledger.closures == 1


def test_no_friction_is_the_same_with_and_without_updates():
    histories = []
    for update in (True, False):
        ops.wipe()
        contacts = sliding_mass(3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.1), update=update)
        contacts.units[0].friction = 0.0
        history = []
        for _ in range(200):
            advance(contacts, 1)
            history.append(tuple(ops.nodeDisp(2)))
        histories.append(history)
    assert histories[0] == histories[1]


def test_force_on_the_body_opposes_penetration_and_slip():
    contacts = sliding_mass(3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.0))
    advance(contacts, 50)
    fx, fy, fz = contacts.global_force_on_j(0)
    assert fz == pytest.approx(MASS_KG * 9.81, rel=1e-3)
    assert (fx, fy) == pytest.approx((-0.6 * 0.2 * fz, -0.8 * 0.2 * fz), rel=2e-3)


def test_opening_and_closing_are_counted_and_reported():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.5))
    changes = expected_changes = 0
    for _ in range(400):
        expected = contacts.time_to_change_s() < DT_S
        advance(contacts, 1)
        changes += len(contacts.changes)
        expected_changes += expected and len(contacts.changes)
    assert changes >= 3
    assert expected_changes >= changes - 2  # linear in time: not every one is foreseen
    assert contacts.ledger()[0].closures >= 2
    assert contacts.ledger()[0].contact_time_s < 0.4


def test_a_gap_that_is_open_at_rest_is_open_and_closes_once():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.0), gap_m=0.02)
    contacts.start_from_rest()
    assert not contacts.closed[0]
    # 0.02 m under g take 64 ms
    advance(contacts, 60)
    assert contacts.ledger()[0].closures == 0
    advance(contacts, 10)
    assert contacts.ledger()[0].closures == 1


@pytest.mark.parametrize("scheme", ["vector", "componentwise", "elastic"])
def test_snapshot_brings_the_tracked_state_back(scheme):
    contacts = sliding_mass(3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.0), scheme=scheme)
    advance(contacts, 20)
    saved = contacts.snapshot()
    before = (contacts.state(0), contacts.ledger())
    advance(contacts, 20)
    assert contacts.state(0) != before[0]
    contacts.restore(saved)
    assert (contacts.state(0), contacts.ledger()) == before


def test_preparing_another_step_length_changes_the_predicted_bound():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, -0.2))
    advance(contacts, 3)
    parameter = contacts.units[0].springs.bounds[0]
    full = ops.getParamValue(parameter)
    contacts.prepare(DT_S / 4)
    assert 0.0 < ops.getParamValue(parameter) < full


def test_soft_tangents_free_the_mode_along_the_surface():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.0))
    stiff = min(ops.eigen("-fullGenLapack", 2))
    with contacts.soft_tangents():
        soft = min(ops.eigen("-fullGenLapack", 2))
    assert stiff > 1e3
    assert soft < 1e-3
    assert min(ops.eigen("-fullGenLapack", 2)) == pytest.approx(stiff)


def test_a_parameter_set_by_others_is_detected():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, 0.0))
    advance(contacts, 10)
    ops.parameter(999, "element", contacts.units[0].element, "material", 2, "Fy")
    ops.updateParameter(999, 1e9)  # somebody else takes the bound over
    with pytest.raises(ContactError, match="beyond their bounds"):
        advance(contacts, 30)


def test_a_parameter_that_reaches_the_normal_spring_is_detected():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, 0.0))
    advance(contacts, 10)
    ops.parameter(999, "element", contacts.units[0].element, "E")  # reaches the normal spring
    ops.updateParameter(999, 1.0)
    with pytest.raises(ContactError, match="normal spring"):
        advance(contacts, 30)


def test_a_retried_step_continues_as_if_it_had_not_failed():
    """OpenSees goes back after a failed step; so do the bounds, whatever was prepared since."""
    histories = []
    for fails in (False, True):
        ops.wipe()
        contacts = sliding_mass(3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.05))
        history = []
        for step in range(60):
            if fails and step % 7 == 3:
                ops.test("NormDispIncr", 1e-30, 1)
                assert ops.analyze(1, DT_S) != 0
                ops.test("NormDispIncr", 1e-12, 50)
                contacts.prepare(DT_S / 4)
                contacts.prepare(DT_S)
            advance(contacts, 1)
            history.append(ops.nodeDisp(2, 1))
        histories.append(history)
    assert histories[1] == pytest.approx(histories[0], rel=1e-12)


def test_a_contact_added_to_a_deformed_model_starts_with_its_full_gap():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, 0.0))
    advance(contacts, 50)
    later = ContactSet()
    later.add(1, 2, (0.0, 1.0), 0.01, 0.2, kn=1e7, kt=1e7)
    ops.analyze(1, DT_S)
    later.after_step(DT_S)
    assert later.openings_m[0] == pytest.approx(0.01, abs=1e-6)
    assert not later.closed[0]


def test_gap_closing_reduces_the_gap():
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    ops.node(1, 0.0, 0.0)
    ops.node(2, 0.0, 0.0)
    contacts = ContactSet()
    contacts.add(1, 2, (1.0, 0.0), 0.05, 0.0, kn=1e6, kt=1e6, gap_closing_m=0.02)
    assert contacts.openings_m == pytest.approx([0.03])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"friction": -0.1}, "friction"),
        ({"kt": 0.0}, "kt_n_per_m"),
        ({"kn": float("nan")}, "kn_n_per_m"),
        ({"gap_m": -0.01}, "gap_m"),
        ({"cohesion_n": -1.0}, "cohesion_n"),
        ({"gap_closing_m": 0.2}, "gap_closing_m"),
        ({"normal": (0.0, 0.0)}, "normal"),
        ({"normal": (1.0, 0.0, 0.0)}, "normal"),
        ({"tangent": (1.0, 0.1)}, "perpendicular"),
        ({"tangent": (0.0, -1.0)}, "counter-clockwise"),
        ({"node_j": 7}, "node_j"),
        ({"node_j": 1}, "differ"),
    ],
)
def test_bad_input_names_the_field(change, message):
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    ops.node(1, 0.0, 0.0)
    ops.node(2, 0.0, 0.0)
    arguments = {
        "node_i": 1,
        "node_j": 2,
        "normal": (1.0, 0.0),
        "gap_m": 0.1,
        "friction": 0.3,
        "kn": 1e6,
        "kt": 1e6,
    }
    with pytest.raises(InputError, match=message):
        ContactSet().add(**(arguments | change))


def test_unknown_scheme_or_coupling_is_refused():
    with pytest.raises(InputError, match="scheme"):
        ContactSet(scheme="vectorial")
    with pytest.raises(InputError, match="coupling"):
        ContactSet(coupling="implicit")


def test_two_sets_share_a_domain():
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node in (1, 2, 3):
        ops.node(node, 0.0, 0.0)
    first, second = ContactSet(), ContactSet(scheme="elastic")
    first.add(1, 2, (cos(radians(30)), sin(radians(30))), 0.1, 0.3, kn=1e6, kt=1e6)
    second.add(1, 3, (1.0, 0.0), 0.1, 0.3, kn=1e6, kt=1e6)
    first.add(2, 3, (1.0, 0.0), 0.1, 0.3, kn=1e6, kt=1e6)
    assert len({unit.element for unit in (*first.units, *second.units)}) == 3
