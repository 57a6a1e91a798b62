"""Intensity measures of ground motions, and their strongest parts.

Measures that depend on orientation are RotD50. Arias intensity and CAV are the mean of the two
components. Significant durations use the sum of both Arias build-ups, which does not depend on
orientation. Recorded motions are cut only on request.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.spectrum import (
    SPECTRUM_PERIODS_S,
    component_psa,
    orbit_rotd50,
    pair_psa,
    sa_avg_periods,
)
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
TAPER_S: Final = 0.5
QUIET_SHARE: Final = 1.0e-5  # share of the Arias intensity of both components, cut at each end


def motion_measures(motion: GroundMotion, t1_s: float | None) -> dict[str, float]:
    """Return the intensity measures of a pair (dict); Sa(T1) and Sa_avg are nan without T1."""
    dt_s = motion.dt_s
    pair = motion.components
    sa_t1_g = sa_avg_g = float("nan")
    if t1_s is not None:
        spectrum = pair_psa(*pair, dt_s, conditioned_periods(t1_s))
        sa_t1_g, sa_avg_g = conditioned_levels(spectrum.rotd50_mps2 / G_MPS2)
    arias = pair_arias_build_up(motion)
    return {
        "im_pga_rotd50_g": orbit_rotd50(*pair) / G_MPS2,
        "im_pgv_rotd50_mps": orbit_rotd50(velocity(pair[0], dt_s), velocity(pair[1], dt_s)),
        "im_sa_t1_rotd50_g": sa_t1_g,
        "im_sa_1p000_rotd50_g": float(pair_psa(*pair, dt_s, 1.0).rotd50_mps2[0]) / G_MPS2,
        "im_saavg_rotd50_g": sa_avg_g,
        "im_arias_mps": 0.5 * float(arias[-1]),
        "im_cav_mps": 0.5 * (cav(pair[0], dt_s) + cav(pair[1], dt_s)),
        "im_d5_75_s": significant_duration(arias, dt_s, 0.05, 0.75),
        "im_d5_95_s": significant_duration(arias, dt_s, 0.05, 0.95),
    }


def conditioned_periods(t1_s: float) -> Vector:
    """Return the periods for `conditioned_levels` in s: the 20 periods of Sa_avg, then T1."""
    return np.append(sa_avg_periods(t1_s), t1_s)


def conditioned_levels(psa_g: Vector) -> tuple[float, float]:
    """Return Sa(T1) and Sa_avg in g from the PSA at `conditioned_periods`."""
    return float(psa_g[-1]), float(np.exp(np.log(psa_g[:-1]).mean()))


def scaled_measures(measures: dict[str, float], scale: float) -> dict[str, float]:
    """Return the measures of a scaled motion from the measures of the unscaled motion."""
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


def measures_and_spectra(
    components: Sequence[Vector],
    dt_s: float,
    t1_s: float | None = None,
    periods_s: Sequence[float] | None = None,
) -> dict[str, Any]:
    """Return the measures and spectra of one component or a pair, keyed by printed name.

    ``_h1`` or ``_h2`` in a name marks a component; names without them belong to the pair.
    """
    periods = periods_s or SPECTRUM_PERIODS_S
    table: dict[str, Any] = {}
    for end, accel in zip(("_h1_", "_h2_"), components, strict=False):
        measures = component_measures(accel, dt_s)
        if t1_s is not None:
            psa_g = component_psa(accel, dt_s, conditioned_periods(t1_s)) / G_MPS2
            measures["sa_t1_g"], measures["saavg_g"] = conditioned_levels(psa_g)
        # the unit stays last: pga_h1_g for pga_g
        table |= {end.join(name.rsplit("_", 1)): value for name, value in measures.items()}
        table[f"psa{end}g"] = (component_psa(accel, dt_s, periods) / G_MPS2).tolist()
    if len(components) == 2:
        a_1, a_2 = components
        pair = GroundMotion(motion_id="pair", dt_s=dt_s, accel_1_mps2=a_1, accel_2_mps2=a_2)
        rotd50, rotd100 = ((psa / G_MPS2).tolist() for psa in pair_psa(a_1, a_2, dt_s, periods))
        table |= {"psa_rotd50_g": rotd50, "psa_rotd100_g": rotd100}
        table = motion_measures(pair, t1_s) | table
    return table | {"dt_s": dt_s, "npts": len(components[0]), "periods_s": list(periods)}


def peak_g(accel_mps2: Vector) -> float:
    """Return the largest absolute acceleration in g."""
    return float(np.abs(accel_mps2).max(initial=0.0)) / G_MPS2


def _running_integral(values: Vector, dt_s: float) -> Vector:
    """Return the integral from the first value by the trapezoidal rule."""
    from scipy.integrate import cumulative_trapezoid  # here: every job imports this module

    return cumulative_trapezoid(values, dx=dt_s, initial=0)


def velocity(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return the velocity in m/s from rest by the trapezoidal rule, without filter."""
    return _running_integral(accel_mps2, dt_s)


def displacement(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return the displacement in m from rest; the trapezoidal rule is applied twice."""
    return _running_integral(velocity(accel_mps2, dt_s), dt_s)


def arias_build_up(accel_mps2: Vector, dt_s: float) -> Vector:
    """Return pi/(2 g) times the running integral of the squared acceleration, in m/s."""
    return np.pi / (2.0 * G_MPS2) * _running_integral(accel_mps2**2, dt_s)


def pair_arias_build_up(motion: GroundMotion) -> Vector:
    """Return the sum of both Arias build-ups in m/s, which does not depend on orientation."""
    first, second = (arias_build_up(accel, motion.dt_s) for accel in motion.components)
    return first + second


def cav(accel_mps2: Vector, dt_s: float) -> float:
    """Return the cumulative absolute velocity, the integral of |a|, in m/s."""
    from scipy.integrate import trapezoid

    return float(trapezoid(np.abs(accel_mps2), dx=dt_s))


def significant_duration(build_up: Vector, dt_s: float, start: float, end: float) -> float:
    """Return the time in s in which a build-up grows from share `start` to share `end`."""
    shares = build_up / build_up[-1]
    return dt_s * (_index_of(shares, end) - _index_of(shares, start))


def _index_of(shares: Vector, level: float) -> float:
    """Return the fractional index at which a non-decreasing history first reaches a level."""
    after = int(np.searchsorted(shares, level))
    if after == 0:
        return 0.0
    step = shares[after] - shares[after - 1]
    return after - 1 + float((level - shares[after - 1]) / step)


def housner_intensity(accel_mps2: Vector, dt_s: float) -> float:
    """Return the integral of the 5 % pseudo-spectral velocity from 0.1 to 2.5 s, in m."""
    psa_mps2 = component_psa(accel_mps2, dt_s, HOUSNER_PERIODS_S)
    psv_mps = psa_mps2 * HOUSNER_PERIODS_S / (2.0 * np.pi)
    from scipy.integrate import trapezoid

    return float(trapezoid(psv_mps, HOUSNER_PERIODS_S))


def strongest_part(motion: GroundMotion, shaking_s: float) -> GroundMotion:
    """Return the strongest part of a motion, with a new digest and a message about the cut."""
    strongest = cut_to_strongest(motion, shaking_s, free_vibration_s=0.0)
    share = pair_arias_build_up(strongest)[-1] / pair_arias_build_up(motion)[-1]
    digest = hashlib.sha256(f"{motion.sha256} strongest {shaking_s} s".encode()).hexdigest()
    message = f"cut to the strongest {shaking_s:g} s: {share:.1%} of the Arias intensity kept"
    return replace(strongest, sha256=digest, messages=(*motion.messages, message))


def cut_to_strongest(
    motion: GroundMotion, shaking_s: float, free_vibration_s: float
) -> GroundMotion:
    """Return the strongest part of a motion, which ends at rest, followed by zeros.

    The window of `shaking_s` with the largest Arias intensity (of both components) is kept; shorter
    motions are not cut. The ends are tapered by half a cosine. A symmetric and an antisymmetric
    smooth acceleration over the window remove the velocity and displacement at its end. Raises
    `InputError` for a window of 2 s or less.
    """
    if not shaking_s > 4.0 * TAPER_S:
        raise InputError(f"shaking_s must be above {4.0 * TAPER_S}, got {shaking_s}")
    size = min(round(shaking_s / motion.dt_s), motion.npts)
    arias = pair_arias_build_up(motion)
    first = int(np.argmax(arias[size - 1 :] - arias[: arias.size - size + 1]))
    n_zeros = round(free_vibration_s / motion.dt_s)
    return _window(motion, first, size).mapped(lambda accel: np.pad(accel, (0, n_zeros)))


def trim_quiet_ends(motion: GroundMotion) -> GroundMotion:
    """Return a motion without the quiet parts before and after the shaking; it ends at rest."""
    arias = pair_arias_build_up(motion)
    arias = arias / arias[-1]
    margin = round(2.0 * TAPER_S / motion.dt_s)
    first = max(int(np.searchsorted(arias, QUIET_SHARE)) - margin, 0)
    last = min(int(np.searchsorted(arias, 1.0 - QUIET_SHARE)) + margin, motion.npts)
    return _window(motion, first, last - first)


def _window(motion: GroundMotion, first: int, size: int) -> GroundMotion:
    return motion.mapped(lambda accel: _at_rest(accel[first : first + size], motion.dt_s))


def _at_rest(accel: Vector, dt_s: float) -> Vector:
    """Return a window with tapered ends whose velocity and displacement end at zero."""

    def end_state(history: Vector) -> Vector:
        return np.array([velocity(history, dt_s)[-1], displacement(history, dt_s)[-1]])

    size = accel.size
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(TAPER_S / dt_s)) * dt_s / TAPER_S)
    tapered = accel.copy()
    tapered[: ramp.size] *= ramp
    tapered[size - ramp.size :] *= ramp[::-1]
    share = np.linspace(0.0, 1.0, size)
    hump = share * (1.0 - share)
    shapes = (hump, hump * (1.0 - 2.0 * share))
    end_states = np.array([end_state(shape) for shape in shapes]).T
    amounts = np.linalg.solve(end_states, end_state(tapered))
    return tapered - amounts[0] * shapes[0] - amounts[1] * shapes[1]
