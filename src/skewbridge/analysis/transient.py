"""The nonlinear response history of one variant under one motion."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import openseespy.opensees as ops

from skewbridge.analysis.column_peaks import model_end
from skewbridge.analysis.damping import apply_rayleigh
from skewbridge.analysis.energy import EnergyBalance
from skewbridge.analysis.energy_checks import energy_ratios
from skewbridge.analysis.ground import Excitation, GroundInput
from skewbridge.analysis.histories import histories_of
from skewbridge.analysis.monitor import Monitor
from skewbridge.analysis.peaks import demands
from skewbridge.analysis.recovery import LADDER, Effort
from skewbridge.analysis.rest import drifts_at_rest
from skewbridge.analysis.result import AnalysisResult
from skewbridge.analysis.series import Series, at_regular_steps
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.status import Watch
from skewbridge.analysis.step_loop import Ending, Progress, StepLoop, solver_log
from skewbridge.analysis.trace import Trace
from skewbridge.bridge.geometry import contact_layout
from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.model import build, domain
from skewbridge.statuses import OK
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

# That of the last state whatever became of the columns: it is no peak.
_RESIDUAL: Final = "column_residual_drift_ratio"


def analyse(
    variant: Variant,
    excitation: Excitation,
    settings: AnalysisSettings,
    options: ModelOptions,
    *,
    histories: bool = False,
    log_path: Path | None = None,
    progress: Progress | None = None,
) -> AnalysisResult:
    """Analyse one variant under one two-component motion.

    The same call gives the same result, bit by bit: nothing depends on the clock.

    Args:
        variant: What to analyse.
        excitation: Ground motion, factor and angle.
        settings: How to integrate and when to stop.
        options: How to model.
        histories: Whether to return the histories.
        log_path: Where OpenSees writes its messages; None drops them.
        progress: Called now and then with the time reached and the duration.

    Raises:
        InputError: An argument is outside its limits; nothing was analysed.
    """
    ground = GroundInput(excitation, settings)
    with solver_log(log_path), domain():
        model = build(variant, settings.model_options(options))
        rayleigh = apply_rayleigh(model)
        ground.apply(model.tags)
        return _History(model, ground, settings, rayleigh, histories=histories).run(progress)


class _History:
    """The response history of a model under gravity."""

    def __init__(
        self,
        model: BridgeModel,
        ground: GroundInput,
        settings: AnalysisSettings,
        rayleigh: tuple[float, float],
        *,
        histories: bool,
    ) -> None:
        self._model, self._ground, self._settings = model, ground, settings
        self._histories = histories
        self._loop = StepLoop(model.contacts, settings)
        self._monitor = Monitor(model, bearings=histories)
        start = self._monitor.read(0.0)
        self._watch = Watch(model, self._monitor.layout, start, settings)
        self._energy = None
        if settings.energy:
            self._energy = EnergyBalance(
                model, self._monitor, ground.at, rayleigh, settings.integrator_command
            )

    def run(self, progress: Progress | None) -> AnalysisResult:
        """Take all steps and return what came of them."""
        ending = self._loop.run(self._ground.steps, self._read, progress)
        trace = self._monitor.trace()
        energy = {} if self._energy is None else self._energy.terms_kj()
        ground = self._ground.at(trace.time_s)
        effort = self._loop.effort
        ratios = energy_ratios(energy)
        whole = demands(self._model, trace, ground, ratios)
        end, found = model_end(self._model.columns, trace), dict(whole)
        if end.mode:  # what the model says afterwards is no demand
            rows = end.rows
            found |= demands(self._model, trace.first(rows), ground[:rows], ratios)
            found[_RESIDUAL] = whole[_RESIDUAL]
        messages = [ending.message] if ending.message else []
        if ending.status == OK:
            rest = drifts_at_rest(self._model, self._settings, trace.under_gravity_m)
            if rest.reason:
                messages.append(f"residual drift is that of the last step: {rest.reason}")
            else:
                found[_RESIDUAL] = max(rest.drifts, default=0.0)
        return AnalysisResult(
            status=ending.status,
            collapse_criterion=ending.collapse_criterion,
            time_reached_s=float(trace.time_s[-1]),
            duration_s=self._ground.duration_s,
            recovery_rung=effort.highest_rung,
            steps_by_rung=tuple(effort.steps_by_rung[rung] for rung in range(len(LADDER))),
            loosened_ratio=self._loosened_ratio(effort),
            substeps=effort.substeps,
            failed_attempts=effort.failed_attempts,
            houbolt_failures=effort.failed_attempts if self._is_houbolt else 0,
            iterations=effort.iterations,
            demands=found,
            whole_history=whole,
            model_end=end,
            energy_kj=energy,
            histories=self._uniform_histories(trace, ground) if self._histories else None,
            contact_layout=contact_layout(self._model) if self._histories else None,
            messages=tuple(messages),
        )

    def _uniform_histories(self, trace: Trace, ground: Series) -> dict[str, Series]:
        rows = at_regular_steps(trace.time_s, self._settings.dt_s)
        return histories_of(self._model, replace(trace, rows=trace.rows[rows]), ground[rows])

    def _read(self) -> Ending | None:
        """Read the state after a step and compare it with the limits."""
        row = self._monitor.read(ops.getTime())
        reason = self._watch.diverged(row)
        if reason:
            self._monitor.drop_last()
            self._energy = None  # the live model is no longer in the state of the last row kept
            message = f"the solution diverged: {reason}"
            return Ending(status="numerical_failure", message=message)
        if self._energy is not None:
            self._energy.collect()
        criterion = self._watch.collapsed(row)
        return Ending(status="collapse", collapse_criterion=criterion) if criterion else None

    @property
    def _is_houbolt(self) -> bool:
        return self._settings.integrator_command[0] == "Houbolt"

    def _loosened_ratio(self, effort: Effort) -> float:
        """Return the share of the steps that met only a looser test than the configured one."""
        usual_j, total = self._settings.tolerance_j, effort.steps_by_rung.total()
        loose = sum(
            count
            for rung, count in effort.steps_by_rung.items()
            if LADDER[rung].tolerance_j > usual_j
        )
        return loose / total if total else 0.0
