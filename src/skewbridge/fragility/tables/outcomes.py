"""What each run says about a limit state (exceeded, not, or unknown) and what unknowns do to fits.

A failed run, and one that went beyond the model, is never dropped in silence. Its peak so far
decides where it exceeds already; else its outcome is unknown and its demand is known only to exceed
that peak.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import Replicates
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.parts import RunCounts
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.beyond_model import is_beyond_model, is_of_column
from skewbridge.fragility.tables.key_columns import KEY_COLUMNS, motion_codes, need_columns
from skewbridge.fragility.tables.limit_states import COLLAPSE_EXCEEDS, LimitState
from skewbridge.statuses import COLLAPSE, OK, STATUSES

#: What can be done with runs whose outcome is unknown.
TREATMENTS: Final[tuple[str, ...]] = ("exclude", "all_exceed", "none_exceed")
MAX_UNKNOWN_SHARE: Final = 0.05
# ASSUME a median is worth printing if unknown outcomes can move it by 15 % at most.
MAX_BOUNDS_RATIO: Final = 1.15  # of the medians when unknown outcomes all, or none, exceed
BOUNDS_TOO_WIDE: Final = "bounds_too_wide"


@dataclass(frozen=True, slots=True, kw_only=True)
class Runs:
    """The runs of one variant, arrays of shape (n,).

    Attributes:
        im: Intensity of each run.
        status: Its status.
        beyond: Whether a column failed beyond the model.
        records: Number of its motion, 0 .. m - 1.
    """

    im: FloatArray
    status: NDArray[np.str_]
    beyond: NDArray[np.bool_]
    records: NDArray[np.intp]

    @property
    def repeated(self) -> bool:
        """Whether some motion ran more than once."""
        return int(np.max(self.records)) + 1 < self.records.size

    @property
    def several_levels(self) -> bool:
        """Whether some motion ran at more than one intensity."""
        order = np.lexsort((self.im, self.records))
        same = np.diff(self.records[order]) == 0
        return bool(np.any(same & (np.diff(self.im[order]) > 0.0)))


@dataclass(frozen=True, slots=True)
class CensoredDemands:
    """Demands of the runs of one variant as a log-log line sees them, arrays of shape (n,).

    Attributes:
        lower: Demand, or the value that it exceeds.
        upper: Equal to it where the demand is known; infinity, or a bound that was assumed.
        used: Runs that take part: those that left a positive demand.
    """

    lower: FloatArray
    upper: FloatArray
    used: NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcomes:
    """Outcomes of the runs of one variant for one limit state, arrays of shape (n,).

    Attributes:
        exceed: True where the limit state is known to be exceeded.
        defined: True where it exceeds by definition, whatever its demand: a collapse, a failed
            column.
        unknown: True where the outcome is unknown.
        demand: Demand, or its peak so far; NaN where a run left none.
        complete: True where the demand is final (the run ended, without collapse, inside the
            model).
    """

    exceed: NDArray[np.bool_]
    defined: NDArray[np.bool_]
    unknown: NDArray[np.bool_]
    demand: FloatArray
    complete: NDArray[np.bool_]

    @property
    def one_sided(self) -> str | None:
        """Status of known outcomes that hold no median: none exceeds, or all do."""
        known = self.exceed[~self.unknown]
        if not np.any(known):
            return existence.NO_EXCEEDANCE
        return existence.ALL_EXCEED if np.all(known) else None

    def assuming(self, exceed: NDArray[np.bool_]) -> "Outcomes":
        """Return the outcomes if those unknown were known."""
        return replace(self, exceed=exceed, unknown=np.zeros_like(self.unknown))

    def censored(self, threshold: float) -> "CensoredDemands":
        """Return the demands as a line sees them; a run that is not complete has no upper end.

        A run that exceeds by definition is known to lie above the threshold, any other above its
        peak so far.
        """
        peak = np.nan_to_num(self.demand, nan=0.0)
        lower = np.where(self.defined, np.maximum(peak, threshold), peak)
        return CensoredDemands(lower, np.where(self.complete, lower, inf), lower > 0.0)

    def judge(
        self,
        fit: FragilityFit,
        settings: FitSettings,
        assume: Callable[[NDArray[np.bool_]], FragilityFit],
    ) -> FragilityFit:
        """Attach the fits of the treatments; refuse a median that unknown outcomes decide.

        ``assume`` gives the fit if all runs were known, of their outcomes.
        """
        bounds: dict[str, FragilityFit] = dict.fromkeys(TREATMENTS, fit)
        if np.any(self.unknown):
            bounds["all_exceed"] = assume(self.exceed | self.unknown)
            bounds["none_exceed"] = assume(self.exceed)
        return self.judge_bounds(fit, settings, bounds)

    def judge_bounds(
        self, fit: FragilityFit, settings: FitSettings, bounds: Mapping[str, FragilityFit]
    ) -> FragilityFit:
        """Attach the fits by treatment; refuse a median that unknown outcomes decide."""
        numbers: dict[str, float] = {}
        for name, bound in bounds.items():
            numbers |= {f"theta_{name}": bound.theta, f"beta_{name}": bound.beta}
        fit = replace(fit, counts=replace(fit.counts or RunCounts(), bounds=numbers))
        share = float(np.mean(self.unknown))
        if share == 0.0:
            return fit
        above = ("unknown_above_5_percent",) if share > MAX_UNKNOWN_SHARE else ()
        fit = replace(fit, warnings=(*fit.warnings, "unknown_outcomes", *above))
        if fit.status != FITTED:
            return fit
        pair = (bounds["all_exceed"].theta, bounds["none_exceed"].theta)
        ratio = max(pair) / min(pair) if all(np.isfinite(pair)) else inf
        wide = ratio > MAX_BOUNDS_RATIO and not settings.accept_bounds
        return fit.without_estimate(BOUNDS_TOO_WIDE) if wide else fit


def runs_of(part: pd.DataFrame, im_column: str) -> Runs:
    """Return the runs of one variant of a demands table."""
    return Runs(
        im=part[im_column].to_numpy(dtype=np.float64),
        status=part["status"].to_numpy(dtype=str),
        beyond=is_beyond_model(part),
        records=motion_codes(part),
    )


def bootstrapped(fit: FragilityFit, again: Replicates) -> FragilityFit:
    """Replace interval and covariance by those of the replicates that have an estimate."""
    theta, beta = again.theta, again.beta
    ci_theta, ci_beta = again.intervals(fit.level)
    good = np.isfinite(theta) & (theta > 0.0) & np.isfinite(beta)
    lacking = float(1.0 - np.mean(good & (beta > 0.0)))
    covariance = np.cov(np.log(theta[good]), beta[good])
    extra = ("bootstrap_without_estimate",) if lacking > MAX_UNKNOWN_SHARE else ()
    return replace(
        fit,
        ci_theta=ci_theta,
        ci_beta=ci_beta,
        ci_method="record_bootstrap",
        var_ln_theta=float(covariance[0, 0]),
        cov_ln_theta_beta=float(covariance[0, 1]),
        var_beta=float(covariance[1, 1]),
        warnings=(*fit.warnings, *extra),
    )


def outcomes_of(
    demand: FloatArray, status: NDArray[np.str_], beyond: NDArray[np.bool_], state: LimitState
) -> Outcomes:
    """Judge runs against a limit state by its median capacity.

    ``demand`` is the peak (so far) of each run, ``status`` its status and ``beyond`` whether a
    column failed beyond the model, shape (n,).
    """
    collapsed = status == COLLAPSE
    complete = (status == OK) & ~beyond
    above = np.nan_to_num(demand, nan=-np.inf) > state.threshold
    # ASSUME a collapsed bridge exceeds every limit state, unless the state says that its peak up
    # to the collapse decides (column shear)
    defined = collapsed & (state.collapse == COLLAPSE_EXCEEDS)
    # ASSUME a failed column has passed all its limit states; the peaks of the rest of the bridge up
    # to the failure say what it went through at least
    defined |= beyond & is_of_column(state.demand)
    exceed = above | defined
    judged = complete | (collapsed & ~beyond)
    return Outcomes(
        exceed=exceed,
        defined=defined,
        unknown=~judged & ~exceed,
        demand=demand,
        complete=complete,
    )


def check_demands(demands: pd.DataFrame, im_column: str, columns: Sequence[str]) -> None:
    """Check the columns of a demands table that a fit uses.

    Raises:
        InputError: A column is missing, a status unknown, an intensity not positive and finite,
            or a completed run has an infinite or negative demand; names row and column.
    """
    need_columns(demands, (*KEY_COLUMNS, im_column, *columns))
    status = demands["status"].to_numpy(dtype=str)
    known = np.isin(status, STATUSES)
    _require(demands, known, "status", f"must be one of {', '.join(STATUSES)}")
    im = demands[im_column].to_numpy(dtype=np.float64)
    _require(demands, np.isfinite(im) & (im > 0.0), im_column, "must be > 0 and finite")
    for column in columns:
        values = demands[column].to_numpy(dtype=np.float64)
        bad = (status == OK) & (np.isinf(values) | (values < 0.0))
        _require(demands, ~bad, column, "must be >= 0 and finite where status is ok")


def _require(demands: pd.DataFrame, good: NDArray[np.bool_], column: str, rule: str) -> None:
    if np.all(good):
        return
    row = int(np.flatnonzero(~good)[0])
    where = f"row {row} ({demands['variant'].iloc[row]}, {demands['motion_id'].iloc[row]})"
    value = demands[column].iloc[row]
    shown = repr(value) if isinstance(value, str) else f"{value:g}"
    raise InputError(f"{column} {rule}, got {shown} in {where}", row=row, column=column)
