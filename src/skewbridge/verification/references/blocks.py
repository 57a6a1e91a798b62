"""Blocks with contact units in OpenSees, and closed forms for a single contact.

Plane models of a sliding or bouncing mass and of a rocking block: x is along the surface, y normal
to it. The caller chooses the time step and, for a `Block`, the penalties.
"""

from dataclasses import dataclass, replace
from math import asin, atan, copysign, cos, hypot, pi, sin, sqrt
from typing import Final, NamedTuple

import numpy as np
import openseespy.opensees as ops
from scipy.optimize import brentq

from skewbridge.contact import ContactSet, Drive, UnitLedger
from skewbridge.errors import SolutionError
from skewbridge.verification.references import live_model as live
from skewbridge.verification.references.live_model import Array

_SETTLING_S: Final = 1e-6
#: source: gravity used to compute the tabulated references
TABLE_G_MPS2: Final = 9.81
_MASS_KG: Final = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A mass with one contact, a constant load onto the surface and a spring along x to an anchor.

    The spring is unstressed at x = 0. If `bounces` is false, the mass rests on the surface.
    """

    mass_kg: float
    kn_n_per_m: float
    kt_n_per_m: float
    friction: float = 0.0
    normal_load_n: float = 0.0
    spring_n_per_m: float = 0.0
    gap_m: float = 0.0
    x0_m: float = 0.0
    v0_mps: tuple[float, float] = (0.0, 0.0)
    bounces: bool = False
    drive: Drive | None = None


class BlockHistory(NamedTuple):
    """Response of a block: position and velocity, shape (n, 2); friction has the sign of slip."""

    t_s: Array
    position_m: Array
    velocity_mps: Array
    friction_n: Array
    normal_n: Array
    ledger: UnitLedger


def run_block(
    block: Block,
    dt_s: float,
    duration_s: float,
    *,
    force_n: live.TimeFunction | None = None,
    base_mps2: live.TimeFunction | None = None,
    anchor_m: live.TimeFunction | None = None,
    integrator: tuple[str | float, ...] = ("Newmark", 0.5, 0.25),
) -> BlockHistory:
    """Run a block under a force along x, a base acceleration or a motion of the spring anchor.

    With a base acceleration the response is relative to the surface.
    """
    times, contacts = live.even_times(duration_s, dt_s), ContactSet()
    ground, mass, anchor = 1, 2, 3

    def state() -> list[float]:
        # The unit measures slip along its normal turned counter-clockwise, which is minus x.
        forces = [-contacts.tangentials_n[0][0], contacts.normals_n[0]]
        return [*ops.nodeDisp(mass), *ops.nodeVel(mass), *forces]

    with live.clean_domain(2, 2):
        for node in (ground, mass, anchor):
            ops.node(node, 0.0, 0.0)
        ops.fix(ground, 1, 1)
        ops.fix(anchor, 0, 1)
        ops.mass(mass, block.mass_kg, block.mass_kg if block.bounces else 0.0)
        ops.uniaxialMaterial("Elastic", 1, block.spring_n_per_m)
        ops.element("zeroLength", 1, anchor, mass, "-mat", 1, "-dir", 1)
        place = ground, mass, (0.0, 1.0), block.gap_m, block.friction
        kn, kt = block.kn_n_per_m, block.kt_n_per_m
        contacts.add(*place, kn=kn, kt=kt, drive=block.drive, name="block")
        ops.setNodeDisp(mass, 1, block.x0_m, "-commit")
        for dof, speed in enumerate(block.v0_mps, start=1):
            ops.setNodeVel(mass, dof, speed, "-commit")
        force = np.zeros_like(times) if force_n is None else force_n(times)
        if base_mps2 is not None:
            force = force - block.mass_kg * base_mps2(times)
        live.load_node(mass, block.normal_load_n, dt_s, force)
        live.path_series(3, dt_s, np.zeros_like(times) if anchor_m is None else anchor_m(times))
        ops.pattern("Plain", 3, 3)
        ops.sp(anchor, 1, 1.0)
        live.prepare_analysis(tolerance_m=1e-13, integrator=integrator)
        if not block.bounces:
            # Press the block onto the surface in a step too short for a motion along x.
            if ops.analyze(1, _SETTLING_S) != 0:
                raise SolutionError("OpenSees did not converge: the block is not on its surface")
            contacts.after_step(_SETTLING_S)
            contacts.start_from_rest()
            ops.setTime(0.0)
        rows = live.record(contacts, times, dt_s, state)
        ledger = contacts.ledger()[0]
    position, velocity, forces = np.split(rows, (2, 4), axis=1)
    return BlockHistory(times, position, velocity, forces[:, 0], forces[:, 1], ledger)


def sliding_block(friction: float, *, kt_n_per_m: float = 1e10) -> Block:
    """Return a block of 1000 kg that rests on a surface under its own weight."""
    block = Block(mass_kg=_MASS_KG, kn_n_per_m=1e9, kt_n_per_m=kt_n_per_m, friction=friction)
    return replace(block, normal_load_n=_MASS_KG * TABLE_G_MPS2)


def falling_block() -> Block:
    """Return a mass of 1000 kg under its weight that hits a contact of 10 MN/m at 1 m/s."""
    block = sliding_block(0.0, kt_n_per_m=1e7)
    return replace(block, kn_n_per_m=1e7, v0_mps=(0.0, -1.0), bounces=True)


# Closed forms, named B1 to B9 as in docs/theory/verification.md. They hold for Coulomb friction and
# rigid contact. The penalty adds an elastic slip of about friction x normal force / Kt, which the
# tolerances allow for.


def free_decay_turning_points(x0_m: float, slip_m: float) -> list[float]:
    """Return the start and turning points (m) of an oscillator with Coulomb friction (B1).

    It starts at rest. Each half cycle reduces the amplitude by 2 F / k = 2 slip_m; the mass stops
    once |x| <= slip_m (Den Hartog 1956, Mechanical Vibrations, section 8.2).
    """
    points = [x0_m]
    while abs(x := points[-1]) > slip_m:
        points.append(-x + copysign(2.0 * slip_m, x))
    return points


def forced_amplitude(frequency_ratio: float, friction_ratio: float) -> float:
    """Return amplitude / (P / k) of an oscillator under P cos(W t) that slides without stops (B2).

    The frequency ratio r = W / w must not be 1, 1/2, 1/3, ...; the friction ratio is F / P (Den
    Hartog 1931, Transactions ASME 53; Shaw 1986, Journal of Sound and Vibration 108).
    """
    r = frequency_ratio
    v = 1.0 / (1.0 - r * r)
    u = sin(pi / r) / (r * (1.0 + cos(pi / r)))
    return sqrt(v * v - (friction_ratio * u) ** 2)


def sine_pulse_first_slip(
    amplitude_mps2: float, period_s: float, friction_mps2: float
) -> tuple[float, float, float]:
    """Return start (s), end (s) and length (m) of a block's first slip under one sine wave (B3).

    The base accelerates; `friction_mps2` is mu g (Newmark 1965, Geotechnique 15).
    """
    w, a, f = 2.0 * pi / period_s, amplitude_mps2, friction_mps2
    t1 = asin(f / a) / w

    def speed(t: float) -> float:
        return f * (t - t1) + a / w * (cos(w * t) - cos(w * t1))

    t2 = float(brentq(speed, t1 + 0.25 * period_s, t1 + period_s, xtol=1e-14))
    s = t2 - t1
    wave = (sin(w * t2) - sin(w * t1)) / w - cos(w * t1) * s
    return t1, t2, f * s * s / 2.0 + a / w * wave


def rectangular_pulse_slip(amplitude_mps2: float, duration_s: float, friction_mps2: float) -> float:
    """Return the slip (m) of a block under a rectangular base pulse (B3; Newmark 1965)."""
    v = amplitude_mps2 * duration_s
    return v * v / (2.0 * friction_mps2) * (1.0 - friction_mps2 / amplitude_mps2)


def falling_mass_impact(
    mass_kg: float, stiffness_n_per_m: float, speed_mps: float, gravity_mps2: float
) -> tuple[float, float]:
    """Return penetration (m) and contact time (s) of a mass that falls on a linear spring (B5).

    source: Goldsmith (1960), Impact, chapter 4.
    """
    w = sqrt(stiffness_n_per_m / mass_kg)
    static = mass_kg * gravity_mps2 / stiffness_n_per_m
    duration_s = 2.0 / w * (pi - atan(speed_mps * w / gravity_mps2))
    return static + hypot(static, speed_mps / w), duration_s


def power_law_penetration(
    mass_kg: float, stiffness_n_per_m_p: float, exponent: float, speed_mps: float
) -> float:
    """Return the largest penetration (m) of a mass into a contact F = k x^p (Hertz: p = 3/2).

    source: Johnson (1985), Contact Mechanics, section 11.4.
    """
    p = exponent
    return ((p + 1.0) * mass_kg * speed_mps**2 / (2.0 * stiffness_n_per_m_p)) ** (1.0 / (p + 1.0))


def circular_path_lag_rad(radius_m: float, elastic_slip_m: float) -> float:
    """Return the lag (rad) of friction behind velocity on a circle under radial return (B6)."""
    return asin(elastic_slip_m / radius_m)


def circular_path_work_j(radius_m: float, elastic_slip_m: float, friction_n: float) -> float:
    """Return the energy (J) lost per circular loop under radial return (B6)."""
    return friction_n * 2.0 * pi * sqrt(radius_m**2 - elastic_slip_m**2)


def straight_loop_work_j(half_stroke_m: float, elastic_slip_m: float, friction_n: float) -> float:
    """Return the energy (J) lost per cycle back and forth along a straight path (B7)."""
    return 4.0 * friction_n * (half_stroke_m - elastic_slip_m)


def belt_period_s(
    mass_kg: float,
    stiffness_n_per_m: float,
    static_n: float,
    kinetic_n: float,
    belt_speed_mps: float,
) -> float:
    """Return the stick-slip period (s) of a mass on a belt (B8); slip starts at kinetic friction.

    source: Popp and Stelter (1990), Philosophical Transactions A 332.
    """
    w = sqrt(stiffness_n_per_m / mass_kg)
    drop = (static_n - kinetic_n) / stiffness_n_per_m
    slip_s = 2.0 / w * (pi - atan(drop * w / belt_speed_mps))
    return slip_s + 2.0 * drop / belt_speed_mps


@dataclass(frozen=True, slots=True, kw_only=True)
class RockingBlock:
    """A rigid rectangular block of half width b and half height h on a rigid base (B9).

    source: Housner (1963), Bulletin of the Seismological Society of America 53.
    """

    half_width_m: float
    half_height_m: float

    @property
    def slenderness_rad(self) -> float:
        """Angle from upright at which the block starts to overturn."""
        return atan(self.half_width_m / self.half_height_m)

    def quarter_period_s(self, angle_rad: float) -> float:
        """Return the time (s) from rest at an angle to upright, by the energy equation."""
        alpha, count = self.slenderness_rad, 4000
        p = sqrt(0.75 * TABLE_G_MPS2 / hypot(self.half_width_m, self.half_height_m))
        # Substituting theta = angle sin(s) removes the singularity of 1 / speed at the start.
        s = (np.arange(count) + 0.5) / count * pi / 2.0
        fall = np.cos(alpha - angle_rad) - np.cos(alpha - angle_rad * np.sin(s))
        return float(np.mean(angle_rad * np.cos(s) / (p * np.sqrt(2.0 * fall)))) * pi / 2.0


class UprightHistory(NamedTuple):
    """Response of an upright block; feet and openings have the columns left and right corner.

    Feet are displacements along x. The angle is positive counter-clockwise and includes the initial
    angle.
    """

    t_s: Array
    angle_rad: Array
    feet_m: Array
    openings_m: Array


def run_upright(
    block: RockingBlock,
    dt_s: float,
    duration_s: float,
    *,
    friction: float,
    angle_rad: float = 0.0,
    base_mps2: live.TimeFunction | None = None,
) -> UprightHistory:
    """Run a block of 1000 kg that can slide, tip and rock on two corners, with large rotations.

    It starts at rest and leans to the left if the angle is positive; the floor accelerates by
    `base_mps2`. The penalty at the corners is 1e9 N/m.
    """
    times, contacts = live.even_times(duration_s, dt_s), ContactSet()
    b, h = block.half_width_m, block.half_height_m
    pivot = -b if angle_rad >= 0.0 else b
    centre, foot, left, right = 1, 2, 3, 4
    with live.clean_domain(2, 3):
        for node, x, y in ((centre, 0.0, h), (foot, 0.0, 0.0), (left, -b, 0.0), (right, b, 0.0)):
            turned_x = pivot + cos(angle_rad) * (x - pivot) - sin(angle_rad) * y
            ops.node(node, turned_x, sin(angle_rad) * (x - pivot) + cos(angle_rad) * y)
        ops.mass(centre, _MASS_KG, _MASS_KG, _MASS_KG * hypot(b, h) ** 2 / 3.0)
        ops.geomTransf("Corotational", 1)
        for element, (i, j) in enumerate(((centre, foot), (foot, left), (foot, right)), start=1):
            # members much stiffer than the penalty
            ops.element("elasticBeamColumn", element, i, j, 1.0, 1.0e12, 1.0, 1)
        for floor, corner in ((5, left), (6, right)):
            x, y = ops.nodeCoord(corner)
            ops.node(floor, x, y)
            ops.fix(floor, 1, 1, 1)
            place = floor, corner, (0.0, 1.0), max(0.0, y), friction
            contacts.add(*place, kn=1.0e9, kt=1.0e9)
        push = np.zeros_like(times) if base_mps2 is None else -_MASS_KG * base_mps2(times)
        live.load_node(centre, _MASS_KG * TABLE_G_MPS2, dt_s, push, rotations=1)
        # Numerical damping removes oscillations of the penalty; rocking is far slower.
        live.prepare_analysis(
            constraints="Plain",
            numberer="RCM",
            tolerance_m=1e-11,
            algorithm="KrylovNewton",
            integrator=("HHT", 0.8),
        )

        def state() -> list[float]:
            feet = [ops.nodeDisp(corner, 1) for corner in (left, right)]
            return [angle_rad + ops.nodeDisp(centre, 3), *feet, *contacts.openings_m]

        rows = live.record(contacts, times, dt_s, state)
    return UprightHistory(times, rows[:, 0], rows[:, 1:3], rows[:, 3:])
