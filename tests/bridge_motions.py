"""Ground motions made in the tests, strong enough to close gaps and yield columns."""

import numpy as np

from skewbridge.motions.record import GroundMotion


def pulse_motion(
    *, duration_s: float = 5.0, peak_mps2: float = 7.0, mirrored: bool = False
) -> GroundMotion:
    """Return two-component pulses with incommensurate periods, mirrored about x if asked."""
    dt_s = 0.005
    t = np.arange(0.0, duration_s + dt_s / 2, dt_s)
    window = np.sin(np.pi * np.clip(t / duration_s, 0.0, 1.0)) ** 2
    along = peak_mps2 * window * np.sin(2 * np.pi * t / 0.9)
    across = 0.8 * peak_mps2 * window * np.sin(2 * np.pi * t / 0.61 + 0.7)
    return GroundMotion(
        motion_id="pulses",
        dt_s=dt_s,
        accel_1_mps2=along,
        accel_2_mps2=-across if mirrored else across,
        sha256="",
    )
