"""Response spectra and intensity measures of ground motions, and their strongest parts.

The oscillator under a piecewise linear base acceleration has an exact recursion (Nigam and
Jennings 1969, Bulletin of the Seismological Society of America 59(2)). For the displacement, the
recursion is a second-order IIR filter. For periods below 10 dt the record is interpolated linearly
with ceil(10 dt/T) steps per sample, as in the published NGA-West2 spectra.

Measures that depend on orientation are RotD50. Arias intensity and CAV are the mean of the two
components. Significant durations use the sum of both Arias build-ups, which does not depend on
orientation. The measures are those of the whole motion, even if an analysis ends before it.
"""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.units import G_MPS2

# ---- Response spectra

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
    """Return the 5 % damped PSA in m/s2: omega^2 x largest relative displacement, (periods,)."""
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
    accel: Vector, dt_s: float, periods_s: ArrayLike, peaks: Callable[[Vector], Any]
) -> Vector:
    """Return omega^2 times ``peaks`` of the displacement of an oscillator, one row per period."""
    periods = np.atleast_1d(np.asarray(periods_s, dtype=np.float64))
    if not (np.isfinite(periods).all() and (periods > 0.0).all()):
        raise InputError(f"periods_s must be positive, got {periods_s}")
    disps_m = _oscillator_disps(accel, dt_s, periods.tolist())
    omegas: list[float] = (2.0 * np.pi / periods).tolist()
    return np.array([peaks(disp) * w**2 for disp, w in zip(disps_m, omegas, strict=True)])


def _oscillator_disps(accel: Vector, dt_s: float, periods_s: Sequence[float]) -> Iterator[Vector]:
    """Yield the displacement (m) of each oscillator over the time of the record, (..., n)."""
    from scipy.signal import lfilter  # here: its import takes a second

    refined, refined_by = accel, 1
    for period_s in periods_s:
        substeps = max(int(np.ceil(STEPS_PER_PERIOD * dt_s / period_s - 1.0e-9)), 1)
        if substeps != refined_by:
            refined, refined_by = _in_substeps(accel, substeps), substeps
        b, a, initial = _filter(2.0 * np.pi / period_s, DAMPING_RATIO, dt_s / substeps)
        yield lfilter(b, a, refined, axis=-1, zi=refined[..., :1] * initial)[0]


def _in_substeps(accel: Vector, substeps: int) -> Vector:
    fractions = np.arange(substeps) / substeps
    interpolated = accel[..., :-1, None] + np.diff(accel)[..., None] * fractions
    return np.concatenate([interpolated.reshape(*accel.shape[:-1], -1), accel[..., -1:]], axis=-1)


def _filter(omega: float, xi: float, dt_s: float) -> tuple[Vector, Vector, Vector]:
    """Return numerator, denominator and initial state of the filter for the displacement.

    The oscillator is at rest when a first sample of 1 arrives. The velocity is eliminated from the
    exact step x[i+1] = A x[i] + B p[i..i+1] for x = (displacement, velocity), p = acceleration.
    """
    damped_ratio = np.sqrt(1.0 - xi * xi)
    omega_d = omega * damped_ratio
    decay = np.exp(-xi * omega * dt_s)
    sine, cosine = np.sin(omega_d * dt_s), np.cos(omega_d * dt_s)
    a11 = decay * (xi / damped_ratio * sine + cosine)
    a12 = decay * sine / omega_d
    a22 = decay * (cosine - xi / damped_ratio * sine)
    determinant = decay * decay

    slope = (2.0 * xi * xi - 1.0) / (omega**2 * dt_s)
    offset = 2.0 * xi / (omega**3 * dt_s)
    velocity_s = cosine - xi / damped_ratio * sine
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
    far_points = np.flatnonzero(squared >= 0.9**2 * squared.max())
    sample = far_points[:: far_points.size // 40 + 1]
    lower_bounds = np.sort(_largest_projections(x[sample], y[sample]))
    is_outer = squared >= lower_bounds[(ORIENTATIONS - 1) // 2] ** 2
    projections = _largest_projections(x[is_outer], y[is_outer])
    return np.array([np.median(projections), projections.max()])


def _largest_projections(x: Vector, y: Vector) -> Vector:
    # Not a matrix product: its threads cost more than they save on arrays this small.
    return np.abs(_COSINES * x + _SINES * y).max(axis=1)


# ---- Intensity measures

IM_COLUMNS: Final = (
    "im_pga_rotd50_g", "im_pgv_rotd50_mps", "im_sa_t1_rotd50_g", "im_sa_1p000_rotd50_g",
    "im_saavg_rotd50_g", "im_arias_mps", "im_cav_mps", "im_d5_75_s", "im_d5_95_s",
)  # fmt: skip
#: Exponent of the scale factor, if it is not 1.
_SCALE_POWERS: Final = {"im_arias_mps": 2, "im_d5_75_s": 0, "im_d5_95_s": 0}
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
    powers = dict.fromkeys(IM_COLUMNS, 1) | _SCALE_POWERS
    return {name: value * scale ** powers[name] for name, value in measures.items()}


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
    components: Sequence[Vector], dt_s: float, t1_s: float | None = None
) -> dict[str, Any]:
    """Return the measures and spectra of one component or a pair, keyed by printed name.

    ``_h1`` or ``_h2`` in a name marks a component; names without them belong to the pair.
    """
    periods = SPECTRUM_PERIODS_S
    table: dict[str, Any] = {}
    for mark, accel in zip(("_h1_", "_h2_"), components, strict=False):
        measures = component_measures(accel, dt_s)
        if t1_s is not None:
            psa_g = component_psa(accel, dt_s, conditioned_periods(t1_s)) / G_MPS2
            measures["sa_t1_g"], measures["saavg_g"] = conditioned_levels(psa_g)
        # the unit stays last: pga_h1_g for pga_g
        table |= {mark.join(name.rsplit("_", 1)): value for name, value in measures.items()}
        table[f"psa{mark}g"] = (component_psa(accel, dt_s, periods) / G_MPS2).tolist()
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
    build_up_1, build_up_2 = (arias_build_up(accel, motion.dt_s) for accel in motion.components)
    return build_up_1 + build_up_2


def cav(accel_mps2: Vector, dt_s: float) -> float:
    """Return the cumulative absolute velocity, the integral of |a|, in m/s."""
    return float(np.trapezoid(np.abs(accel_mps2), dx=dt_s))


def significant_duration(build_up: Vector, dt_s: float, start: float, end: float) -> float:
    """Return the time in s in which a build-up grows from `start` to `end`, shares of its total."""
    shares, positions = build_up / build_up[-1], np.arange(build_up.size)
    first, last = np.interp([start, end], shares, positions)
    return dt_s * float(last - first)


def housner_intensity(accel_mps2: Vector, dt_s: float) -> float:
    """Return the integral of the 5 % pseudo-spectral velocity from 0.1 to 2.5 s, in m."""
    psa_mps2 = component_psa(accel_mps2, dt_s, HOUSNER_PERIODS_S)
    psv_mps = psa_mps2 * HOUSNER_PERIODS_S / (2.0 * np.pi)
    return float(np.trapezoid(psv_mps, HOUSNER_PERIODS_S))


def strongest_part(motion: GroundMotion, shaking_s: float) -> GroundMotion:
    """Return the strongest part of a motion, with a new digest and a message about the cut.

    A motion that is not longer than ``shaking_s`` does not change.
    """
    if motion.npts <= round(shaking_s / motion.dt_s):
        return motion
    strongest = cut_to_strongest(motion, shaking_s, free_vibration_s=0.0)
    share = pair_arias_build_up(strongest)[-1] / pair_arias_build_up(motion)[-1]
    digest = hashlib.sha256(f"{motion.sha256} strongest {shaking_s} s".encode()).hexdigest()
    message = f"cut to the strongest {shaking_s:g} s: {share:.1%} of the Arias intensity kept"
    return replace(strongest, sha256=digest, messages=(*motion.messages, message))


def cut_warning(motion: GroundMotion, duration_s: float | None) -> str:
    """Return a warning if a motion cut to this length (s) loses strong shaking, or no text."""
    if duration_s is None:
        return ""
    kept_part = slice(motion.npts_until(duration_s))
    arias, size_g = pair_arias_build_up(motion), np.hypot(*motion.components) / G_MPS2
    peak_g, whole_peak_g = size_g[kept_part].max(), size_g.max()
    # strong shaking ends at 95 % of the Arias intensity, as in the significant duration
    if arias[kept_part][-1] >= 0.95 * arias[-1] and peak_g == whole_peak_g:
        return ""
    return (
        f"motion {motion.motion_id}: {1.0 - arias[kept_part][-1] / arias[-1]:.0%} of the Arias "
        f"intensity is after duration_s = {duration_s:g} (unscaled peak until then {peak_g:.3g} of "
        f"{whole_peak_g:.3g} g), but the intensity measures are those of the whole motion"
    )


def shaken_s(motion: GroundMotion, t1_s: float, tail_ratio: float | None) -> float:
    """Return the time (s) after which a motion cannot raise peaks of a bridge; None: its length.

    Afterwards the displacements in plan of the 5 % damped oscillators with the periods of Sa_avg,
    up to 3 T1, stay below ``tail_ratio`` of their peaks.
    """
    # ASSUME such oscillators cover a bridge whose joints close and columns yield
    if tail_ratio is None:
        return motion.duration_s
    pair, end_share = np.stack(motion.components), 0.0
    for disps_m in _oscillator_disps(pair, motion.dt_s, sa_avg_periods(t1_s).tolist()):
        radius_m = np.hypot(*disps_m)
        last = int(np.flatnonzero(radius_m >= tail_ratio * radius_m.max())[-1])
        end_share = max(end_share, last / radius_m.size)
    return end_share * motion.duration_s


def cut_to_strongest(
    motion: GroundMotion, shaking_s: float, free_vibration_s: float
) -> GroundMotion:
    """Return the strongest part of a motion, which ends at rest, followed by zeros.

    The window of `shaking_s` with the largest Arias intensity (of both components) is kept, or a
    shorter motion as a whole. The ends are tapered by half a cosine. A symmetric and an
    antisymmetric smooth acceleration remove the velocity and displacement at the end. Raises
    `InputError` for a window of 2 s or less, or zeros of more than 600 s.
    """
    if not shaking_s > 4.0 * TAPER_S:
        raise InputError(f"shaking_s must be above {4.0 * TAPER_S}, got {shaking_s}")
    if not 0.0 <= free_vibration_s <= 600.0:
        raise InputError(f"free_vibration_s must be within 0 to 600, got {free_vibration_s}")
    size = min(round(shaking_s / motion.dt_s), motion.npts)
    arias = pair_arias_build_up(motion)
    start = int(np.argmax(arias[size - 1 :] - arias[: arias.size - size + 1]))
    n_zeros = round(free_vibration_s / motion.dt_s)
    return _window(motion, start, size).mapped(lambda accel: np.pad(accel, (0, n_zeros)))


def trim_quiet_ends(motion: GroundMotion) -> GroundMotion:
    """Return a motion without the quiet parts before and after the shaking; it ends at rest."""
    arias = pair_arias_build_up(motion)
    arias = arias / arias[-1]
    margin = round(2.0 * TAPER_S / motion.dt_s)
    start = max(int(np.searchsorted(arias, QUIET_SHARE)) - margin, 0)
    stop = min(int(np.searchsorted(arias, 1.0 - QUIET_SHARE)) + margin, motion.npts)
    return _window(motion, start, stop - start)


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
    parabola = share * (1.0 - share)
    corrections = (parabola, parabola * (1.0 - 2.0 * share))
    end_states = np.array([end_state(shape) for shape in corrections]).T
    amplitudes = np.linalg.solve(end_states, end_state(tapered))
    return tapered - amplitudes[0] * corrections[0] - amplitudes[1] * corrections[1]
