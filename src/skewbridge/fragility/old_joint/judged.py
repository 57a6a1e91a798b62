"""What a joint model says of one limit state, and which of its two fits to use."""

import json
from dataclasses import dataclass
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from skewbridge.fragility.old_joint.by_motion import jackknife_covariance
from skewbridge.fragility.old_joint.fits import JointFit
from skewbridge.fragility.old_joint.model import JointModel
from skewbridge.fragility.old_joint.runs import JointRuns
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Outcomes

#: Kind of data, and the method of a variant's own fit that it is compared with.
SOURCES: Final = {"demand": "cloud", "exceedance": "exceedance"}
# Standard errors by which the outcomes must predict better than the demands to be preferred.
_CLEARLY: Final = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """A fit with its estimate, without each motion and by bootstrap: parameters and scatter^2."""

    fit: JointFit
    best: tuple[FloatArray, FloatArray] | None = None
    left_out: tuple[FloatArray, FloatArray] | None = None
    again: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """A fit of one limit state, with what leaving variants out says of it."""

    row: dict[str, Any]
    loss: FloatArray | None = None  # by known run


def judged(
    runs: JointRuns,
    outcomes: Outcomes,
    named: tuple[LimitState, str, Fitted],
    own: pd.DataFrame | None,
    settings: FitSettings,
) -> Judged:
    """Return the columns of a fit of one limit state.

    ``named`` are the limit state, the kind of data and the fit; ``own`` the fits of the single
    variants, by variant.
    """
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
        return Judged(row=row)
    # ASSUME a study states no median that none of its runs reached, or all of them passed
    if (status := outcomes.one_sided) is not None:
        return Judged(row=row | {"status": status})
    ln_capacity = float(np.log(state.threshold)) if source == "demand" else 0.0
    coefficients, ln_beta = fit.surface.curves(*best, ln_capacity)
    slope = float(np.mean(fit.surface.medians(best[0], ln_capacity)[1]))
    if not (np.all(np.isfinite(coefficients)) and np.isfinite(ln_beta[0])):
        return Judged(row=row | {"status": "slope_not_positive"})
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
    return Judged(row=row, loss=loss)


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


def preferred(found: dict[str, Judged], motion: NDArray[np.intp]) -> str:
    """Return the source to use, an empty text where none has an estimate."""
    able = [source for source, each in found.items() if each.row["status"] == FITTED]
    if len(able) < len(SOURCES):
        return able[0] if able else ""
    demand, outcome = found["demand"].loss, found["exceedance"].loss
    if demand is None or outcome is None:
        return able[0]
    gain = np.bincount(motion, demand - outcome)
    gain = gain[np.bincount(motion) > 0]
    scatter = float(np.std(gain, ddof=1)) * np.sqrt(gain.size)
    errors = [found[source].row["loo_error"] for source in ("exceedance", "demand")]
    better = float(np.sum(gain)) > _CLEARLY * scatter and errors[0] < errors[1]
    return "exceedance" if better else "demand"
