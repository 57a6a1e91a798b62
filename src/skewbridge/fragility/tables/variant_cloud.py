"""Cloud fits of one variant of a study: a line where all runs completed, else Tobit."""

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_lines
from skewbridge.fragility.likelihood.fit import OK, FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.methods import cloud, tobit
from skewbridge.fragility.tables.limit_states import COLLAPSE_EXCEEDS, LimitState
from skewbridge.fragility.tables.outcomes import Outcomes
from skewbridge.fragility.tables.runs import FitSettings, Runs, bootstrapped, judge_unknown


def fit_variant_cloud(
    runs: Runs, outcomes: Outcomes, state: LimitState, options: FitSettings
) -> tuple[FragilityFit, dict[str, float]]:
    """Fit the line; a run that did not complete is censored at its peak so far."""
    blank = FragilityFit(method="cloud", status=OK, n_runs=runs.im.size, level=options.level)
    if np.any(outcomes.complete & (outcomes.demand <= 0.0)):
        return replace(blank, status="non_positive_demand"), {}
    known = ~outcomes.unknown
    exceed = outcomes.exceed[known]
    # ASSUME a study states no median that no run reached: without one exceedance (or
    # non-exceedance) theta would be an extrapolation of the line.
    if not np.any(exceed) or np.all(exceed):
        reason = existence.ALL_EXCEED if np.any(exceed) else existence.NO_EXCEEDANCE
        refused = replace(_line_only(blank, runs, outcomes), status=reason)
        return judge_unknown(refused, {}, outcomes, options)
    peak = np.nan_to_num(outcomes.demand, nan=0.0)
    defined = ~outcomes.complete & outcomes.exceed & (state.collapse == COLLAPSE_EXCEEDS)
    lower = np.where(defined, np.maximum(peak, state.threshold), peak)
    fit = _line_fit(runs, outcomes, lower, None, lower > 0.0, state, options)
    bounds = {"exclude": fit, "all_exceed": fit, "none_exceed": fit}
    if np.any(outcomes.unknown):
        c = state.threshold
        usable = known & (lower > 0.0)
        raised = np.where(outcomes.unknown, np.maximum(lower, c), lower)
        below = np.where(outcomes.unknown, c, inf)
        floor = np.where(outcomes.unknown & (lower <= 0.0), c * 1e-6, lower)
        ends = {
            "exclude": (lower, None, usable),
            "all_exceed": (raised, None, raised > 0.0),
            "none_exceed": (floor, below, floor > 0.0),
        }
        bounds = {
            name: _line_fit(runs, outcomes, *end, state, options, interval=False)
            for name, end in ends.items()
        }
    return judge_unknown(replace(fit, method="cloud"), bounds, outcomes, options)


def _line_fit(
    runs: Runs,
    outcomes: Outcomes,
    lower: FloatArray,
    upper: FloatArray | None,
    used: NDArray[np.bool_],
    state: LimitState,
    options: FitSettings,
    *,
    interval: bool = True,
) -> FragilityFit:
    complete = outcomes.complete[used]
    im, edp = runs.im[used], lower[used]
    if np.all(complete):
        fit = cloud.fit_cloud(
            im,
            edp,
            state.threshold,
            level=options.level,
            n_records=int(np.unique(runs.records[used]).size),
        )
        if fit.status == OK and runs.repeated and interval:
            weights = _weights(runs, used, options)
            again = refit_lines(np.log(im), np.log(edp), weights, np.log(state.threshold), 0.0)
            fit = bootstrapped(fit, again.intervals(options.level), again.theta, again.beta)
        return fit
    top = None if upper is None else upper[used]
    fit = tobit.fit_tobit(
        im,
        edp,
        state.threshold,
        censored=~complete,
        upper=top,
        level=options.level,
        interval=interval and not runs.repeated,
    )
    if fit.status == OK and runs.repeated and interval:
        again = tobit.refit_tobit(
            im, edp, state.threshold, ~complete, _weights(runs, used, options), upper=top
        )
        fit = bootstrapped(fit, again.intervals(options.level), again.theta, again.beta)
    if np.sum(complete) >= 4 and np.ptp(im[complete]) > 0.0:
        line = cloud.fit_line(np.log(im[complete]), np.log(edp[complete]))
        flags = tuple(cloud.line_warnings(line))
        fit = replace(
            fit,
            warnings=(*fit.warnings, *flags),
            details={**cloud.line_details(line), **fit.details},
        )
    return fit


def _weights(runs: Runs, used: NDArray[np.bool_], options: FitSettings) -> FloatArray:
    _, codes = np.unique(runs.records[used], return_inverse=True)
    return record_weights(codes, options.replicates, np.random.default_rng(options.seed))


def _line_only(blank: FragilityFit, runs: Runs, outcomes: Outcomes) -> FragilityFit:
    """Return the slope and scatter of the completed runs, without a median."""
    used = outcomes.complete
    if np.sum(used) < 3 or np.ptp(runs.im[used]) == 0.0:
        return blank
    line = cloud.fit_line(np.log(runs.im[used]), np.log(outcomes.demand[used]))
    return replace(
        blank,
        details=cloud.line_details(line),
        warnings=tuple(cloud.line_warnings(line)),
    )
