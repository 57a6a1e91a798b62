"""Strong two-component motions made in the tests: they close gaps and yield columns."""

import numpy as np

from skewbridge.motions.record import GroundMotion
from skewbridge.units import G_MPS2

DT_S = 0.01


def strong_motion(duration_s=6.0, peak_g=0.8, seed=7):
    """Return pulses in seeded noise that close the 51 mm gap of OSB1 often within 4 s."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(round(duration_s / DT_S) + 1) * DT_S
    rise = np.clip(t_s / 0.5, 0.0, 1.0) * np.exp(-(((t_s - 2.0) / 1.5) ** 2))
    smooth = np.hanning(15)
    smooth /= smooth.sum()

    def component(period_s, phase):
        noise = np.convolve(rng.standard_normal(t_s.size), smooth, "same")
        wave = rise * (np.cos(2 * np.pi * t_s / period_s + phase) + 0.5 * noise)
        return peak_g * G_MPS2 * wave / np.abs(wave).max()

    return GroundMotion(
        motion_id="strong", dt_s=DT_S, accel_1_mps2=component(0.9, 0.0),
        accel_2_mps2=0.7 * component(0.7, 1.0), sha256="made in the test",
    )  # fmt: skip


def mirrored(motion):
    return motion.with_components(motion.accel_1_mps2, -motion.accel_2_mps2)
