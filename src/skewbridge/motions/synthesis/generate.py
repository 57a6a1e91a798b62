"""Make synthetic motions: model parameters, waveforms, calibration, orientation."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion, Vector
from skewbridge.motions.synthesis.calibration import calibrate_pair, target_spectrum
from skewbridge.motions.synthesis.ddk18 import ModelParameters, draw_parameters
from skewbridge.motions.synthesis.process import (
    corner_frequency_hz,
    pulse_acceleration,
    simulate_background,
)
from skewbridge.motions.synthesis.scenario import Scenario
from skewbridge.units import G_MPS2

DT_S: Final = 0.01
SOURCE: Final = "synthetic: model of Dabaghi and Der Kiureghian (2018)"
_GOLDEN_SHARE: Final = 0.5 * (np.sqrt(5.0) - 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SynthesisOptions:
    """How motions are made from the model.

    Attributes:
        calibrate: ``bssa14`` brings medians and dispersions to that model; ``none`` leaves the
            model as published.
        orientation: ``random`` turns each pair about the vertical, so that the stronger principal
            component is not always along the bridge; ``principal`` keeps component 1 the stronger
            one. A pulse keeps its direction, component 1, in any case.
        dt_s: Time step in s.
    """

    calibrate: Literal["bssa14", "none"] = "bssa14"
    orientation: Literal["random", "principal"] = "random"
    dt_s: float = DT_S

    def __post_init__(self) -> None:
        if self.calibrate not in {"bssa14", "none"}:
            raise InputError(f"calibrate must be bssa14 or none, got {self.calibrate!r}")
        if self.orientation not in {"random", "principal"}:
            raise InputError(f"orientation must be random or principal, got {self.orientation!r}")
        if not 0.001 <= self.dt_s <= 0.02:
            raise InputError(f"dt_s must be within 0.001 to 0.02, got {self.dt_s}")


def synthesize(
    scenario: Scenario, *, index: int, seed: int, options: SynthesisOptions | None = None
) -> GroundMotion:
    """Return one synthetic motion; it depends on the seed and its own index (from 0) only.

    The random stream is that of ``SeedSequence([seed, index])``.

    Raises:
        InputError: A negative seed or index.
    """
    how = options or SynthesisOptions()
    parameters, rng = drawn_parameters(scenario, index=index, seed=seed)
    one_g, two_g, start_s = simulate_background(parameters, scenario.magnitude, rng, how.dt_s)
    if how.calibrate == "bssa14":
        target_g = target_spectrum(scenario, seed, index)
        corner_hz = corner_frequency_hz(scenario.magnitude)
        one_g, two_g = calibrate_pair(one_g, two_g, how.dt_s, target_g, corner_hz)
    if parameters.pulse is not None:
        time_s = np.arange(one_g.size, dtype=np.float64) * how.dt_s - start_s
        one_g = one_g + pulse_acceleration(parameters.pulse, time_s)
    elif how.orientation == "random":
        # ASSUME any direction of the principal axes is as likely as another
        one_g, two_g = _turned(one_g, two_g, np.pi * ((index + 1) * _GOLDEN_SHARE % 1.0))
    return GroundMotion(
        motion_id=f"syn{index + 1:03d}",
        dt_s=how.dt_s,
        accel_1_mps2=one_g * G_MPS2,
        accel_2_mps2=two_g * G_MPS2,
        event=f"DDK18 M{scenario.magnitude:g} {scenario.mechanism}"
        + (", pulse" if parameters.pulse is not None else ""),
        magnitude=scenario.magnitude,
        distance_km=scenario.distance_km,
        vs30_mps=scenario.vs30_mps,
        station=f"seed {seed}, number {index + 1}",
        source=SOURCE,
    )


def drawn_parameters(
    scenario: Scenario, *, index: int, seed: int
) -> tuple[ModelParameters, np.random.Generator]:
    """Return the parameters of one motion of a stream, and the stream after them.

    Raises:
        InputError: A negative seed or index.
    """
    if seed < 0 or index < 0:
        raise InputError(f"seed and index must not be negative, got {seed} and {index}")
    rng = np.random.default_rng(np.random.SeedSequence([seed, index]))
    with_pulse = _has_pulse(scenario, rng)
    return draw_parameters(scenario, rng, with_pulse=with_pulse), rng


def _has_pulse(scenario: Scenario, rng: np.random.Generator) -> bool:
    draw = float(rng.uniform())  # drawn in any case: the option must not shift the stream
    if scenario.pulse == "probability":
        return draw < scenario.pulse_probability
    return scenario.pulse == "all"


def _turned(one: Vector, two: Vector, angle_rad: float) -> tuple[Vector, Vector]:
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    return cosine * one - sine * two, sine * one + cosine * two
