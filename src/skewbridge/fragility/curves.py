"""Fragility curves of a study: one row per variant, limit state and method.

All states of one demand share one line (method ``cloud``) or one dispersion (``exceedance``,
``ida_interval``), so that their curves do not cross. The medians of two methods are compared as in
Hausman (1978), Econometrica 46(6):1251-1271; the variance is from the jackknife over motions.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, partial
from itertools import zip_longest
from math import inf, nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row
from skewbridge.fragility import demand_table, motion_means
from skewbridge.fragility import fits as fitting
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED, MAX_BOUNDS_RATIO, FragilityFit
from skewbridge.fragility.likelihood import Maximum, NormalKernel, drop_of, maximise
from skewbridge.fragility.limit_states import COLLAPSE_EXCEEDS, LimitState, States
from skewbridge.fragility.lines import FLATTEST_SLOPE, Lines
from skewbridge.fragility.outcomes import (
    TREATMENTS,
    DemandOutcomes,
    demand_outcomes,
    end_counts,
    states_by_demand,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.union import UNION_COLUMNS, Union, correlation, reached_modes, residuals
from skewbridge.statuses import COLLAPSE

#: Methods in order of preference.
METHODS: Final = ("cloud", "exceedance", "ida_interval")

CURVE_COLUMNS: Final = demand_table.described("curves")
_FIT_COLUMNS: Final = list(CURVE_COLUMNS)[list(CURVE_COLUMNS).index("component") :]


def fit_study(
    demands: pd.DataFrame, limit_states: States, settings: FitSettings = DEFAULTS, *, jobs: int = 1
) -> pd.DataFrame:
    """Fit fragility curves of every variant and limit state of a demands table.

    The table has `CURVE_COLUMNS` and one row per variant, limit state and method. ``cloud`` fits a
    line to ln demand (Tobit if some demands are censored). ``exceedance`` is a probit fit to the
    outcomes of runs. ``ida_interval`` is added if motions ran at several levels. Theta and beta are
    NaN unless ``status`` is ``ok``. There is no estimate for a state that no run, or every run,
    exceeds. Raises `InputError` if there are no limit states.
    """
    if not limit_states:
        raise InputError("no limit states to fit")
    rows_of = partial(_variant_rows, states=limit_states, settings=settings)
    columns = [settings.im, *(state.demand for state in limit_states)]
    rows = demand_table.spread(rows_of, demand_table.variants_of(demands, columns), jobs)
    table = pd.DataFrame([row for part in rows for row in part])
    names = dict.fromkeys((*demand_table.variant_columns(demands), *CURVE_COLUMNS))
    return table[[name for name in names if name in table]]


def _variant_rows(part: pd.DataFrame, *, states: States, settings: FitSettings) -> list[Row]:
    """Return the rows of one variant."""
    described = demand_table.variant_values(part)
    fits = [
        (_UnionFits if group[0].modes else _DemandFits)(part, group, settings)
        for group in states_by_demand(states).values()
    ]
    known = {state: each for each in fits for state in each.states}
    unions = [each for each in fits if isinstance(each, _UnionFits)]
    for mode in dict.fromkeys(mode for each in unions for s in each.states for mode in s.modes):
        known.setdefault(mode, _DemandFits(part, [mode], settings))
    for union in unions:
        union.known = known
    rows = [row for each in fits for row in each.rows]
    for state in (state for union in unions for state in union.states):
        _prefer_one_method(rows, state)
    return [described | row for row in rows]


#: Median and dispersion for each treatment of unknown outcomes; `_PEAKS` if a run collapsed.
type _Bounds = dict[str, tuple[float, float]]
_PEAKS: Final = "peaks"  # peaks of collapsed runs count as exact


class _StateFits(NamedTuple):
    """Fits of the J states of one demand; NaN if there is no fit."""

    fits: list[FragilityFit]  # fits to all runs
    ln_theta: Floats  # from all runs, then without each motion, shape (J, 1 + M)
    beta: Floats  # common dispersion, in the same order, shape (1 + M,)

    def median(self, j: int) -> tuple[float, float]:
        """Return theta and beta of state j from all runs."""
        return motion_means.exp_end(self.ln_theta[j, 0]), float(self.beta[0])


class _Curve(NamedTuple):
    """Curve of one state by one method; arrays are from all runs, then without each motion."""

    fit: FragilityFit
    ln_theta: Floats  # shape (1 + M,)
    beta: Floats
    total: Floats  # including the dispersion of the capacity
    bounds: _Bounds
    columns: Row  # `UNION_COLUMNS` of a union of two modes


class _DemandFits:
    """The fits of one variant for all states of one demand."""

    def __init__(self, part: pd.DataFrame, states: States, settings: FitSettings) -> None:
        self._part, self.states, self._settings = part, states, settings
        self._im = part[settings.im].to_numpy(dtype=np.float64)
        self._ln_im, self._motion = np.log(self._im), demand_table.motion_codes(part)
        self._weights = motion_means.motion_weights(self._motion)
        self._motions = int(np.max(self._motion)) + 1
        self.outcomes = demand_outcomes(part, states)

    @cached_property
    def lines(self) -> Lines:
        """Lines from all runs, then without each motion."""
        return self.outcomes.lines(self._ln_im, self._weights)

    @cached_property
    def _found(self) -> dict[str, _StateFits]:
        found = {"cloud": self._clouds(self.lines), "exceedance": self._exceedance(self.outcomes)}
        return found if (brackets := self._brackets()) is None else found | {METHODS[2]: brackets}

    @cached_property
    def curves(self) -> list[dict[str, _Curve]]:
        """Curves of each state by method, before unknown outcomes are considered."""
        bounds = self._bounds()
        curves: list[dict[str, _Curve]] = []
        for j, state in enumerate(self.states):
            by_method: dict[str, _Curve] = {}
            for method, found in self._found.items():
                # capacity dispersion is divided by the slope b of the line
                # ASSUME the capacity is independent of the demand
                with np.errstate(divide="ignore", invalid="ignore"):
                    wide = np.hypot(found.beta, state.dispersion / self.lines.b)
                total = wide if state.dispersion else found.beta
                own = bounds[method][j] if method in bounds else {}
                values = found.fits[j], found.ln_theta[j], found.beta, total
                by_method[method] = _Curve(*values, own, {})
            curves.append(by_method)
        return curves

    @cached_property
    def printed(self) -> list[dict[str, FragilityFit]]:
        """Fits of each state by method, without estimates that unknown outcomes may change."""
        printed: list[dict[str, FragilityFit]] = []
        for state, curves in zip(self.states, self.curves, strict=True):
            fits = {method: curve.fit for method, curve in curves.items()}
            share = self.outcomes.counts(state)["n_unknown"] / self._im.size
            names = ["unknown_above_5_percent"] if share > 0.05 else []
            for method, curve in curves.items() if share else ():
                if curve.bounds:
                    fits[method] = fits[method].judged(curve.bounds, names=names)
            # Large demands cause collapse, so censoring by collapse is not independent of the
            # demand. A median is accepted only if it hardly depends on how these peaks are treated.
            other = curves["cloud"].bounds.get(_PEAKS)
            change = np.log(other[0]) - curves["cloud"].ln_theta[0] if other else 0.0
            if fits["cloud"].status == FITTED and not abs(change) <= np.log(MAX_BOUNDS_RATIO):
                fits["cloud"] = fits["cloud"].without_estimate(BOUNDS_TOO_WIDE)
            printed.append(fits)
        return printed

    @property
    def rows(self) -> list[Row]:
        """Rows of the table of curves, without the columns that describe the variant."""
        outcomes, states = self.outcomes, self.states
        missing = outcomes.complete & np.isnan(outcomes.lower)
        counts = end_counts(self._part) | {"n_runs": self._im.size, "n_records": self._motions}
        counts |= {"n_censored": int(np.sum(outcomes.is_bound)), "n_missing": int(np.sum(missing))}
        if np.any(missing) and np.all(missing[outcomes.complete]):
            blank = FragilityFit(method="", status=fitting.NOT_APPLICABLE)
            return [self._row(m, state, blank, counts) for state in states for m in METHODS[:2]]
        rows: list[Row] = []
        for state, curves, fits in zip(states, self.curves, self.printed, strict=True):
            known = counts | outcomes.counts(state)
            difference = curves["exceedance"].ln_theta - curves["cloud"].ln_theta
            compared = _compared(fits, difference, known)
            for method, fit in fits.items():
                row = self._row(method, state, fit, known) | compared.get(method, {})
                row |= _total_dispersion(fit, curves[method].total)
                row |= curves[method].columns if fit.status == FITTED else {}
                for name in TREATMENTS if curves[method].bounds else ():
                    row[f"theta_{name}"], row[f"beta_{name}"] = curves[method].bounds[name]
                rows.append(row)
        return rows

    def _clouds(self, lines: Lines) -> _StateFits:
        """Return the cloud fits; a state that no run, or every run, exceeds has no estimate."""
        outcomes, used = self.outcomes, self.outcomes.used
        medians = np.stack([lines.ln_theta(state.threshold) for state in self.states])
        kept = np.any(self._weights[:, used] == 0.0, axis=1)
        without = Lines(lines.ln_a[kept], lines.b[kept], lines.sigma[kept])
        repeated = np.unique(self._motion[used]).size < np.sum(used)
        own, capacities = without if repeated else None, [(s.threshold, 0.0) for s in self.states]
        cloud = self._ln_im[used], *outcomes.ln_ends
        fits = fitting.fit_cloud_states(cloud, capacities, self._settings, own)
        refused = (
            fit if status == FITTED else fit.without_estimate(status)
            for fit, status in zip(fits, map(outcomes.status, self.states), strict=True)
        )
        return _StateFits(list(refused), medians, lines.beta())

    def _exceedance(self, outcomes: DemandOutcomes, *, intervals: bool = True) -> _StateFits:
        """Fit the exceedance probabilities of all states with a common dispersion."""
        # Ordered probit: a run that exceeds state j but not state k has the probability
        # Phi(eta_j) - Phi(eta_k), with eta_j = a0_j + a1 ln x.
        exceed = np.column_stack([outcomes.exceed(state) for state in self.states])
        known = ~np.column_stack([outcomes.unknown(state) for state in self.states])
        maxima = fitting.exceedance_maxima(self._ln_im, known, exceed) if intervals else ()
        columns = zip_longest(known.T, exceed.T, maxima)
        fits = [self._alone(*column, whole=intervals) for column in columns]
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
            fits, usable, places, (low[rows], high[rows]), rows, intervals=intervals, profile=single
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
        count = len(self._weights)
        return _StateFits(fits, np.full((len(fits), count), nan), np.full(count, nan))

    def _common_slope(
        self,
        fits: list[FragilityFit],  # fits of single states, for start values
        usable: list[int],  # numbers of the states to fit
        places: tuple[Index, Index],  # states at the lower and upper bound of each row, (n,) each
        ends: tuple[Floats, Floats],  # bounds of each row in ln intensity, shape (n,) each
        runs: Index,  # run of each row, for its weight
        *,
        intervals: bool = True,
        profile: bool = True,  # rows are independent: profile intervals instead of the jackknife
    ) -> _StateFits:
        """Fit the usable states together; the parameters are a0 of each state and the common a1."""
        common, eye = self._without_estimates(fits), -np.eye(len(usable))
        slope = float(np.mean([1.0 / fits[j].beta for j in usable]))
        middles = np.log([fits[j].theta for j in usable])
        # fits of single states may cross: start the common fit with medians at least 5 % apart
        middles[1:] = middles[0] + np.cumsum(np.maximum(np.diff(middles), 0.05))
        whole = NormalKernel(eye[places[0]], *ends, upper_covariates=eye[places[1]])
        best = maximise(whole, np.array([[*(-slope * middles), slope]]))
        params, converged = best.params, best.converged
        if intervals and converged[0]:
            kernel = NormalKernel(eye[places[0]], *ends, self._weights[1:, runs], eye[places[1]])
            again = maximise(kernel, np.tile(params, (len(self._weights) - 1, 1)), covariance=False)
            params = np.vstack([params, again.params])
            converged = np.append(converged, again.converged)
        good = converged & (params[:, -1] > FLATTEST_SLOPE)
        a1 = np.where(good, params[:, -1], nan)
        common.beta[: a1.size] = 1.0 / a1
        common.ln_theta[usable, : a1.size] = (-params[:, :-1] / a1[:, None]).T
        if not good[0]:
            status = fitting.NON_INCREASING if converged[0] else fitting.NOT_CONVERGED
            for j in usable:
                fits[j] = fits[j].without_estimate(status)
            return common
        drop = drop_of(self._settings.confidence) if intervals and profile else None
        blanks, size = [fits[j] for j in usable], len(usable)
        found = fitting.fits_of_states(blanks, whole, best, np.eye(size + 1)[:-1], size, drop)
        for j, fit in zip(usable, found, strict=True):
            if intervals and not profile:
                fit = fitting.jackknifed(fit, common.ln_theta[j, 1:], common.beta[1:])
            fits[j] = fit.warned(*fitting.common_warnings(fit, self._im, self._motions))
        return common

    def _bounds(self) -> dict[str, list[_Bounds]]:
        """Return (theta, beta) for each method, state and treatment of unknown outcomes."""
        outcomes, states = self.outcomes, self.states
        bounds = {
            method: [dict.fromkeys(TREATMENTS, fits.median(j)) for j in range(len(states))]
            for method, fits in self._found.items()
            if method in METHODS[:2]
        }
        unknown = [j for j, state in enumerate(states) if np.any(outcomes.unknown(state))]
        for name in TREATMENTS if unknown else ():
            treated = outcomes
            for state in states:
                treated = treated.treated(state, name)
            # the exceedance fit itself already excludes unknown outcomes
            common = None if name == "exclude" else self._exceedance(treated, intervals=False)
            for j in unknown:
                bounds["cloud"][j][name] = self._end(outcomes.treated(states[j], name), j)
                if common is not None:
                    bounds["exceedance"][j][name] = common.median(j)
        ended = (self._part["status"] == COLLAPSE).to_numpy() & np.isposinf(outcomes.upper)
        by_definition = any(each.collapse == COLLAPSE_EXCEEDS for each in states)
        if np.any(ended) and not by_definition:
            final = replace(outcomes, upper=np.where(ended, outcomes.lower, outcomes.upper))
            for j, each in enumerate(bounds["cloud"]):
                each[_PEAKS] = self._end(final, j)
        return bounds

    def _end(self, outcomes: DemandOutcomes, j: int) -> tuple[float, float]:
        """Return theta and beta of state j from the line through all runs."""
        line = outcomes.lines(self._ln_im, self._weights[:1])
        theta = motion_means.exp_end(line.ln_theta(self.states[j].threshold)[0])
        return theta, float(line.beta()[0])

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


class _UnionFits(_DemandFits):
    """The fits of one variant for states that are the union of failure modes."""

    #: Fits that include every mode.
    known: Mapping[LimitState, _DemandFits]

    @cached_property
    def curves(self) -> list[dict[str, _Curve]]:
        """Curves of each state by method: unions of the curves of the modes that runs exceed."""
        return [
            {method: self._union(method, curve, state) for method, curve in curves.items()}
            if self.outcomes.status(state) == FITTED
            else curves
            for state, curves in zip(self.states, super().curves, strict=True)
        ]

    def _union(self, method: str, direct: _Curve, state: LimitState) -> _Curve:
        """Return the union by one method; ``direct`` is the fit to the outcomes in any mode."""
        if not (modes := reached_modes(self._part, state)):
            return direct
        fits = [self.known[mode] for mode in modes]
        parts: list[_Curve] = []
        reasons: list[str] = []
        for mode, each in zip(modes, fits, strict=True):
            # a mode without a curve by this method has its curve by another method; a mode that
            # other failures censor too much for a curve of its own has its fit to the known runs
            place, tried = each.states.index(mode), dict.fromkeys((method, *METHODS[:2]))
            curves, printed = each.curves[place], each.printed[place]
            good = [name for name in tried if printed[name].status == FITTED]
            good += [name for name in tried if curves[name].fit.status == FITTED]
            parts += [curves[name] for name in good[:1]]
            reasons += [] if good[:1] == [method] else [printed[method].status]
        if len(parts) < len(modes) or len(reasons) == len(modes):
            is_fitted = direct.fit.status == FITTED
            fit = direct.fit.without_estimate(reasons[0]) if is_fitted else direct.fit
            return direct._replace(fit=fit)
        if len(parts) == 1:
            single = {"line_demand": modes[0].demand, "capacity_dispersion": modes[0].dispersion}
            return parts[0]._replace(columns=single)
        ln_theta, beta, total = (np.array([part[n] for part in parts]) for n in (1, 2, 3))
        ln_theta[:, 0] = [np.log(part.fit.theta) for part in parts]
        total = np.where(np.isnan(total), beta, total)
        apart = [residuals(each.outcomes, each.lines, self._ln_im) for each in fits]
        rho = correlation(apart[0], apart[1], self._weights)
        union = Union.of(ln_theta, beta, total, rho)
        (ln_any, wide), (_, records) = union.summary(), Union(ln_theta, beta, rho).summary()
        fit = FragilityFit(method="union", status=FITTED, level=self._settings.confidence)
        fit = replace(fit, theta=motion_means.exp_end(ln_any[0]), beta=float(records[0]))
        fit = fitting.jackknifed(fit, ln_any[1:], records[1:])
        fit = fit.warned(*fitting.common_warnings(fit, self._im, self._motions))
        # ASSUME unknown outcomes change the median of the union as that of the direct fit
        scale = float(np.exp(ln_any[0] - direct.ln_theta[0]))
        bounds = {name: (scale * theta, b) for name, (theta, b) in direct.bounds.items()}
        values = *np.column_stack([np.exp(ln_theta[:, 0]), total[:, 0]]).ravel(), union.rho[0]
        columns = dict(zip(UNION_COLUMNS, map(float, values), strict=True)) | {"line_demand": ""}
        return _Curve(fit, ln_any, records, wide, bounds, columns)


def _prefer_one_method(rows: list[Row], union: LimitState) -> None:
    """Prefer one method for both modes and their union if both methods have a curve of a mode."""
    # ASSUME the modes use one method, because a union by one method may be below a mode by another
    by_state: dict[LimitState, dict[str, Row]] = {}
    for state in (*union.modes, union):
        key = state.component, state.name, state.demand
        own = (r for r in rows if (r["component"], r["limit_state"], r["demand"]) == key)
        by_state[state] = {row["method"]: row for row in own if row["status"] == FITTED}
    both = [own for s, own in by_state.items() if s != union and {*METHODS[:2]} <= {*own}]
    if not both:
        return
    preferred = METHODS[any(own[METHODS[1]]["preferred"] for own in both)]
    for own in (*both, by_state[union]):
        for method, row in own.items():
            row["preferred"] = method == preferred


def _compared(
    fits: Mapping[str, FragilityFit], difference: Floats, known: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Compare the cloud and exceedance fits of one state; return table columns for each method."""
    # `difference` (1 + M,) is ln(exceedance median / cloud median): all runs, then without a motion
    cloud, exceedance = (fits[method].status == FITTED for method in METHODS[:2])
    ratio, z = nan, nan
    if cloud and exceedance:
        ratio = motion_means.exp_end(difference[0])
        left_out = difference[1:][np.isfinite(difference[1:])]
        if left_out.size > 2:
            error = float(np.sqrt(motion_means.jackknife_covariance(left_out[:, None])[0, 0]))
            z = float(difference[0] / error) if error > 0.0 else nan
    # ASSUME a difference between the medians of two methods is worth reporting if it exceeds 15 %
    # or two standard errors
    far = abs(z) > 2.0
    differ = bool(far or abs(ratio - 1.0) > 0.15)
    # prefer exceedance to cloud if z is above 2 and five runs lie on each side of the threshold
    sides = min(known["n_exceed"], known["n_runs"] - known["n_exceed"] - known["n_unknown"])
    by_count = exceedance and (not cloud or (far and sides >= 5))
    shared = {"methods_ratio": ratio, "methods_z": z, "methods_differ": differ}
    preferred = {"cloud": cloud and not by_count, "exceedance": by_count}
    return {method: shared | {"preferred": each} for method, each in preferred.items()}


def _total_dispersion(fit: FragilityFit, total: Floats) -> Row:
    """Return the total dispersion (record-to-record and capacity) and its jackknife interval."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(total)
    if fit.status != FITTED or not np.isfinite(logs[0]):
        return {}
    middle, left_out = motion_means.exp_end(logs[0]), logs[1:][np.isfinite(logs[1:])]
    factor = motion_means.jackknife_factors(left_out[:, None], fit.level)[0]
    ends = {"beta_total_low": middle / factor, "beta_total_high": middle * factor}
    return {"beta_total": middle} | ends
