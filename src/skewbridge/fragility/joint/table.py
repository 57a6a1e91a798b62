"""The table of joint models: one per bridge, abutment model, limit state and kind of data."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.joint.by_motion import jackknife_covariance
from skewbridge.fragility.joint.columns import JOINT_COLUMNS
from skewbridge.fragility.joint.fits import (
    NO_AXIS,
    JointFit,
    fit_demand,
    fit_outcomes,
)
from skewbridge.fragility.joint.model import JointModel
from skewbridge.fragility.joint.runs import JointRuns, joint_runs
from skewbridge.fragility.likelihood.bootstrap import record_weights
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.key_columns import BRIDGE_COLUMNS
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Outcomes, check_demands

#: Kind of data, and the method of a variant's own fit that it is compared with.
SOURCES: Final = {"demand": "cloud", "exceedance": "exceedance"}
# Standard errors by which the outcomes must predict better than the demands to be preferred.
_CLEARLY: Final = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Fitted:
    """A fit with its estimate, without each motion and by bootstrap: parameters and scatter^2."""

    fit: JointFit
    best: tuple[FloatArray, FloatArray] | None = None
    left_out: tuple[FloatArray, FloatArray] | None = None
    again: tuple[FloatArray, FloatArray] | None = None


class _Draws:
    """Weights of the bootstrap, made once per number of motions."""

    def __init__(self, settings: FitSettings) -> None:
        self._settings = settings
        self._weights: dict[int, FloatArray] = {}

    def fitted(self, fit: JointFit) -> _Fitted:
        """Return a fit with its replicates."""
        if fit.sums is None:
            return _Fitted(fit=fit)
        count = fit.sums.score.shape[0]
        if count not in self._weights:
            draw = (self._settings.bootstrap, self._settings.seed)
            self._weights[count] = record_weights(np.arange(count), *draw)
        return _Fitted(
            fit=fit,
            best=fit.sums.best(),
            left_out=fit.sums.one_left_out(),
            again=fit.sums.reweighted(self._weights[count]),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Judged:
    """A fit of one limit state, with what leaving variants out says of it."""

    row: dict[str, Any]
    loss: FloatArray | None = None  # by known run


def joint_table(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    curves: pd.DataFrame,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Fit one model over the axes per bridge, abutment model and limit state.

    Args:
        demands: The demands table.
        limit_states: The limit states.
        im_column: The intensity measure.
        curves: The fits of the single variants, which leaving variants out is measured against.
        settings: Confidence level, replicates and seed.

    Returns:
        Rows with the columns `JOINT_COLUMNS`, two per limit state.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    check_demands(demands, im_column, list(dict.fromkeys(s.demand for s in limit_states)))
    rows: list[dict[str, Any]] = []
    for key, part in demands.groupby(list(BRIDGE_COLUMNS), sort=True):
        own = curves[(curves["bridge"] == key[0]) & (curves["abutment"] == key[1])]
        runs = joint_runs(part.reset_index(drop=True), im_column)
        named = dict(zip(BRIDGE_COLUMNS, key, strict=True)) | {"im": im_column}
        rows += [named | row for row in _rows(runs, limit_states, own, settings)]
    return pd.DataFrame(rows, columns=list(JOINT_COLUMNS))


def _rows(
    runs: JointRuns, states: Sequence[LimitState], own: pd.DataFrame, settings: FitSettings
) -> Iterator[dict[str, Any]]:
    kept: dict[tuple[str, bytes], _Fitted] = {}
    draws = _Draws(settings)
    fitted = own[own["status"] == FITTED]
    names = ["component", "limit_state", "method"]
    theirs = {key: part.set_index("variant") for key, part in fitted.groupby(names)}
    for state in states:
        outcomes = runs.outcomes(state)
        judged = {
            source: _judged(
                runs,
                outcomes,
                (state, source, each),
                theirs.get((state.component, state.name, SOURCES[source])),
                settings,
            )
            for source, each in _fits(runs, outcomes, state, (kept, draws)).items()
        }
        chosen = _preferred(judged, runs.motion[~outcomes.unknown])
        for source, each in judged.items():
            yield each.row | {"preferred": source == chosen}


def _fits(
    runs: JointRuns,
    outcomes: Outcomes,
    state: LimitState,
    cache: tuple[dict[tuple[str, bytes], _Fitted], _Draws],
) -> dict[str, _Fitted]:
    if not runs.box.limits:
        return dict.fromkeys(SOURCES, _Fitted(fit=JointFit(status=NO_AXIS)))
    kept, draws = cache
    peak = np.nan_to_num(outcomes.demand, nan=0.0)
    lower = np.where(outcomes.defined, np.maximum(peak, state.threshold), peak)
    used = np.where(outcomes.complete, np.isfinite(outcomes.demand), lower > 0.0)
    key = (state.demand, lower.tobytes())  # states of one demand share the fit
    if key not in kept:
        kept[key] = draws.fitted(fit_demand(runs, lower, outcomes.complete, used))
    known = ~outcomes.unknown & (np.isfinite(outcomes.demand) | outcomes.exceed)
    outcome = fit_outcomes(runs, outcomes.exceed, known, kept[key].fit)
    return {"demand": kept[key], "exceedance": draws.fitted(outcome)}


def _judged(
    runs: JointRuns,
    outcomes: Outcomes,
    named: tuple[LimitState, str, _Fitted],
    own: pd.DataFrame | None,
    settings: FitSettings,
) -> _Judged:
    state, source, fitted = named
    fit = fitted.fit
    known = ~outcomes.unknown
    hit = outcomes.exceed[known]
    row: dict[str, Any] = {
        "component": state.component,
        "limit_state": state.name,
        "source": source,
        "status": fit.status,
        "level": settings.confidence,
        "tau": fit.tau,
        "sigma": fit.sigma,
        "criterion": fit.criterion,
        "press": fit.press,
        "n_variants": len(runs.variants),
        "n_runs": runs.ln_im.size,
        "n_motions": runs.motions,
        "n_exceed": int(np.sum(outcomes.exceed)),
        "n_unknown": int(np.sum(outcomes.unknown)),
        "n_censored": fit.censored,
        "demand": state.demand,
        "threshold": state.threshold,
        "capacity_dispersion": state.dispersion,
    }
    best, left_out, again = fitted.best, fitted.left_out, fitted.again
    if fit.surface is None or fit.without is None or not (best and left_out and again):
        return _Judged(row=row)
    # ASSUME a study states no median that none of its runs reached, or all of them passed
    if (status := outcomes.one_sided) is not None:
        return _Judged(row=row | {"status": status})
    ln_capacity = float(np.log(state.threshold)) if source == "demand" else 0.0
    coefficients, ln_beta = fit.surface.curves(*best, ln_capacity)
    slope = float(np.mean(fit.surface.medians(best[0], ln_capacity)[1]))
    if not (np.all(np.isfinite(coefficients)) and np.isfinite(ln_beta[0])):
        return _Judged(row=row | {"status": "slope_not_positive"})
    without = np.column_stack(fit.surface.curves(*left_out, ln_capacity))
    row |= {
        "status": FITTED,
        "beta": float(np.exp(ln_beta[0])),
        "terms": ";".join(fit.surface.median_terms),
        "coefficients": coefficients[0].tolist(),
        "covariance": jackknife_covariance(without).ravel().tolist(),
        "box": json.dumps({**fit.surface.box.fixed, **fit.surface.box.limits}),
        "signed_skew": fit.surface.box.signed_skew,
        "log_gap": fit.surface.box.log_gap,
        "model_terms": ";".join(fit.surface.terms),
        "slope": slope if source == "demand" else nan,
    }
    medians = fit.surface.left_out_medians(fit.without, ln_capacity)
    loss = _loss(runs, known, hit, medians, row["beta"])
    row |= _middle(row, fit.surface.curves(*again, ln_capacity)[0])
    row |= _left_out_errors(runs, fit, medians, own) | {"log_loss": float(np.mean(loss))}
    return _Judged(row=row, loss=loss)


def _middle(row: dict[str, Any], again: FloatArray) -> dict[str, Any]:
    """Return the model in the middle of its box; ``again`` are coefficients of replicates."""
    model = JointModel.of_row(row)
    place = {name: 0.5 * (low + high) for name, (low, high) in model.box.limits.items()}
    vector = model.vector(place)
    theta, low, high = model.median(place)
    replicates = again @ vector
    usable = replicates[np.isfinite(replicates)]
    return {
        "theta": theta,
        "theta_low": low,
        "theta_high": high,
        "beta_low": model.ci_beta[0],
        "beta_high": model.ci_beta[1],
        "beta_total": model.beta_total,
        "se_ln_theta": float(np.sqrt(vector @ model.covariance[:-1, :-1] @ vector)),
        "se_bootstrap": float(np.std(usable, ddof=1)) if usable.size > 1 else nan,
    }


def _left_out_errors(
    runs: JointRuns, fit: JointFit, medians: FloatArray, own: pd.DataFrame | None
) -> dict[str, Any]:
    """Return the errors of the medians of left-out variants against their ``own`` fits."""
    found: dict[str, Any] = {"loo_error": nan, "loo_error_max": nan, "loo_variants": 0}
    if own is not None:
        theirs = own[["theta", "var_ln_theta"]].reindex(runs.variants["variant"])
        size = np.abs(np.exp(medians) / theirs["theta"].to_numpy(dtype=np.float64) - 1.0)
        if np.any(np.isfinite(size)):
            worst = int(np.nanargmax(size))
            return {
                "loo_error": float(np.nanmedian(size)),
                "loo_error_max": float(size[worst]),
                "loo_error_max_variant": str(runs.variants["variant"].iloc[worst]),
                "loo_error_max_se": float(np.sqrt(theirs["var_ln_theta"].iloc[worst])),
                "loo_variants": int(np.sum(np.isfinite(size))),
            }
    if fit.level_error is not None and np.any(np.isfinite(fit.level_error)):
        shift = np.abs(np.expm1(fit.level_error))
        found |= {"loo_error": float(np.nanmedian(shift)), "loo_error_max": float(np.nanmax(shift))}
    return found


def _loss(
    runs: JointRuns,
    known: NDArray[np.bool_],
    hit: NDArray[np.bool_],
    medians: FloatArray,
    beta: float,
) -> FloatArray:
    eta = (runs.ln_im[known] - medians[runs.variant[known]]) / beta
    return -special.log_ndtr(np.where(hit, eta, -eta))


def _preferred(judged: dict[str, _Judged], motion: NDArray[np.intp]) -> str:
    """Return the source to use, an empty text where none has an estimate."""
    able = [source for source, each in judged.items() if each.row["status"] == FITTED]
    if len(able) < len(SOURCES):
        return able[0] if able else ""
    demand, outcome = judged["demand"].loss, judged["exceedance"].loss
    if demand is None or outcome is None:
        return able[0]
    gain = np.bincount(motion, demand - outcome)
    gain = gain[np.bincount(motion) > 0]
    scatter = float(np.std(gain, ddof=1)) * np.sqrt(gain.size)
    errors = [judged[source].row["loo_error"] for source in ("exceedance", "demand")]
    better = float(np.sum(gain)) > _CLEARLY * scatter and errors[0] < errors[1]
    return "exceedance" if better else "demand"
