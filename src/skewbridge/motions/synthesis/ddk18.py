"""Parameters of the bidirectional near-fault model of Dabaghi and Der Kiureghian (2018).

Earthquake Engineering and Structural Dynamics 47:1369-1393 and PEER report 2014/17. The parameters
of a motion are correlated normal variables about a regression on the scenario, transformed to
their own distributions.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from scipy.special import betaincinv, ndtr

from skewbridge.motions.record import Vector
from skewbridge.motions.synthesis.scenario import Scenario

_REDRAW_LIMIT = 2.0  # source: DDK18, errors beyond two standard deviations are drawn again


@dataclass(frozen=True, slots=True, kw_only=True)
class Background:
    """Parameters of the modulated filtered noise of one component.

    Attributes:
        arias_cm_s: Arias intensity in cm/s.
        d5_95_s: Time between 5 and 95 % of the Arias intensity.
        d0_5_s: Time to 5 %.
        d0_30_s: Time to 30 %.
        f_mid_hz: Filter frequency at 30 %.
        f_slope_hz_per_s: Its rate of change.
        damping_ratio: Filter damping.
    """

    arias_cm_s: float
    d5_95_s: float
    d0_5_s: float
    d0_30_s: float
    f_mid_hz: float
    f_slope_hz_per_s: float
    damping_ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulse:
    """Parameters of the velocity pulse of component 1.

    Attributes:
        peak_cm_s: Amplitude of the velocity pulse.
        period_s: Pulse period.
        oscillations: Number of oscillations (gamma).
        phase_rad: Phase (nu).
        peak_time_s: Time of the peak of the envelope.
    """

    peak_cm_s: float
    period_s: float
    oscillations: float
    phase_rad: float
    peak_time_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelParameters:
    """What one motion is made from; `pulse` is None for a motion without one."""

    component_1: Background
    component_2: Background
    pulse: Pulse | None


@cache
def _regression(with_pulse: bool) -> tuple[Vector, Vector, Vector]:
    """Return coefficients, standard deviations and the Cholesky factor of the correlation."""
    path = files("skewbridge.motions.synthesis").joinpath("data/ddk18.json")
    table = json.loads(path.read_text(encoding="utf-8"))["pulse" if with_pulse else "nopulse"]
    return np.array(table["beta"]), np.array(table["sigma"]), np.linalg.cholesky(table["corr"])


def mean_normals(scenario: Scenario, *, with_pulse: bool) -> Vector:
    """Return the regression values of the normal variables, shape (14,), with pulse (19,)."""
    return _regression(with_pulse)[0] @ np.array(scenario.predictors)


def draw_parameters(
    scenario: Scenario, rng: np.random.Generator, *, with_pulse: bool
) -> ModelParameters:
    """Return one random set of parameters."""
    _, sigma, root = _regression(with_pulse)
    mean = mean_normals(scenario, with_pulse=with_pulse)
    while True:
        errors = root @ rng.standard_normal(mean.size)
        if np.abs(errors).max() > _REDRAW_LIMIT:
            continue
        parameters = transform(mean + sigma * errors, with_pulse=with_pulse)
        pulse = parameters.pulse
        if pulse is None or pulse.peak_time_s >= 0.5 * pulse.oscillations * pulse.period_s:
            return parameters


def transform(normals: Vector, *, with_pulse: bool) -> ModelParameters:
    """Return the physical parameters of a vector of normal variables."""
    pulse = _pulse(normals[:5]) if with_pulse else None
    one, two = np.split(normals[5:] if with_pulse else normals, 2)
    return ModelParameters(component_1=_background(one), component_2=_background(two), pulse=pulse)


def _pulse(normals: Vector) -> Pulse:
    return Pulse(
        peak_cm_s=float(np.exp(normals[0])),
        period_s=float(np.exp(normals[1])),
        # source: smelt, beta distribution of gamma on 2 to 3.2
        oscillations=2.0 + 1.2 * _beta(normals[2], 1.30326178289206, 3.96858083951547),
        phase_rad=float(2.0 * np.pi * ndtr(normals[3])),
        peak_time_s=float(np.exp(normals[4])),
    )


def _background(normals: Vector) -> Background:
    arias, d5_95, d0_5, d0_30, f_mid = (float(value) for value in np.exp(normals[:5]))
    # source: smelt, beta distribution of ln(damping) on -4.7 to 0
    log_damping = -4.7 + 4.7 * _beta(normals[6], 5.33551936215137, 3.82954843573707)
    return Background(
        arias_cm_s=arias,
        d5_95_s=d5_95,
        d0_5_s=d0_5,
        d0_30_s=d0_30,
        f_mid_hz=f_mid,
        f_slope_hz_per_s=_frequency_slope(float(ndtr(normals[5]))),
        damping_ratio=float(np.exp(log_damping)),
    )


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
