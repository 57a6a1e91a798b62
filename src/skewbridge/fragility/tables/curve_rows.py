"""The columns of results/fragility/curves.parquet and how a fit becomes a row of it."""

from collections.abc import Mapping
from math import nan
from typing import Any, Final

import numpy as np

from skewbridge.fragility.old_likelihood.fit import FragilityFit
from skewbridge.fragility.old_likelihood.parts import LineFit
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import TREATMENTS
from skewbridge.variant.axes import AXES

CURVE_COLUMNS: Final[dict[str, str]] = {
    "variant": "name of the variant",
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    **{axis.name: f"{axis.description}, {axis.unit}".removesuffix(", -") for axis in AXES},
    "component": "component of the limit state",
    "limit_state": "degree of damage",
    "method": "cloud | exceedance | ida_interval | ordered (one dispersion for all states)",
    "model": "estimator behind the method (cloud_ols, cloud_tobit, stripes, ida_interval)",
    "status": "ok, or why there is no estimate",
    "theta": "median of the intensity measure at which the median capacity is reached",
    "beta": "record-to-record dispersion",
    "beta_total": "dispersion with that of the capacity, sqrt(beta^2 + (dispersion/b)^2)",
    "var_ln_theta": "variance of ln theta",
    "cov_ln_theta_beta": "covariance of ln theta and beta",
    "var_beta": "variance of beta",
    "theta_low": "lower end of the interval of theta; 0 is unbounded",
    "theta_high": "upper end of the interval of theta; infinity is unbounded",
    "beta_low": "lower end of the interval of beta",
    "beta_high": "upper end of the interval of beta",
    "ci_method": "fieller | profile | record_bootstrap | wald (method ordered)",
    "level": "confidence level of the intervals",
    "loglik": "log-likelihood at the maximum",
    "warnings": "names separated by semicolons",
    "n_runs": "runs of the variant",
    "n_records": "motions behind them",
    "n_exceed": "runs known to exceed",
    "n_unknown": "runs, failed or beyond the model, whose outcome is unknown",
    "n_collapse": "collapsed runs",
    "n_beyond_model": "runs in which a column failed beyond the model",
    "theta_exclude": "median with unknown outcomes left out",
    "beta_exclude": "dispersion with unknown outcomes left out",
    "theta_all_exceed": "median if all unknown outcomes exceed",
    "beta_all_exceed": "dispersion if all unknown outcomes exceed",
    "theta_none_exceed": "median if no unknown outcome exceeds",
    "beta_none_exceed": "dispersion if no unknown outcome exceeds",
    "theta_bracket_low": "separated data: last level without an exceedance; theta lies above it",
    "theta_bracket_high": "separated data: first level with an exceedance; theta lies below it",
    "theta_bound_low": "one-sided lower bound of theta where nothing exceeds or the data separate",
    "theta_bound_high": "one-sided upper bound where everything exceeds or the data separate",
    "theta_bound_beta": "dispersion assumed for these bounds",
    "theta_firth": "penalised (Firth) median of separated data, not the maximum likelihood",
    "beta_firth": "penalised (Firth) dispersion of separated data",
    "ln_a": "intercept of ln demand on ln intensity",
    "b": "slope of ln demand on ln intensity",
    "sigma": "scatter of ln demand about that line",
    "curvature_p": "p-value of the curvature test",
    "scatter_p": "p-value of the test of constant scatter",
    "normal_p": "p-value of Lilliefors' test that the scatter is normal",
    "link_p": "p-value of the test of a curvature in the predictor of an exceedance fit",
    "common_beta_p": "ordered: p-value against states with dispersions of their own",
    "aic": "Akaike's criterion; compares models of one method on the same runs",
    "plateau": "demand at which the runs level off; empty where a straight line does as well",
    "plateau_im": "intensity from which they do",
    "plateau_gain": "Akaike's criterion of the straight line less that of line and plateau",
    "mechanism": "why no run reached the state: plastic_hinge ... | plateau | weak_motions | "
    "no_demand",
    "reach": "the same as a sentence",
    "im": "intensity measure",
    "demand": "demand column",
    "threshold": "median capacity, in the unit of the demand column",
    "capacity_dispersion": "dispersion of the capacity",
    "collapse_rule": "exceeds | peak: whether a collapsed run exceeds by definition",
    "citation": "source of the capacity",
}
_LINE: Final = ("ln_a", "b", "sigma", "curvature_p", "scatter_p", "normal_p")
_PLATEAU: Final = ("plateau", "plateau_im", "plateau_gain")
_TOLD: Final = ("mechanism", "reach")
_CLOUD_PARAMETERS: Final = 3
_BOUNDS: Final = tuple(
    f"{parameter}_{treatment}" for treatment in TREATMENTS for parameter in ("theta", "beta")
)


def curve_row(
    fit: FragilityFit,
    state: LimitState,
    im_column: str,
    facts: Mapping[str, Any],
    *,
    slope: float | None = None,
) -> dict[str, Any]:
    """Return the row of one fit (without the columns that name the variant).

    ``facts`` are n_runs, n_records, n_exceed, n_unknown, n_collapse, n_beyond_model and the
    columns of `skewbridge.fragility.tables.reach`; ``slope`` is b of the log-log line, which
    carries the dispersion of the capacity over to the intensity measure, if there is one.
    """
    total = nan
    if slope is not None and slope > 0.0:
        # ASSUME capacity independent of demand; b carries its dispersion over to the intensity
        total = float(np.hypot(fit.beta, state.dispersion / slope))
    link_p = fit.goodness.link_p if fit.goodness else None
    firth = (fit.separation.firth if fit.separation else None) or {}
    line = fit.line or LineFit()
    row: dict[str, Any] = {
        **{name: getattr(fit, name) for name in CURVE_COLUMNS if hasattr(fit, name)},
        **{name: getattr(line, name) for name in _LINE},
        "component": state.component,
        "limit_state": state.name,
        "model": _model(fit),
        "beta_total": total,
        "theta_low": fit.ci_theta[0],
        "theta_high": fit.ci_theta[1],
        "beta_low": fit.ci_beta[0],
        "beta_high": fit.ci_beta[1],
        "warnings": ";".join(dict.fromkeys((*fit.warnings, *state.warnings))),
        **facts,
        **_bounds_of(fit),
        "link_p": nan if link_p is None else link_p,
        "aic": _aic(fit),
        "theta_firth": firth.get("theta", nan),
        "beta_firth": firth.get("beta", nan),
        "im": im_column,
        "demand": state.demand,
        "threshold": state.threshold,
        "capacity_dispersion": state.dispersion,
        "collapse_rule": state.collapse,
        "citation": state.citation,
        "common_beta_p": facts.get("common_beta_p", nan),
        **{name: facts.get(name, nan) for name in _PLATEAU},
        **{name: facts.get(name, "") for name in _TOLD},
        **dict.fromkeys(_BOUNDS, nan),
        **((fit.counts.bounds if fit.counts else None) or {}),
    }
    return {name: row[name] for name in CURVE_COLUMNS if name in row}


def _bounds_of(fit: FragilityFit) -> dict[str, float]:
    """Return bracket and one-sided bounds of the median of a fit without an estimate."""
    found = dict.fromkeys(
        ("theta_bracket_low", "theta_bracket_high", "theta_bound_low", "theta_bound_high"), nan
    )
    beta = nan
    if fit.bound is not None:
        bound, beta = fit.bound.headline
        found["theta_bound_low" if fit.bound.side == "lower" else "theta_bound_high"] = bound
    if fit.separation is not None:
        found["theta_bracket_low"], found["theta_bracket_high"] = fit.separation.theta_interval
        for name, ends in (fit.separation.theta_bounds_given_beta or {}).items():
            beta, (found["theta_bound_low"], found["theta_bound_high"]) = float(name), ends
    return found | {"theta_bound_beta": beta}


def _aic(fit: FragilityFit) -> float:
    """Return Akaike's criterion of an estimate, NaN without one."""
    if fit.goodness is not None:
        return fit.goodness.aic
    parameters = _CLOUD_PARAMETERS if fit.method == "cloud" else 2
    return 2.0 * parameters - 2.0 * fit.loglik


def _model(fit: FragilityFit) -> str:
    """Return the estimator behind the method of a fit."""
    if fit.method == "exceedance":
        return "stripes"
    if fit.method == "cloud":
        censored = fit.counts is not None and fit.counts.n_censored is not None
        return "cloud_tobit" if censored else "cloud_ols"
    return fit.method
