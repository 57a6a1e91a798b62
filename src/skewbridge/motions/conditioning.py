"""Cutting of motions, with the effect on their measures.

Recorded motions stay as they are unless this is requested.
"""

import hashlib
from dataclasses import replace
from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.intensity import displacement, pair_arias_build_up, velocity
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.spectrum import pair_psa

TAPER_S: Final = 0.5
QUIET_SHARE: Final = 1.0e-5  # of the Arias intensity of both components, dropped at each end
EFFECT_PERIODS_S: Final = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)


def strongest_part(motion: GroundMotion, shaking_s: float) -> GroundMotion:
    """Return the strongest part of a motion; its digest and messages state the cut."""
    part = cut_to_strongest(motion, shaking_s, free_vibration_s=0.0)
    share = effect_on_measures(motion, part)["arias_ratio"]
    digest = hashlib.sha256(f"{motion.sha256} strongest {shaking_s} s".encode()).hexdigest()
    message = f"cut to the strongest {shaking_s:g} s: {share:.1%} of the Arias intensity left"
    return replace(part, sha256=digest, messages=(*motion.messages, message))


def cut_to_strongest(
    motion: GroundMotion, shaking_s: float, free_vibration_s: float
) -> GroundMotion:
    """Return the strongest part of a motion, ending at rest, with zeros after it.

    The window of the given length with the most Arias intensity (of both components) is kept, its
    ends are tapered by half a cosine, and the velocity and displacement at its end are removed by
    two smooth accelerations over the window, a symmetric and an antisymmetric one. A shorter motion
    is kept whole. `InputError` for a length that is not positive.
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
    """Return the motion with zeros added at its end."""
    if not 0.0 <= seconds <= 600.0:
        raise InputError(f"free_vibration_s must be within 0 to 600, got {seconds}")
    tail = round(seconds / motion.dt_s)
    return motion.mapped(lambda accel: np.pad(accel, (0, tail)))


def effect_on_measures(before: GroundMotion, after: GroundMotion) -> dict[str, float]:
    """Return ratios after over before: ``arias_ratio``, ``psa_<period>_ratio`` of RotD50."""
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
    ends = np.array([end_state(shape) for shape in shapes]).T
    amounts = np.linalg.solve(ends, end_state(tapered))
    return tapered - amounts[0] * shapes[0] - amounts[1] * shapes[1]
