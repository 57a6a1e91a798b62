"""Cutting and resampling of motions, with the effect on their measures.

Recorded motions stay as they are unless this is requested.
"""

import hashlib
import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.intensity import displacement, pair_arias_build_up, velocity
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.spectrum import pair_psa

TAPER_S: Final = 0.5
QUIET_SHARE: Final = 1.0e-5  # of the Arias intensity of both components, dropped at each end
MAX_RATIO: Final = 100  # of two time steps
EFFECT_PERIODS_S: Final = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditioning:
    """Treatment of each motion of a suite; by default none.

    Attributes:
        remove_mean: Subtract the mean of each component.
        dt_s: Resample to this time step, low-passed.
        shaking_s: Keep only the strongest part of this length.
        free_vibration_s: Zeros added at the end.
    """

    remove_mean: bool = False
    dt_s: float | None = None
    shaking_s: float | None = None
    free_vibration_s: float = 0.0

    def apply(self, motion: GroundMotion) -> GroundMotion:
        """Return the conditioned motion; its digest and messages state the treatment."""
        if self == Conditioning():
            return motion
        result = remove_mean(motion) if self.remove_mean else motion
        if self.dt_s is not None:
            result = resampled(result, self.dt_s)
        if self.shaking_s is None:
            result = add_free_vibration(result, self.free_vibration_s)
        else:
            result = cut_to_strongest(result, self.shaking_s, self.free_vibration_s)
        kept = effect_on_measures(motion, result)["arias_ratio"]
        digest = hashlib.sha256(f"{motion.sha256} {self!r}".encode()).hexdigest()
        message = f"conditioned ({self!r}): {kept:.1%} of the Arias intensity left"
        return replace(result, sha256=digest, messages=(*motion.messages, message))


def cut_to_strongest(
    motion: GroundMotion, shaking_s: float, free_vibration_s: float
) -> GroundMotion:
    """Return the strongest part of a motion, ending at rest, with zeros after it.

    The window of the given length with the most Arias intensity (of both components) is kept, its
    ends are tapered by half a cosine, and the velocity and displacement at its end are removed by
    two smooth accelerations over the window, a symmetric and an antisymmetric one. A shorter motion
    is kept whole.

    Raises:
        InputError: A length that is not positive.
    """
    if not shaking_s > 4.0 * TAPER_S:
        raise InputError(f"shaking_s must be above {4.0 * TAPER_S}, got {shaking_s}")
    size = min(round(shaking_s / motion.dt_s), motion.npts)
    both = pair_arias_build_up(motion)
    first = int(np.argmax(both[size - 1 :] - both[: both.size - size + 1]))
    return add_free_vibration(_window(motion, first, size), free_vibration_s)


def trim_quiet_ends(motion: GroundMotion) -> GroundMotion:
    """Return a motion without the quiet parts before and after the shaking, ending at rest."""
    both = pair_arias_build_up(motion)
    both = both / both[-1]
    margin = round(2.0 * TAPER_S / motion.dt_s)
    first = max(int(np.searchsorted(both, QUIET_SHARE)) - margin, 0)
    last = min(int(np.searchsorted(both, 1.0 - QUIET_SHARE)) + margin, motion.npts)
    return _window(motion, first, last - first)


def add_free_vibration(motion: GroundMotion, seconds: float) -> GroundMotion:
    """Return the motion with zeros added at its end.

    Raises:
        InputError: A negative length.
    """
    if not 0.0 <= seconds <= 600.0:
        raise InputError(f"free_vibration_s must be within 0 to 600, got {seconds}")
    tail = round(seconds / motion.dt_s)
    return motion.mapped(lambda accel: np.pad(accel, (0, tail)))


def remove_mean(motion: GroundMotion) -> GroundMotion:
    """Return the motion without the mean of each component (a constant baseline offset)."""
    return motion.mapped(lambda accel: accel - accel.mean())


def resampled(motion: GroundMotion, dt_s: float) -> GroundMotion:
    """Return the motion at another time step, low-passed against aliasing where it gets coarser.

    The new values are those of the band-limited signal, by a symmetric (zero-phase) filter.

    Raises:
        InputError: The ratio of the time steps is not a ratio of integers up to 100.
    """
    if not (np.isfinite(dt_s) and dt_s > 0.0):
        raise InputError(f"dt_s must be positive, got {dt_s}")
    ratio = motion.dt_s / dt_s
    up, down = Fraction(ratio).limit_denominator(MAX_RATIO).as_integer_ratio()
    if not (1 <= up <= MAX_RATIO and math.isclose(up / down, ratio, rel_tol=1.0e-9)):
        raise InputError(f"time steps with ratio {ratio:.6g} can't be resampled: no small ratio")
    if up == down:
        return motion
    # An edge at 90 % of the lower Nyquist frequency, 80 dB down beyond it
    factor = max(up, down)
    from scipy.signal import firwin, resample_poly  # here: every job imports this module

    taps = firwin(2 * 40 * factor + 1, 0.9 / factor, window=("kaiser", 8.0))
    return motion.mapped(
        lambda accel: resample_poly(accel, up, down, window=taps), dt_s=motion.dt_s * down / up
    )


def effect_on_measures(before: GroundMotion, after: GroundMotion) -> dict[str, float]:
    """Return measures of a motion after a treatment, as ratios to those before.

    Returns:
        ``arias_ratio`` and ``psa_<period>_ratio`` of RotD50 at a few periods.
    """
    both = (before, after)
    arias = [float(pair_arias_build_up(motion)[-1]) for motion in both]
    psa = [pair_psa(*m.components, m.dt_s, EFFECT_PERIODS_S).rotd50_mps2 for m in both]
    names = [f"psa_{period_s:g}_ratio" for period_s in EFFECT_PERIODS_S]
    ratios = (psa[1] / psa[0]).tolist()
    return {"arias_ratio": arias[1] / arias[0], **dict(zip(names, ratios, strict=True))}


def _window(motion: GroundMotion, first: int, size: int) -> GroundMotion:
    return motion.mapped(lambda accel: _at_rest(accel[first : first + size], motion.dt_s))


def _at_rest(accel: Vector, dt_s: float) -> Vector:
    """Return a window with tapered ends whose velocity and displacement end at zero."""
    size = accel.size
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(TAPER_S / dt_s)) * dt_s / TAPER_S)
    tapered = accel.copy()
    tapered[: ramp.size] *= ramp
    tapered[size - ramp.size :] *= ramp[::-1]
    share = np.linspace(0.0, 1.0, size)
    hump = share * (1.0 - share)
    shapes = (hump, hump * (1.0 - 2.0 * share))
    ends = np.array([_end_state(shape, dt_s) for shape in shapes]).T
    amounts = np.linalg.solve(ends, _end_state(tapered, dt_s))
    return tapered - amounts[0] * shapes[0] - amounts[1] * shapes[1]


def _end_state(accel: Vector, dt_s: float) -> Vector:
    return np.array([velocity(accel, dt_s)[-1], displacement(accel, dt_s)[-1]])
