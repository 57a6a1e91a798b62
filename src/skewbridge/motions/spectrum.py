"""Response spectra of one component, and RotD50 and RotD100 of a pair.

The oscillator under a piecewise linear base acceleration has an exact recursion (Nigam and
Jennings 1969, Bulletin of the Seismological Society of America 59(2)). For the displacement, the
recursion is a second-order IIR filter, which scipy runs in compiled code.

For periods below 10 dt the record is interpolated linearly with ceil(10 dt/T) steps per sample, as
in the published NGA-West2 spectra.
"""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector

DAMPING_RATIO: Final = 0.05
STEPS_PER_PERIOD: Final = 10
ORIENTATIONS: Final = 180  # every degree; 180 to 359 repeat the same projections
#: Periods of spectra that are printed or drawn.
SPECTRUM_PERIODS_S: Final = (
    0.01, 0.02, 0.03, 0.05, 0.075, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0,
    4.0, 5.0, 7.5, 10.0,
)  # fmt: skip

_ANGLES_RAD: Final = np.deg2rad(np.arange(ORIENTATIONS))[:, None]
_COSINES: Final = np.cos(_ANGLES_RAD)
_SINES: Final = np.sin(_ANGLES_RAD)


class PairSpectrum(NamedTuple):
    """Pseudo-spectral acceleration of a pair: median and maximum over all orientations."""

    rotd50_mps2: Vector
    rotd100_mps2: Vector


def component_psa(accel_mps2: Vector, dt_s: float, periods_s: ArrayLike) -> Vector:
    """Return the 5 % damped pseudo-spectral acceleration of one component, shape (periods,).

    It is omega^2 times the largest relative displacement, in m/s2.
    """
    return _spectrum(accel_mps2, dt_s, periods_s, lambda disp_m: max(disp_m.max(), -disp_m.min()))


def pair_psa(
    accel_1_mps2: Vector, accel_2_mps2: Vector, dt_s: float, periods_s: ArrayLike
) -> PairSpectrum:
    """Return RotD50 and RotD100 of the PSA of a pair in m/s2, both of shape (periods,).

    References:
        Boore (2010), Bulletin of the Seismological Society of America 100(4).
    """
    pair = np.stack([accel_1_mps2, accel_2_mps2])
    return PairSpectrum(*_spectrum(pair, dt_s, periods_s, _orbit_peaks).T)


def orbit_rotd50(first: Vector, second: Vector) -> float:
    """Return the RotD50 of any two-component history: the median of its peaks over orientations."""
    return float(_orbit_peaks(np.stack([first, second]))[0])


def sa_avg_periods(t1_s: float) -> Vector:
    """Return the 20 log-spaced periods from 0.2 T1 to 3 T1 that Sa_avg averages over.

    References:
        Eads, Miranda and Lignos (2015), Earthquake Engineering and Structural Dynamics 44(12).
    """
    if not (np.isfinite(t1_s) and t1_s > 0.0):
        raise InputError(f"t1_s must be positive, got {t1_s}")
    return np.geomspace(0.2 * t1_s, 3.0 * t1_s, 20)


def _spectrum(
    accel: Vector, dt_s: float, periods_s: ArrayLike, peaks: Callable[[Vector], ArrayLike]
) -> Vector:
    """Return omega^2 times the peak displacements of an oscillator, one row per period."""
    periods = np.atleast_1d(np.asarray(periods_s, dtype=np.float64))
    if not (np.isfinite(periods).all() and (periods > 0.0).all()):
        raise InputError(f"periods_s must be positive, got {periods_s}")
    from scipy.signal import lfilter  # here: its import takes a second

    rows: list[ArrayLike] = []
    refined, refined_by = accel, 1
    for period_s in periods.tolist():
        substeps = max(int(np.ceil(STEPS_PER_PERIOD * dt_s / period_s - 1.0e-9)), 1)
        if substeps != refined_by:
            refined, refined_by = _in_substeps(accel, substeps), substeps
        omega = 2.0 * np.pi / period_s
        b, a, initial = _filter(omega, DAMPING_RATIO, dt_s / substeps)
        disp_m = lfilter(b, a, refined, axis=-1, zi=refined[..., :1] * initial)[0]
        rows.append(peaks(disp_m) * omega**2)
    return np.array(rows)


def _in_substeps(accel: Vector, substeps: int) -> Vector:
    """Return linearly interpolated accelerations with ``substeps`` sub-steps per step."""
    shares = np.arange(substeps) / substeps
    inner = accel[..., :-1, None] + np.diff(accel)[..., None] * shares
    return np.concatenate([inner.reshape(*accel.shape[:-1], -1), accel[..., -1:]], axis=-1)


def _filter(omega: float, xi: float, dt_s: float) -> tuple[Vector, Vector, Vector]:
    """Return the numerator, the denominator and the initial state of the filter.

    The initial state is that at rest with a first sample of 1. The velocity is eliminated from the
    exact step x[i+1] = A x[i] + B p[i..i+1] for x = (displacement, velocity).
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
    """Return RotD50 and RotD100 of an orbit of shape (2, npts).

    Points whose radius is below both middle values of the 180 sorted peaks can't change the result.
    A few outer points give lower bounds of all peaks; only points with a radius of at least the
    lower middle bound are projected. The result is exact; with a fixed share of the component peaks
    as limit it would not be (Stewart et al. 2017, PEER 2017/09).
    """
    x, y = orbit
    squared = x * x + y * y
    # 0.9 of the largest radius and about 40 points: both affect only the speed
    outer = np.flatnonzero(squared >= 0.9**2 * squared.max())
    sample = outer[:: outer.size // 40 + 1]
    bounds = np.sort(_largest_projections(x[sample], y[sample]))
    is_outer = squared >= bounds[(ORIENTATIONS - 1) // 2] ** 2
    projections = _largest_projections(x[is_outer], y[is_outer])
    return np.array([np.median(projections), projections.max()])


def _largest_projections(x: Vector, y: Vector) -> Vector:
    # Not a matrix product: its threads cost more than they save on arrays this small.
    return np.abs(_COSINES * x + _SINES * y).max(axis=1)
