"""Accelerations of the model: modulated filtered white noise, high-passed, plus a pulse.

Equations of Dabaghi and Der Kiureghian (2018); all accelerations in this module are in g.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from skewbridge.motions.intensity import arias_build_up
from skewbridge.motions.record import Vector
from skewbridge.motions.synthesis.ddk18 import Background, ModelParameters, Pulse
from skewbridge.units import G_MPS2, GAL

MIN_FREQUENCY_HZ: Final = 0.3  # source: DDK18, floor of the filter frequency
DURATION_OF_D0_95: Final = 2.5
_NEGLIGIBLE: Final = 1.0e-9  # share of an impulse response that is dropped
_MODEL_G_CM_S2: Final = 981.0  # the model's own g: its Arias intensities are in cm/s with it
_STARTS: Final = ((1.0, 0.2), (2.0, 0.2), (5.0, 0.2), (1.0, 1.0), (2.0, 1.0), (5.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulation:
    """Envelope q(t): rises as c (t/peak)^power until the peak, then falls as exp(-decay t).

    Attributes:
        power: Exponent of the rise.
        decay_per_s: Rate of the fall.
        peak_s: Time of the peak.
        amplitude_g: Value at the peak.
    """

    power: float
    decay_per_s: float
    peak_s: float
    amplitude_g: float

    def at(self, time_s: Vector) -> Vector:
        """Return the envelope in g."""
        rise = np.minimum(time_s / self.peak_s, 1.0) ** self.power
        fall = np.exp(-self.decay_per_s * np.maximum(time_s - self.peak_s, 0.0))
        return self.amplitude_g * rise * fall

    def time_of_share(self, share: float) -> float:
        """Return the time by which a share of the integral of q^2 is reached."""
        decay, rising = self.decay_per_s, self.peak_s / (2.0 * self.power + 1.0)
        energy = share * (rising + 0.5 / decay)
        if energy <= rising:
            return self.peak_s * (energy / rising) ** (1.0 / (2.0 * self.power + 1.0))
        return self.peak_s - np.log1p(-2.0 * decay * (energy - rising)) / (2.0 * decay)


def fit_modulation(arias_cm_s: float, d5_95_s: float, d0_5_s: float, d0_30_s: float) -> Modulation:
    """Return the envelope whose 5, 30 and 95 % times are nearest to the given ones."""
    wanted_s = np.array([d0_5_s, d0_30_s, d0_5_s + d5_95_s])
    shares = (0.05, 0.30, 0.95)

    def misfit(logs: Vector) -> Vector:
        power, decay, peak_s = (float(value) for value in np.exp(logs))
        shape = Modulation(power=power, decay_per_s=decay, peak_s=peak_s, amplitude_g=1.0)
        return np.array([shape.time_of_share(share) for share in shares]) - wanted_s

    best = None
    bounds = (np.log([1e-3, 1e-3, 1e-2]), np.log([100.0, 100.0, 200.0]))
    for power, decay in _STARTS:
        start = np.log([power, decay, d0_30_s])
        fit = least_squares(misfit, start, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
        if best is None or fit.cost < best.cost:
            best = fit
        if best.cost < 1.0e-12:
            break
    power, decay, peak_s = (float(value) for value in np.exp(best.x)) if best else (1.0, 1.0, 1.0)
    total_s = peak_s / (2.0 * power + 1.0) + 0.5 / decay
    amplitude_g = np.sqrt(arias_cm_s / _MODEL_G_CM_S2 / (0.5 * np.pi * total_s))
    return Modulation(power=power, decay_per_s=decay, peak_s=peak_s, amplitude_g=float(amplitude_g))


def envelope_of(background: Background) -> Modulation:
    """Return the envelope of a component."""
    b = background
    return fit_modulation(b.arias_cm_s, b.d5_95_s, b.d0_5_s, b.d0_30_s)


def meets_its_times(background: Background) -> bool:
    """Say whether the envelope of a component has exactly the times that it is fitted to.

    Of some drawn times there is none. The nearest one is then at a kink of the misfit, where the
    search stops at a place that differs between processors.
    """
    fit = envelope_of(background)
    d0_95_s = background.d0_5_s + background.d5_95_s
    wanted_s = {0.05: background.d0_5_s, 0.30: background.d0_30_s, 0.95: d0_95_s}
    return all(
        abs(fit.time_of_share(share) - time_s) < 1.0e-6 for share, time_s in wanted_s.items()
    )


def filtered_noise(
    background: Background, modulation: Modulation, noise: Vector, dt_s: float
) -> Vector:
    """Return the response of the time-varying filter to white noise, of unit variance.

    Each impulse rings at the filter frequency of its own instant. All impulses are advanced
    together by one lag at a time, until the slowest has died out.
    """
    npts = noise.size
    time_s = np.arange(npts, dtype=np.float64) * dt_s
    first_s, middle_s, last_s = (modulation.time_of_share(share) for share in (0.01, 0.30, 0.99))
    clock_s = np.clip(time_s, first_s, last_s)
    frequency_hz = background.f_mid_hz + background.f_slope_hz_per_s * (clock_s - middle_s)
    omega = 2.0 * np.pi * np.maximum(frequency_hz, MIN_FREQUENCY_HZ)
    zeta = background.damping_ratio
    step = np.exp((-zeta + 1j * np.sqrt(1.0 - zeta * zeta)) * omega * dt_s)
    lags = int(np.ceil(-np.log(_NEGLIGIBLE) / (zeta * float(omega.min()) * dt_s)))
    total, square = np.zeros(npts), np.zeros(npts)
    state = omega.astype(np.complex128)
    for lag in range(1, min(lags, npts)):
        state = state[: npts - lag] * step[: npts - lag]
        response = state.imag
        total[lag:] += response * noise[: npts - lag]
        square[lag:] += response * response
    return np.divide(total, np.sqrt(square), out=np.zeros(npts), where=square > 0.0)


def corner_frequency_hz(magnitude: float) -> float:
    """Return the corner of the model's high-pass filter."""
    return 10.0 ** (1.4071 - 0.3452 * magnitude)  # source: DDK18


def high_pass(accel_g: Vector, dt_s: float, corner_hz: float) -> Vector:
    """Return the acceleration after a zero-phase Butterworth high-pass of order 4."""
    frequency_hz = np.fft.rfftfreq(accel_g.size, dt_s)
    frequency_hz[0] = frequency_hz[1]
    gain = 1.0 / np.sqrt(1.0 + (corner_hz / frequency_hz) ** 8)
    gain[0] = 0.0
    return np.fft.irfft(np.fft.rfft(accel_g) * gain, accel_g.size)


def simulate_background(
    parameters: ModelParameters, magnitude: float, rng: np.random.Generator, dt_s: float
) -> tuple[Vector, Vector, float]:
    """Return two background components in g without pulse, and the time the motion starts.

    The zero pads the filter needs stay at both ends; the model's t = 0 is the returned time.
    """
    parts = (parameters.component_1, parameters.component_2)
    envelopes = [envelope_of(part) for part in parts]
    pulse = parameters.pulse
    duration_s = DURATION_OF_D0_95 * max(b.d0_5_s + b.d5_95_s for b in parts)
    if pulse is not None:
        duration_s = max(duration_s, pulse.peak_time_s + pulse.oscillations * pulse.period_s)
    npts = int(np.ceil(duration_s / dt_s)) + 1
    time_s = np.arange(npts, dtype=np.float64) * dt_s
    corner_hz = corner_frequency_hz(magnitude)
    pad = int(np.ceil(0.5 * 1.5 * 4 / corner_hz / dt_s))
    components: list[Vector] = []
    for part, envelope in zip(parts, envelopes, strict=True):
        noise = rng.standard_normal(npts)
        shaking = envelope.at(time_s) * filtered_noise(part, envelope, noise, dt_s)
        accel_g = high_pass(np.pad(shaking, pad), dt_s, corner_hz)
        components.append(accel_g * np.sqrt(part.arias_cm_s / arias_cm_s(accel_g, dt_s)))
    return components[0], components[1], pad * dt_s


def arias_cm_s(accel_g: Vector, dt_s: float) -> float:
    """Return the Arias intensity in cm/s with the model's g."""
    of_standard_g = float(arias_build_up(accel_g * G_MPS2, dt_s)[-1]) / GAL
    return of_standard_g * _MODEL_G_CM_S2 * GAL / G_MPS2


def pulse_acceleration(pulse: Pulse, time_s: Vector) -> Vector:
    """Return the acceleration of the modified Mavroeidis-Papageorgiou velocity pulse, in g."""
    fp = 1.0 / pulse.period_s
    gamma, nu = pulse.oscillations, pulse.phase_rad
    residual = pulse.peak_cm_s / (4.0 * np.pi * fp * (1.0 - gamma * gamma))
    residual *= np.sin(nu + gamma * np.pi) - np.sin(nu - gamma * np.pi)
    since_s = time_s - pulse.peak_time_s
    carrier = 2.0 * np.pi * fp * since_s
    hump = carrier / gamma
    oscillation = 0.5 * pulse.peak_cm_s * np.cos(carrier + nu) - residual * fp / gamma
    slope = -0.5 * pulse.peak_cm_s * np.sin(carrier + nu) * 2.0 * np.pi * fp
    rate = slope * (1.0 + np.cos(hump)) - oscillation * np.sin(hump) * 2.0 * np.pi * fp / gamma
    inside = np.abs(since_s) <= 0.5 * gamma * pulse.period_s
    return np.where(inside, rate, 0.0) / _MODEL_G_CM_S2
