"""Model of one demand of a bridge in all its variants; medians and dispersions follow from it.

    ln D = level + slope x + bend max(x - knot, 0) + shift(v) + drift(v) x + exp(gamma x) (u + e)

x is ln intensity minus its mean. The shift of a variant v is a sum over axes, with a value for each
level of an axis, plus interactions with a prior about zero; the drift is an effect of an axis that
changes with intensity, with a narrow prior. u is the effect of the motion at one incidence, e the
scatter of a run (`mixed`). Shape (straight or bent) and growth of the scatter are those that
predict left-out motions best. Blocks (events, else motions) are left out in turn for the jackknife.

Sources: choice by left-out groups, Stone (1974), J. R. Stat. Soc. B 36(2):111-147.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import combinations, product
from math import nan
from typing import Any, Final, NamedTuple, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Mask, Row
from skewbridge.fragility import demand_table
from skewbridge.fragility import fits as fitting
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.mixed import MixedData, MixedFit, fit_mixed, predictive_loglik
from skewbridge.fragility.motion_means import Jackknifed, jackknife_covariance
from skewbridge.fragility.outcomes import (
    DemandOutcomes,
    collapsed_runs,
    demand_outcomes,
    states_by_demand,
)
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.union import Union, correlation
from skewbridge.variant.variant import lacking_axes

SKEW: Final = "skew_deg"
#: Standard deviations of the priors of ln demand: effects of single axes (no prior, but axes that
#: the variants cannot separate share their effect), interactions of two and of three axes at single
#: levels, and the interaction of two axes that is proportional to both.
_SHIFTS: Final = (30.0, 0.1, 0.05)
_PROPORTIONAL: Final = 1.0
#: Takes the place of a level in a term proportional to the axis, from 0 to 1 over its range.
_LINEAR: Final = np.inf
# ASSUME the effect of an axis on ln demand changes by some 3 % per unit of ln intensity
_DRIFT: Final = 0.03
_LOOSE: Final = 10.0  # factor of wide priors
#: Smallest factor of a prior's precision: priors divide effects that variants cannot separate.
_LIGHTEST: Final = 0.01
#: Largest number of levels of an axis with a value each; with more, the effect is a parabola.
_MOST_LEVELS: Final = 6
#: Possible places of the knot: shares of the runs below it.
_KNOTS: Final = (0.25, 0.5, 0.75)
#: Smallest number of motions with known demands on each side of the knot, and of a fit.
_LEAST_BESIDE: Final = 5
LEAST_MOTIONS: Final = 4
# ASSUME a further parameter has to raise the log-likelihood of left-out motions by at least 3
_LEAST_GAIN: Final = 3.0
FLATTEST: Final = 1e-3
TOO_FEW_RUNS: Final = "too_few_runs"
_HALVINGS: Final = 34
#: Dispersion above which a demand hardly grows with intensity where it reaches a threshold.
_LARGEST_BETA: Final = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisRange:
    """Axes of the variants of one bridge and abutment model, and their levels.

    Effects have a value at each level, between them a cubic spline (2 levels: line; 3: parabola).
    """

    levels: Mapping[str, Sequence[float]]

    @classmethod
    def of_variants(cls, variants: pd.DataFrame, names: Sequence[str]) -> Self:
        """Return the axes of a table with one row per variant."""
        levels: dict[str, list[float]] = {}
        for name in names:
            values = variants[name].to_numpy(dtype=np.float64)
            if name == SKEW and not (np.any(values > 0.0) and np.any(values < 0.0)):
                values = np.abs(values)
            values = np.unique(values)
            if values.size > _MOST_LEVELS:
                values = np.linspace(values[0], values[-1], 3)
            if np.all(np.isfinite(values)):
                levels[name] = values.tolist()
        return cls(levels=levels)

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """Smallest and largest value of each axis."""
        return {name: (values[0], values[-1]) for name, values in self.levels.items()}

    @property
    def varying(self) -> tuple[str, ...]:
        """Axes that differ between the variants."""
        return tuple(name for name, values in self.levels.items() if len(values) > 1)

    @property
    def middle(self) -> dict[str, float]:
        """Middle of the range of each varying axis."""
        return {name: 0.5 * sum(self.limits[name]) for name in self.varying}

    @property
    def terms(self) -> list[tuple[tuple[str, float], ...]]:
        """Terms of ``shift`` as (axis, level) pairs: single, then products of two and three."""
        by_axis = [[(name, level) for level in self.levels[name][1:]] for name in self.varying]
        linear = [tuple((name, _LINEAR) for name in pair) for pair in combinations(self.varying, 2)]
        at_levels = [
            term
            for order in range(1, len(_SHIFTS) + 1)
            for axes in combinations(by_axis, order)
            for term in product(*axes)
        ]
        return [*at_levels, *linear]

    @property
    def names(self) -> list[str]:
        """Names of the coefficients: the terms of ``shift``, then those of ``drift``."""
        names = [
            ":".join(name if level == _LINEAR else f"{name}={level:g}" for name, level in term)
            for term in self.terms
        ]
        return [*names, *(f"{names[i]}:ln_im" for i in range(self.drifts))]

    @property
    def drifts(self) -> int:
        """Number of terms of ``drift``: those of single axes, which come first in `terms`."""
        return sum(len(term) == 1 for term in self.terms)

    @property
    def deviations(self) -> Floats:
        """Prior standard deviations of effects (``shift``), then of their slopes (``drift``)."""
        shift_deviations = [
            _PROPORTIONAL if term[0][1] == _LINEAR else _SHIFTS[len(term) - 1]
            for term in self.terms
        ]
        return np.array([*shift_deviations, *[_DRIFT] * self.drifts])

    def matrix(self, values: Mapping[str, Any]) -> Floats:
        """Return the q regressors of ``shift`` at n points, given by axis ``values``, (n, q)."""
        columns: dict[tuple[str, float], Floats] = {}
        for name in self.varying:
            levels = self.levels[name]
            value = np.atleast_1d(self.counted(name, np.asarray(values[name], dtype=np.float64)))
            weights = _cardinal_spline(tuple(levels))(value)
            columns |= {(name, level): weights[:, k] for k, level in enumerate(levels)}
            columns[name, _LINEAR] = (value - levels[0]) / (levels[-1] - levels[0])
        size = next((column.size for column in columns.values()), 1)
        products = [np.prod([columns[factor] for factor in term], axis=0) for term in self.terms]
        return np.column_stack([np.empty((size, 0)), *products])

    def check(self, values: Mapping[str, float]) -> None:
        """Check a point; an `InputError` names an axis that is missing, unknown or out of range."""
        limits = self.limits
        for name in (*self.varying, *values):
            low, high = limits.get(name, (-np.inf, np.inf))
            problem = "" if name in limits else f"is not an axis: give {', '.join(limits)}"
            if name not in values:
                problem = f"is missing; give a value within {low:g}..{high:g}"
            elif not low - 1e-9 <= self.counted(name, values[name]) <= high + 1e-9:
                problem = f"must be within {low:g}..{high:g}, the range of the study"
                problem += f", got {values[name]:g}"
            if problem:
                raise InputError(f"{name} {problem}", column=name)

    def counted(self, name: str, value: Any) -> Any:
        """Return the value of an axis in the model: |skew| unless the study has both signs."""
        is_signed = name == SKEW and self.levels.get(SKEW, (0.0,))[0] < 0.0
        return abs(value) if name == SKEW and not is_signed else value


@lru_cache(maxsize=64)
def _cardinal_spline(levels: tuple[float, ...]) -> Callable[[Floats], Floats]:
    """Return the cubic spline that is 1 at each level in turn and 0 at the others."""
    from scipy.interpolate import CubicSpline  # imported only when needed: it is slow to load

    return CubicSpline(levels, np.eye(len(levels)))


@dataclass(frozen=True, slots=True, kw_only=True)
class DemandModel:
    """R models of one demand: of all runs, then without each event or motion (jackknife).

    The last models, one per term of ``drift``, include the standard error from its prior.
    """

    axes: AxisRange
    #: Level, slope, bend, coefficients of shift and drift, gamma, ln tau, ln sigma; shape (R, m).
    parameters: Floats
    centre: float  # mean of ln intensity
    knot: float  # x of the bend; infinite: straight
    span: tuple[float, float]  # range of x, beyond which the scatter is constant
    motions: int  # number of motions with a usable run

    @property
    def deviation(self) -> Floats:
        """Standard deviation of ln demand at x = 0, corrected for few motions, shape (R,)."""
        variance = np.sum(np.exp(2.0 * self.parameters[:, -2:]), axis=1)
        # level and slope, and a bend, were estimated
        n_estimated, count = 2 + bool(np.isfinite(self.knot)), np.full(len(variance), self.motions)
        count[1 : len(variance) - self.axes.drifts] -= 1
        return np.sqrt(variance * count / np.maximum(count - n_estimated, 1))

    def at(self, values: Mapping[str, Any]) -> "PointModel":
        """Return the models at one point, a mapping from axis to value."""
        terms = self.axes.matrix(values)[0]
        level, slope, bend = self.parameters[:, :3].T
        shift, drift = np.split(self.parameters[:, 3:-3], [terms.size], axis=1)
        slope = slope + drift @ terms[: drift.shape[1]]
        return PointModel(self, level + shift @ terms, slope, slope + bend, self.deviation)


class PointModel(NamedTuple):
    """R models of one demand at one point of the axes; arrays of shape (R,)."""

    model: DemandModel
    level: Floats  # of ln demand at x = 0
    slope: Floats  # below the knot
    above: Floats  # slope above the knot
    deviation: Floats  # of ln demand at x = 0

    def ln_demand(self, ln_im: Floats) -> Floats:
        """Return the median ln demand at ln intensities (..., R)."""
        x = ln_im - self.model.centre
        above_knot = np.maximum(x - self.model.knot, 0.0)
        return self.level + self.slope * x + (self.above - self.slope) * above_knot

    def scatter(self, ln_im: Floats) -> Floats:
        """Return the standard deviation of ln demand at ln intensities (..., R)."""
        x = np.clip(ln_im - self.model.centre, *self.model.span)
        return self.deviation * np.exp(self.model.parameters[:, -3] * x)

    def ln_theta(self, threshold: float) -> Floats:
        """Return ln of the intensity at which the median demand is the threshold, shape (R,)."""
        is_rising = (self.slope > FLATTEST) & (self.above > FLATTEST)
        slope, knot = np.where(is_rising, self.slope, nan), self.model.knot
        x = (np.log(threshold) - self.level) / slope
        if np.isfinite(knot):
            x = np.where(x > knot, knot + (x - knot) * slope / self.above, x)
        return self.model.centre + x

    def slope_at(self, ln_im: Floats) -> Floats:
        """Return the slope of ln demand at one ln intensity for each model, shape (R,)."""
        return np.where(ln_im - self.model.centre > self.model.knot, self.above, self.slope)

    def score(self, threshold: float, dispersion: ArrayLike, ln_im: Floats) -> Floats:
        """Return z of the probability Phi(z) to exceed a state at ln intensities (..., R)."""
        ln_excess = self.ln_demand(ln_im) - np.log(threshold)
        return ln_excess / np.hypot(self.scatter(ln_im), dispersion)

    def curves(self, threshold: float, dispersion: float) -> tuple[Floats, Floats, Floats]:
        """Return ln theta, beta of records and beta_total of a state, shape (R,) each.

        beta is half of the ln range in which the probability of the model rises from 16 to 84 %.
        """
        middle, span_ends = self.ln_theta(threshold), self.model.centre + np.array(self.model.span)
        widest = np.max(self.scatter(span_ends[:, None]), axis=0)
        with np.errstate(invalid="ignore"):
            flattest = np.where(np.isnan(middle), nan, np.minimum(self.slope, self.above))
        # both dispersions (records, total) and both sides (16 and 84 %): shape (2, 2, R)
        capacity = np.array([0.0, dispersion])[:, None, None]
        side = np.array([-1.0, 1.0])[:, None]
        outer = np.broadcast_to(np.hypot(widest, capacity) / flattest, (2, 2, middle.size))
        inner = np.zeros_like(outer)
        for _ in range(_HALVINGS):
            width = 0.5 * (inner + outer)
            is_inside = side * self.score(threshold, capacity, middle + side * width) < 1.0
            inner, outer = np.where(is_inside, width, inner), np.where(is_inside, outer, width)
        records, total = np.mean(0.5 * (inner + outer), axis=1)
        return middle, records, total

    def columns(self) -> Row:
        """Return the columns of the table of curves that describe the model from all runs."""
        model, level, slope, above = self.model, *(float(values[0]) for values in self[1:4])
        growth = float(model.parameters[0, -3])
        row: Row = {"ln_a": level - slope * model.centre, "b": slope, "growth": growth}
        row["sigma"] = float(self.deviation[0] * np.exp(-growth * model.centre))
        bent = np.isfinite(model.knot)
        return row | ({"knot": np.exp(model.centre + model.knot), "b_above": above} if bent else {})

    def largest_distance(self, state: LimitState, ln_theta: float, total: float) -> float:
        """Return the largest |P of the model - P of the lognormal curve| in the range of runs."""
        ln_im = self.model.centre + np.linspace(*self.model.span, 201)
        z = self.score(state.threshold, state.dispersion, ln_im[:, None])[:, 0]
        return float(np.max(np.abs(special.ndtr(z) - special.ndtr((ln_im - ln_theta) / total))))


class StateCurve(NamedTuple):
    """Curves of one state at one point for R models: of all runs, then without each event."""

    ln_theta: Floats  # shape (R,)
    beta: Floats  # of records
    total: Floats  # including the capacity
    modes: Union | None = None  # if the state is a union of two failure modes, with total beta
    records: Union | None = None  # the same union with beta of records
    points: tuple[tuple[PointModel, LimitState], ...] = ()  # demand models of the modes
    priors: int = 0  # number of last models that are errors from priors, see `DemandModel`

    def ln_median(self) -> Jackknifed:
        """Return ln theta with the influence of each motion."""
        return self.ln_median_and_beta()[0]

    def ln_median_and_beta(self) -> list[Jackknifed]:
        """Return ln theta and ln beta with the influence of each motion that has one on either."""
        # Fieller's interval, as of ratios, covers single medians no better in simulations
        logs = np.column_stack([self.ln_theta, np.log(self.beta)])
        return Jackknifed.of_replicates(logs, self.priors).columns()

    def ln_ratio(self, over: "StateCurve") -> Jackknifed:
        """Return ln of theta / theta of another curve of these models."""
        at = [(point, curve.ln_theta[0]) for curve in (self, over) for point, _ in curve.points]
        with np.errstate(invalid="ignore", divide="ignore"):  # without a block, it may not rise
            slopes = [np.log(point.slope_at(ln_im)) for point, ln_im in at]
        # ASSUME the slope of two modes, or at two points, is their geometric mean
        ln_slope = np.mean(slopes or [np.zeros_like(self.ln_theta)], axis=0)
        return Jackknifed.of_ratio(self.ln_theta - over.ln_theta, ln_slope, self.priors)

    def probability(self, ln_im: float, *, total: bool = True) -> float:
        """Return P(exceeds) from all runs, with or without the dispersion of the capacity."""
        beta, modes = (self.total, self.modes) if total else (self.beta, self.records)
        if modes is not None:
            return float(modes.probability(np.array(ln_im))[0])
        return float(special.ndtr((ln_im - self.ln_theta[0]) / beta[0]))


@dataclass(frozen=True, kw_only=True)
class DemandFit:
    """The fitted model of a demand with its data."""

    model: DemandModel
    outcomes: DemandOutcomes  # of all n runs
    #: Standardised ln demand minus that of each of R models; NaN for bounds; shape (R, n).
    residuals: Floats
    setup: "_Setup"

    def treated(self, outcomes: DemandOutcomes, steps: int = 100) -> DemandModel:
        """Return the model (R = 1) refitted to other outcomes; its knot is not fitted again."""
        model, start = self.model, self.model.parameters[0]
        data = self.setup.data(outcomes, model.centre, model.knot, grows=bool(start[-3]))
        parameters = fit_mixed(data, start, steps).parameters[None]
        return replace(model, parameters=parameters, motions=self.setup.used_motions(outcomes))

    def exceeds(self, state: LimitState) -> Floats:
        """Return P(a run exceeds a state | lower bound of its demand) for each run, shape (n,)."""
        model, setup = self.model, self.setup
        delta, growth = model.parameters[0, :-3], model.parameters[0, -3]
        x = np.clip(setup.ln_im - model.centre, *model.span)
        scatter = model.deviation[0] * np.exp(growth * x)
        mean = setup.design(model.centre, model.knot) @ delta
        with np.errstate(divide="ignore"):
            bound = np.log(np.nan_to_num(self.outcomes.lower))
        limits = np.log(state.threshold), bound
        tails = [special.log_ndtr((mean - limit) / scatter) for limit in limits]
        return np.exp(np.minimum(tails[0] - tails[1], 0.0))

    @property
    def effects(self) -> Floats:
        """Regressors of the level and of the effects of single axes in V variants, (V, 1 + d)."""
        of_axes = self.setup.matrix[:, : self.setup.axes.drifts]
        return np.column_stack([np.ones(len(of_axes)), of_axes])

    @cached_property
    def without_variants(self) -> list[DemandModel | str]:
        """Model fitted without each variant in turn, or why the other variants do not suffice."""
        setup, effects = self.setup, self.effects
        rank, models = np.linalg.matrix_rank(effects), list[DemandModel | str]()
        for variant in range(len(effects)):
            other_effects = np.delete(effects, variant, axis=0)
            if len(other_effects) < 1 or np.linalg.matrix_rank(other_effects) < rank:
                models.append(fitting.NOT_APPLICABLE)
                continue
            lower = np.where(setup.variant == variant, nan, self.outcomes.lower)
            models.append(self.treated(replace(self.outcomes, lower=lower), steps=1))
        return models


@dataclass(frozen=True, slots=True, kw_only=True)
class _Setup:
    """Runs of one bridge and abutment model without their demands, arrays of shape (n,)."""

    axes: AxisRange
    ln_im: Floats
    motion: Index
    shaking: Index  # motion and incidence: the group of the random effect
    block: Index
    variant: Index
    matrix: Floats  # terms of the shift of each variant, shape (V, q)
    precision: Floats  # of the priors of shift and drift

    def used_motions(self, outcomes: DemandOutcomes) -> int:
        """Return the number of motions with a usable run."""
        return np.unique(self.motion[outcomes.used]).size

    def design(self, centre: float, knot: float) -> Floats:
        """Return the regressors X (see `mixed`) of all runs, shape (n, 3 + q + drifts)."""
        x, shift = self.ln_im - centre, self.matrix[self.variant]
        above = np.maximum(x - knot, 0.0)
        interaction = shift[:, : self.axes.drifts] * x[:, None]
        return np.column_stack([np.ones(x.size), x, above, shift, interaction])

    def data(
        self, outcomes: DemandOutcomes, centre: float, knot: float, *, grows: bool
    ) -> MixedData:
        """Return the data of a fit with this knot; the scatter may grow with intensity or not."""
        is_used, bend = outcomes.used, 0.0 if np.isfinite(knot) else 1.0
        with np.errstate(divide="ignore"):
            lower, upper = np.log([outcomes.lower[is_used], outcomes.upper[is_used]])
        return MixedData(
            design=self.design(centre, knot)[is_used],
            lower=lower,
            upper=upper,
            motion=np.unique(self.shaking[is_used], return_inverse=True)[1],
            precision=np.concatenate([[0.0, 0.0, bend], self.precision]),
            growth=(self.ln_im[is_used] - centre) * grows,
        )


def _fit_demand(arguments: tuple[_Setup, DemandOutcomes]) -> DemandFit | str:
    setup, outcomes = arguments
    axes, motion, block = setup.axes, setup.motion, setup.block
    is_used, is_exact = outcomes.used, outcomes.used & ~outcomes.is_bound
    if np.unique(motion[is_exact]).size < LEAST_MOTIONS:
        return TOO_FEW_RUNS
    if np.ptp(setup.ln_im[is_exact]) == 0.0:
        return fitting.SINGLE_LEVEL
    if np.ptp(outcomes.lower[is_exact]) == 0.0:
        return fitting.NON_INCREASING
    centre = float(np.mean(setup.ln_im[is_used]))
    x = setup.ln_im - centre
    codes = np.unique(setup.shaking[is_used], return_index=True)[1]
    blocks = block[is_used][codes]
    block_numbers, group = np.unique(blocks, return_inverse=True)
    design_rows, y = setup.design(centre, np.inf)[is_exact], np.log(outcomes.lower[is_exact])
    design_rows = design_rows[:, : 3 + axes.drifts]  # without interactions, which have priors
    # ASSUME ln demands that differ from parallel lines by less than 1e-9 have no scatter
    if np.ptp(y - design_rows @ np.linalg.lstsq(design_rows, y, rcond=None)[0]) < 1e-9:
        return fitting.ZERO_DISPERSION
    setup = replace(setup, precision=_precision(setup, outcomes, centre, group))
    chosen: tuple[float, float, MixedFit, Floats] | None = None
    # ASSUME fewer than five blocks cannot choose: a straight line with constant scatter
    can_choose = block_numbers.size >= _LEAST_BESIDE
    knots = _knots(x, is_exact, motion) if can_choose else [np.inf]
    for grows in (False, True) if can_choose else (False,):
        for knot in knots if not grows or chosen is None else (chosen[1],):
            start = chosen[2].parameters if chosen is not None and grows else None
            data = setup.data(outcomes, centre, knot, grows=grows)
            fit = fit_mixed(data, start)
            left_out = fit.without_groups(group)
            predicted = predictive_loglik(data, group, left_out) if can_choose else 0.0
            is_rising = np.all(np.cumsum(fit.parameters[1:3]) > FLATTEST)
            if chosen is None or (is_rising and predicted > chosen[0] + _LEAST_GAIN):
                chosen = predicted, knot, fit, left_out
    assert chosen is not None
    _, knot, fit, left_out = chosen
    if fit.parameters[1] <= FLATTEST:
        return fitting.NON_INCREASING
    blocks = 1 + int(np.max(block))
    parameters = np.tile(fit.parameters, (1 + blocks + axes.drifts, 1))
    if block_numbers.size > 1:  # else there is no model without the block
        parameters[1 + block_numbers] = left_out
    parameters[1 + blocks :] += _shrinkage_errors(fit, axes.drifts)
    model = DemandModel(
        axes=axes,
        parameters=parameters,
        centre=centre,
        knot=knot,
        span=(float(np.min(x[is_used])), float(np.max(x[is_used]))),
        motions=setup.used_motions(outcomes),
    )
    residuals = np.full((len(parameters), is_used.size), nan)
    mean = parameters[:, :-3] @ setup.design(centre, knot)[is_exact].T
    growth = np.exp(-parameters[:, -3:-2] * x[is_exact])
    residuals[:, is_exact] = (np.log(outcomes.lower[is_exact]) - mean) * growth
    return DemandFit(model=model, outcomes=outcomes, residuals=residuals, setup=setup)


def _precision(setup: _Setup, outcomes: DemandOutcomes, centre: float, group: Index) -> Floats:
    """Return the precisions of the priors of ``shift`` and ``drift`` for use with the likelihood.

    An effect of an axis scatters from motion to motion, equally in all cells of other axes, but
    the likelihood takes the scatter of runs as independent. Its standard errors are too small for
    effects that scatter more between motions than runs do, and too large for effects that scatter
    less. The precision of a prior is therefore multiplied by jackknife variance / likelihood
    variance of its coefficient. Both variances are from a fit with wide priors.
    """
    wide_setup = replace(setup, precision=(_LOOSE * setup.axes.deviations) ** -2.0)
    fit = fit_mixed(wide_setup.data(outcomes, centre, np.inf, grows=False))
    is_held, data_information = ~np.isfinite(fit.precision), np.sum(fit.information, axis=0)
    inverse = np.linalg.inv(data_information + np.diag(np.where(is_held, 1.0, fit.precision)))
    by_likelihood = np.diag(inverse @ data_information @ inverse)[3:-3]
    by_jackknife = np.diag(jackknife_covariance(fit.without_groups(group)))[3:-3]
    ratio = np.ones_like(by_likelihood)
    np.divide(by_jackknife, by_likelihood, out=ratio, where=by_likelihood > 0.0)
    return setup.axes.deviations**-2.0 * np.maximum(ratio, _LIGHTEST)


def _shrinkage_errors(fit: MixedFit, drifts: int) -> Floats:
    """Return the errors of all m parameters due to the priors of the drifts, shape (drifts, m).

    A prior pulls its drift towards zero in every model of the jackknife, which therefore misses
    this error. Row i is the error if the true drift i is one prior standard deviation.
    """
    is_held, n_columns = ~np.isfinite(fit.precision), fit.parameters.size - 3
    prior = np.where(is_held, 0.0, fit.precision)
    information = np.sum(fit.information, axis=0)
    information[is_held], information[:, is_held] = 0.0, 0.0
    prior_errors = np.diag(prior)[:, n_columns - drifts : n_columns] * _DRIFT
    return np.linalg.solve(information + np.diag(prior + is_held), prior_errors).T


def _knots(x: Floats, exact: Mask, motion: Index) -> list[float]:
    """Return the values of ``x`` at which a bend is tried; infinity means a straight line."""

    def has_both_sides(knot: float) -> bool:
        sides = exact & (x < knot), exact & (x > knot)
        return min(np.unique(motion[side]).size for side in sides) >= _LEAST_BESIDE

    return [np.inf, *filter(has_both_sides, np.quantile(x[exact], _KNOTS).tolist())]


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeModels:
    """Demand models of one bridge and abutment model, from which all its curves follow."""

    labels: dict[str, Any]  # bridge and abutment
    im: str  # column of the intensity
    runs: pd.DataFrame  # n runs
    axes: AxisRange
    variants: pd.DataFrame  # one row per variant, with its axes
    variant: Index  # number of the variant of each run, shape (n,)
    block: Index  # number of the block of each run, 0 .. B - 1
    fits: Mapping[tuple[str, str], DemandFit | str]  # keys: component and demand
    _curves: dict[tuple[Any, ...], StateCurve | str] = field(default_factory=dict)
    _of_peaks: dict[tuple[str, str, bool], DemandModel | str] = field(default_factory=dict)
    _correlations: dict[tuple[LimitState, LimitState], Floats] = field(default_factory=dict)

    @property
    def replicates(self) -> int:
        """Number R of models of each demand."""
        return 2 + int(np.max(self.block)) + self.axes.drifts

    def modes(self, state: LimitState) -> list[LimitState]:
        """Return the failure modes of a state that some run exceeds; the state itself if none."""
        outcomes = ((mode, demand_outcomes(self.runs, [mode])) for mode in state.modes)
        reached = [m for m, known in outcomes if known.status(m) != fitting.NO_EXCEEDANCE]
        return reached or [state]

    def fit(self, state: LimitState) -> DemandFit | str:
        """Return the model of the demand of a state, or the reason why there is none."""
        return self.fits.get((state.component, state.demand), fitting.NO_EXCEEDANCE)

    def of_peaks(self, state: LimitState, *, exact: bool) -> DemandModel | str:
        """Return the model (R = 1) of the demand of a fitted state, or why there is none.

        The peaks of `collapsed_runs` are demands if ``exact``, else lower bounds.
        """
        key, fit = (state.component, state.demand, exact), self.fit(state)
        if key not in self._of_peaks and not isinstance(fit, str):
            peaks, collapsed = self.runs[state.demand], collapsed_runs(self.runs)
            outcomes = fit.outcomes.of_peaks(peaks, collapsed, exact=exact)
            refit = _fit_demand((fit.setup, outcomes))
            if not isinstance(refit, str):
                refit = replace(refit.model, parameters=refit.model.parameters[:1])
            self._of_peaks[key] = refit
        return self._of_peaks[key]

    def correlation(self, mode_1: LimitState, mode_2: LimitState) -> Floats:
        """Return the correlation of the demands of two failure modes, shape (R,)."""
        fit_1, fit_2, count = self.fit(mode_1), self.fit(mode_2), self.replicates
        if isinstance(fit_1, str) or isinstance(fit_2, str):
            return np.zeros(count)
        if (mode_1, mode_2) not in self._correlations:
            weights = (self.block != np.arange(-1, count - 1)[:, None]).astype(np.float64)
            rho = correlation(fit_1.residuals, fit_2.residuals, weights)
            self._correlations[mode_1, mode_2] = rho
        return self._correlations[mode_1, mode_2]

    def curve(self, state: LimitState, values: Mapping[str, Any]) -> StateCurve | str:
        """Return the curves of a state at a point, or the reason why there are none."""
        key = state, *(float(values[name]) for name in self.axes.varying)
        if key not in self._curves:
            modes = self.modes(state)
            models = [fit if isinstance(fit, str) else fit.model for fit in map(self.fit, modes)]
            rho = self.correlation(*modes) if len(modes) > 1 else None
            self._curves[key] = state_curve(models, modes, values, rho)
        return self._curves[key]


def state_curve(
    models: Sequence[DemandModel | str],
    modes: Sequence[LimitState],
    values: Mapping[str, Any],
    rho: Floats | None = None,
) -> StateCurve | str:
    """Return the curves of the union of one or two modes at a point, or the reason for none.

    ``rho`` (R,) is the correlation of the demands of two modes.
    """
    mode_curves: list[StateCurve] = []
    for model, mode in zip(models, modes, strict=True):
        if isinstance(model, str):
            return model
        point = model.at(values)
        curves = point.curves(mode.threshold, mode.dispersion)
        mode_curves.append(StateCurve(*curves, points=((point, mode),), priors=model.axes.drifts))
        if np.isnan(mode_curves[-1].ln_theta[0]) or mode_curves[-1].beta[0] > _LARGEST_BETA:
            return fitting.NON_INCREASING
    if rho is None:
        return mode_curves[0]
    medians, records, total = np.swapaxes([curve[:3] for curve in mode_curves], 0, 1)
    union = Union.of(medians, records, total, rho)
    middle, half_range = union.summary()
    record_union = Union(medians, records, rho)
    points = tuple(point for mode_curve in mode_curves for point in mode_curve.points)
    beta, priors = record_union.summary()[1], mode_curves[0].priors
    return StateCurve(middle, beta, half_range, union, record_union, points, priors)


def fit_models(
    demands: pd.DataFrame,
    limit_states: States,
    settings: FitSettings,
    *,
    further: Sequence[str] = (),  # columns that distinguish variants in addition to the axes
    jobs: int = 1,
) -> list[BridgeModels]:
    """Return the demand models of every bridge and abutment model of a checked demands table."""
    modes = dict.fromkeys(mode for state in limit_states for mode in state.modes or (state,))
    groups = states_by_demand(list(modes))
    models = [
        _without_fits(labels, runs.reset_index(drop=True), settings.im, further)
        for labels, runs in demand_table.models_of(demands)
    ]
    pairs = product(models, groups.values())
    items = ((setup, demand_outcomes(bridge.runs, states)) for (bridge, setup), states in pairs)
    fits = iter(demand_table.spread(_fit_demand, items, jobs))
    return [replace(bridge, fits={key: next(fits) for key in groups}) for bridge, _ in models]


def _without_fits(
    labels: dict[str, Any], runs: pd.DataFrame, im: str, further: Sequence[str]
) -> tuple[BridgeModels, _Setup]:
    """Return models without fits, and the data for fits, of one bridge and abutment model.

    If the runs have a column ``event``, the motions of an event are left out together.
    """
    lacking = lacking_axes(str(runs["abutment"].iloc[0]))
    names = [name for name in demand_table.axis_names(runs) if name not in lacking]
    further = [name for name in further if name not in names]
    code = runs.groupby(["variant", *further], sort=True).ngroup().to_numpy(dtype=np.intp)
    _, first_runs, variant = np.unique(code, return_index=True, return_inverse=True)
    columns = list(dict.fromkeys([*demand_table.variant_columns(runs), *further]))
    variants = runs.iloc[first_runs].reset_index(drop=True)[columns]
    axes = AxisRange.of_variants(variants, [*names, *further])
    terms = axes.matrix({str(name): variants[name] for name in variants})
    shared: Any = {"axes": axes, "variant": variant, "block": demand_table.block_codes(runs)}
    setup = _Setup(
        ln_im=np.log(runs[im].to_numpy(dtype=np.float64)),
        motion=demand_table.motion_codes(runs),
        shaking=demand_table.shaking_codes(runs),
        matrix=np.broadcast_to(terms, (len(variants), len(axes.terms))),
        precision=axes.deviations**-2.0,
        **shared,
    )
    models = BridgeModels(labels=labels, im=im, runs=runs, variants=variants, fits={}, **shared)
    return models, setup
