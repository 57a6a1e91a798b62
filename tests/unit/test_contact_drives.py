"""User functions of state and time that drive the parameters of a contact."""

import numpy as np
import openseespy.opensees as ops
import pytest

from skewbridge.contact import ContactSet, Drive, UnitState, make_step
from skewbridge.contact.drives import (
    approach_stiffness_drive,
    hunt_crossley_drive,
    kelvin_voigt_drive,
    stribeck_drive,
    stribeck_friction,
)
from skewbridge.errors import InputError
from skewbridge.verification.references.blocks import Block, run_block
from skewbridge.verification.references.live_model import Solver


@pytest.fixture(autouse=True)
def domain():
    ops.wipe()
    yield
    ops.wipe()


def season(state: UnitState, time_s: float) -> dict[str, float]:
    """A joint that closes by 20 mm within 1 s while its friction wears off with the slip."""
    return {
        "gap_closing_m": 0.020 * min(1.0, time_s),
        "friction": max(0.1, 0.3 - 0.5 * state.slip_path_m),
    }


def pressed_mass(drive):
    """A mass on soft springs, 10 mm before a wall that comes nearer."""
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    ops.node(1, 0.0, 0.0)
    ops.node(2, 0.0, 0.0)
    ops.fix(1, 1, 1)
    ops.mass(2, 1.0, 1.0)
    ops.uniaxialMaterial("Elastic", 1, 1.0e3, 60.0)
    ops.element("zeroLength", 1, 1, 2, "-mat", 1, 1, "-dir", 1, 2)
    contacts = ContactSet()
    contacts.add(1, 2, (-1.0, 0.0), 0.010, 0.3, kn=1e6, kt=1e6, drive=drive)
    Solver(constraints="Plain", algorithm="Newton").prepare()
    return contacts


def test_a_slow_ramp_closes_the_gap_and_presses():
    contacts = pressed_mass(Drive(parameters=("gap_closing_m", "friction"), function=season))
    contacts.units[0].friction = 0.0
    closed_at = None
    for step in range(1500):
        assert make_step(contacts, 1e-3)
        if closed_at is None and contacts.closed[0]:
            closed_at = (step + 1) * 1e-3
    # 10 mm of 20 mm/s; then the wall pushes the springs by 10 mm less the penetration.
    assert closed_at == pytest.approx(0.5, abs=3e-3)  # a drive acts in the step after
    assert contacts.normals_n[0] == pytest.approx(1.0e3 * 0.010, rel=2e-3)
    assert contacts.openings_m[0] == pytest.approx(-10.0 / 1e6, rel=1e-2)


def test_wear_lowers_the_friction_along_the_slip_path():
    drive = Drive(parameters=("gap_closing_m", "friction"), function=season)
    block = Block(
        mass_kg=1000.0,
        kn_n_per_m=1e9,
        kt_n_per_m=1e9,
        friction=0.3,
        normal_load_n=9810.0,
        v0_mps=(1.5, 0.0),
        gap_m=0.0,
        drive=Drive(
            parameters=("friction",),
            function=lambda state, time_s: {"friction": season(state, time_s)["friction"]},
        ),
    )
    history = run_block(block, 1e-3, 1.4)
    assert drive.parameters == ("gap_closing_m", "friction")
    slid = history.position_m[-1, 0]
    # Energy: m v^2 / 2 = integral of (0.3 - 0.5 s) N ds up to 0.4 m, then 0.1 N.
    g = 9.81
    first = (0.3 * 0.4 - 0.25 * 0.4**2) * g
    expected = 0.4 + (0.5 * 1.5**2 - first) / (0.1 * g)
    assert slid == pytest.approx(expected, rel=5e-3)


def test_stribeck_friction_falls_from_static_to_kinetic():
    options = {"static": 0.4, "kinetic": 0.3, "stribeck_speed_mps": 0.01}
    assert stribeck_friction(0.0, **options) == pytest.approx(0.4)
    assert stribeck_friction(1.0, **options) == pytest.approx(0.3)
    assert stribeck_friction(0.01, **options) == pytest.approx(0.3 + 0.1 * np.exp(-1.0))
    assert stribeck_friction(2.0, **options, viscous_s_per_m=0.05) == pytest.approx(0.4)


def test_an_unknown_parameter_name_is_refused():
    with pytest.raises(InputError, match="temperature"):
        Drive(parameters=("temperature",), function=lambda state, time_s: {})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kn_n_per_m": 1.0}, "declared"),
        ({"friction": -0.1}, "not negative"),
        ({"friction": float("nan")}, "finite"),
    ],
)
def test_the_values_of_a_drive_are_checked(values, message):
    contacts = pressed_mass(Drive(parameters=("friction",), function=lambda s, t: values))
    with pytest.raises(InputError, match=message):
        make_step(contacts, 1e-3)


@pytest.mark.parametrize(
    "make",
    [
        lambda: stribeck_drive(static=0.2, kinetic=0.3, stribeck_speed_mps=0.01),
        lambda: stribeck_drive(static=0.4, kinetic=0.3, stribeck_speed_mps=0.0),
        lambda: kelvin_voigt_drive(kn_n_per_m=0.0, dashpot_n_s_per_m=1.0),
        lambda: kelvin_voigt_drive(kn_n_per_m=1.0, dashpot_n_s_per_m=-1.0),
        lambda: hunt_crossley_drive(stiffness_n_per_m_p=1.0, exponent=1.0, damping=-1.0),
        lambda: approach_stiffness_drive(kn_n_per_m=1.0, reference_speed_mps=0.0, exponent=1.0),
    ],
)
def test_impossible_laws_are_refused(make):
    with pytest.raises(InputError):
        make()


def test_a_step_in_parts_ends_at_the_same_time():
    contacts = pressed_mass(Drive(parameters=("gap_closing_m", "friction"), function=season))
    for _ in range(600):
        assert make_step(contacts, 1e-3, parts_on_change=4)
    assert ops.getTime() == pytest.approx(0.6)
    assert contacts.ledger()[0].closures >= 1


def test_a_drive_without_values_changes_nothing():
    contacts = pressed_mass(Drive(parameters=("gap_closing_m",), function=lambda s, t: {}))
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(2, 20.0, 0.0)
    for _ in range(500):
        assert make_step(contacts, 1e-3)
    # the springs carry 10 mm of 1 kN/m, the wall the rest of the load
    assert contacts.normals_n[0] == pytest.approx(20.0 - 1.0e3 * 0.010, rel=2e-3)
