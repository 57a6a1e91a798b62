"""Cutting and resampling of motions, and what it does to them.

None of this is applied to recorded motions unless asked for.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, resample_poly

from skewbridge.errors import InputError
from skewbridge.motions.intensity import arias_build_up
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.spectrum import pair_psa

type Vector = NDArray[np.float64]

TAPER_S: Final = 0.5
EFFECT_PERIODS_S: Final = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)


def cut_to_strongest(
    motion: GroundMotion, shaking_s: float, free_vibration_s: float
) -> GroundMotion:
    """Return the strongest part of a motion, ending at rest, with zeros after it.

    The window of the given length with the most Arias intensity (of both components) is kept, its
    ends are tapered by half a cosine, and the velocity left at its end is removed by a parabola
    of acceleration over the window.

    Args:
        motion: The motion.
        shaking_s: Longest part kept; a shorter motion is kept whole.
        free_vibration_s: Zeros added, in s.

    Raises:
        InputError: A length that is not positive.
    """
    if not shaking_s > 4.0 * TAPER_S:
        msg = f"shaking_s must be above {4.0 * TAPER_S}, got {shaking_s}"
        raise InputError(msg)
    if not free_vibration_s >= 0.0:
        msg = f"free_vibration_s must not be negative, got {free_vibration_s}"
        raise InputError(msg)
    dt_s = motion.dt_s
    size = min(round(shaking_s / dt_s), motion.npts)
    both = arias_build_up(motion.accel_1_mps2, dt_s) + arias_build_up(motion.accel_2_mps2, dt_s)
    first = int(np.argmax(both[size - 1 :] - both[: both.size - size + 1]))
    tail = round(free_vibration_s / dt_s)
    parts = [
        np.pad(_at_rest(accel[first : first + size], dt_s), (0, tail))
        for accel in (motion.accel_1_mps2, motion.accel_2_mps2)
    ]
    return motion.with_components(parts[0], parts[1])


def add_free_vibration(motion: GroundMotion, seconds: float) -> GroundMotion:
    """Return the motion with zeros added at its end."""
    tail = round(seconds / motion.dt_s)
    return motion.with_components(
        np.pad(motion.accel_1_mps2, (0, tail)), np.pad(motion.accel_2_mps2, (0, tail))
    )


def remove_mean(motion: GroundMotion) -> GroundMotion:
    """Return the motion with the mean of each component taken off (a constant baseline offset)."""
    return motion.with_components(
        motion.accel_1_mps2 - motion.accel_1_mps2.mean(),
        motion.accel_2_mps2 - motion.accel_2_mps2.mean(),
    )


def resampled(motion: GroundMotion, dt_s: float) -> GroundMotion:
    """Return the motion at another time step, low-passed against aliasing where it gets coarser.

    The new values are those of the band-limited signal, by a symmetric (zero-phase) filter.

    Raises:
        InputError: The ratio of the time steps is no ratio of integers up to 1000.
    """
    if not (np.isfinite(dt_s) and dt_s > 0.0):
        msg = f"dt_s must be positive, got {dt_s}"
        raise InputError(msg)
    ratio = motion.dt_s / dt_s
    up, down = _small_ratio(ratio)
    if up == down:
        return motion
    # An edge at 90 % of the lower Nyquist frequency, 80 dB down beyond it
    factor = max(up, down)
    taps = firwin(2 * 40 * factor + 1, 0.9 / factor, window=("kaiser", 8.0))
    parts = [
        resample_poly(accel, up, down, window=taps)
        for accel in (motion.accel_1_mps2, motion.accel_2_mps2)
    ]
    return motion.with_components(parts[0], parts[1], dt_s=motion.dt_s * down / up)


def effect_on_measures(before: GroundMotion, after: GroundMotion) -> dict[str, float]:
    """Return what a treatment left of a motion, as ratios after/before.

    Returns:
        ``arias_ratio`` and ``psa_<period>_ratio`` of RotD50 at a few periods.
    """
    arias = [
        float(
            arias_build_up(m.accel_1_mps2, m.dt_s)[-1] + arias_build_up(m.accel_2_mps2, m.dt_s)[-1]
        )
        for m in (before, after)
    ]
    psa = [
        pair_psa(m.accel_1_mps2, m.accel_2_mps2, m.dt_s, EFFECT_PERIODS_S).rotd50_mps2
        for m in (before, after)
    ]
    ratios = psa[1] / psa[0]
    named = {
        f"psa_{period_s:g}_ratio": float(ratio)
        for period_s, ratio in zip(EFFECT_PERIODS_S, ratios, strict=True)
    }
    return {"arias_ratio": arias[1] / arias[0]} | named


def _at_rest(accel: Vector, dt_s: float) -> Vector:
    """Return a window with tapered ends whose velocity ends at zero."""
    size = accel.size
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(TAPER_S / dt_s)) * dt_s / TAPER_S)
    tapered = accel.copy()
    tapered[: ramp.size] *= ramp
    tapered[size - ramp.size :] *= ramp[::-1]
    share = np.linspace(0.0, 1.0, size)
    hump = share * (1.0 - share)
    return tapered - hump * (np.sum(tapered) / np.sum(hump))  # both end at 0: sum = trapezoid


def _small_ratio(ratio: float) -> tuple[int, int]:
    for down in range(1, 1001):
        up = round(ratio * down)
        if 1 <= up <= 1000 and math.isclose(up / down, ratio, rel_tol=1.0e-6):
            return up, down
    msg = f"time steps with ratio {ratio:.6g} can't be resampled: no small ratio"
    raise InputError(msg)
