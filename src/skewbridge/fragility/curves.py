"""Fragility curves of a study: one row per variant, limit state and method.

The method ``cloud`` is the demand model of a bridge (`demand_model`), common to its variants. It is
preferred in all variants, or in none. Fits to the outcomes of single variants check it: all states
of one demand share a dispersion (``exceedance``, ``ida_interval``), so that their curves do not
cross. The medians of two methods are compared as in Hausman (1978), Econometrica 46(6):1251-1271;
the variance is from the jackknife over motions.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from itertools import zip_longest
from math import inf, nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.demands.validity import is_beyond_model
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row, records_of
from skewbridge.fragility import demand_table, motion_means
from skewbridge.fragility import fits as fitting
from skewbridge.fragility.demand_model import BridgeModels, StateCurve, fit_models, state_curve
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED, MAX_BOUNDS_RATIO, FragilityFit
from skewbridge.fragility.likelihood import Maximum, NormalKernel, drop_of, maximise
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.fragility.lines import FLATTEST_SLOPE
from skewbridge.fragility.outcomes import (
    TREATMENTS,
    DemandOutcomes,
    demand_outcomes,
    end_counts,
    states_by_demand,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.union import UNION_COLUMNS, Union
from skewbridge.statuses import COLLAPSE

#: Methods in order of preference.
METHODS: Final = ("cloud", "exceedance", "ida_interval")

CURVE_COLUMNS: Final = demand_table.described("curves")
_FIT_COLUMNS: Final = list(CURVE_COLUMNS)[list(CURVE_COLUMNS).index("component") :]


def fit_study(
    demands: pd.DataFrame,
    limit_states: States,
    settings: FitSettings = DEFAULTS,
    *,
    models: list[BridgeModels] | None = None,
    jobs: int = 1,
) -> pd.DataFrame:
    """Fit fragility curves of every variant and limit state of a demands table.

    The table has `CURVE_COLUMNS` and one row per variant, limit state and method. ``cloud`` is from
    the demand models, which are fitted if not given. ``exceedance`` is a probit fit to the outcomes
    of runs. ``ida_interval`` is added if motions ran at several levels. Theta and beta are NaN
    unless ``status`` is ``ok``. There is no estimate for a state that no run, or every run,
    exceeds. Raises `InputError` if there are no limit states.
    """
    if not limit_states:
        raise InputError("no limit states to fit")
    if models is None:
        models = fit_models(demands, limit_states, settings, jobs=jobs)
    rows_of = partial(_variant_rows, states=limit_states, settings=settings)
    items = (item for each in models for item in _variants(each, limit_states, settings))
    rows = demand_table.spread(rows_of, items, jobs)
    table = pd.DataFrame([row for part in rows for row in part])
    names = dict.fromkeys((*demand_table.variant_columns(demands), *CURVE_COLUMNS))
    return _with_preferred(table)[[name for name in names if name in table]]


def _with_preferred(table: pd.DataFrame) -> pd.DataFrame:
    """Prefer the first method with an estimate in some variant, for each bridge and state."""
    fitted = (table["status"] == FITTED) & table["method"].isin(METHODS[:2])
    rank = table["method"].map({name: place for place, name in enumerate(METHODS)}).where(fitted)
    keys = [table[n] for n in (*demand_table.BRIDGE_COLUMNS, "component", "limit_state")]
    best = rank.groupby(keys).transform("min")
    return table.assign(preferred=(rank == best).to_numpy())


#: Median and dispersion for each treatment of unknown outcomes; `_PEAKS` if a run collapsed.
type _Bounds = dict[str, tuple[float, float]]
_SURE: Final = 0.95
_PEAKS: Final = "peaks"  # peaks of collapsed runs count as exact


class _Cloud(NamedTuple):
    """Curve of one state in one variant by the demand model, or the reason why there is none."""

    curve: StateCurve | str
    bounds: _Bounds
    columns: Row


class _Item(NamedTuple):
    """One variant: its runs, the block of each run, and its curves by the demand model."""

    part: pd.DataFrame
    block: Index
    blocks: int
    clouds: Mapping[LimitState, _Cloud]
    slopes: Mapping[LimitState, Floats]  # of ln demand at the median, (1 + B,)
    correlations: Mapping[LimitState, Floats]  # of the demands of two modes, (1 + B,)
    doubtful: Mapping[LimitState, Mask]  # runs whose outcome is in doubt


def _variants(models: BridgeModels, states: States, settings: FitSettings) -> Iterator[_Item]:
    """Yield the variants of a bridge with their curves by the demand model."""
    every = dict.fromkeys([*states, *(mode for state in states for mode in state.modes)])
    shared = {
        state: _BridgeState(models, state, group, settings)
        for group in states_by_demand(list(every)).values()
        for state in group
    }
    columns = [settings.im, *(state.demand for state in every)]
    runs = demand_table.demand_columns(models.runs, columns)
    blocks = models.replicates - 1
    two = [state for state in states if len(models.modes(state)) > 1]
    correlations = {state: models.correlation(*models.modes(state)) for state in two}
    for number, values in enumerate(records_of(models.variants)):
        own = models.variant == number
        clouds = {state: each.cloud(values) for state, each in shared.items()}
        slopes = {state: each.slope(values) for state, each in shared.items()}
        doubtful = {state: each.doubtful[own] for state, each in shared.items()}
        found = clouds, slopes, correlations, doubtful
        yield _Item(runs[own], models.block[own], blocks, *found)


class _BridgeState:
    """A limit state of a bridge, with the models for other treatments of unknown outcomes."""

    def __init__(
        self, models: BridgeModels, state: LimitState, group: States, settings: FitSettings
    ) -> None:
        self._models, self._state, self._settings = models, state, settings
        self._group = group  # states of the same component and demand
        self._modes = models.modes(state)
        self._fits = [models.fit(mode) for mode in self._modes]

    @cached_property
    def doubtful(self) -> Mask:
        """Runs of the bridge with an unknown outcome that the demand models do not predict."""
        unknown = demand_outcomes(self._models.runs, self._group).unknown(self._state)
        # ASSUME an outcome that a model predicts with a probability of 95 % is not in doubt
        fits = [fit for fit in self._fits if not isinstance(fit, str)]
        sure = [f.exceeds(mode) > _SURE for f, mode in zip(fits, self._modes, strict=False)]
        return unknown & ~np.logical_or.reduce([np.zeros_like(unknown), *sure])

    @cached_property
    def _treated(self) -> dict[str, list[Any]]:
        """Demand models of the modes for each treatment of the unknown outcomes of the bridge."""
        fits = [fit for fit in self._fits if not isinstance(fit, str)]
        if len(fits) < len(self._fits) or not np.any(fits[0].outcomes.exceed(self._modes[0])):
            return {}
        both, unknown = list(zip(fits, self._modes, strict=True)), self.doubtful
        treated = {
            name: [fit.treated(fit.outcomes.treated(mode, name, unknown)) for fit, mode in both]
            for name in (TREATMENTS if np.any(unknown) else ())
        }
        # a run in which a column failed before it collapsed is censored by the failure
        runs = self._models.runs
        ended = (runs["status"] == COLLAPSE).to_numpy() & ~is_beyond_model(runs)
        by_definition = any(mode.collapse == COLLAPSE_EXCEEDS for mode in self._modes)
        ended = [ended & np.isposinf(fit.outcomes.upper) for fit in fits]
        if np.any(ended) and not by_definition:
            treated[_PEAKS] = [
                fit.treated(
                    replace(
                        fit.outcomes, upper=np.where(at, fit.outcomes.lower, fit.outcomes.upper)
                    )
                )
                for fit, at in zip(fits, ended, strict=True)
            ]
        return treated

    def slope(self, values: Row) -> Floats:
        """Return the slope of ln demand at the median; NaN for a union or without a model."""
        fit, curve = self._fits[0], self._models.curve(self._state, values)
        if isinstance(fit, str) or isinstance(curve, str) or len(self._fits) > 1:
            return np.full(self._models.replicates, nan)
        return fit.model.at(values).slope_at(curve.ln_theta)

    def cloud(self, values: Row) -> _Cloud:
        """Return the curve of the variant at ``values``."""
        curve = self._models.curve(self._state, values)
        if isinstance(curve, str):
            return _Cloud(curve, {}, {})
        same = motion_means.exp_end(curve.ln_theta[0]), float(curve.beta[0])
        bounds: _Bounds = dict.fromkeys(TREATMENTS, same)
        for name, models in self._treated.items():
            rho = None if len(models) == 1 else self._models.correlation(*self._modes)[:1]
            other = state_curve(models, self._modes, values, rho)
            found = (nan, nan) if isinstance(other, str) else (other.ln_theta[0], other.beta[0])
            bounds[name] = motion_means.exp_end(found[0]), float(found[1])
        if curve.modes is not None:
            medians, wide = np.exp(curve.modes.ln_theta[:, 0]), curve.modes.beta[:, 0]
            numbers = *np.column_stack([medians, wide]).ravel(), curve.modes.rho[0]
            columns = dict(zip(UNION_COLUMNS, map(float, numbers), strict=True))
            return _Cloud(curve, bounds, columns | {"line_demand": "", "model": "union"})
        fit, mode = self._fits[0], self._modes[0]
        assert not isinstance(fit, str)
        point, ends = fit.model.at(values), (float(curve.ln_theta[0]), float(curve.total[0]))
        columns: Row = point.columns() | {"max_dp": point.largest_distance(mode, *ends)}
        columns["model"] = "mixed_tobit" if np.any(fit.outcomes.is_bound) else "mixed"
        capacity = {"line_demand": mode.demand, "capacity_dispersion": mode.dispersion}
        return _Cloud(curve, bounds, columns | capacity)


class _Curve(NamedTuple):
    """Curve of one state by one method; arrays are from all runs, then without each block."""

    fit: FragilityFit
    ln_theta: Floats  # shape (1 + B,)
    beta: Floats
    total: Floats  # including the dispersion of the capacity
    bounds: _Bounds
    columns: Row


class _StateFits(NamedTuple):
    """Fits of the J states of one demand to outcomes; NaN if there is no fit."""

    fits: list[FragilityFit]  # fits to all runs
    ln_theta: Floats  # from all runs, then without each block, shape (J, 1 + B)
    beta: Floats  # common dispersion, in the same order, shape (1 + B,)


def _variant_rows(item: _Item, *, states: States, settings: FitSettings) -> list[Row]:
    """Return the rows of one variant."""
    described = demand_table.variant_values(item.part)
    groups = [_DemandFits(item, own, settings) for own in states_by_demand(states).values()]
    known = {state: each for each in groups for state in each.states}
    for mode in dict.fromkeys(mode for state in states for mode in state.modes):
        known.setdefault(mode, _DemandFits(item, [mode], settings))
    return [described | row for each in groups for row in each.rows(known)]


class _DemandFits:
    """The fits of one variant for all states of one demand."""

    def __init__(self, item: _Item, states: States, settings: FitSettings) -> None:
        self._item, self._part, self.states, self._settings = item, item.part, states, settings
        self._im = item.part[settings.im].to_numpy(dtype=np.float64)
        self._ln_im, self._motion = np.log(self._im), demand_table.motion_codes(item.part)
        #: Blocks with a run, and weights of the runs: all, then all except each of these blocks.
        self._present = np.unique(item.block)
        self._weights = (item.block != np.append(-1, self._present)[:, None]).astype(np.float64)
        self._motions = int(np.max(self._motion)) + 1
        self.outcomes = demand_outcomes(item.part, states)

    @cached_property
    def curves(self) -> list[dict[str, _Curve]]:
        """Curves of each state by method, before unknown outcomes are considered."""
        found = {"exceedance": self._exceedance(self.outcomes)}
        found |= {} if (brackets := self._brackets()) is None else {METHODS[2]: brackets}
        treated = {}
        doubtful = [self._item.doubtful[state] for state in self.states]
        for name in TREATMENTS if np.any(doubtful) else ():
            outcomes = self.outcomes
            for state, runs in zip(self.states, doubtful, strict=True):
                outcomes = outcomes.treated(state, name, runs)
            # the exceedance fit itself already excludes unknown outcomes
            same = name == "exclude"
            treated[name] = found["exceedance"] if same else self._exceedance(outcomes, whole=False)
        curves: list[dict[str, _Curve]] = []
        for j, state in enumerate(self.states):
            by_method = {"cloud": self._cloud(state)}
            for method, fits in found.items():
                # capacity dispersion is divided by the slope of ln demand at the median
                # ASSUME the capacity is independent of the demand
                wide = np.hypot(fits.beta, state.dispersion / self._item.slopes[state])
                total = wide if state.dispersion else fits.beta
                shown = treated or dict.fromkeys(TREATMENTS, fits)
                bounds = {
                    name: (motion_means.exp_end(each.ln_theta[j, 0]), float(each.beta[0]))
                    for name, each in shown.items()
                    if method == METHODS[1]
                }
                by_method[method] = _Curve(
                    fits.fits[j], fits.ln_theta[j], fits.beta, total, bounds, {}
                )
            curves.append(by_method)
        return curves

    def _cloud(self, state: LimitState) -> _Curve:
        """Return the curve of a state by the demand model."""
        curve, bounds, columns = self._item.clouds[state]
        level, status = self._settings.confidence, self.outcomes.status(state)
        name = str(columns.get("model", "mixed"))
        blank = FragilityFit(method=name, status=status, n_runs=self._im.size, level=level)
        if isinstance(curve, str) or status != FITTED:
            status = curve if isinstance(curve, str) and status == FITTED else status
            none = np.full(1 + self._item.blocks, nan)
            return _Curve(replace(blank, status=status), none, none, none, bounds, {})
        theta, beta = motion_means.exp_end(curve.ln_theta[0]), float(curve.beta[0])
        fit = replace(blank, theta=theta, beta=beta)
        fit = fitting.jackknifed(fit, curve.ln_theta[1:], curve.beta[1:])
        of_theta, of_beta = (
            motion_means.interval(logs, level)[1:] for logs in (curve.ln_theta, np.log(curve.beta))
        )
        fit = replace(fit, ci_theta=of_theta, ci_beta=of_beta)
        names = fitting.common_warnings(fit, self._im, self._motions)
        bend, growth = (float(columns.get(name, 0.0)) for name in ("b_above", "growth"))
        if np.isfinite(columns.get("knot", nan)):
            names.append("saturating" if bend < columns["b"] else "curved")
        names += ["heteroscedastic"] if growth != 0.0 else []
        return _Curve(fit.warned(*names), *curve[:3], bounds, columns)

    def rows(self, known: Mapping[LimitState, "_DemandFits"]) -> list[Row]:
        """Return the rows of the table of curves, without the columns that describe the variant."""
        outcomes = self.outcomes
        missing = outcomes.complete & np.isnan(outcomes.lower)
        counts = end_counts(self._part) | {"n_runs": self._im.size, "n_records": self._motions}
        counts |= {"n_censored": int(np.sum(outcomes.is_bound)), "n_missing": int(np.sum(missing))}
        if np.any(missing) and np.all(missing[outcomes.complete]):
            blank = FragilityFit(method="", status=fitting.NOT_APPLICABLE)
            return [self._row(m, s, blank, counts) for s in self.states for m in METHODS[:2]]
        rows: list[Row] = []
        for state, curves in zip(self.states, self.curves, strict=True):
            if state.modes and self.outcomes.status(state) == FITTED:
                curves = curves | {"exceedance": self._union(curves["exceedance"], state, known)}
            fits, counted = self._printed(state, curves), counts | outcomes.counts(state)
            difference = curves["exceedance"].ln_theta - curves["cloud"].ln_theta
            compared = _compared(fits, difference)
            for method, fit in fits.items():
                row = self._row(method, state, fit, counted)
                row |= compared if method in METHODS[:2] else {}
                row |= _total_dispersion(fit, curves[method].total)
                row |= curves[method].columns if fit.status == FITTED else {}
                for name in TREATMENTS if TREATMENTS[0] in curves[method].bounds else ():
                    row[f"theta_{name}"], row[f"beta_{name}"] = curves[method].bounds[name]
                rows.append(row)
        return rows

    def _printed(self, state: LimitState, curves: Mapping[str, _Curve]) -> dict[str, FragilityFit]:
        """Return the fits by method, without estimates that unknown outcomes may change."""
        # a median that underflows is none
        fits = {
            method: fit.without_estimate(BOUNDS_TOO_WIDE) if fit.theta == 0.0 else fit
            for method, fit in ((method, curve.fit) for method, curve in curves.items())
        }
        share = self.outcomes.counts(state)["n_unknown"] / self._im.size
        names = ["unknown_above_5_percent"] if share > 0.05 else []
        for method, curve in curves.items() if share else ():
            if TREATMENTS[0] in curve.bounds:
                fits[method] = fits[method].judged(curve.bounds, names=names)
        # Large demands cause collapse, so censoring by collapse is not independent of the demand.
        # A median is accepted only if it hardly depends on how these peaks are treated.
        other = curves["cloud"].bounds.get(_PEAKS)
        change = np.log(other[0]) - curves["cloud"].ln_theta[0] if other else 0.0
        if fits["cloud"].status == FITTED and not abs(change) <= np.log(MAX_BOUNDS_RATIO):
            fits["cloud"] = fits["cloud"].without_estimate(BOUNDS_TOO_WIDE)
        return fits

    def _union(
        self, direct: _Curve, state: LimitState, known: Mapping[LimitState, "_DemandFits"]
    ) -> _Curve:
        """Return the union of the exceedance fits of the modes; ``direct`` if no mode has one.

        A mode without a curve of its own, with few failures, does not count.
        """
        curves = [known[m].curves[known[m].states.index(m)][METHODS[1]] for m in state.modes]
        parts = [curve for curve in curves if curve.fit.status == FITTED]
        if not parts:
            return direct
        if len(parts) == 1:
            mode = state.modes[[curve.fit.status for curve in curves].index(FITTED)]
            single = {"line_demand": mode.demand, "capacity_dispersion": mode.dispersion}
            return parts[0]._replace(bounds=direct.bounds, columns=single)
        medians, records, total = (np.array([part[n] for part in parts]) for n in (1, 2, 3))
        total = np.where(np.isnan(total), records, total)
        rho = self._item.correlations.get(state, np.zeros(medians.shape[1]))
        union = Union.of(medians, records, total, rho)
        (middle, wide), (_, beta) = union.summary(), Union(medians, records, rho).summary()
        theta = motion_means.exp_end(middle[0])
        fit = replace(direct.fit, theta=theta, beta=float(beta[0]), status=FITTED, method="union")
        fit = fitting.jackknifed(fit, middle[1:], beta[1:])
        values = *np.column_stack([np.exp(medians[:, 0]), total[:, 0]]).ravel(), union.rho[0]
        columns = dict(zip(UNION_COLUMNS, map(float, values), strict=True)) | {"line_demand": ""}
        # ASSUME unknown outcomes change the median of the union as that of the direct fit
        scale = float(np.exp(middle[0] - direct.ln_theta[0]))
        bounds = {name: (scale * theta, b) for name, (theta, b) in direct.bounds.items()}
        return _Curve(fit, middle, beta, wide, bounds, columns)

    def _exceedance(self, outcomes: DemandOutcomes, *, whole: bool = True) -> _StateFits:
        """Fit the exceedance probabilities of all states with a common dispersion."""
        # Ordered probit: a run that exceeds state j but not state k has the probability
        # Phi(eta_j) - Phi(eta_k), with eta_j = a0_j + a1 ln x.
        exceed = np.column_stack([outcomes.exceed(state) for state in self.states])
        known = ~np.column_stack([outcomes.unknown(state) for state in self.states])
        maxima = fitting.exceedance_maxima(self._ln_im, known, exceed) if whole else ()
        columns = zip_longest(known.T, exceed.T, maxima)
        fits = [self._alone(*column, whole=whole) for column in columns]
        estimable = [j for j, fit in enumerate(fits) if fit.status == FITTED]
        # states exceeded in the same known runs share an intercept: fit only the first of them
        first: dict[int, int] = {}
        for before, j in zip([None, *estimable], estimable, strict=False):
            apart = before is None or np.any(exceed[:, before] & known[:, j] & ~exceed[:, j])
            first[j] = j if before is None or apart else first[before]
        if not (usable := sorted(set(first.values()))):
            return self._without_estimates(fits)
        passed = exceed[:, usable].sum(axis=1)  # number of usable states that each run exceeds
        not_passed = known[:, usable] & ~exceed[:, usable]
        ended = ~np.any(not_passed, axis=1)
        rows = np.flatnonzero((passed > 0) | ~ended)
        places = np.argmax(not_passed, axis=1)[rows], np.maximum(passed - 1, 0)[rows]
        low, high = np.where(ended, -inf, self._ln_im), np.where(passed > 0, self._ln_im, inf)
        single = self._motions == self._im.size
        common = self._common_slope(
            fits, usable, places, (low[rows], high[rows]), rows, whole=whole, profile=single
        )
        for j, same in first.items():
            common.ln_theta[j] = common.ln_theta[same]
            common.fits[j] = replace(common.fits[same], details=fits[j].details)
        return common

    def _alone(
        self, known: Mask, exceed: Mask, best: Maximum | None, *, whole: bool
    ) -> FragilityFit:
        """Fit one state alone; unless ``whole``, return only its status and a start value."""
        im, hits = self._im[known], exceed[known].astype(np.float64)
        each, settings = np.ones(im.size), self._settings
        if whole and im.size:
            further: Any = {"n_records": int(np.unique(self._motion[known]).size), "maximum": best}
            return fitting.fit_stripes(im, each, hits, settings=settings, interval=False, **further)
        status = fitting.binomial_status(np.log(im), each, hits)
        start = np.exp(np.quantile(np.log(im), 1.0 - np.mean(hits))) if status == FITTED else nan
        return FragilityFit(method="stripes", status=status, theta=float(start), beta=0.5)

    def _brackets(self) -> _StateFits | None:
        """Fit the brackets of first exceedance; return None if each motion ran at one level."""
        motions = self._motion
        if not (pd.Series(self._im).groupby(motions).nunique() > 1).any():
            return None
        fits: list[FragilityFit] = []
        ends: list[tuple[Floats, Floats, Index]] = []
        for state in self.states:
            known = np.flatnonzero(~self.outcomes.unknown(state))
            exceed = self.outcomes.exceed(state)[known].astype(np.float64)
            runs = self._im[known], exceed, motions[known]
            fit, low, high = fitting.fit_first_exceedances(*runs, self._settings)
            status = fitting.NO_EXCEEDANCE if fit.status == fitting.ALL_CENSORED else fit.status
            fits.append(replace(fit, status=status))
            # the first run of a motion represents its bracket
            ends.append((low, high, known[np.unique(motions[known], return_index=True)[1]]))
        usable = [j for j, fit in enumerate(fits) if fit.status == FITTED]
        if not usable:
            return self._without_estimates(fits)
        parts = [ends[j] for j in usable]
        low, high, runs = map(np.concatenate, zip(*parts, strict=True))
        place = np.repeat(np.arange(len(usable)), [len(part[0]) for part in parts])
        with np.errstate(divide="ignore"):
            logs = np.log(low), np.log(high)
        single = len(usable) == 1  # with one state, the brackets of motions are independent
        return self._common_slope(fits, usable, (place, place), logs, runs, profile=single)

    def _without_estimates(self, fits: list[FragilityFit]) -> _StateFits:
        count = 1 + self._item.blocks
        return _StateFits(fits, np.full((len(fits), count), nan), np.full(count, nan))

    def _common_slope(
        self,
        fits: list[FragilityFit],  # fits of single states, for start values
        usable: list[int],  # numbers of the states to fit
        places: tuple[Index, Index],  # states at the lower and upper bound of each row, (n,) each
        ends: tuple[Floats, Floats],  # bounds of each row in ln intensity, shape (n,) each
        runs: Index,  # run of each row, for its weight
        *,
        whole: bool = True,
        profile: bool = True,  # rows are independent: profile intervals instead of the jackknife
    ) -> _StateFits:
        """Fit the usable states together; the parameters are a0 of each state and the common a1."""
        common, eye = self._without_estimates(fits), -np.eye(len(usable))
        slope = float(np.mean([1.0 / fits[j].beta for j in usable]))
        middles = np.log([fits[j].theta for j in usable])
        # fits of single states may cross: start the common fit with medians at least 5 % apart
        middles[1:] = middles[0] + np.cumsum(np.maximum(np.diff(middles), 0.05))
        kernel = NormalKernel(eye[places[0]], *ends, upper_covariates=eye[places[1]])
        best = maximise(kernel, np.array([[*(-slope * middles), slope]]))
        params, converged = best.params, best.converged
        if whole and converged[0]:
            others = NormalKernel(eye[places[0]], *ends, self._weights[1:, runs], eye[places[1]])
            again = maximise(others, np.tile(params, (len(self._weights) - 1, 1)), covariance=False)
            params = np.vstack([params, again.params])
            converged = np.append(converged, again.converged)
        good = converged & (params[:, -1] > FLATTEST_SLOPE)
        a1 = np.where(good, params[:, -1], nan)
        # a block without a run has no influence
        common.beta[:], common.ln_theta[usable] = 1.0 / a1[0], -params[0, :-1, None] / a1[0]
        blocks = 1 + self._present[: a1.size - 1]
        common.beta[blocks] = 1.0 / a1[1:]
        common.ln_theta[np.ix_(usable, blocks)] = (-params[1:, :-1] / a1[1:, None]).T
        if not good[0]:
            status = fitting.NON_INCREASING if converged[0] else fitting.NOT_CONVERGED
            for j in usable:
                fits[j] = fits[j].without_estimate(status)
            return common
        drop = drop_of(self._settings.confidence) if whole and profile else None
        blanks, size = [fits[j] for j in usable], len(usable)
        found = fitting.fits_of_states(blanks, kernel, best, np.eye(size + 1)[:-1], size, drop)
        for j, fit in zip(usable, found, strict=True):
            if whole and not profile:
                fit = fitting.jackknifed(fit, common.ln_theta[j, blocks], common.beta[blocks])
            fits[j] = fit.warned(*fitting.common_warnings(fit, self._im, self._motions))
        return common

    def _row(
        self, method: str, state: LimitState, fit: FragilityFit, known: Mapping[str, Any]
    ) -> Row:
        """Return the table columns of one fit that do not depend on the other fits."""
        row: Row = dict.fromkeys(_FIT_COLUMNS, nan)
        row |= {name: value for name, value in fit.details.items() if name in row}
        names = "status theta beta var_ln_theta cov_ln_theta_beta var_beta ci_method level loglik"
        row |= {name: getattr(fit, name) for name in names.split()}
        row["theta_low"], row["theta_high"] = fit.ci_theta
        row["beta_low"], row["beta_high"] = fit.ci_beta
        row |= state.columns | {"collapse_rule": state.collapse, "citation": state.citation}
        row |= {"preferred": False, "methods_differ": False, "reach": "", **known}
        row |= {"method": method, "model": fit.method, "im": self._settings.im}
        row["warnings"] = ";".join(dict.fromkeys((*fit.warnings, *state.warnings)))
        row["line_demand"] = state.demand
        beyond = motion_means.motions_beyond(np.log(fit.theta), self._ln_im, self._motion)
        row["extrapolated"] = fit.status == FITTED and beyond < motion_means.MIN_BEYOND
        row["n_motions_beyond"] = beyond if fit.status == FITTED else nan
        row["im_low"], row["im_high"] = motion_means.covered_range(self._im, self._motion)
        if known.get("n_exceed") == 0:
            largest = np.nanmax(self.outcomes.lower, initial=0.0)
            label = label_of(state.demand)
            row["reach"] = f"{label}: largest {largest:.2g}, state at {state.threshold:.2g}"
        return row


def _compared(fits: Mapping[str, FragilityFit], difference: Floats) -> Row:
    """Compare the cloud and exceedance fits of one state; return columns of the table."""
    # `difference` (1 + B,) is ln(exceedance median / cloud median): all runs, then without a block
    ratio, z = nan, nan
    if all(fits[method].status == FITTED for method in METHODS[:2]):
        ratio = motion_means.exp_end(difference[0])
        left_out = difference[1:][np.isfinite(difference[1:])]
        if left_out.size > 2:
            error = float(np.sqrt(motion_means.jackknife_covariance(left_out[:, None])[0, 0]))
            z = float(difference[0] / error) if error > 0.0 else nan
    # ASSUME a difference between the medians of two methods is worth reporting if it exceeds two
    # standard errors
    return {"methods_ratio": ratio, "methods_z": z, "methods_differ": abs(z) > 2.0}


def _total_dispersion(fit: FragilityFit, total: Floats) -> Row:
    """Return the total dispersion (record-to-record and capacity) and its jackknife interval."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(total)
    if fit.status != FITTED or not np.isfinite(logs[0]):
        return {}
    names = ("beta_total", "beta_total_low", "beta_total_high")
    return dict(zip(names, motion_means.interval(logs, fit.level), strict=True))
