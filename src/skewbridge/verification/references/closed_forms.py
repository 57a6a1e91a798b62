"""Closed forms for one contact and one degree of freedom, each with its source.

The letters B1 to B9 are those of docs/theory/verification.md. All of them hold for Coulomb
friction and a rigid contact; the penalty adds an elastic slip of the order of (friction x normal
force) / Kt, for which the tolerances of the tests allow.
"""

from dataclasses import dataclass
from math import asin, atan, cos, hypot, pi, sin, sqrt

import numpy as np
from scipy.optimize import brentq


def free_decay_turning_points(x0_m: float, slip_m: float) -> list[float]:
    """Return the turning points of an oscillator with Coulomb friction, the start included (B1).

    It starts at rest. Every half cycle loses 2 F / k = 2 slip_m; the mass stops where
    |x| <= slip_m.

    References:
        Den Hartog (1956), Mechanical Vibrations, section 8.2.
    """
    points = [x0_m]
    while abs(points[-1]) > slip_m:
        x = points[-1]
        points.append(-x + 2.0 * slip_m * (1.0 if x > 0.0 else -1.0))
    return points


def forced_amplitude(frequency_ratio: float, friction_ratio: float) -> float:
    """Return amplitude / (P / k) of an oscillator under P cos(W t), motion without stops (B2).

    The frequency ratio r = W / w must not be 1, 1/2, 1/4, ...; the friction ratio is F / P.

    References:
        Den Hartog (1931), Transactions ASME 53; Shaw (1986), Journal of Sound and Vibration 108.
    """
    r = frequency_ratio
    v = 1.0 / (1.0 - r * r)
    u = sin(pi / r) / (r * (1.0 + cos(pi / r)))
    return sqrt(v * v - (friction_ratio * u) ** 2)


def sine_pulse_first_slip(
    amplitude_mps2: float, period_s: float, friction_mps2: float
) -> tuple[float, float, float]:
    """Return start, end (s) and slip (m) of a block's first slip under one sine wave (B3).

    The block is on a moving base; friction is mu g.

    References:
        Newmark (1965), Geotechnique 15 (rigid sliding block).
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
    """Return the slip of a block on a base under a rectangular pulse (B3).

    References:
        Newmark (1965), Geotechnique 15: V^2 / (2 mu g) (1 - mu g / A).
    """
    v = amplitude_mps2 * duration_s
    return v * v / (2.0 * friction_mps2) * (1.0 - friction_mps2 / amplitude_mps2)


def falling_mass_impact(
    mass_kg: float, stiffness_n_per_m: float, speed_mps: float, gravity_mps2: float
) -> tuple[float, float]:
    """Return penetration (m) and time of contact (s) of a mass that falls on a linear spring (B5).

    References:
        Goldsmith (1960), Impact, chapter 4.
    """
    w = sqrt(stiffness_n_per_m / mass_kg)
    static = mass_kg * gravity_mps2 / stiffness_n_per_m
    duration_s = 2.0 / w * (pi - atan(speed_mps * w / gravity_mps2))
    return static + hypot(static, speed_mps / w), duration_s


def power_law_penetration(
    mass_kg: float, stiffness_n_per_m_p: float, exponent: float, speed_mps: float
) -> float:
    """Return the deepest penetration of a mass into F = k x^p (Hertz for p = 3/2).

    References:
        Johnson (1985), Contact Mechanics, section 11.4.
    """
    p = exponent
    return ((p + 1.0) * mass_kg * speed_mps**2 / (2.0 * stiffness_n_per_m_p)) ** (1.0 / (p + 1.0))


def circular_path_lag_rad(radius_m: float, elastic_slip_m: float) -> float:
    """Return the angle by which friction lags the velocity on a circle (B6), radial return."""
    return asin(elastic_slip_m / radius_m)


def circular_path_work_j(radius_m: float, elastic_slip_m: float, friction_n: float) -> float:
    """Return the energy lost per loop on a circle (B6), radial return."""
    return friction_n * 2.0 * pi * sqrt(radius_m**2 - elastic_slip_m**2)


def straight_loop_work_j(half_stroke_m: float, elastic_slip_m: float, friction_n: float) -> float:
    """Return the energy lost per cycle between two ends of a straight path (B7)."""
    return 4.0 * friction_n * (half_stroke_m - elastic_slip_m)


def belt_period_s(
    mass_kg: float,
    stiffness_n_per_m: float,
    static_n: float,
    kinetic_n: float,
    belt_speed_mps: float,
) -> float:
    """Return the period of a mass that sticks and slips on a belt, friction falling at once (B8).

    References:
        Popp and Stelter (1990), Philosophical Transactions A 332.
    """
    w = sqrt(stiffness_n_per_m / mass_kg)
    drop = (static_n - kinetic_n) / stiffness_n_per_m
    slip_s = 2.0 / w * (pi - atan(drop * w / belt_speed_mps))
    return slip_s + 2.0 * drop / belt_speed_mps


@dataclass(frozen=True, slots=True, kw_only=True)
class RockingBlock:
    """A rigid rectangular block, half width b and half height h, on a rigid base (B9).

    References:
        Housner (1963), Bulletin of the Seismological Society of America 53.
    """

    half_width_m: float
    half_height_m: float
    gravity_mps2: float

    @property
    def slenderness_rad(self) -> float:
        """Angle at which the block is on the point of overturning."""
        return atan(self.half_width_m / self.half_height_m)

    @property
    def uplift_mps2(self) -> float:
        """Base acceleration that lifts the block: g b / h."""
        return self.gravity_mps2 * self.half_width_m / self.half_height_m

    def quarter_period_s(self, angle_rad: float) -> float:
        """Return the time from rest at an angle to upright, by quadrature of the energy."""
        alpha, count = self.slenderness_rad, 4000
        p = sqrt(0.75 * self.gravity_mps2 / hypot(self.half_width_m, self.half_height_m))
        # theta = angle sin(s) removes the singularity of 1 / speed at the start.
        s = (np.arange(count) + 0.5) / count * pi / 2.0
        fall = np.cos(alpha - angle_rad) - np.cos(alpha - angle_rad * np.sin(s))
        return float(np.mean(angle_rad * np.cos(s) / (p * np.sqrt(2.0 * fall)))) * pi / 2.0
