"""The nonlinear response history of one variant under one motion."""

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from functools import partial
from math import ceil, isfinite, isnan
from os import devnull
from pathlib import Path
from typing import Final

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.contact_layout import contact_plan
from skewbridge.analysis.damping import apply_rayleigh
from skewbridge.analysis.energy import EnergyBalance, energy_residual_ratio
from skewbridge.analysis.gravity import apply_gravity
from skewbridge.analysis.histories import histories_of
from skewbridge.analysis.monitor import Monitor
from skewbridge.analysis.peaks import demands
from skewbridge.analysis.recovery import Effort, Stepper
from skewbridge.analysis.result import AnalysisResult, Status
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.status import Watch
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.options import ModelOptions
from skewbridge.bridge.tags import TagAllocator
from skewbridge.contact import ContactError
from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion
from skewbridge.variant.variant import Variant

type Progress = Callable[[float, float], None]

# Houbolt restarts as the trapezoidal rule after a failed step, which makes energy at contacts.
MAX_TRUSTED_HOUBOLT_FAILURES: Final = 2
# What the works of forces that jump may miss; above it something is wrong with the solution.
MAX_TRUSTED_RESIDUAL: Final = 0.05
MAX_SCALED_ACCEL_MPS2: Final = 1.0e3  # a hundred g: a wrong unit, not a motion
_STEPS_PER_REPORT: Final = 50


def analyse(
    variant: Variant,
    motion: GroundMotion,
    scale: float,
    incidence_deg: float,
    settings: AnalysisSettings,
    options: ModelOptions,
    *,
    histories: bool = False,
    log_path: Path | None = None,
    progress: Progress | None = None,
) -> AnalysisResult:
    """Analyse one variant under one two-component motion.

    Between its values the record is interpolated linearly. The same call gives the same result,
    bit by bit: nothing depends on the clock.

    Args:
        variant: Bridge, abutment model, skew, gap and friction.
        motion: Ground motion; component 1 points along x at incidence 0.
        scale: Factor on both components.
        incidence_deg: Counter-clockwise angle from x to component 1.
        settings: How to integrate and when to stop.
        options: How to model.
        histories: Whether to return the histories.
        log_path: Where OpenSees writes its messages; None drops them.
        progress: Called now and then with the time reached and the duration.

    Raises:
        InputError: An argument is outside its limits; nothing was analysed.
    """
    ground = GroundInput(motion, scale, incidence_deg, settings)
    with solver_log(log_path), domain():
        model = build(variant, settings.model_options(options))
        apply_gravity(model)
        rayleigh = apply_rayleigh(model)
        ground.apply(model.tags)
        return _Run(model, ground, settings, rayleigh, histories=histories).go(progress)


@contextmanager
def solver_log(path: Path | None) -> Generator[None]:
    """Send what OpenSees prints to a file, and to nowhere afterwards."""
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
    ops.logFile(devnull if path is None else str(path), "-noEcho")
    try:
        yield
    finally:
        ops.logFile(devnull, "-noEcho")


class GroundInput:
    """The excitation of one analysis along the bridge axes.

    Args:
        motion: Ground motion.
        scale: Factor on both components.
        incidence_deg: Counter-clockwise angle from x to component 1.
        settings: Window and free vibration.

    Raises:
        InputError: The scale is not positive, a value is no number, or a unit must be wrong.
    """

    def __init__(
        self, motion: GroundMotion, scale: float, incidence_deg: float, settings: AnalysisSettings
    ) -> None:
        if not (isfinite(scale) and scale > 0.0):
            raise InputError(f"scale must be a positive number, got {scale}")
        if not isfinite(incidence_deg):
            raise InputError(f"incidence_deg must be a number, got {incidence_deg}")
        accel = scale * np.column_stack(motion.along_axes(incidence_deg))
        largest = float(np.abs(accel).max())
        if not largest <= MAX_SCALED_ACCEL_MPS2:
            raise InputError(
                f"motion {motion.motion_id}: peak acceleration must be at most "
                f"{MAX_SCALED_ACCEL_MPS2:g} m/s2, got {largest:g}"
            )
        shaken_s = min(settings.duration_s or motion.duration_s, motion.duration_s)
        self.dt_s = motion.dt_s
        self.accel_mps2 = accel[: ceil(shaken_s / motion.dt_s - 1e-9) + 1]
        self.steps = ceil((shaken_s + settings.free_vibration_s) / settings.dt_s - 1e-9)
        self.duration_s = self.steps * settings.dt_s
        self._times_s = np.arange(len(self.accel_mps2)) * motion.dt_s

    def apply(self, tags: TagAllocator) -> None:
        """Load the domain: uniform excitation along x and y."""
        # ASSUME abutments and bent move alike: no wave passage, no vertical component
        for direction, values in enumerate(self.accel_mps2.T, start=1):
            series = tags.series()
            ops.timeSeries("Path", series, "-dt", self.dt_s, "-values", *values.tolist())
            ops.pattern("UniformExcitation", tags.pattern(), direction, "-accel", series)

    def at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ground acceleration at given times, shape (n, 2)."""
        return np.column_stack(
            [np.interp(times_s, self._times_s, values, right=0.0) for values in self.accel_mps2.T]
        )


class _Run:
    """One analysis of a model under gravity."""

    def __init__(
        self,
        model: BridgeModel,
        ground: GroundInput,
        settings: AnalysisSettings,
        rayleigh: tuple[float, float],
        *,
        histories: bool,
    ) -> None:
        self._histories = histories
        self._model, self._ground, self._settings = model, ground, settings
        if model.contacts is not None:
            model.contacts.start_from_rest()
        self._monitor = Monitor(model, bearings=histories)
        start = self._monitor.read(0.0)
        self._watch = Watch(model, self._monitor.layout, start, settings)
        self._energy = (
            EnergyBalance(model, self._monitor, ground.at, rayleigh) if settings.energy else None
        )
        self._end: tuple[Status, str] | None = None
        self._message = ""
        self._has_left = False
        configure_solver(settings)
        self._stepper = Stepper(
            integrator=settings.integrator_command,
            dt_s=settings.dt_s,
            loosen=partial(set_test, settings),
            max_iterations=settings.max_iterations,
            before=self._before,
            after=self._after,
        )
        ops.analysis("Transient", "-noWarnings")

    def go(self, progress: Progress | None) -> AnalysisResult:
        """Take all steps and return what came of them."""
        budget = self._settings.mean_iterations * self._ground.steps
        effort = self._stepper.effort
        try:
            for number in range(1, self._ground.steps + 1):
                converged = self._stepper.step()
                if self._end is not None:
                    break
                if not converged:
                    self._finish("numerical_failure", "no attempt at a step converged")
                    break
                if effort.iterations > budget:
                    self._finish("timeout", f"more than {budget:.0f} iterations")
                    break
                if progress is not None and number % _STEPS_PER_REPORT == 0:
                    progress(number * self._settings.dt_s, self._ground.duration_s)
        except ContactError as error:
            self._finish("numerical_failure", str(error))
        return self._result(effort)

    def _before(self, dt_s: float) -> None:
        if self._model.contacts is not None:
            self._model.contacts.prepare(dt_s)

    def _after(self, dt_s: float) -> None:
        """Update the contacts, read the state and compare it with the limits."""
        if self._end is not None:
            return
        if self._model.contacts is not None:
            self._model.contacts.after_step(dt_s)
        row = self._monitor.read(ops.getTime())
        reason = self._watch.diverged(row)
        if reason:
            self._monitor.drop_last()
            self._finish("numerical_failure", f"the solution diverged: {reason}")
            self._has_left = True
            return
        if self._energy is not None:
            self._energy.collect()
        criterion = self._watch.collapsed(row)
        if criterion:
            self._end = ("collapse", criterion)

    def _finish(self, status: Status, message: str) -> None:
        self._end = (status, "")
        self._message = message

    def _result(self, effort: Effort) -> AnalysisResult:
        status, criterion = self._end or ("ok", "")
        trace = self._monitor.trace()
        # The live model is no longer in the state of the last row when the solution has left.
        energy = {} if self._energy is None or self._has_left else self._energy.terms_kj()
        ratio = energy_residual_ratio(energy)
        ground = self._ground.at(trace.time_s)
        return AnalysisResult(
            status=status,
            collapse_criterion=criterion,
            time_reached_s=float(trace.time_s[-1]),
            duration_s=self._ground.duration_s,
            recovery_rung=effort.highest_rung,
            substeps=effort.substeps,
            failed_attempts=effort.failed_attempts,
            iterations=effort.iterations,
            demands=demands(self._model, trace, ground, ratio),
            energy_kj=energy,
            histories=histories_of(self._model, trace, ground) if self._histories else None,
            plan=contact_plan(self._model) if self._histories else None,
            messages=tuple(self._messages(effort, energy)),
        )

    def _messages(self, effort: Effort, energy: Mapping[str, float]) -> Generator[str]:
        if self._message:
            yield self._message
        is_houbolt = self._settings.integrator_command[0] == "Houbolt"
        if is_houbolt and effort.failed_attempts > MAX_TRUSTED_HOUBOLT_FAILURES:
            yield (
                f"{effort.failed_attempts} failed attempts under Houbolt: each restarts it as the "
                "trapezoidal rule, compare with a smaller step"
            )
        residual = energy_residual_ratio(energy)
        if not isnan(residual):
            if abs(residual) > MAX_TRUSTED_RESIDUAL:
                yield f"{residual:.1%} of the input energy is not accounted for"
            made = -energy["contact"] / energy["largest_input"]
            if made > MAX_TRUSTED_RESIDUAL:
                yield f"the contacts made {made:.1%} of the input energy"


def configure_solver(settings: AnalysisSettings) -> None:
    """Set what stays the same for all attempts; friction keeps the tangent symmetric."""
    ops.wipeAnalysis()
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    set_test(settings, 1.0)


def set_test(settings: AnalysisSettings, loosening: float) -> None:
    """Set the convergence test with its tolerance times a factor."""
    ops.test("EnergyIncr", loosening * settings.tolerance_j, settings.max_iterations)
