"""Cloud fits of one variant of a study: a line where all runs completed, else Tobit."""

from dataclasses import replace
from math import inf

import numpy as np

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import Replicates, refit_lines, shared_weights
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods import cloud, tobit
from skewbridge.fragility.methods.goodness import lilliefors
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import (
    TREATMENTS,
    CensoredDemands,
    Outcomes,
    Runs,
    bootstrapped,
)


def fit_variant_cloud(
    runs: Runs,
    outcomes: Outcomes,
    state: LimitState,
    settings: FitSettings,
    *,
    capacity_dispersion: float = 0.0,
) -> FragilityFit:
    """Fit the line; a run that did not complete is censored at its peak so far.

    ``capacity_dispersion`` c widens beta to sqrt(s^2 + c^2)/b.
    """
    line = _VariantLine(runs, outcomes, state, settings, capacity_dispersion)
    if np.any(outcomes.complete & (outcomes.demand <= 0.0)):
        refused = line.without_estimate(existence.NON_POSITIVE)
        return outcomes.judge_bounds(refused, settings, dict.fromkeys(TREATMENTS, refused))
    data = outcomes.censored(state.threshold)
    fit = line.fit(data, outcomes)
    bounds: dict[str, FragilityFit] = dict.fromkeys(TREATMENTS, fit)
    if np.any(outcomes.unknown):
        c, unknown = state.threshold, outcomes.unknown
        raised = np.where(unknown, np.maximum(data.lower, c), data.lower)
        floor = np.where(unknown & (data.lower <= 0.0), c * 1e-6, data.lower)
        ends = {
            "exclude": (replace(data, used=data.used & ~unknown), outcomes),
            "all_exceed": (
                CensoredDemands(raised, np.where(unknown, inf, data.upper), raised > 0.0),
                outcomes.assuming(outcomes.exceed | unknown),
            ),
            "none_exceed": (
                CensoredDemands(floor, np.where(unknown, c, data.upper), floor > 0.0),
                outcomes.assuming(outcomes.exceed),
            ),
        }
        bounds = {
            name: line.fit(end, assumed, interval=False) for name, (end, assumed) in ends.items()
        }
    return outcomes.judge_bounds(replace(fit, method="cloud"), settings, bounds)


def refit_censored(
    im: FloatArray, data: CensoredDemands, threshold: float, weights: FloatArray
) -> Replicates:
    """Fit the line of R weighted replicates, by least squares or, if some are censored, Tobit.

    The arrays hold the runs that take part; ``weights`` has shape (R, n).
    """
    if np.array_equal(data.lower, data.upper):
        return refit_lines(np.log(im), np.log(data.lower), weights, np.log(threshold))
    return tobit.refit_tobit(im, data.lower, threshold, data.upper, weights)


class _VariantLine:
    """The line of one variant and limit state, fitted to its demands or to assumed ones."""

    def __init__(
        self,
        runs: Runs,
        outcomes: Outcomes,
        state: LimitState,
        settings: FitSettings,
        capacity_dispersion: float,
    ) -> None:
        self._runs, self._complete, self._peaks = runs, outcomes.complete, outcomes.demand
        self._threshold, self._settings = state.threshold, settings
        self._capacity = capacity_dispersion

    def fit(
        self, data: CensoredDemands, outcomes: Outcomes, *, interval: bool = True
    ) -> FragilityFit:
        """Return the fit, refused where the outcomes hold no median."""
        # ASSUME a study states no median that no run reached: without one exceedance (or
        # non-exceedance) theta would be an extrapolation of the line.
        if outcomes.one_sided is not None:
            return self.without_estimate(outcomes.one_sided)
        used, resample = data.used, self._runs.repeated and interval
        im, motions = self._runs.im[used], self._runs.records[used]
        kept = CensoredDemands(data.lower[used], data.upper[used], used[used])
        complete = self._complete[used]
        wide = {"capacity_dispersion": self._capacity}
        if np.all(complete):
            fit = cloud.fit_cloud(
                im,
                kept.lower,
                self._threshold,
                settings=self._settings,
                n_records=int(np.unique(motions).size),
                **wide,
            )
        else:
            fit = tobit.fit_tobit(
                im,
                kept.lower,
                self._threshold,
                kept.upper,
                settings=self._settings,
                interval=interval and not self._runs.repeated,
                **wide,
            )
        if fit.status == FITTED and resample:
            weights = shared_weights(motions, self._settings.bootstrap, self._settings.seed)[1:]
            again = refit_censored(im, kept, self._threshold, weights)
            fit = bootstrapped(fit, again.widened(self._capacity))
        if np.sum(complete) < 4 or np.ptp(im[complete]) == 0.0:
            return fit
        x, y = np.log(im[complete]), np.log(kept.lower[complete])
        line = cloud.fit_line(x, y)
        tested = line
        if line.sigma > 1e-12:
            residual = y - line.ln_a - line.b * x
            tested = replace(line, normal_p=lilliefors(residual).p_value)
        if not np.all(complete):
            fit = replace(fit, warnings=(*fit.warnings, *cloud.line_warnings(line)))
        # the tests are those of the completed runs, intercept, slope and scatter those of Tobit
        own = fit.line or line
        return replace(fit, line=replace(tested, ln_a=own.ln_a, b=own.b, sigma=own.sigma))

    def without_estimate(self, status: str) -> FragilityFit:
        """Return the slope and scatter of the completed runs, without a median."""
        runs, used = self._runs, self._complete & (np.nan_to_num(self._peaks) > 0.0)
        blank = FragilityFit(
            method="cloud", status=status, n_runs=runs.im.size, level=self._settings.confidence
        )
        if np.sum(used) < 3 or np.ptp(runs.im[used]) == 0.0 or not np.all(used[self._complete]):
            return blank
        line = cloud.fit_line(np.log(runs.im[used]), np.log(self._peaks[used]))
        return replace(blank, line=line, warnings=tuple(cloud.line_warnings(line)))
