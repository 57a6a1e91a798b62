"""Bidirectional near-fault model of Dabaghi and Der Kiureghian (2018).

The model is in Earthquake Engineering and Structural Dynamics 47:1369-1393 and PEER report 2014/17.
Its parameters are transformed from correlated normal variables, whose means come from a regression
on the scenario. A motion is modulated, filtered and high-passed white noise, plus a pulse in some
scenarios. Accelerations in this module are in g.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import ClassVar, Final, Literal, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import betaincinv, ndtr

from skewbridge.errors import InputError
from skewbridge.motions.intensity import arias_build_up
from skewbridge.motions.record import Vector
from skewbridge.units import G_MPS2, GAL

# source: Dabaghi and Der Kiureghian (2018), range of the regression data; below M 6.5 the third
# predictor is ambiguous in the publication, so the model is not offered there.
SCENARIO_LIMITS: Final = {
    "magnitude": (6.5, 7.9),
    "distance_km": (0.1, 31.0),
    "vs30_mps": (139.0, 2016.0),
    "ztor_km": (0.0, 20.0),
    "rupture_to_site_km": (0.0, 500.0),
}
_REDRAW_LIMIT = 2.0  # source: DDK18, errors beyond two standard deviations are drawn again
MIN_FREQUENCY_HZ: Final = 0.3  # source: DDK18, floor of the filter frequency
_NEGLIGIBLE: Final = 1.0e-9  # relative amplitude at which an impulse response is cut off
_MODEL_G_CM_S2: Final = 981.0  # g of the model, used in its Arias intensities in cm/s
_STARTS: Final = ((1.0, 0.2), (2.0, 0.2), (5.0, 0.2), (1.0, 1.0), (2.0, 1.0), (5.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Earthquake, path and site."""

    magnitude: float  # moment magnitude
    distance_km: float  # closest distance to the rupture
    vs30_mps: float  # average shear-wave velocity of the upper 30 m
    mechanism: Literal["strike_slip", "reverse"] = "strike_slip"  # reverse: also oblique
    ztor_km: float = 0.0  # depth to the top of the rupture
    #: Length of the rupture towards the site (strike-slip) or up-dip of the hypocentre (reverse);
    #: only matters for pulses.
    rupture_to_site_km: float = 20.0
    pulse: Literal["none", "all"] = "none"  # near-fault pulse
    LIMITS: ClassVar[Mapping[str, tuple[float, float]]] = SCENARIO_LIMITS

    def __post_init__(self) -> None:
        for name, (low, high) in self.LIMITS.items():
            value = getattr(self, name)
            if not low <= value <= high:  # also refuses nan
                raise InputError(f"{name} must be within {low} to {high}, got {value}")

    @property
    def joyner_boore_km(self) -> float:
        """Distance in km to the surface projection of the rupture of a vertical fault."""
        # ASSUME a vertical fault: rjb^2 = rrup^2 - ztor^2
        return math.sqrt(max(self.distance_km**2 - self.ztor_km**2, 0.0))

    @property
    def predictors(self) -> tuple[float, ...]:
        """The eight predictors of the regression of the model parameters."""
        log_r = 0.5 * math.log(self.distance_km**2 + 36.0)
        reverse = 1.0 if self.mechanism == "reverse" else 0.0
        return (
            1.0,
            self.magnitude,
            max(self.magnitude - 6.5, 0.0),
            log_r,
            self.magnitude * log_r,
            reverse * min(self.ztor_km, 1.0),
            math.log(min(self.vs30_mps, 1100.0)),
            self.rupture_to_site_km,
        )


class Background(NamedTuple):
    """Parameters of the modulated filtered noise of one component."""

    arias_cm_s: float
    d5_95_s: float  # time between 5 and 95 % of the Arias intensity
    d0_5_s: float  # time to 5 %
    d0_30_s: float  # time to 30 %
    f_mid_hz: float  # filter frequency at 30 %
    f_slope_hz_per_s: float  # rate of change of the filter frequency
    damping_ratio: float  # damping ratio of the filter


class Pulse(NamedTuple):
    """Velocity pulse of component 1; oscillations and phase are gamma and nu in the publication."""

    peak_cm_s: float
    period_s: float
    oscillations: float
    phase_rad: float
    peak_time_s: float


class ModelParameters(NamedTuple):
    """Parameters of one motion; `pulse` is None for a motion without one."""

    components: tuple[Background, Background]
    pulse: Pulse | None


@cache
def _regression(pulse: str) -> tuple[Vector, Vector, Vector]:
    """Return coefficients, standard deviations and the Cholesky factor of the correlation."""
    text = (Path(__file__).parent / "data/ddk18.json").read_text(encoding="utf-8")
    table = json.loads(text)["nopulse" if pulse == "none" else "pulse"]
    return np.array(table["beta"]), np.array(table["sigma"]), np.linalg.cholesky(table["corr"])


def mean_normals(scenario: Scenario) -> Vector:
    """Return the means of the normal variables, shape (14,), or (19,) with a pulse."""
    return _regression(scenario.pulse)[0] @ np.array(scenario.predictors)


def draw_parameters(scenario: Scenario, rng: np.random.Generator) -> ModelParameters:
    """Return one random set of parameters."""
    mean = mean_normals(scenario)
    _, sigma, root = _regression(scenario.pulse)
    while True:
        errors = root @ rng.standard_normal(mean.size)
        if np.abs(errors).max() > _REDRAW_LIMIT:
            continue
        parameters = transform(mean + sigma * errors)
        pulse = parameters.pulse
        if pulse is None or pulse.peak_time_s >= 0.5 * pulse.oscillations * pulse.period_s:
            return parameters


def transform(normals: Vector) -> ModelParameters:
    """Return the physical parameters for 14 normal variables, or for 19 with a pulse."""
    normals_1, normals_2 = np.split(normals[-14:], 2)
    pulse = None
    if normals.size > 14:
        peak_cm_s, period_s, peak_time_s = np.exp(normals[[0, 1, 4]]).tolist()
        # source: smelt, beta distribution of gamma on 2 to 3.2
        oscillations = 2.0 + 1.2 * _beta(normals[2], 1.30326178289206, 3.96858083951547)
        phase_rad = float(2.0 * np.pi * ndtr(normals[3]))
        pulse = Pulse(peak_cm_s, period_s, oscillations, phase_rad, peak_time_s)
    return ModelParameters((_background(normals_1), _background(normals_2)), pulse)


def _background(normals: Vector) -> Background:
    # source: smelt, beta distribution of ln(damping) on -4.7 to 0
    log_damping = -4.7 + 4.7 * _beta(normals[6], 5.33551936215137, 3.82954843573707)
    slope = _frequency_slope(float(ndtr(normals[5])))
    values = [*np.exp(normals[:5]).tolist(), slope, float(np.exp(log_damping))]
    return Background._make(values)


def _frequency_slope(p: float) -> float:
    """Return the p-quantile of the two-sided truncated exponential distribution of f'."""
    # source: smelt
    a, b, c, lower = 14.2935537214223, 6.40242376475815, 4.42179588354923, -3.5
    below = b / c * p + np.exp(b * lower)
    if below <= 1.0:
        return float(np.log(below) / b)
    return float(-np.log(a / b * (1.0 - np.exp(b * lower)) - a / c * p + 1.0) / a)


def _beta(normal: float, alpha: float, beta: float) -> float:
    return float(betaincinv(alpha, beta, ndtr(normal)))


class Modulation(NamedTuple):
    """Envelope q(t): it grows as c (t/peak)^power to the peak, then decays as exp(-decay t)."""

    power: float
    decay_per_s: float
    peak_s: float
    amplitude_g: float = 1.0

    def at(self, time_s: Vector) -> Vector:
        """Return the envelope at these times, in g."""
        rise = np.minimum(time_s / self.peak_s, 1.0) ** self.power
        fall = np.exp(-self.decay_per_s * np.maximum(time_s - self.peak_s, 0.0))
        return self.amplitude_g * rise * fall

    def time_of_share(self, share: float) -> float:
        """Return the time in s at which the integral of q^2 reaches a share of its total."""
        decay, rising = self.decay_per_s, self.peak_s / (2.0 * self.power + 1.0)
        energy = share * (rising + 0.5 / decay)
        if energy <= rising:
            return self.peak_s * (energy / rising) ** (1.0 / (2.0 * self.power + 1.0))
        return self.peak_s - np.log1p(-2.0 * decay * (energy - rising)) / (2.0 * decay)


def fit_modulation(arias_cm_s: float, d5_95_s: float, d0_5_s: float, d0_30_s: float) -> Modulation:
    """Return the envelope that best fits the times of 5, 30 and 95 % of the Arias intensity."""
    wanted_s = np.array([d0_5_s, d0_30_s, d0_5_s + d5_95_s])

    def misfit(logs: Vector) -> Vector:
        return _times_of(Modulation(*np.exp(logs).tolist())) - wanted_s

    logs, cost = np.zeros(3), math.inf
    bounds = (np.log([1e-3, 1e-3, 1e-2]), np.log([100.0, 100.0, 200.0]))
    for power, decay in _STARTS:
        start = np.log([power, decay, d0_30_s])
        fit = least_squares(misfit, start, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
        if fit.cost < cost:
            logs, cost = fit.x, fit.cost
        if cost < 1.0e-12:
            break
    shape = Modulation(*np.exp(logs).tolist())
    total_s = shape.peak_s / (2.0 * shape.power + 1.0) + 0.5 / shape.decay_per_s
    amplitude_g = float(np.sqrt(arias_cm_s / _MODEL_G_CM_S2 / (0.5 * np.pi * total_s)))
    return shape._replace(amplitude_g=amplitude_g)


def _times_of(shape: Modulation) -> Vector:
    """Return the times in s of 5, 30 and 95 % of the Arias intensity."""
    return np.array([shape.time_of_share(share) for share in (0.05, 0.30, 0.95)])


def filtered_noise(
    background: Background, modulation: Modulation, noise: Vector, dt_s: float
) -> Vector:
    """Return the unit-variance response of the time-varying filter to white noise, shape (npts,).

    The response to each impulse has the filter frequency at the time of the impulse. All responses
    are advanced together by one lag at a time, until the slowest one has decayed.
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
    response_sum, square = np.zeros(npts), np.zeros(npts)
    state = omega.astype(np.complex128)
    for lag in range(1, min(lags, npts)):
        state = state[: npts - lag] * step[: npts - lag]
        response = state.imag
        response_sum[lag:] += response * noise[: npts - lag]
        square[lag:] += response * response
    return np.divide(response_sum, np.sqrt(square), out=np.zeros(npts), where=square > 0.0)


def corner_frequency_hz(magnitude: float) -> float:
    """Return the corner frequency in Hz of the model's high-pass filter."""
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
    """Return two background components in g without pulse, and the start time of the motion in s.

    Both ends keep the zeros that the filter needs; t = 0 of the model is at the start time.
    """
    parts, pulse = parameters
    duration_s = 2.5 * max(b.d0_5_s + b.d5_95_s for b in parts)
    if pulse is not None:
        duration_s = max(duration_s, pulse.peak_time_s + pulse.oscillations * pulse.period_s)
    npts = int(np.ceil(duration_s / dt_s)) + 1
    time_s = np.arange(npts, dtype=np.float64) * dt_s
    corner_hz = corner_frequency_hz(magnitude)
    pad = int(np.ceil(0.5 * 1.5 * 4 / corner_hz / dt_s))
    components: list[Vector] = []
    for background in parts:
        envelope, noise = fit_modulation(*background[:4]), rng.standard_normal(npts)
        shaking = envelope.at(time_s) * filtered_noise(background, envelope, noise, dt_s)
        accel_g = high_pass(np.pad(shaking, pad), dt_s, corner_hz)
        components.append(accel_g * np.sqrt(background.arias_cm_s / arias_cm_s(accel_g, dt_s)))
    return components[0], components[1], pad * dt_s


def arias_cm_s(accel_g: Vector, dt_s: float) -> float:
    """Return the Arias intensity in cm/s, computed with the model's value of g."""
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
    is_in_pulse = np.abs(since_s) <= 0.5 * gamma * pulse.period_s
    return np.where(is_in_pulse, rate, 0.0) / _MODEL_G_CM_S2
