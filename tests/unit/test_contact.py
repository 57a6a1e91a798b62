"""Contacts: law, frames, parameters and drives; sets on small live domains; sizes of steps."""

import importlib
import sys
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from math import cos, hypot, inf, nan, radians, sin
from types import SimpleNamespace

import numpy as np
import openseespy.opensees as ops
import pytest
from reference_pages import ROOT

from skewbridge import contact
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.step_loop import LONGEST_S, LOOK_AHEAD, SWING_S, StepLoop
from skewbridge.contact import ContactError, ContactSet, Drive, drives, make_step
from skewbridge.contact import element as contact_element
from skewbridge.contact.element import contact_frame
from skewbridge.contact.law import advance_pair, yields_by_direction, yields_on_cone
from skewbridge.errors import InputError
from skewbridge.verification.references.live_model import prepare_analysis
from skewbridge.verification.studies.blocks import Block, run_block

MASS_KG = 1000.0
DT_S = 1e-3
STIFF = {"kn": 1e6, "kt": 1e6}
LAW = contact.ContactLaw(kn_n_per_m=1e5, kt_n_per_m=1e5, friction=0.3, cohesion_n=1500.0)


@pytest.fixture(autouse=True)
def domain():
    ops.wipe()
    yield
    ops.wipe()


def nodes_at_one_place(ndm, ndf, count=2):
    ops.wipe()
    ops.model("basic", "-ndm", ndm, "-ndf", ndf)
    for node in range(1, count + 1):
        ops.node(node, *[0.0] * ndm)


def sliding_mass(ndm, ndf, normal, velocity, mass_kg=MASS_KG, gap_m=0.0, scheme="vector"):
    """A mass that touches a wall under a constant force and slides: deceleration mu N / m."""
    nodes_at_one_place(ndm, ndf)
    ops.fix(1, *[1] * ndf)
    rotations = ndf - ndm
    ops.fix(2, *[0] * ndm, *[1] * rotations)
    ops.mass(2, *[mass_kg] * ndm, *[0.0] * rotations)
    contacts = ContactSet(scheme=scheme)
    contacts.add(1, 2, normal, gap_m, 0.2, kn=1e4 * mass_kg, kt=1e4 * mass_kg)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, *[-mass_kg * 9.81 * n for n in normal], *[0.0] * rotations)
    for dof, value in enumerate(velocity, start=1):
        ops.setNodeVel(2, dof, value, "-commit")
        ops.setNodeDisp(2, dof, -9.81 / 1e4 * normal[dof - 1], "-commit")  # in equilibrium
    prepare_analysis(constraints="Plain", algorithm="Newton")
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
    advance(contacts, 49)
    # the force on the body opposes penetration and slip
    weight_n = 9.81 * mass_kg
    expected_n = [weight_n * (n - 0.2 * v) for n, v in zip(normal, velocity, strict=True)]
    assert contacts.global_force_on_j(0) == pytest.approx(expected_n, rel=3e-3, abs=1e-6 * weight_n)
    advance(contacts, 750)
    slid = sum(v * ops.nodeDisp(2, dof) for dof, v in enumerate(velocity, start=1))
    # v^2 / (2 mu g), plus the elastic slip mu N / kt and a first step without friction
    assert slid == pytest.approx(1.0 / (2 * 0.2 * 9.81), rel=5e-3)
    ledger = contacts.ledger()[0]
    assert ledger.slip_work_j == pytest.approx(0.5 * mass_kg, rel=5e-3)
    assert (ledger.closures, ledger.cone_violation_ratio < 1e-9) == (1, True)


@pytest.mark.parametrize(("ndm", "push"), [(2, (1.0, 0.0)), (3, (0.6, 0.8, 0.0))])
def test_a_block_pushed_by_static_steps_slides_only_above_its_friction_limit(ndm, push):
    moved_m = []
    for push_n in (0.98 * 1962.0, 1.10 * 1962.0):  # mu m g = 1962 N
        contacts = sliding_mass(ndm, ndm, (0.0, 0.0, 1.0)[-ndm:], (0.1,) * ndm)
        contacts.start_from_rest()  # as after a transient, whose velocities remain
        ops.uniaxialMaterial("Elastic", 1, 10.0 * MASS_KG)  # support, a thousandth of the contact
        ops.element("zeroLength", 999, 1, 2, *["-mat", *[1] * (ndm - 1), "-dir", *range(1, ndm)])
        # after a second, in four steps; then constant
        ops.timeSeries("Path", 2, "-time", 0, 1, 2, 9, "-values", 0.0, 0.0, push_n, push_n)
        ops.pattern("Plain", 2, 2)
        ops.load(2, *push)
        ops.wipeAnalysis()
        prepare_analysis(integrator=("LoadControl", 0.25), analysis="Static")
        advance(contacts, 28)
        moved_m.append(hypot(*ops.nodeDisp(2)[: ndm - 1]))
    assert moved_m[0] == pytest.approx(0.98 * 1962.0 / (10_010.0 * MASS_KG), rel=1e-9)
    assert moved_m[1] > 0.999 * 0.1 * 1962.0 / (10.0 * MASS_KG)


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


def test_a_gap_closes_once_in_a_fall_and_the_opening_ratio_is_zero_without_a_gap():
    falling = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.0), gap_m=0.02)
    falling.start_from_rest()
    advance(falling, 40)
    # it starts 9.81 / 1e4 m below its place and falls for 40 ms
    opening_m = 0.02 - 9.81 / 1e4 - 9.81 * 0.040**2 / 2
    assert falling.least_opening_ratio == pytest.approx(opening_m / 0.02, rel=0.02)
    advance(falling, 20)  # 0.02 m take 64 ms
    assert falling.ledger()[0].closures == 0
    advance(falling, 10)
    assert falling.ledger()[0].closures == 1
    thrown = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.5))
    advance(thrown, 40)
    # open by 0.5 t - g t^2 / 2, but without a gap it may close at any time: steps stay short
    assert thrown.openings_m[0] == pytest.approx(0.5 * 0.040 - 9.81 * 0.040**2 / 2, rel=0.1)
    assert thrown.least_opening_ratio == 0.0


def test_preparing_another_step_length_changes_the_predicted_bound():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, -0.2))
    advance(contacts, 3)
    parameter = contacts.units[0].springs.bounds[0]
    full = ops.getParamValue(parameter)
    contacts.prepare(DT_S / 4)
    assert 0.0 < ops.getParamValue(parameter) < full


@pytest.mark.parametrize("scheme", ["vector", "componentwise", "elastic"])
def test_a_pair_that_opened_without_slip_has_no_friction(scheme):
    contacts = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.5), scheme=scheme)
    advance(contacts, 10)
    ops.setNodeVel(2, 1, 1.0, "-commit")
    ops.domainChange()  # the integrator reads the new velocity
    advance(contacts, 10)
    assert ops.nodeVel(2, 1) == pytest.approx(1.0)
    assert ops.eleResponse(contacts.units[0].element, "force")[0] == 0.0


def test_soft_tangents_free_the_mode_along_the_surface():
    contacts = sliding_mass(2, 2, (0.0, 1.0), (0.0, 0.0))
    stiff = min(ops.eigen("-fullGenLapack", 2))
    with contacts.soft_tangents():
        soft = min(ops.eigen("-fullGenLapack", 2))
    assert soft < 1e-3 < 1e3 < stiff
    assert min(ops.eigen("-fullGenLapack", 2)) == pytest.approx(stiff)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("material", 2, "Fy"), 1e9, "outside their bounds"),  # another bound of the friction
        (("E",), 1.0, "normal spring"),  # the short form reaches the normal spring
    ],
)
def test_a_parameter_set_by_others_is_detected(place, value, message):
    contacts = sliding_mass(2, 2, (0.0, 1.0), (1.0, 0.0))
    advance(contacts, 10)
    ops.parameter(999, "element", contacts.units[0].element, *place)
    ops.updateParameter(999, value)
    with pytest.raises(ContactError, match=message):
        advance(contacts, 30)


def test_a_retried_step_continues_as_if_it_had_not_failed():
    def history_m(*, fails):
        contacts = sliding_mass(3, 3, (0.0, 0.0, 1.0), (0.6, 0.8, 0.05))
        for step in range(60):
            if fails and step % 7 == 3:
                ops.test("NormDispIncr", 1e-30, 1)
                assert ops.analyze(1, DT_S) != 0
                ops.test("NormDispIncr", 1e-12, 50)
                contacts.prepare(DT_S / 4)
                contacts.prepare(DT_S)
            advance(contacts, 1)
            yield ops.nodeDisp(2, 1)

    assert [*history_m(fails=True)] == pytest.approx([*history_m(fails=False)], rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"friction": -0.1}, "friction"), ({"kt": 0.0}, "kt_n_per_m"), ({"kn": nan}, "kn_n_per_m"),
        ({"gap_m": -0.01}, "gap_m"), ({"cohesion_n": -1.0}, "cohesion_n"),
        ({"normal": (0.0, 0.0)}, "normal"), ({"normal": (1.0, 0.0, 0.0)}, "normal"),
        ({"tangent": (1.0, 0.1)}, "perpendicular"), ({"tangent": (0.0, -1.0)}, "counter-clockwise"),
        ({"node_j": 7}, "node_j"), ({"node_j": 1}, "differ"), ({"scheme": "vectorial"}, "scheme"),
        ({"coupling": "implicit"}, "coupling"),
    ],
)  # fmt: skip
def test_bad_input_names_the_field(change, message):
    nodes_at_one_place(2, 2)
    good = {"node_i": 1, "node_j": 2, "normal": (1.0, 0.0), "gap_m": 0.1, "friction": 0.3}
    options = {key: change[key] for key in ("scheme", "coupling") if key in change}
    with pytest.raises(InputError, match=message):
        ContactSet(**options).add(**(good | STIFF | change))


def test_the_script_runs_and_both_models_hit_and_slide(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    for ledger in importlib.import_module("contact_in_your_model").main():
        assert ledger.closures >= 1
        assert min(ledger.max_penetration_m, ledger.slip_work_j) > 0.0
        # What the compression of a step differs from its prediction, over the largest limit.
        assert ledger.cone_violation_ratio < 0.02
    for name in ("contact_in_your_model", "foreign_models"):
        sys.modules.pop(name)


def test_stick_points_follow_slip_and_yields_stay_on_the_cone():
    slipped = advance_pair(LAW, (0.0, 0.0), (0.3, 0.4), -0.1)
    assert slipped.is_slipping
    assert hypot(0.3 - slipped.stick_m[0], 0.4 - slipped.stick_m[1]) == pytest.approx(0.045)
    stuck = advance_pair(LAW, (0.0, 0.0), (0.01, 0.02), -0.1)
    assert (stuck.is_slipping, stuck.stick_m) == (False, (0.0, 0.0))
    assert advance_pair(LAW, (0.0, 0.0), (0.3, 0.4), 0.01) == (0.0, (0.0, 0.0), (0.3, 0.4), False)
    first, second = yields_on_cone(-1000.0, 0.0, 4500.0)
    assert (first - 1000.0, hypot(first, second)) == pytest.approx((second, 4500.0))
    assert yields_on_cone(-30e3, 40e3, 4500.0) == pytest.approx((2700.0, 3600.0))
    assert yields_by_direction(-3.0, 4.0, 4500.0) == pytest.approx((2700.0, 3600.0))
    # without a direction
    assert yields_by_direction(0.0, 0.0, 1.0) == pytest.approx((0.5**0.5, 0.5**0.5))
    assert yields_on_cone(0.0, 0.0, 0.0) == (0.0, 0.0)
    # The squares of these forces are zero in floating point.
    assert yields_on_cone(0.0, 2e-313, 8e-291) == (0.0, 2e-313)


def test_frames_are_right_handed_with_horizontal_tangents_or_refused():
    normal = (cos(radians(30)), -sin(radians(30)), 0.4)
    for ndm in (2, 3):
        frame = np.array(contact_frame(normal[:ndm], None, ndm))
        np.testing.assert_allclose(frame @ frame.T, np.eye(ndm), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
    assert frame[1, 2] == pytest.approx(0.0)
    for sign in (1.0, -1.0):
        assert contact_frame((0.0, 0.0, sign), None, 3)[1] == pytest.approx((1.0, 0.0, 0.0))
    assert contact_frame((0.0, 0.0, 1.0), (1.0, 0.0, 1e-6), 3)[1] == pytest.approx((1.0, 0.0, 0.0))
    with pytest.raises(InputError, match="perpendicular"):
        contact_frame((0.0, 0.0, 1.0), (1.0, 0.0, 0.1), 3)
    with pytest.raises(InputError, match="ndm"):
        contact_frame((1.0,), None, 1)


def with_contact(*arguments, **options):
    contacts = ContactSet(*arguments, **options)
    contacts.add(1, 2, (1.0, 0.0, 0.0), 0.05, 0.5, kn=2e9, kt=2e8)
    return contacts


@pytest.mark.parametrize("wrong", ["name", "position", "no position"])
def test_a_parameter_that_does_not_act_is_noticed(monkeypatch, wrong):
    nodes_at_one_place(3, 6)
    attach = contact_element._attach

    def attach_wrongly(tags, element, position, name):
        if name != "Fy" or (wrong == "no position" and position == 1):
            return attach(tags, element, position, name)
        if wrong != "no position":
            return attach(tags, element, *((position, "Fyield") if wrong == "name" else (1, name)))
        parameter = tags.parameter()  # the short form of OpenSees reaches the normal spring, too
        ops.parameter(parameter, "element", element, name)
        return parameter

    monkeypatch.setattr(contact_element, "_attach", attach_wrongly)
    with pytest.raises(ContactError, match="does not act"):
        with_contact()


def test_tags_of_the_user_are_left_alone_or_used():
    nodes_at_one_place(3, 6)
    ops.uniaxialMaterial("Elastic", 7, 1.0)
    ops.element("zeroLength", 40, 1, 2, "-mat", 7, "-dir", 1)
    ops.parameter(12, "element", 40, "material", 1, "E")
    (unit,) = with_contact(contact.TagSource()).units
    assert (unit.element > 40, min(unit.springs.bounds) > 12) == (True, True)
    ops.remove("element", unit.element)  # its materials remain
    with_contact()
    tag = partial(next, count(5001))
    (unit,) = with_contact(SimpleNamespace(element=tag, material=tag, parameter=tag)).units
    assert unit.element > 5000


def pressed_mass(drive):
    """A mass on soft springs, 10 mm before a wall."""
    nodes_at_one_place(2, 2)
    ops.fix(1, 1, 1)
    ops.mass(2, 1.0, 1.0)
    ops.uniaxialMaterial("Elastic", 1, 1.0e3, 60.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, 1, "-dir", 1, 2)
    contacts = ContactSet()
    contacts.add(1, 2, (-1.0, 0.0), 0.010, 0.3, kn=1e6, kt=1e6, drive=drive)
    prepare_analysis(constraints="Plain", algorithm="Newton")
    return contacts


def test_friction_falls_by_wear_along_the_slip_path_and_from_static_to_kinetic():
    def worn(state: contact.UnitState, time_s: float) -> dict[str, float]:
        return {"friction": max(0.1, 0.3 - 0.5 * state.slip_path_m)}

    stiff = {"kn_n_per_m": 1e9, "kt_n_per_m": 1e9, "gap_m": 0.0, "friction": 0.3}
    loads = {"mass_kg": 1000.0, "normal_load_n": 9810.0, "v0_mps": (1.5, 0.0)}
    block = Block(**stiff, **loads, drive=Drive(parameters=("friction",), function=worn))
    slid = run_block(block, 1e-3, 1.4).q[-1, 0]
    # Energy: v^2 / 2 / g = integral of (0.3 - 0.5 s) ds up to 0.4 m, then 0.1 times the rest.
    rest_m = (0.5 * 1.5**2 / 9.81 - (0.3 * 0.4 - 0.25 * 0.4**2)) / 0.1
    assert slid == pytest.approx(0.4 + rest_m, rel=5e-3)
    options = {"static": 0.4, "kinetic": 0.3, "stribeck_speed_mps": 0.01}
    for speed_mps, friction in ((0.0, 0.4), (1.0, 0.3), (0.01, 0.3 + 0.1 * np.exp(-1.0))):
        assert drives.stribeck_friction(speed_mps, **options) == pytest.approx(friction)
    assert drives.stribeck_friction(2.0, **options, viscous_s_per_m=0.05) == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("values", "message"),
    [({"kn_n_per_m": 1.0}, "declared"), ({"friction": -0.1}, "not negative"),
     ({"friction": nan}, "finite")],
)  # fmt: skip
def test_the_values_of_a_drive_are_checked(values, message):
    contacts = pressed_mass(Drive(parameters=("friction",), function=lambda s, t: values))
    with pytest.raises(InputError, match=message):
        make_step(contacts, 1e-3)


def test_impossible_laws_are_refused():
    for make, values in (
        (drives.stribeck_drive, {"static": 0.2, "kinetic": 0.3, "stribeck_speed_mps": 0.01}),
        (drives.stribeck_drive, {"static": 0.4, "kinetic": 0.3, "stribeck_speed_mps": 0.0}),
        (drives.kelvin_voigt_drive, {"kn_n_per_m": 0.0, "dashpot_n_s_per_m": 1.0}),
        (drives.kelvin_voigt_drive, {"kn_n_per_m": 1.0, "dashpot_n_s_per_m": -1.0}),
        (Drive, {"parameters": ("temperature",), "function": lambda state, time_s: {}}),
    ):
        with pytest.raises(InputError):
            make(**values)


def test_a_drive_without_values_changes_nothing_and_a_step_in_parts_ends_at_its_time():
    contacts = pressed_mass(Drive(parameters=("friction",), function=lambda s, t: {}))
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 20.0, 0.0)
    for _ in range(500):
        assert make_step(contacts, 1e-3, parts_on_change=4)
    assert ops.getTime() == pytest.approx(0.5)
    assert contacts.ledger()[0].closures >= 1
    # the springs carry 10 mm of 1 kN/m, the wall the rest of the load
    assert contacts.normals_n[0] == pytest.approx(20.0 - 1.0e3 * 0.010, rel=2e-3)


SETTINGS = AnalysisSettings(dt_s=0.010, contact_dt_s=0.005, event_dt_s=0.0003125)
OPEN_S, CONTACT_S, FINEST_S = 0.010, 0.005, 0.0003125
MUCH, LITTLE, FAIR = 2 * SETTINGS.max_friction_error, 0.0, 0.5 * SETTINGS.max_friction_error


@dataclass
class Contacts:
    """Contacts with prescribed friction errors and changes; records the step sizes."""

    errors: list[float] = field(default_factory=list)  # after each step
    closes_after: int = -1  # number of the step
    time_to_change: float = inf
    is_any_closed: bool = True
    least_opening_ratio = 1.0
    sizes_s: list[float] = field(default_factory=list)

    start_from_rest = prepare = staticmethod(lambda *_: None)  # nothing moves yet

    def after_step(self, dt_s: float) -> None:
        self.sizes_s.append(dt_s)

    def time_to_change_s(self) -> float:
        return self.time_to_change

    def time_to_closing_s(self, accel_mps2: float) -> float:
        return inf

    @property
    def changes(self) -> tuple[int, ...]:
        return (0,) if len(self.sizes_s) == self.closes_after else ()

    @property
    def friction_error(self) -> float:
        number = len(self.sizes_s) - 1
        return self.errors[number] if 0 <= number < len(self.errors) else FAIR


def sizes_s(contacts: Contacts, steps: int, settings: AnalysisSettings = SETTINGS) -> list[float]:
    nodes_at_one_place(1, 1)
    ops.fix(1, 1)
    ops.mass(2, 1.0)
    ops.uniaxialMaterial("Elastic", 1, 1.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
    assert StepLoop(contacts, settings).run(steps, lambda: None).status == "ok"
    assert sum(contacts.sizes_s) == pytest.approx(steps * settings.dt_s)
    return contacts.sizes_s


class Swinging(Contacts):
    least_opening_ratio = property(lambda self: 0.7 if len(self.sizes_s) == 2 else 0.8)

    def time_to_closing_s(self, accel_mps2: float) -> float:
        return 0.0


def test_steps_are_shorter_while_the_deck_swings_and_for_some_time_after() -> None:
    found = sizes_s(Swinging(is_any_closed=False), 40)
    swing = [size for size in found[2:] if size < OPEN_S]
    assert found[: 2 + len(swing)] == [OPEN_S] * 2 + swing
    assert sum(swing) == pytest.approx(SWING_S)


#: Contacts and the sizes of the steps made in three regular steps, s.
CASES = {
    "halved at a large error": (Contacts(errors=[FAIR, MUCH, MUCH, FAIR, MUCH]),
                                [5e-3] * 2 + [2.5e-3, *[1.25e-3] * 2, *[0.625e-3] * 24]),
    "from the finest after a closing": (
        Contacts(closes_after=2, errors=[LITTLE] * 99),
        [5e-3] * 2 + [FINEST_S * parts for parts in (1, 1, 2, 4, 8, 16)] + [5e-3] * 2,
    ),
    "constant at a moderate error": (Contacts(closes_after=2), [5e-3] * 2 + [FINEST_S] * 64),
    "shorter before a change": (
        Contacts(is_any_closed=False, time_to_change=LOOK_AHEAD * 1.3e-3), [1.25e-3] * 24,
    ),
    "longer in the open": (Contacts(is_any_closed=False), [OPEN_S, 2 * OPEN_S]),
    "shorter in contact": (Contacts(), [CONTACT_S] * 6),
}  # fmt: skip


@pytest.mark.parametrize(("contacts", "expected"), CASES.values(), ids=CASES)
def test_steps_follow_closings_and_the_friction_error(contacts, expected) -> None:
    assert sizes_s(contacts, 3) == expected


def test_steps_have_limits_and_are_regular_without_event_steps() -> None:
    # far from closing they are made together; the first ones prove the tangent
    assert max(sizes_s(Contacts(is_any_closed=False), 20)) == pytest.approx(LONGEST_S)
    found = sizes_s(Contacts(errors=[MUCH] * 99), 2)
    assert min(found) == found[-1] == FINEST_S
    plain = AnalysisSettings(dt_s=0.002, contact_dt_s=None, event_dt_s=None)
    contacts = Contacts(errors=[MUCH] * 99, closes_after=1, time_to_change=1e-9)
    assert sizes_s(contacts, 3, plain) == [0.002] * 3
