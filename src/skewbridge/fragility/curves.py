"""Fragility curves of a study: one row per variant, limit state and method.

The method ``cloud`` is the demand model of a bridge (`demand_model`), common to its variants. It is
preferred in all variants, or in none. Probit fits to the outcomes of single variants check it: all
states of one demand share a dispersion (``exceedance``), so that their curves do not cross. Medians
are compared as in Hausman (1978), Econometrica 46(6):1251-1271; the jackknife gives the variance.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise
from math import inf, nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.demands.validity import is_beyond_model
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row, records_of
from skewbridge.fragility import demand_model, demand_table, motion_means
from skewbridge.fragility import fits as fitting
from skewbridge.fragility.demand_model import BridgeModels, DemandModel, StateCurve
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED, FragilityFit
from skewbridge.fragility.likelihood import NormalKernel, drop_of, maximise
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.fragility.motion_means import Jackknifed
from skewbridge.fragility.outcomes import (
    TREATMENTS,
    DemandOutcomes,
    collapsed_runs,
    demand_outcomes,
    outcomes_by_state,
    states_by_demand,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.union import Union

#: Methods in order of preference.
METHODS: Final = ("cloud", "exceedance")
_CLOUD, _EXCEEDANCE = METHODS

CURVE_COLUMNS: Final = demand_table.described("curves")
_FIT_COLUMNS: Final = list(CURVE_COLUMNS)[list(CURVE_COLUMNS).index("component") :]
_TOTAL: Final = ("beta_total", "beta_total_low", "beta_total_high")
#: Median and dispersion for each treatment of unknown outcomes, and `_PEAKS` if a run collapsed.
type _Bounds = dict[str, tuple[float, float]]
_SURE: Final = 0.95
#: Peaks of collapsed runs count as exact; with `COLLAPSE_EXCEEDS`, only as lower bounds.
_PEAKS: Final = "peaks"


def fit_study(
    models: Iterable[BridgeModels],
    limit_states: States,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the table `curves` from the demand models and fits to the outcomes of runs.

    Theta and beta are NaN unless ``status`` is ``ok``. There is no estimate for a state that no
    run, or every run, exceeds. Raises `InputError` if there are no limit states.
    """
    if not limit_states:
        raise InputError("no limit states to fit: give at least one")
    rows_of = partial(_variant_rows, states=limit_states, settings=settings)
    variants = (variant for model in models for variant in _variants(model, limit_states, settings))
    rows = demand_table.spread(rows_of, variants, jobs)
    table = pd.DataFrame([row for rows_of_variant in rows for row in rows_of_variant])
    # preferred: the first method with a median in some variant of the bridge. Medians withheld
    # because of unknown outcomes count: the other method would leave out these runs.
    has_median = table["status"].isin((FITTED, BOUNDS_TOO_WIDE))
    rank = table["method"].map(METHODS.index).where(has_median)
    keys = [table[n] for n in (*demand_table.BRIDGE_COLUMNS, "component", "limit_state")]
    best_rank = rank.groupby(keys).transform("min")
    preferred = ((rank == best_rank) & (table["status"] == FITTED)).to_numpy()
    names = dict.fromkeys((*demand_table.variant_columns(table), *CURVE_COLUMNS))
    return table.assign(preferred=preferred)[[name for name in names if name in table]]


class _Cloud(NamedTuple):
    """Curve of one state in one variant by the demand model, or the reason why there is none."""

    curve: StateCurve | str
    bounds: _Bounds
    columns: Row
    slope: Floats  # of ln demand at the median, (R,); NaN for a union or without a curve
    doubtful: Mask  # runs of the variant whose outcome is in doubt, (n,)


class _Variant(NamedTuple):
    """One variant: its runs, the event or motion of each, and its curves by the demand model."""

    runs: pd.DataFrame
    block: Index
    shaking: Index  # number of the motion and incidence of each run, (n,)
    replicates: int  # number R of estimates: from all runs, without each block, from priors
    priors: int  # number of estimates that are errors from priors
    clouds: Mapping[LimitState, _Cloud]
    correlations: Mapping[LimitState, Floats]  # of the demands of two modes, (R,)


def _variants(models: BridgeModels, states: States, settings: FitSettings) -> Iterator[_Variant]:
    all_states = dict.fromkeys([*states, *(mode for state in states for mode in state.modes)])
    outcomes = outcomes_by_state(models.runs, list(all_states))
    by_state = {state: _BridgeState(models, state, known) for state, known in outcomes.items()}
    columns = [settings.im, *(state.demand for state in all_states)]
    runs = demand_table.demand_columns(models.runs, columns)
    modes = {state: models.modes(state) for state in states}
    correlations = {s: models.correlation(*pair) for s, pair in modes.items() if len(pair) > 1}
    for number, values in enumerate(records_of(models.variants)):
        rows, counts = models.variant == number, (models.replicates, models.axes.drifts)
        clouds = {state: of_state.cloud(values, rows) for state, of_state in by_state.items()}
        shaking = demand_table.shaking_codes(runs[rows])
        yield _Variant(runs[rows], models.block[rows], shaking, *counts, clouds, correlations)


class _BridgeState:
    """A limit state of a bridge, with the models for other treatments of unknown outcomes."""

    def __init__(self, models: BridgeModels, state: LimitState, outcomes: DemandOutcomes) -> None:
        self._models, self._state, self._outcomes = models, state, outcomes
        self._modes = models.modes(state)
        fits = ((models.fit(mode), mode) for mode in self._modes)
        self._fitted = [(fit, mode) for fit, mode in fits if not isinstance(fit, str)]

    @cached_property
    def doubtful(self) -> Mask:
        """Runs of the bridge with an unknown outcome that the demand models do not predict."""
        unknown = self._outcomes.unknown(self._state)
        # ASSUME an outcome that a model predicts with a probability of 95 % is not in doubt
        certain = [fit.exceeds(mode) > _SURE for fit, mode in self._fitted]
        return unknown & ~np.logical_or.reduce([np.zeros_like(unknown), *certain])

    @cached_property
    def _treated(self) -> dict[str, list[DemandModel | str]]:
        """Demand models of the failure modes, refitted with each treatment of unknown outcomes."""
        fitted, unknown = self._fitted, self.doubtful
        if len(fitted) < len(self._modes) or not np.any(fitted[0][0].outcomes.exceed(fitted[0][1])):
            return {}
        treated: dict[str, list[DemandModel | str]] = {
            name: [fit.treated(fit.outcomes.treated(mode, name, unknown)) for fit, mode in fitted]
            for name in (TREATMENTS if np.any(unknown) else ())
        }
        exact = all(mode.collapse != COLLAPSE_EXCEEDS for mode in self._modes)
        if np.any(collapsed_runs(self._models.runs)):
            treated[_PEAKS] = [self._models.of_peaks(mode, exact=exact) for mode in self._modes]
        return treated

    def cloud(self, values: Row, rows: Mask) -> _Cloud:
        """Return the curve of the variant with the axis ``values`` and the runs ``rows``."""
        curve = self._models.curve(self._state, values)
        nan_values, doubtful = np.full(self._models.replicates, nan), self.doubtful[rows]
        if isinstance(curve, str):
            return _Cloud(curve, {}, {}, nan_values, doubtful)
        estimate = motion_means.exp_end(curve.ln_theta[0]), float(curve.beta[0])
        bounds: _Bounds = dict.fromkeys(TREATMENTS, estimate)
        for name, models in self._treated.items():
            rho = None if len(models) == 1 else self._models.correlation(*self._modes)[:1]
            refit = demand_model.state_curve(models, self._modes, values, rho)
            bounds[name] = nan, nan
            if not isinstance(refit, str):
                bounds[name] = motion_means.exp_end(refit.ln_theta[0]), float(refit.beta[0])
        if curve.modes is not None:
            columns = curve.modes.columns() | {"model": "union"}
            return _Cloud(curve, bounds, columns, nan_values, doubtful)
        ((fit, _),), ((point, mode),) = self._fitted, curve.points
        columns: Row = point.columns() | {"capacity_dispersion": mode.dispersion}
        columns["max_dp"] = point.largest_distance(mode, curve.ln_theta[0], curve.total[0])
        columns["model"] = "mixed_tobit" if np.any(fit.outcomes.is_bound) else "mixed"
        return _Cloud(curve, bounds, columns, point.slope_at(curve.ln_theta), doubtful)


class _Curve(NamedTuple):
    """Curve of one state by one method; R estimates: all runs, then without each event."""

    fit: FragilityFit
    ln_theta: Floats  # shape (R,)
    beta: Floats
    total: Floats  # including the dispersion of the capacity
    bounds: _Bounds
    columns: Row


class _StateFits(NamedTuple):
    """Fits of the J states of one demand to outcomes; NaN if there is no fit."""

    fits: list[FragilityFit]  # fits to all runs
    ln_theta: Floats  # R estimates of each state, shape (J, R)
    beta: Floats  # common dispersion, shape (R,)


class _DemandRuns:
    """The n runs of one variant with their outcomes for all states of one demand."""

    def __init__(self, variant: _Variant, states: States, settings: FitSettings) -> None:
        self.variant, self.states, self.settings = variant, states, settings
        self.im = variant.runs[settings.im].to_numpy(dtype=np.float64)
        self.ln_im, self.motion = np.log(self.im), demand_table.motion_codes(variant.runs)
        self.motions = int(np.max(self.motion)) + 1
        #: Whether levels may follow outcomes, as in an IDA: each motion then counts once.
        self.levels_differ = not demand_table.has_common_steps(self.ln_im, variant.shaking)
        #: Blocks (events or motions) with a run, and weights 0 or 1 of the runs without each one.
        self.present = np.unique(variant.block)
        self.weights = (variant.block != self.present[:, None]).astype(np.float64)
        self.outcomes = demand_outcomes(variant.runs, states)
        demands = self.outcomes.lower[self.outcomes.complete]
        self.lacks_demand = demands.size > 0 and bool(np.all(np.isnan(demands)))


def _variant_rows(variant: _Variant, *, states: States, settings: FitSettings) -> list[Row]:
    described = demand_table.variant_values(variant.runs)
    groups = [_DemandRuns(variant, group, settings) for group in states_by_demand(states).values()]
    modes = dict.fromkeys(mode for state in states for mode in state.modes if mode not in states)
    curves = {
        state: by_method
        for runs in (*groups, *(_DemandRuns(variant, [mode], settings) for mode in modes))
        if not runs.lacks_demand
        for state, by_method in _curves(runs).items()
    }
    return [described | row for runs in groups for row in _rows(runs, curves)]


def _curves(runs: _DemandRuns) -> dict[LimitState, dict[str, _Curve]]:
    """Return the curves of each state by method, with those that `_printed_fits` withholds."""
    exceedance = _exceedance_fits(runs, runs.outcomes)
    treated: dict[str, _StateFits] = {}
    doubtful = [runs.variant.clouds[state].doubtful for state in runs.states]
    for name in TREATMENTS if np.any(doubtful) else ():
        outcomes = runs.outcomes
        for state, rows in zip(runs.states, doubtful, strict=True):
            outcomes = outcomes.treated(state, name, rows)
        treated[name] = _exceedance_fits(runs, outcomes, in_full=False)
    treated = treated or dict.fromkeys(TREATMENTS, exceedance)
    curves: dict[LimitState, dict[str, _Curve]] = {}
    for j, state in enumerate(runs.states):
        bounds = {
            name: (motion_means.exp_end(fits.ln_theta[j, 0]), float(fits.beta[0]))
            for name, fits in treated.items()
        }
        # capacity dispersion is divided by the slope of ln demand at the median
        # ASSUME the capacity is independent of the demand
        beta = beta_total = exceedance.beta
        if state.dispersion:
            beta_total = np.hypot(beta, state.dispersion / runs.variant.clouds[state].slope)
        estimates = exceedance.ln_theta[j], beta, beta_total
        by_outcome = _Curve(exceedance.fits[j], *estimates, bounds, {})
        curves[state] = {_CLOUD: _cloud_curve(runs, state), _EXCEEDANCE: by_outcome}
    return curves


def _cloud_curve(runs: _DemandRuns, state: LimitState) -> _Curve:
    curve, bounds, columns, *_ = runs.variant.clouds[state]
    level, status = runs.settings.confidence, runs.outcomes.status(state)
    if isinstance(curve, str) and status == FITTED:
        status = curve
    name = str(columns.get("model", "mixed"))
    fit = FragilityFit(method=name, status=status, n_runs=runs.im.size, level=level)
    if isinstance(curve, str) or status != FITTED:
        no_values = np.full(runs.variant.replicates, nan)
        return _Curve(fit, no_values, no_values, no_values, bounds, {})
    fit = replace(fit, theta=motion_means.exp_end(curve.ln_theta[0]), beta=float(curve.beta[0]))
    fit = fitting.jackknifed(fit, curve.ln_theta, curve.beta, curve.priors)
    names = fitting.common_warnings(fit, runs.im, runs.motions)
    if np.isfinite(columns.get("knot", nan)):
        names.append("saturating" if columns["b_above"] < columns["b"] else "curved")
    names += ["heteroscedastic"] if columns.get("growth", 0.0) != 0.0 else []
    return _Curve(fit.warned(*names), *curve[:3], bounds, columns)


def _union_curve(
    runs: _DemandRuns, state: LimitState, curves: Mapping[LimitState, Mapping[str, _Curve]]
) -> _Curve:
    """Return the union of the exceedance fits of the modes of a state, or the fit of the state.

    Modes with too few failures for a curve are left out.
    """
    by_outcomes = curves[state][_EXCEEDANCE]
    fits = {mode: curves[mode][_EXCEEDANCE] for mode in state.modes if mode in curves}
    fitted = {mode: curve for mode, curve in fits.items() if curve.fit.status == FITTED}
    if not fitted:
        return by_outcomes
    if len(fitted) == 1:
        ((mode, mode_fit),) = fitted.items()
        columns: Row = {"capacity_dispersion": mode.dispersion}
        return mode_fit._replace(bounds=by_outcomes.bounds, columns=columns)
    medians, records, totals = np.swapaxes([curve[1:4] for curve in fitted.values()], 0, 1)
    totals = np.where(np.isnan(totals), records, totals)
    rho = runs.variant.correlations.get(state, np.zeros(medians.shape[1]))
    union = Union.of(medians, records, totals, rho)
    (ln_theta, beta_total), (_, beta) = union.summary(), Union(medians, records, rho).summary()
    theta = motion_means.exp_end(ln_theta[0])
    fit = replace(by_outcomes.fit, theta=theta, beta=float(beta[0]), status=FITTED, method="union")
    fit = fitting.jackknifed(fit, ln_theta, beta)
    # ASSUME unknown outcomes change the median of the union as that of the direct fit
    scale = float(np.exp(ln_theta[0] - by_outcomes.ln_theta[0]))
    bounds = {name: (scale * median, b) for name, (median, b) in by_outcomes.bounds.items()}
    return _Curve(fit, ln_theta, beta, beta_total, bounds, union.columns())


def _exceedance_fits(
    runs: _DemandRuns, outcomes: DemandOutcomes, *, in_full: bool = True
) -> _StateFits:
    """Fit the exceedance probabilities of all states with a common dispersion."""
    exceed = np.column_stack([outcomes.exceed(state) for state in runs.states])
    is_known = ~np.column_stack([outcomes.unknown(state) for state in runs.states])
    outcomes_of = zip(is_known.T, exceed.T, strict=True)
    fits = [_single_fit(runs, *of_state, in_full=in_full) for of_state in outcomes_of]
    estimable = [j for j, fit in enumerate(fits) if fit.status == FITTED]
    blocks = runs.variant.replicates
    common = _StateFits(fits, np.full((len(fits), blocks), nan), np.full(blocks, nan))
    if not estimable:
        return common
    # states exceeded in the same known runs share an intercept: fit only the first of them
    pairs = pairwise(estimable)
    disagree = (exceed[:, i] & is_known[:, j] & ~exceed[:, j] for i, j in pairs)
    number = np.cumsum([0, *(int(np.any(rows)) for rows in disagree)])
    distinct = [estimable[first] for first in np.unique(number, return_index=True)[1]]
    single = [fits[j] for j in distinct]
    joint = _common_slope(runs, single, is_known[:, distinct], exceed[:, distinct], in_full=in_full)
    for j, intercept_number in zip(estimable, number, strict=True):
        fits[j] = replace(joint.fits[intercept_number], details=fits[j].details)
        common.ln_theta[j] = joint.ln_theta[intercept_number]
    return common._replace(beta=joint.beta)


def _common_slope(
    runs: _DemandRuns,
    single: list[FragilityFit],  # fits of k single states, for start values
    is_known: Mask,  # outcomes, shape (n, k)
    exceed: Mask,
    *,
    in_full: bool,
) -> _StateFits:
    """Fit k states together: P = Phi(a0 + a1 ln x) with a0 of each state and a common slope a1."""
    size = len(single)
    if runs.levels_differ:
        rows, lower_state, low, high = _brackets(runs, is_known, exceed)
        upper_state = lower_state
    else:
        # Ordered probit: a run that exceeds state j but not state k has the probability
        # Phi(eta_j) - Phi(eta_k), with eta_j = a0_j + a1 ln x.
        passed, not_passed = exceed.sum(axis=1), is_known & ~exceed
        ended = ~np.any(not_passed, axis=1)
        rows = np.flatnonzero((passed > 0) | ~ended)
        low = np.where(ended, -inf, runs.ln_im)[rows]
        high = np.where(passed > 0, runs.ln_im, inf)[rows]
        lower_state = np.argmax(not_passed, axis=1)[rows]
        upper_state = np.maximum(passed - 1, 0)[rows]
    lower_rows, upper_rows = -np.eye(size)[lower_state], -np.eye(size)[upper_state]
    slope = float(np.mean([1.0 / fit.beta for fit in single]))
    ln_medians = np.log([fit.theta for fit in single])
    # fits of single states may cross: start the common fit with medians at least 5 % apart
    ln_medians[1:] = ln_medians[0] + np.cumsum(np.maximum(np.diff(ln_medians), 0.05))
    kernel = NormalKernel(lower_rows, low, high, upper_covariates=upper_rows)
    maximum = maximise(kernel, np.array([[*(-slope * ln_medians), slope]]))
    params, converged = maximum.params, maximum.converged
    if in_full and converged[0]:
        jackknife = NormalKernel(lower_rows, low, high, runs.weights[:, rows], upper_rows)
        jackknifed = maximise(jackknife, np.tile(params, (len(runs.weights), 1)))
        params = np.vstack([params, jackknifed.params])
        converged = np.append(converged, jackknifed.converged)
    is_valid = converged & (params[:, -1] > fitting.FLATTEST_SLOPE)
    a1 = np.where(is_valid, params[:, -1], nan)
    # a block without a run has no influence: its estimates are those from all runs
    number = np.zeros(runs.variant.replicates, dtype=np.intp)
    left_out = 1 + runs.present[: a1.size - 1]
    number[left_out] = np.arange(1, a1.size)
    beta, ln_theta = (1.0 / a1)[number], (-params[:, :-1] / a1[:, None]).T[:, number]
    if not is_valid[0]:
        status = fitting.NON_INCREASING if converged[0] else fitting.NOT_CONVERGED
        return _StateFits([fit.without_estimate(status) for fit in single], ln_theta, beta)
    profile = in_full and runs.motions == runs.im.size  # else runs are not independent
    drop = drop_of(runs.settings.confidence) if profile else None
    fits = fitting.fits_of_states(single, kernel, maximum, np.eye(size + 1)[:-1], size, drop)
    for j, fit in enumerate(fits):
        if in_full and not profile:
            fits[j] = fit = fitting.jackknifed(fit, ln_theta[j], beta)
        fits[j] = fit.warned(*fitting.common_warnings(fit, runs.im, runs.motions))
    return _StateFits(fits, ln_theta, beta)


def _brackets(
    runs: _DemandRuns, is_known: Mask, exceed: Mask
) -> tuple[Index, Index, Floats, Floats]:
    """Return the brackets of ln intensity at which each motion first exceeds each of k states.

    The arrays have a value per bracket: one run of the motion, the state, and both ends.
    """
    # ASSUME a bracket does not depend on the capacity within it. In simulated searches, medians of
    # states above the one of the search are up to 15 % too high; the demand model is unbiased.
    brackets: list[tuple[Index, ...]] = []
    for state in range(is_known.shape[1]):
        known = np.flatnonzero(is_known[:, state])
        shaking = runs.variant.shaking[known]
        lower, upper, _ = fitting.first_exceedances(runs.im[known], exceed[known, state], shaking)
        first_runs = known[np.unique(shaking, return_index=True)[1]]
        with np.errstate(divide="ignore"):
            brackets.append((first_runs, np.full(lower.size, state), np.log(lower), np.log(upper)))
    rows, states, low, high = map(np.concatenate, zip(*brackets, strict=True))
    return rows, states, low, high


def _single_fit(runs: _DemandRuns, is_known: Mask, exceed: Mask, *, in_full: bool) -> FragilityFit:
    """Fit one state alone; unless ``in_full``, return only its status and a start value."""
    im, exceeds = runs.im[is_known], exceed[is_known].astype(np.float64)
    ones = np.ones(im.size)
    if runs.levels_differ and im.size:
        shaking = runs.variant.shaking[is_known]
        fit = fitting.fit_first_exceedances(im, exceeds, shaking, runs.settings)
        if fit.status == fitting.ALL_CENSORED:
            return replace(fit, status=fitting.NO_EXCEEDANCE)
        return fit
    if in_full and im.size:
        options: Any = {"n_records": np.unique(runs.motion[is_known]).size, "interval": False}
        return fitting.fit_stripes(im, ones, exceeds, settings=runs.settings, **options)
    status = fitting.binomial_status(np.log(im), ones, exceeds)
    start = np.exp(np.quantile(np.log(im), 1.0 - np.mean(exceeds))) if status == FITTED else nan
    return FragilityFit(method="stripes", status=status, theta=float(start), beta=0.5)


def _rows(runs: _DemandRuns, curves: Mapping[LimitState, Mapping[str, _Curve]]) -> list[Row]:
    outcomes, level = runs.outcomes, runs.settings.confidence
    counts = {"n_runs": runs.im.size, "n_records": runs.motions}
    counts |= {"n_beyond_model": int(np.sum(is_beyond_model(runs.variant.runs)))}
    counts |= {"n_censored": int(np.sum(outcomes.is_bound))}
    rows: list[Row] = []
    for state in runs.states:
        if runs.lacks_demand:
            no_fit = FragilityFit(method="", status=fitting.NOT_APPLICABLE)
            rows += [_row(runs, method, state, no_fit, counts) for method in METHODS]
            continue
        by_method = dict(curves[state])
        if state.modes and outcomes.status(state) == FITTED:
            by_method[_EXCEEDANCE] = _union_curve(runs, state, curves)
        fits, all_counts = _printed_fits(runs, state, by_method), counts | outcomes.counts(state)
        difference = by_method[_EXCEEDANCE].ln_theta - by_method[_CLOUD].ln_theta
        compared = _compared(fits, difference, runs.variant.priors)
        for method, fit in fits.items():
            curve = by_method[method]
            row = _row(runs, method, state, fit, all_counts) | compared
            if fit.status == FITTED:
                row |= curve.columns
                if np.isfinite(curve.total[0]):
                    total = Jackknifed.of_replicates(np.log(curve.total), runs.variant.priors)
                    row |= dict(zip(_TOTAL, total.exp_interval(level), strict=True))
            for name in set(TREATMENTS) & set(curve.bounds):
                row[f"theta_{name}"], row[f"beta_{name}"] = curve.bounds[name]
            rows.append(row)
    return rows


def _printed_fits(
    runs: _DemandRuns, state: LimitState, curves: Mapping[str, _Curve]
) -> dict[str, FragilityFit]:
    """Return the fits by method, without estimates that unknown outcomes may change too much."""
    # a median that underflows is none
    fits = {
        method: fit.without_estimate(BOUNDS_TOO_WIDE) if fit.theta == 0.0 else fit
        for method, fit in ((method, curve.fit) for method, curve in curves.items())
    }
    share = runs.outcomes.counts(state)["n_unknown"] / runs.im.size
    names = ["unknown_above_5_percent"] if share > 0.05 else []
    for method, curve in curves.items() if share else ():
        if curve.bounds:
            fits[method] = fits[method].limited(curve.bounds, names=names)
    # Large demands cause collapse, so censoring by collapse is not independent of the demand.
    # A median is accepted only if it hardly depends on how these peaks are treated.
    lower_bound = curves[_CLOUD].bounds.get(_PEAKS)
    ln_change = np.log(lower_bound[0]) - curves[_CLOUD].ln_theta[0] if lower_bound else 0.0
    if fits[_CLOUD].status == FITTED and not abs(ln_change) <= np.log(fitting.MAX_BOUNDS_RATIO):
        fits[_CLOUD] = fits[_CLOUD].without_estimate(BOUNDS_TOO_WIDE)
    return fits


def _row(
    runs: _DemandRuns, method: str, state: LimitState, fit: FragilityFit, counts: Mapping[str, int]
) -> Row:
    row: Row = dict.fromkeys(_FIT_COLUMNS, nan)
    row |= {name: value for name, value in fit.details.items() if name in row}
    names = "status theta beta var_ln_theta cov_ln_theta_beta var_beta ci_method level loglik"
    row |= {name: getattr(fit, name) for name in names.split()}
    row["theta_low"], row["theta_high"] = fit.ci_theta
    row["beta_low"], row["beta_high"] = fit.ci_beta
    row |= state.columns | {"collapse_rule": state.collapse, "citation": state.citation}
    row |= {"preferred": False, "methods_differ": False, "reach": "", **counts}
    row |= {"method": method, "model": fit.method, "im": runs.settings.im}
    row["warnings"] = ";".join(dict.fromkeys((*fit.warnings, *state.warnings)))
    row["im_low"], row["im_high"] = low, high = motion_means.covered_range(runs.im, runs.motion)
    row["extrapolated"] = fit.status == FITTED and not low <= fit.theta <= high
    if counts.get("n_exceed") == 0:
        largest = np.nanmax(runs.outcomes.lower, initial=0.0)
        label = label_of(state.demand)
        row["reach"] = f"{label}: largest {largest:.2g}, state at {state.threshold:.2g}"
    return row


def _compared(fits: Mapping[str, FragilityFit], difference: Floats, priors: int) -> Row:
    # `difference` (R,) is ln(exceedance median / cloud median)
    if any(fits[method].status != FITTED for method in METHODS):
        return {"methods_ratio": nan, "methods_differ": False}
    error = float(Jackknifed.of_replicates(difference, priors).error)
    # ASSUME a difference between the medians of two methods is worth reporting if it exceeds two
    # standard errors
    differs = error > 0.0 and abs(difference[0]) > 2.0 * error
    return {"methods_ratio": motion_means.exp_end(difference[0]), "methods_differ": bool(differs)}
