"""Frequency content of histories: mean periods and Fourier ratios with and without friction.

References:
    Rathje, Abrahamson and Bray (1998), J. Geotech. Geoenviron. Eng. 124(2):150-159: mean period.
    Konno and Ohmachi (1998), BSSA 88(1):228-241: smoothing on a logarithmic frequency axis.
"""

from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.fragility.columns import FloatArray

DEFAULT_BAND_HZ: Final = (0.1, 10.0)
_BANDWIDTH: Final = 40.0  # source: Konno and Ohmachi (1998), their b for engineering use


def mean_period_s(
    values: FloatArray, dt_s: float, band_hz: tuple[float, float] = DEFAULT_BAND_HZ
) -> float:
    """Return the mean period sum(A^2/f)/sum(A^2) of a history, for example of the deck, s.

    The history has shape (n,) and is equally spaced; its mean is taken off.

    Raises:
        InputError: The history is constant, too short or not finite.
    """
    frequency, amplitude = fourier_amplitude(values, dt_s, band_hz)
    power = amplitude**2
    return float(np.sum(power / frequency) / np.sum(power))


def fourier_amplitude(
    values: FloatArray, dt_s: float, band_hz: tuple[float, float] = DEFAULT_BAND_HZ
) -> tuple[FloatArray, FloatArray]:
    """Return frequencies in the band and Fourier amplitudes (unit of the history times s)."""
    if values.ndim != 1 or values.size < 16 or not np.all(np.isfinite(values)):
        raise InputError(f"a history needs 16 or more finite values, got shape {values.shape}")
    if not dt_s > 0.0:
        raise InputError(f"dt_s must be > 0, got {dt_s:g}")
    centred = values - np.mean(values)
    if np.ptp(centred) == 0.0:
        raise InputError("a constant history has no frequency content")
    # padded to a power of two above twice the length, so that the band is finely sampled
    size = 1 << (2 * centred.size - 1).bit_length()
    spectrum = np.abs(np.fft.rfft(centred, size)) * dt_s
    frequency = np.fft.rfftfreq(size, dt_s)
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    if np.sum(inside) < 8:
        raise InputError(
            f"band {band_hz} Hz holds {int(np.sum(inside))} frequencies of the history, need 8"
        )
    return frequency[inside], spectrum[inside]


def fourier_ratio(
    with_friction: FloatArray,
    without: FloatArray,
    dt_s: float,
    grid_hz: FloatArray,
    band_hz: tuple[float, float] = DEFAULT_BAND_HZ,
) -> FloatArray:
    """Return the ratio of smoothed Fourier amplitudes of two histories at given frequencies.

    Both histories, shape (n,), are of the same motion; ``grid_hz`` lies inside the band.
    """
    f_top, top = fourier_amplitude(with_friction, dt_s, band_hz)
    f_bottom, bottom = fourier_amplitude(without, dt_s, band_hz)
    return konno_ohmachi(f_top, top, grid_hz) / konno_ohmachi(f_bottom, bottom, grid_hz)


def konno_ohmachi(frequency: FloatArray, amplitude: FloatArray, grid: FloatArray) -> FloatArray:
    """Return the smoothed amplitude: window [sin(b log10 f/fc)/(b log10 f/fc)]^4, b = 40."""
    argument = _BANDWIDTH * np.log10(frequency / grid[:, None])
    window = np.sinc(argument / np.pi) ** 4
    return window @ amplitude / np.sum(window, axis=1)
