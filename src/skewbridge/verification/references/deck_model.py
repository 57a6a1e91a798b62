"""The rigid skew deck on bearings between two abutments: geometry, matrices, excitation, history.

Three degrees of freedom at the mass centre, q = (ux, uy, theta), linear in theta. The plan is a
parallelogram with edges (L, 0) and W (tan a, 1). The ends carry two contacts each, at the acute
and at the obtuse corner. With the outward normal n = (cos a, -sin a) of the right end, its tangent
t = (sin a, cos a), s = +1 right and -1 left:

    opening_i = gap - s (n . u + theta (n_y x_i - n_x y_i))
    slip_i = t . u + theta (t_y x_i - t_x y_i)

References:
    Dimitrakopoulos (2011), Engineering Structures 33, 813-826 (the model and its pulse).
"""

from dataclasses import dataclass
from math import cos, pi, radians, sin, tan
from typing import Final, Self

import numpy as np

from skewbridge.contact.restitution import kelvin_voigt_damping_ratio
from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2
from skewbridge.verification.references.cases import DeckCase
from skewbridge.verification.references.live_model import Array, first_crossing_s

# Right and left end, acute and obtuse corner.
CORNERS: Final = ("ra", "ro", "lo", "la")


@dataclass(frozen=True, slots=True, kw_only=True)
class Corner:
    """One contact of the deck.

    Attributes:
        name: One of `CORNERS`.
        end: 0 right, 1 left.
        x_m: Position from the mass centre.
        y_m: Position from the mass centre.
        normal_row: Opening = gap + normal_row . q.
        tangent_row: Slip = tangent_row . q.
    """

    name: str
    end: int
    x_m: float
    y_m: float
    normal_row: tuple[float, float, float]
    tangent_row: tuple[float, float, float]

    @property
    def normal(self) -> tuple[float, float]:
        """Outward normal of the abutment, towards the deck."""
        return self.normal_row[:2]


@dataclass(frozen=True, slots=True, kw_only=True)
class SkewDeck:
    """Matrices and corners of a deck case.

    Attributes:
        mass: Diagonal of the mass matrix (kg, kg, kg m2).
        stiffness: Diagonal of the bearing stiffness.
        damping: Diagonal of the damping, 2 xi w M.
        dashpot_n_s_per_m: Dashpot of each corner for the given restitution.
    """

    mass: tuple[float, ...]
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    corners: tuple[Corner, ...]
    dashpot_n_s_per_m: float

    @property
    def normal_rows(self) -> Array:
        """Shape (4, 3)."""
        return np.array([corner.normal_row for corner in self.corners])

    @property
    def tangent_rows(self) -> Array:
        """Shape (4, 3)."""
        return np.array([corner.tangent_row for corner in self.corners])


@dataclass(frozen=True, slots=True, kw_only=True)
class DeckHistory:
    """Response of a deck; n times.

    Attributes:
        q: Displacements (ux, uy, theta), shape (n, 3).
        openings_m: Shape (n, 4), order `CORNERS`, negative in contact.
        normals_n: Compressions, shape (n, 4).
        tangentials_n: Friction forces with the sign of slip, shape (n, 4).
        energy_residual_ratio: Input less all works and stored energies at the end, over the
            largest input.
    """

    t_s: Array
    q: Array
    openings_m: Array
    normals_n: Array
    tangentials_n: Array
    energy_residual_ratio: float

    def peaks(self) -> dict[str, float]:
        """Return the absolute maxima."""
        ux, uy, theta = (float(peak) for peak in np.abs(self.q).max(axis=0))
        penetration = max(0.0, float(-self.openings_m.min()))
        return {"ux_m": ux, "uy_m": uy, "theta_rad": theta, "penetration_m": penetration}

    def first_contact_s(self) -> float | None:
        """Return the time at which the first gap closes, linear between samples."""
        return first_crossing_s(self.t_s, self.openings_m.min(axis=1))


def make_deck(case: DeckCase) -> SkewDeck:
    """Return the matrices and corners of a case."""
    length, width, skew = case.length_m, case.width_m, radians(case.skew_deg)
    inertia = case.mass_kg * (length**2 + (width / cos(skew)) ** 2) / 12.0
    mass = (case.mass_kg, case.mass_kg, inertia)
    speeds = [2.0 * pi / t for t in (case.period_x_s, case.period_y_s, case.period_theta_s)]
    frequencies = list(zip(mass, speeds, strict=True))
    # The two springs of an end work together in a flat impact, on the whole mass.
    zeta = kelvin_voigt_damping_ratio(case.restitution) if case.restitution else 0.0
    return SkewDeck(
        mass=mass,
        stiffness=tuple(m * w**2 for m, w in frequencies),
        damping=tuple(2.0 * case.damping_ratio * w * m for m, w in frequencies),
        corners=_corners(length, width, skew),
        dashpot_n_s_per_m=2.0 * zeta * (case.normal_stiffness_n_per_m * case.mass_kg / 2.0) ** 0.5,
    )


def _corners(length_m: float, width_m: float, skew_rad: float) -> tuple[Corner, ...]:
    n = (cos(skew_rad), -sin(skew_rad))
    t = (sin(skew_rad), cos(skew_rad))
    # The acute corner of the right end lies on the side to which the skew leans.
    lean = 1.0 if skew_rad >= 0.0 else -1.0
    corners: list[Corner] = []
    for name in CORNERS:
        s = 1.0 if name[0] == "r" else -1.0
        y = 0.5 * width_m * lean * s * (1.0 if name[1] == "a" else -1.0)
        x = s * 0.5 * length_m + y * tan(skew_rad)
        corners.append(
            Corner(
                name=name,
                end=0 if s > 0.0 else 1,
                x_m=x,
                y_m=y,
                normal_row=(-s * n[0], -s * n[1], -s * (n[1] * x - n[0] * y)),
                tangent_row=(t[0], t[1], t[1] * x - t[0] * y),
            )
        )
    return tuple(corners)


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseAcceleration:
    """Ground acceleration: a cosine pulse along x, or two sampled components.

    Attributes:
        amplitude_mps2: Amplitude of the pulse.
        period_s: Period and duration of the pulse.
        sample_dt_s: Time step of the record; zero for the pulse.
        samples_mps2: Accelerations of the record, shape (2, n), linear between samples.
    """

    amplitude_mps2: float = 0.0
    period_s: float = 1.0
    sample_dt_s: float = 0.0
    samples_mps2: Array | None = None

    @classmethod
    def of_motion(cls, motion: GroundMotion) -> Self:
        """Return the acceleration of a record, component 1 along x."""
        samples = np.array([motion.accel_1_mps2, motion.accel_2_mps2])
        return cls(sample_dt_s=motion.dt_s, samples_mps2=samples)

    def at(self, times_s: Array) -> Array:
        """Return the acceleration at times, shape (2, n)."""
        if self.samples_mps2 is not None:
            grid = self.sample_dt_s * np.arange(self.samples_mps2.shape[1])
            return np.array(
                [np.interp(times_s, grid, component, right=0.0) for component in self.samples_mps2]
            )
        pulse = self.amplitude_mps2 * np.cos(2.0 * pi / self.period_s * times_s)
        return np.array([np.where(times_s <= self.period_s, pulse, 0.0), np.zeros_like(times_s)])

    def mean(self, starts_s: Array, ends_s: Array) -> Array:
        """Return the mean acceleration over intervals, shape (2, n): a jump keeps its impulse."""
        if self.samples_mps2 is not None:
            return 0.5 * (self.at(starts_s) + self.at(ends_s))
        speed = 2.0 * pi / self.period_s
        low, high = np.clip(starts_s, 0.0, self.period_s), np.clip(ends_s, 0.0, self.period_s)
        impulse = self.amplitude_mps2 / speed * (np.sin(speed * high) - np.sin(speed * low))
        return np.array([impulse / (ends_s - starts_s), np.zeros_like(starts_s)])


def pulse_of(case: DeckCase) -> BaseAcceleration:
    """Return the pulse of a case that has one."""
    if case.pulse is None:
        raise ValueError("the case has no pulse")
    return BaseAcceleration(
        amplitude_mps2=case.pulse.amplitude_g * G_MPS2, period_s=case.pulse.period_s
    )


type Response = tuple[Array, Array, Array, Array, Array]
"""q and its velocity, shape (n, 3); openings, compressions and friction, shape (n, 4)."""


class DeckEnergy:
    """Works of a deck by the trapezoidal rule, summed over consecutive parts of its response."""

    def __init__(self, deck: SkewDeck) -> None:
        self._deck = deck
        self._mass, self._damping = np.array(deck.mass), np.array(deck.damping)
        self._given = self._lost = self._kept = self._largest = 0.0

    def add(self, response: Response, accel_mps2: Array) -> None:
        """Add a part under a ground acceleration, shape (2, n); the next part starts at its end."""
        q, v, openings, normals, tangentials = response
        step = np.diff(q, axis=0)
        force = np.zeros_like(q)
        force[:, :2] = -self._mass[:2] * accel_mps2.T
        given = self._given + np.cumsum(np.sum(_mid(force) * step, axis=1))
        self._given = float(given[-1])
        self._largest = max(self._largest, float(np.abs(given).max()))
        slips = q @ self._deck.tangent_rows.T
        self._lost += float(np.sum(self._damping * _mid(v) * step))
        self._lost += float(np.sum(_mid(normals) * -np.diff(openings, axis=0)))
        self._lost += float(np.sum(_mid(tangentials) * np.diff(slips, axis=0)))
        stiffness = np.array(self._deck.stiffness)
        self._kept = 0.5 * float(self._mass @ v[-1] ** 2 + stiffness @ q[-1] ** 2)

    def history(self, times_s: Array, response: Response) -> DeckHistory:
        """Return a response at chosen times with the energy residual of all parts."""
        residual = self._given - self._lost - self._kept
        q, _, openings, normals, friction = response
        return DeckHistory(
            t_s=times_s,
            q=q,
            openings_m=openings,
            normals_n=normals,
            tangentials_n=friction,
            energy_residual_ratio=residual / self._largest if self._largest > 0.0 else 0.0,
        )


def _mid(values: Array) -> Array:
    return 0.5 * (values[1:] + values[:-1])
