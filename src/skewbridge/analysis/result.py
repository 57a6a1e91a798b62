"""What an analysis returns: plain data, however it ended."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skewbridge.analysis.column_peaks import ModelEnd
from skewbridge.bridge.geometry import ContactLayout
from skewbridge.statuses import Status


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisResult:
    """One analysis, with the peaks up to where it got.

    Attributes:
        collapse_criterion: Demand whose limit was passed, or empty.
        time_reached_s: Time of the last converged step.
        duration_s: Time that the analysis was to reach.
        recovery_rung: Highest rung of the recovery ladder in use, 0 none.
        steps_by_rung: (Sub-)steps that converged on each rung of the ladder.
        loosened_ratio: Share of them that met only a looser convergence test than the usual one.
        substeps: Beyond the regular steps.
        houbolt_failures: Failed attempts if the integrator is Houbolt, which each restarts.
        iterations: Equilibrium iterations, those of failed attempts included.
        demands: The demand columns of the table, in their units.
        whole_history: The same as peaks to the end, whatever became of the columns.
        model_end: When a column reached its capacity; the demands are peaks up to then.
        energy_kj: Energy balance by term; empty when it was not kept.
        histories: Columns of the history table at the regular steps, each of shape (steps + 1,),
            or None.
        contact_layout: Where the contacts are, when there are histories and contacts.
    """

    status: Status
    collapse_criterion: str
    time_reached_s: float
    duration_s: float
    recovery_rung: int
    steps_by_rung: tuple[int, ...]
    loosened_ratio: float
    substeps: int
    failed_attempts: int
    houbolt_failures: int
    iterations: int
    demands: dict[str, float]
    whole_history: dict[str, float]
    model_end: ModelEnd
    energy_kj: Mapping[str, float]
    histories: dict[str, NDArray[np.float64]] | None
    contact_layout: ContactLayout | None
    messages: tuple[str, ...]
