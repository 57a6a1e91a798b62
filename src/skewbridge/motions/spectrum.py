"""Response spectra of linear oscillators, per component and over all orientations.

The oscillator under a piecewise linear base acceleration has an exact recursion (Nigam and
Jennings 1969, Bulletin of the Seismological Society of America 59(2)); written for the
displacement alone it is a second-order IIR filter, which scipy runs in compiled code.

Below a period of 10 dt the record is interpolated linearly with ceil(10 dt/T) steps per sample:
the convention found in the published NGA-West2 spectra.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector

DAMPING_RATIO: Final = 0.05
STEPS_PER_PERIOD: Final = 10
ORIENTATIONS: Final = 180  # every degree; 180 to 359 repeat the same projections
# These values only affect the speed: share of the largest radius, number of points.
_OUTERMOST: Final = 0.9
_OUTER_POINTS: Final = 40

_ANGLES_RAD: Final = np.deg2rad(np.arange(ORIENTATIONS))[:, None]
_COSINES: Final = np.cos(_ANGLES_RAD)
_SINES: Final = np.sin(_ANGLES_RAD)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairSpectrum:
    """Pseudo-spectral accelerations of a pair of components, all of shape (periods,).

    RotD50 and RotD100 are the median and the maximum over all orientations.
    """

    periods_s: Vector
    psa_1_mps2: Vector
    psa_2_mps2: Vector
    rotd50_mps2: Vector
    rotd100_mps2: Vector


def component_psa(
    accel_mps2: Vector, dt_s: float, periods_s: ArrayLike, damping_ratio: float = DAMPING_RATIO
) -> Vector:
    """Return the pseudo-spectral acceleration of one component, shape (periods,).

    It is omega^2 times the largest relative displacement, in m/s2; the damping ratio is within 0
    and below 1.
    """
    periods = _checked_periods(periods_s, damping_ratio)
    psa = np.empty(periods.size)
    record = _Record(accel_mps2, dt_s)
    for row, period_s in enumerate(periods):
        disp_m = record.displacement(float(period_s), damping_ratio)
        psa[row] = max(disp_m.max(), -disp_m.min()) * (2.0 * np.pi / period_s) ** 2
    return psa


def pair_psa(
    accel_1_mps2: Vector,
    accel_2_mps2: Vector,
    dt_s: float,
    periods_s: ArrayLike,
    damping_ratio: float = DAMPING_RATIO,
) -> PairSpectrum:
    """Return the spectra of a pair: each component, RotD50 and RotD100.

    References:
        Boore (2010), Bulletin of the Seismological Society of America 100(4).
    """
    periods = _checked_periods(periods_s, damping_ratio)
    record = _Record(np.stack([accel_1_mps2, accel_2_mps2]), dt_s)
    table = np.empty((4, periods.size))
    for row, period_s in enumerate(periods):
        orbit_m = record.displacement(float(period_s), damping_ratio)
        table[:, row] = _orbit_peaks(orbit_m)
        table[:, row] *= (2.0 * np.pi / period_s) ** 2
    return PairSpectrum(
        periods_s=periods,
        psa_1_mps2=table[0],
        psa_2_mps2=table[1],
        rotd50_mps2=table[2],
        rotd100_mps2=table[3],
    )


def orbit_rotd50(first: Vector, second: Vector) -> float:
    """Return the median over orientations of the peak of any two-component history."""
    return float(_orbit_peaks(np.stack([first, second]))[2])


def sa_avg_periods(t1_s: float) -> Vector:
    """Return the 20 log-spaced periods from 0.2 T1 to 3 T1 that Sa_avg averages over.

    References:
        Eads, Miranda and Lignos (2015), Earthquake Engineering and Structural Dynamics 44(12).
    """
    if not (np.isfinite(t1_s) and t1_s > 0.0):
        raise InputError(f"t1_s must be positive, got {t1_s}")
    return np.geomspace(0.2 * t1_s, 3.0 * t1_s, 20)


def _checked_periods(periods_s: ArrayLike, damping_ratio: float) -> Vector:
    periods = np.atleast_1d(np.asarray(periods_s, dtype=np.float64))
    if not (np.isfinite(periods).all() and (periods > 0.0).all()):
        raise InputError(f"periods_s must be positive, got {periods_s}")
    if not 0.0 <= damping_ratio < 1.0:
        raise InputError(f"damping_ratio must be within 0 and below 1, got {damping_ratio}")
    return periods


class _Record:
    """Accelerations with their last linear refinement, cached for the next period."""

    def __init__(self, accel: Vector, dt_s: float) -> None:
        self._accel = accel
        self._dt_s = dt_s
        self._refined = accel
        self._substeps = 1

    def displacement(self, period_s: float, damping_ratio: float) -> Vector:
        """Return relative displacements in m from rest, along the last axis."""
        substeps = max(int(np.ceil(STEPS_PER_PERIOD * self._dt_s / period_s - 1.0e-9)), 1)
        accel = self._in_substeps(substeps)
        b, a, rest = _filter(2.0 * np.pi / period_s, damping_ratio, self._dt_s / substeps)
        from scipy.signal import lfilter  # here: its import takes a second

        return lfilter(b, a, accel, axis=-1, zi=accel[..., :1] * rest)[0]

    def _in_substeps(self, substeps: int) -> Vector:
        if substeps != self._substeps:
            accel = self._accel
            shares = np.arange(substeps) / substeps
            inner = accel[..., :-1, None] + np.diff(accel)[..., None] * shares
            inner = inner.reshape(*accel.shape[:-1], -1)
            self._refined = np.concatenate([inner, accel[..., -1:]], axis=-1)
            self._substeps = substeps
        return self._refined


def _filter(omega: float, xi: float, dt_s: float) -> tuple[Vector, Vector, Vector]:
    """Return numerator, denominator and the start state (per unit of the first sample) of rest.

    With the exact step x[i+1] = A x[i] + B p[i..i+1] for x = (displacement, velocity), the
    velocity is eliminated.
    """
    root = np.sqrt(1.0 - xi * xi)
    omega_d = omega * root
    decay = np.exp(-xi * omega * dt_s)
    sine, cosine = np.sin(omega_d * dt_s), np.cos(omega_d * dt_s)
    a11 = decay * (xi / root * sine + cosine)
    a12 = decay * sine / omega_d
    a22 = decay * (cosine - xi / root * sine)
    determinant = decay * decay

    slope = (2.0 * xi * xi - 1.0) / (omega**2 * dt_s)
    offset = 2.0 * xi / (omega**3 * dt_s)
    velocity_s = cosine - xi / root * sine
    velocity_c = omega_d * sine + xi * omega * cosine
    b11 = decay * ((slope + xi / omega) * sine / omega_d + (offset + omega**-2) * cosine) - offset
    b12 = -decay * (slope * sine / omega_d + offset * cosine) - omega**-2 + offset
    b21 = decay * ((slope + xi / omega) * velocity_s - (offset + omega**-2) * velocity_c)
    b21 += 1.0 / (omega**2 * dt_s)
    b22 = -decay * (slope * velocity_s - offset * velocity_c) - 1.0 / (omega**2 * dt_s)

    numerator = np.array([b12, b11 - a22 * b12 + a12 * b22, a12 * b21 - a22 * b11])
    denominator = np.array([1.0, -(a11 + a22), determinant])
    return numerator, denominator, np.array([-b12, b11 - numerator[1]])


def _orbit_peaks(orbit: Vector) -> Vector:
    """Return the peaks of component 1, of 2, RotD50 and RotD100 of an orbit, shape (2, npts).

    Points nearer to the centre than the two middle ones of the 180 peaks can't change them: some
    of the outermost points give lower bounds of all peaks, and only points beyond the lower middle
    one of these are projected. This is exact, unlike a fixed share of the component peaks (Stewart
    et al. 2017, PEER 2017/09).
    """
    x, y = orbit
    squared = x * x + y * y
    outer = np.flatnonzero(squared >= _OUTERMOST**2 * squared.max())
    some = outer[:: outer.size // _OUTER_POINTS + 1]
    bounds = np.sort(_largest_projections(x[some], y[some]))
    beyond = squared >= bounds[(ORIENTATIONS - 1) // 2] ** 2
    projections = _largest_projections(x[beyond], y[beyond])
    peak_1, peak_2 = max(x.max(), -x.min()), max(y.max(), -y.min())
    return np.array([peak_1, peak_2, np.median(projections), projections.max()])


def _largest_projections(x: Vector, y: Vector) -> Vector:
    # Not a matrix product: its threads cost more than they save on arrays this small.
    return np.abs(_COSINES * x + _SINES * y).max(axis=1)
