"""Joint models: medians over the axes of a study, and prediction between its variants.

One model per bridge, abutment model and demand: ln D = terms of the axes + b ln IM + a random
effect of the motion + scatter of the run. The slope b is common to all variants, so the median of a
state with capacity c is exp((ln c - terms)/b), its dispersion is the same everywhere, and the
curves of a component do not cross.

References:
    Allen (1974), Technometrics 16(1):125-127, for the sum of squares of left-out predictions.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import nan
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import Floats, Index, Row
from skewbridge.fragility import demand_table
from skewbridge.fragility.curves import described_as_curves
from skewbridge.fragility.fits import FITTED, NON_INCREASING, NOT_APPLICABLE
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.mixed import MixedData, MixedFit, fit_mixed, outer_by, without_each_motion
from skewbridge.fragility.motion_means import jackknife_covariance
from skewbridge.fragility.outcomes import DemandOutcomes, demand_outcomes, states_by_demand
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.variant.axes import AXES, axis
from skewbridge.variant.variant import lacking_axes

TOO_FEW_MOTIONS: Final = "too_few_motions"
NO_AXIS: Final = "no_axis_varies"
LARGE_ERROR: Final = "prediction_error_above_25_percent"
UNCONFIRMED: Final = "no_variant_estimate"
MAX_LEFT_OUT_ERROR: Final = 0.25
MIN_MOTIONS: Final = 5
SKEW: Final = "skew_deg"
GAP: Final = "gap_mm"
REFERENCE_GAP_MM: Final = 50.8  # 2 in
_SLACK: Final = 1e-9
_CLOUD_COLUMNS: Final = ["variant", "component", "limit_state", "theta", "var_ln_theta"]
_FLATTEST_SLOPE: Final = 1e-3
_THINNEST: Final = 1e-10
_CLEARLY_BETTER: Final = 1e-6
_WORTH_PROCESSES: Final = 8  # ASSUME a demand takes about a second

JOINT_COLUMNS: Final[dict[str, str]] = {
    **described_as_curves("bridge abutment component limit_state status"),
    "theta": "median intensity in the middle of every axis",
    **described_as_curves("theta_low theta_high beta beta_low beta_high"),
    **described_as_curves("beta_total beta_total_low beta_total_high level"),
    "loo_error": "median relative error of theta for left-out variants",
    "loo_error_max": "largest of these errors",
    "loo_error_max_variant": "variant with the largest error",
    "loo_error_max_se": "standard error of ln theta in its cloud fit",
    "loo_variants": "number of variants compared",
    "terms": "terms of ln theta after the constant, joined by semicolons",
    "coefficients": "coefficients of ln theta, constant first",
    "covariance": "covariance of coefficients, ln beta and ln beta_total, row by row",
    "axis_ranges": "smallest and largest value of each axis in the study, as JSON",
    "signed_skew": "true if the sign of the skew matters",
    "slope": "slope of ln demand on ln intensity",
    "tau": "standard deviation of ln demand between motions",
    "sigma": "standard deviation of ln demand within motions",
    "press": "RMS error of ln demand of left-out variants",
    "n_variants": "number of variants",
    "n_runs": "runs in the fit",
    "n_motions": "motions in the fit",
    **described_as_curves("n_exceed n_unknown"),
    "n_right_censored": "runs with only a lower bound of the demand",
    "n_left_censored": "runs with only an upper bound of the demand",
    **described_as_curves("im demand threshold capacity_dispersion"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisRange:
    """Range of the axes of the variants of one bridge and abutment model.

    In a model, skew counts as skew/60 degrees (its size, unless the study has both signs), the gap
    as gap/50.8 mm, friction as it is, any other axis as a share of its largest possible value.
    """

    limits: Mapping[str, tuple[float, float]]  # smallest and largest value as it counts, by axis
    signed_skew: bool = False  # whether the study has skews of both signs

    @classmethod
    def of_variants(cls, variants: pd.DataFrame, names: Iterable[str]) -> "AxisRange":
        """Return the range of some axes over a table with a row per variant."""
        skew = variants[SKEW].to_numpy(dtype=np.float64) if SKEW in variants else np.zeros(1)
        blank = cls(limits={}, signed_skew=bool(np.any(skew > 0.0) and np.any(skew < 0.0)))
        values = {name: blank._counted(name, variants[name].to_numpy(np.float64)) for name in names}
        limits = {name: (float(np.min(v)), float(np.max(v))) for name, v in values.items()}
        finite = {name: ends for name, ends in limits.items() if np.all(np.isfinite(ends))}
        return replace(blank, limits=finite)

    @property
    def varying(self) -> tuple[str, ...]:
        """Axes that differ between the variants."""
        return tuple(name for name, (low, high) in self.limits.items() if low < high)

    @property
    def middle(self) -> dict[str, float]:
        """Middle of the range of each varying axis."""
        return {name: 0.5 * sum(self.limits[name]) for name in self.varying}

    def variables(self, values: Mapping[str, Any]) -> dict[str, Floats]:
        """Return the variables of the model at values of the axes, by axis, shape (n,) each."""
        found: dict[str, Floats] = {}
        for name in self.varying:
            value = np.atleast_1d(self._counted(name, np.asarray(values[name], dtype=np.float64)))
            scale = REFERENCE_GAP_MM if name == GAP else axis(name).high
            is_scaled = axis(name).unit != "-" and 0.0 < scale < np.inf
            found[name] = value / scale if is_scaled else value
        return found

    def check(self, values: Mapping[str, float]) -> None:
        """Check that a point lies inside the range; an `InputError` names the axis that does not.

        Axes that the abutment model lacks are ignored.
        """
        possible = {*self.limits, *(each.name for each in AXES)}
        for name in (*self.varying, *values):
            low, high = self.limits.get(name, (-np.inf, np.inf))
            problem = "" if name in possible else "is not an axis of the study"
            if name not in values:
                problem = f"is missing; the study varies it within {low:g}..{high:g}"
            elif not low - _SLACK <= self._counted(name, values[name]) <= high + _SLACK:
                problem = f"must be within {low:g}..{high:g}, the range of the study"
                problem += f", got {values[name]:g}"
            if problem:
                raise InputError(f"{name} {problem}", column=name)

    def _counted(self, name: str, value: Any) -> Any:
        return abs(value) if name == SKEW and not self.signed_skew else value


def term_matrix(terms: Sequence[str], variables: Mapping[str, Floats]) -> Floats:
    """Return a column of ones and one per term (axes joined by colons), shape (n, 1 + q)."""
    size = next((value.size for value in variables.values()), 1)
    products = [np.prod([variables[name] for name in term.split(":")], axis=0) for term in terms]
    return np.column_stack([np.ones(size), *products])


def term_sets(variables: Mapping[str, Floats]) -> list[tuple[str, ...]]:
    """Return the sets of terms to compare: main effects, with squares, with products, with both.

    A set has only terms that the variants, with ``variables`` of shape (V,), can distinguish, and,
    except for main effects, fewer than would fit every variant.
    """
    squares = [f"{name}:{name}" for name, value in variables.items() if np.unique(value).size > 2]
    products = [f"{a}:{b}" for a, b in combinations(variables, 2)]
    sets: list[tuple[str, ...]] = []
    for further in ([], squares, products, [*squares, *products]):
        kept: tuple[str, ...] = ()
        for term in [*variables, *further]:
            matrix = term_matrix((*kept, term), variables)
            if matrix.shape[0] - matrix.shape[1] >= (0 if term in variables else 1):
                kept = (*kept, term) if np.linalg.matrix_rank(matrix) == len(kept) + 2 else kept
        sets.append(kept)
    return list(dict.fromkeys(sets))


@dataclass(frozen=True, slots=True, kw_only=True)
class JointModel:
    """A joint model of one limit state: ln theta is linear in terms of the axes."""

    axis_range: AxisRange
    terms: tuple[str, ...]  # after the constant
    coefficients: Floats  # of ln theta, shape (1 + q,)
    beta: float  # record-to-record
    beta_total: float  # including the capacity
    covariance: Floats  # of coefficients, ln beta and ln beta_total, shape (3 + q, 3 + q)
    freedom: int  # degrees of freedom of the intervals
    level: float  # confidence level of the intervals

    @classmethod
    def of_row(cls, row: Mapping[str, Any]) -> "JointModel":
        """Return the model of a row of results/fragility/joint.parquet."""
        coefficients = np.asarray(row["coefficients"], dtype=np.float64)
        size = coefficients.size + 2
        limits = {name: (low, high) for name, (low, high) in json.loads(row["axis_ranges"]).items()}
        return cls(
            axis_range=AxisRange(limits=limits, signed_skew=bool(row["signed_skew"])),
            terms=tuple(filter(None, str(row["terms"]).split(";"))),
            coefficients=coefficients,
            beta=float(row["beta"]),
            beta_total=float(row["beta_total"]),
            covariance=np.asarray(row["covariance"], dtype=np.float64).reshape(size, size),
            freedom=int(row["n_motions"]) - 2,
            level=float(row["level"]),
        )

    def interval(self, estimate: float, variance: float, level: float) -> tuple[float, float]:
        """Return the ends of the interval of exp(estimate)."""
        half = special.stdtrit(self.freedom, 0.5 + 0.5 * level) * np.sqrt(variance)
        return float(np.exp(estimate - half)), float(np.exp(estimate + half))

    def vector(self, values: Mapping[str, float]) -> Floats:
        """Return the constant and the terms at values of the axes, shape (1 + q,)."""
        return term_matrix(self.terms, self.axis_range.variables(values))[0]

    def median(self, values: Mapping[str, float]) -> tuple[float, float, float]:
        """Return theta and the ends of its interval at values of the axes."""
        return self._exponential(self.vector(values), self.level)

    def ratio(
        self, below: Mapping[str, float], above: Mapping[str, float], level: float
    ) -> tuple[float, float, float]:
        """Return the ratio of medians of two points, above to below, and its interval."""
        return self._exponential(self.vector(above) - self.vector(below), level)

    def _exponential(self, vector: Floats, level: float) -> tuple[float, float, float]:
        estimate = float(vector @ self.coefficients)
        variance = float(vector @ self.covariance[:-2, :-2] @ vector)
        return (float(np.exp(estimate)), *self.interval(estimate, variance, level))


def joint_table(
    demands: pd.DataFrame,
    limit_states: States,
    curves: pd.DataFrame | None,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return `JOINT_COLUMNS` of one model over the axes per bridge, abutment model and state."""
    own = pd.DataFrame(columns=_CLOUD_COLUMNS)
    if curves is not None:
        own = curves.query("method == 'cloud' and status == @FITTED")[_CLOUD_COLUMNS]
    items = (
        (
            model | {"im": settings.im, "level": settings.confidence},
            demand_table.demand_columns(part, [settings.im, demand]),
            states,
            own[own["component"] == component],
        )
        for model, part in demand_table.models_of(demands)
        for (component, demand), states in states_by_demand(limit_states).items()
    )
    rows = demand_table.spread(_rows, items, jobs, least=_WORTH_PROCESSES)
    table = pd.DataFrame([row for part in rows for row in part], columns=list(JOINT_COLUMNS))
    if curves is not None:  # do not use a model that no fit of a single variant confirms
        table.loc[(table["status"] == FITTED) & table["loo_variants"].eq(0), "status"] = UNCONFIRMED
    return table


def _rows(item: tuple[dict[str, Any], pd.DataFrame, list[LimitState], pd.DataFrame]) -> list[Row]:
    """Return the rows of the states of one demand: of model columns, runs, states and clouds."""
    model, runs, states, clouds = item
    lacking = lacking_axes(str(model["abutment"]))
    names = [name for name in demand_table.axis_names(runs) if name not in lacking]
    labels = runs["variant"].to_numpy(dtype=str)
    _, first, codes = np.unique(labels, return_index=True, return_inverse=True)
    variants = runs.iloc[first][["variant", *names]].reset_index(drop=True)
    axis_range = AxisRange.of_variants(variants, names)
    outcomes = demand_outcomes(runs, states, str(model["im"]))
    ln_im = np.log(runs[str(model["im"])].to_numpy(dtype=np.float64))
    fit = _fit_demand(outcomes, ln_im, demand_table.motion_codes(runs), codes, axis_range, variants)
    left_out = None if isinstance(fit, str) else without_each_motion(fit.data, fit.fit)
    rows: list[Row] = []
    for state in states:
        status = outcomes.status(state)
        row = {
            **model,
            **state.columns,
            "status": fit if status == FITTED and isinstance(fit, str) else status,
            "axis_ranges": json.dumps(dict(axis_range.limits)),
            "signed_skew": axis_range.signed_skew,
            "n_variants": len(variants),
            **outcomes.counts(state),
        }
        if status == FITTED and left_out is not None and not isinstance(fit, str):
            own = clouds[clouds["limit_state"] == state.name].set_index("variant")
            row |= _estimate(fit, left_out, state, row, own.reindex(variants["variant"]))
        rows.append(row)
    return rows


class _DemandFit(NamedTuple):
    """Model of ln demand with columns 1, ln IM and terms."""

    data: MixedData
    fit: MixedFit
    terms: tuple[str, ...]
    matrix: Floats  # constant and terms of the variants, (V, 1 + q)
    left_out_variant: Floats  # coefficients without each variant, (V, p)
    press: float


def _fit_demand(
    outcomes: DemandOutcomes,
    ln_im: Floats,
    motion: Index,
    variant: Index,
    axis_range: AxisRange,
    variants: pd.DataFrame,
) -> _DemandFit | str:
    """Return the model that predicts left-out variants best, or why there is none."""
    if not axis_range.varying:
        return NO_AXIS
    used, (lower, upper) = outcomes.used, outcomes.ln_ends
    known, variant = lower == upper, variant[used]
    motion = np.unique(motion[used], return_inverse=True)[1]
    if np.unique(motion[known]).size < MIN_MOTIONS:
        return TOO_FEW_MOTIONS
    values = {name: variants[name].to_numpy(dtype=np.float64) for name in axis_range.varying}
    variables = axis_range.variables(values)
    best: _DemandFit | None = None
    for terms in term_sets(variables):
        matrix = term_matrix(terms, variables)
        design = np.insert(matrix[variant], 1, ln_im[used], axis=1)
        if np.linalg.matrix_rank(design[known]) < design.shape[1]:
            continue
        data = MixedData(design=design, lower=lower, upper=upper, motion=motion)
        fit = fit_mixed(data)
        without, press = _without_each_variant(data, fit, variant, len(variants))
        if best is None or press < best.press * (1.0 - _CLEARLY_BETTER):
            best = _DemandFit(data, fit, terms, matrix, without, press)
    return NOT_APPLICABLE if best is None else best


def _without_each_variant(
    data: MixedData, fit: MixedFit, variant: Index, count: int
) -> tuple[Floats, float]:
    """Return coefficients without each variant (V, p), and the root mean square error."""
    # by generalised least squares; NaN and infinity where the others do not determine them
    # ASSUME tau, sigma and the expected values of censored demands of the other variants do not
    # change if a variant is left out
    values = np.column_stack([data.design, fit.expected])
    motions, size = int(np.max(data.motion)) + 1, values.shape[1]
    cell = np.zeros((count, motions, size))
    np.add.at(cell, (variant, data.motion), values)
    runs = np.zeros((count, motions))
    np.add.at(runs, (variant, data.motion), 1.0)
    others, left = np.sum(cell, axis=0) - cell, np.sum(runs, axis=0) - runs
    shrinkage = fit.tau**2 / (fit.sigma**2 + left * fit.tau**2)
    products = values.T @ values - outer_by(variant, values, count)
    shrunk = others * np.sqrt(shrinkage)[:, :, None]
    products -= np.swapaxes(shrunk, 1, 2) @ shrunk
    matrix, right = products[:, :-1, :-1], products[:, :-1, -1]
    scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), 1e-300))
    matrix = matrix / scale[:, :, None] / scale[:, None, :]
    sure = np.linalg.eigvalsh(matrix)[:, 0] > _THINNEST
    out = np.full(scale.shape, np.nan)
    out[sure] = np.linalg.solve(matrix[sure], (right / scale)[sure][:, :, None])[:, :, 0]
    out /= scale
    effect = shrinkage * (others[:, :, -1] - np.einsum("vgp,vp->vg", others[:, :, :-1], out))
    error = fit.expected - np.sum(data.design * out[variant], axis=1)
    error -= effect[variant, data.motion]
    return out, float(np.sqrt(np.mean(error**2))) if np.all(sure) else np.inf


def _estimate(
    fit: _DemandFit, left_out: Floats, state: LimitState, row: Mapping[str, Any], own: pd.DataFrame
) -> Row:
    """Return the columns of a state from the parameters without each motion, shape (G, m)."""
    # `own` are the cloud fits of the V variants
    motions = len(left_out)
    estimate = _state_parameters(fit.fit.parameters[None, :], motions, state)[0]
    without = _state_parameters(left_out, motions - 1, state)
    found: dict[str, Any] = {"slope": float(fit.fit.delta[1]), "press": fit.press}
    found |= {"tau": fit.fit.tau, "sigma": fit.fit.sigma, "terms": ";".join(fit.terms)}
    found |= {
        "n_runs": fit.data.motion.size,
        "n_motions": motions,
        "n_right_censored": int(np.sum(np.isinf(fit.data.upper))),
        "n_left_censored": int(np.sum(np.isinf(fit.data.lower))),
    }
    if not (np.all(np.isfinite(estimate)) and np.all(np.isfinite(without))):
        return found | {"status": NON_INCREASING}
    found |= {"beta": float(np.exp(estimate[-2])), "beta_total": float(np.exp(estimate[-1]))}
    found["coefficients"] = estimate[:-2].tolist()
    found["covariance"] = jackknife_covariance(without).ravel().tolist()
    model = JointModel.of_row({**row, **found})
    found["theta"], found["theta_low"], found["theta_high"] = model.median(model.axis_range.middle)
    for name, place in (("beta", -2), ("beta_total", -1)):
        ends = model.interval(estimate[place], model.covariance[place, place], model.level)
        found[f"{name}_low"], found[f"{name}_high"] = ends
    delta = fit.left_out_variant
    slope = np.where(delta[:, 1] > _FLATTEST_SLOPE, delta[:, 1], nan)
    level = delta[:, 0] + np.sum(delta[:, 2:] * fit.matrix[:, 1:], axis=1)
    predicted = np.exp((np.log(state.threshold) - level) / slope)
    error = np.abs(predicted / own["theta"].to_numpy(dtype=np.float64) - 1.0)
    if not (compared := int(np.sum(np.isfinite(error)))):
        return found | {"loo_variants": 0}
    worst = int(np.nanargmax(error))
    found |= {
        "loo_variants": compared,
        "loo_error": float(np.nanmedian(error)),
        "loo_error_max": float(error[worst]),
        "loo_error_max_variant": str(own.index[worst]),
        "loo_error_max_se": float(np.sqrt(own["var_ln_theta"].iloc[worst])),
    }
    return found | ({"status": LARGE_ERROR} if error[worst] > MAX_LEFT_OUT_ERROR else {})


def _state_parameters(parameters: Floats, motions: int, state: LimitState) -> Floats:
    """Return coefficients of ln theta, ln beta and ln beta_total, shape (K, 3 + q)."""
    # NaN where the slope is not positive; `parameters` have the shape (K, m)
    slope = parameters[:, 1:2]
    slope = np.where(slope > _FLATTEST_SLOPE, slope, nan)
    level = np.column_stack([np.log(state.threshold) - parameters[:, 0], -parameters[:, 2:-2]])
    # maximum likelihood does not count the line through the motions: level and slope
    variance = np.sum(np.exp(2.0 * parameters[:, -2:]), axis=1) * motions / (motions - 2.0)
    total = variance + state.dispersion**2
    spread_terms = 0.5 * np.log(np.column_stack([variance, total])) - np.log(slope)
    return np.column_stack([level / slope, spread_terms])
