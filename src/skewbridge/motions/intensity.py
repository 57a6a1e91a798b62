"""Intensity measures of a ground motion, units in the names.

RotD50 where an orientation matters. Arias intensity, CAV and significant durations have one value
per pair: Arias and CAV are the mean of the two components, the durations come from the summed
build-up of both (which no rotation changes).
"""

from typing import Final

import numpy as np

from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.spectrum import component_psa, orbit_rotd50, pair_psa, sa_avg_periods
from skewbridge.units import G_MPS2

# Exponent of the scale factor for each measure.
SCALE_POWERS: Final = {
    "im_pga_rotd50_g": 1,
    "im_pgv_rotd50_mps": 1,
    "im_sa_t1_rotd50_g": 1,
    "im_sa_1p000_rotd50_g": 1,
    "im_saavg_rotd50_g": 1,
    "im_arias_mps": 2,
    "im_cav_mps": 1,
    "im_d5_75_s": 0,
    "im_d5_95_s": 0,
}
IM_COLUMNS: Final = tuple(SCALE_POWERS)
# source: Housner (1952), spectrum intensity between 0.1 and 2.5 s
HOUSNER_PERIODS_S: Final = np.linspace(0.1, 2.5, 121)


def motion_measures(motion: GroundMotion, t1_s: float | None) -> dict[str, float]:
    """Return the intensity measures of a pair by column; Sa(T1) and Sa_avg are nan without T1."""
    dt_s = motion.dt_s
    pair = motion.components
    sa_t1_g = sa_avg_g = float("nan")
    if t1_s is not None:
        spectrum = pair_psa(*pair, dt_s, conditioned_periods(t1_s))
        sa_t1_g, sa_avg_g = conditioned_levels(spectrum.rotd50_mps2 / G_MPS2)
    both = pair_arias_build_up(motion)
    return {
        "im_pga_rotd50_g": orbit_rotd50(*pair) / G_MPS2,
        "im_pgv_rotd50_mps": orbit_rotd50(velocity(pair[0], dt_s), velocity(pair[1], dt_s)),
        "im_sa_t1_rotd50_g": sa_t1_g,
        "im_sa_1p000_rotd50_g": float(pair_psa(*pair, dt_s, 1.0).rotd50_mps2[0]) / G_MPS2,
        "im_saavg_rotd50_g": sa_avg_g,
        "im_arias_mps": 0.5 * float(both[-1]),
        "im_cav_mps": 0.5 * (cav(pair[0], dt_s) + cav(pair[1], dt_s)),
        "im_d5_75_s": significant_duration(both, dt_s, 0.05, 0.75),
        "im_d5_95_s": significant_duration(both, dt_s, 0.05, 0.95),
    }


def conditioned_periods(t1_s: float) -> Vector:
    """Return the periods for `conditioned_levels` in s: those of Sa_avg, then T1."""
    return np.append(sa_avg_periods(t1_s), t1_s)


def conditioned_levels(psa_g: Vector) -> tuple[float, float]:
    """Return Sa(T1) and Sa_avg in g from the PSA at `conditioned_periods`."""
    return float(psa_g[-1]), float(np.exp(np.log(psa_g[:-1]).mean()))


def scaled_measures(measures: dict[str, float], scale: float) -> dict[str, float]:
    """Return the measures of a motion multiplied by a factor, from those at factor 1."""
    return {name: value * scale ** SCALE_POWERS[name] for name, value in measures.items()}


def component_measures(accel_mps2: Vector, dt_s: float) -> dict[str, float]:
    """Return the measures of one component: peaks, Arias, CAV, durations, Housner intensity."""
    build_up = arias_build_up(accel_mps2, dt_s)
    return {
        "pga_g": peak_g(accel_mps2),
        "pgv_mps": float(np.abs(velocity(accel_mps2, dt_s)).max()),
        "pgd_m": float(np.abs(displacement(accel_mps2, dt_s)).max()),
        "arias_mps": float(build_up[-1]),
        "cav_mps": cav(accel_mps2, dt_s),
        "d5_75_s": significant_duration(build_up, dt_s, 0.05, 0.75),
        "d5_95_s": significant_duration(build_up, dt_s, 0.05, 0.95),
        "housner_m": housner_intensity(accel_mps2, dt_s),
    }


def peak_g(accel_mps2: Vector) -> float:
    """Return the largest absolute acceleration in g."""
    return float(np.abs(accel_mps2).max()) / G_MPS2


def _running_integral(values: Vector, dt_s: float) -> Vector:
    """Return the integral from the first value by the trapezoidal rule."""
    from scipy.integrate import cumulative_trapezoid  # here: every job imports this module

    return cumulative_trapezoid(values, dx=dt_s, initial=0)


def velocity(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return the velocity in m/s by the trapezoidal rule from rest; nothing is filtered."""
    return _running_integral(accel_mps2, dt_s)


def displacement(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return the displacement in m by the trapezoidal rule twice from rest."""
    return _running_integral(velocity(accel_mps2, dt_s), dt_s)


def arias_build_up(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return pi/(2 g) times the running integral of the squared acceleration, in m/s."""
    return np.pi / (2.0 * G_MPS2) * _running_integral(accel_mps2**2, dt_s)


def pair_arias_build_up(motion: GroundMotion) -> Vector:
    """Return the sum of the Arias build-ups of both components; no rotation changes it."""
    first, second = (arias_build_up(accel, motion.dt_s) for accel in motion.components)
    return first + second


def cav(accel_mps2: Vector, dt_s: float) -> float:
    """Return the cumulative absolute velocity, the integral of |a|, in m/s."""
    from scipy.integrate import trapezoid

    return float(trapezoid(np.abs(accel_mps2), dx=dt_s))


def significant_duration(build_up: Vector, dt_s: float, start: float, end: float) -> float:
    """Return the time in s between two shares of a build-up, interpolated between samples."""
    share = build_up / build_up[-1]
    return dt_s * (_index_of(share, end) - _index_of(share, start))


def _index_of(share: Vector, level: float) -> float:
    """Return the fractional index at which a non-decreasing history first reaches a level."""
    after = int(np.searchsorted(share, level))
    if after == 0:
        return 0.0
    rise = share[after] - share[after - 1]
    return after - 1 + float((level - share[after - 1]) / rise)


def housner_intensity(accel_mps2: Vector, dt_s: float) -> float:
    """Return the integral of the 5 % pseudo-spectral velocity from 0.1 to 2.5 s, in m."""
    psa_mps2 = component_psa(accel_mps2, dt_s, HOUSNER_PERIODS_S)
    psv_mps = psa_mps2 * HOUSNER_PERIODS_S / (2.0 * np.pi)
    from scipy.integrate import trapezoid

    return float(trapezoid(psv_mps, HOUSNER_PERIODS_S))
