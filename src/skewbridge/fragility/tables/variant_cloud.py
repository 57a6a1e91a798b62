"""Cloud fits of one variant of a study: a line where all runs completed, else Tobit."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_lines
from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.parts import RunCounts
from skewbridge.fragility.methods import cloud, tobit
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import TREATMENTS, Outcomes, Runs, bootstrapped


@dataclass(frozen=True, slots=True)
class _Cloud:
    """Demands of the runs as the line sees them, arrays of shape (n,).

    Attributes:
        lower: Demand, or the value that it exceeds.
        upper: Its upper end where the run did not complete.
        used: Runs that take part.
    """

    lower: FloatArray
    upper: FloatArray
    used: NDArray[np.bool_]


def fit_variant_cloud(
    runs: Runs, outcomes: Outcomes, state: LimitState, settings: FitSettings
) -> FragilityFit:
    """Fit the line; a run that did not complete is censored at its peak so far."""
    blank = FragilityFit(
        method="cloud", status=FITTED, n_runs=runs.im.size, level=settings.confidence
    )
    if np.any(outcomes.complete & (outcomes.demand <= 0.0)):
        unusable = replace(blank, status="non_positive_demand")
        return replace(unusable, counts=RunCounts(bounds={}))
    known = ~outcomes.unknown
    exceed = outcomes.exceed[known]
    # ASSUME a study states no median that no run reached: without one exceedance (or
    # non-exceedance) theta would be an extrapolation of the line.
    if not np.any(exceed) or np.all(exceed):
        reason = existence.ALL_EXCEED if np.any(exceed) else existence.NO_EXCEEDANCE
        refused = replace(_line_only(blank, runs, outcomes), status=reason)
        return outcomes.judge_bounds(refused, settings, {})
    peak = np.nan_to_num(outcomes.demand, nan=0.0)
    lower = np.where(outcomes.defined, np.maximum(peak, state.threshold), peak)
    endless = np.full(lower.size, inf)
    fit = _line_fit(runs, outcomes, _Cloud(lower, endless, lower > 0.0), state, settings)
    bounds: dict[str, FragilityFit] = dict.fromkeys(TREATMENTS, fit)
    if np.any(outcomes.unknown):
        c = state.threshold
        raised = np.where(outcomes.unknown, np.maximum(lower, c), lower)
        below = np.where(outcomes.unknown, c, inf)
        floor = np.where(outcomes.unknown & (lower <= 0.0), c * 1e-6, lower)
        ends = {
            "exclude": _Cloud(lower, endless, known & (lower > 0.0)),
            "all_exceed": _Cloud(raised, endless, raised > 0.0),
            "none_exceed": _Cloud(floor, below, floor > 0.0),
        }
        bounds = {
            name: _line_fit(runs, outcomes, end, state, settings, interval=False)
            for name, end in ends.items()
        }
    return outcomes.judge_bounds(replace(fit, method="cloud"), settings, bounds)


def _line_fit(
    runs: Runs,
    outcomes: Outcomes,
    data: _Cloud,
    state: LimitState,
    settings: FitSettings,
    *,
    interval: bool = True,
) -> FragilityFit:
    used = data.used
    complete = outcomes.complete[used]
    im, edp, motions = runs.im[used], data.lower[used], runs.records[used]
    threshold = state.threshold
    resample = runs.repeated and interval
    if np.all(complete):
        records = int(np.unique(motions).size)
        fit = cloud.fit_cloud(im, edp, threshold, settings=settings, n_records=records)
        if fit.status == FITTED and resample:
            weights = record_weights(motions, settings.bootstrap, settings.seed)
            again = refit_lines(np.log(im), np.log(edp), weights, np.log(threshold))
            fit = bootstrapped(fit, again)
        return fit
    upper = np.where(complete, edp, data.upper[used])
    fit = tobit.fit_tobit(
        im, edp, threshold, upper, settings=settings, interval=interval and not runs.repeated
    )
    if fit.status == FITTED and resample:
        weights = record_weights(motions, settings.bootstrap, settings.seed)
        fit = bootstrapped(fit, tobit.refit_tobit(im, edp, threshold, upper, weights))
    if np.sum(complete) >= 4 and np.ptp(im[complete]) > 0.0:
        line = cloud.fit_line(np.log(im[complete]), np.log(edp[complete]))
        fit = replace(fit, warnings=(*fit.warnings, *cloud.line_warnings(line)))
        # the tests are those of the completed runs, intercept, slope and scatter those of Tobit
        own = fit.line or line
        fit = replace(fit, line=replace(line, ln_a=own.ln_a, b=own.b, sigma=own.sigma))
    return fit


def _line_only(blank: FragilityFit, runs: Runs, outcomes: Outcomes) -> FragilityFit:
    """Return the slope and scatter of the completed runs, without a median."""
    used = outcomes.complete
    if np.sum(used) < 3 or np.ptp(runs.im[used]) == 0.0:
        return blank
    line = cloud.fit_line(np.log(runs.im[used]), np.log(outcomes.demand[used]))
    return replace(blank, line=line, warnings=tuple(cloud.line_warnings(line)))
