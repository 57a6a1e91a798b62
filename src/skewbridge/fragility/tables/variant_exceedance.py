"""Exceedance (probit) and bracket fits of one variant of a study."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_exceedance
from skewbridge.fragility.likelihood.fit import OK, FragilityFit
from skewbridge.fragility.methods import ida
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.tables.outcomes import Outcomes
from skewbridge.fragility.tables.runs import FitSettings, Runs, bootstrapped, judge_unknown


def fit_exceedance(
    runs: Runs, outcomes: Outcomes, options: FitSettings
) -> tuple[FragilityFit, dict[str, float]]:
    """Fit the probability of exceedance to the known outcomes.

    The interval is of the profile where every motion ran once, by record bootstrap otherwise:
    runs of one motion are not independent.

    Returns:
        The fit, and median and dispersion of the three treatments of unknown outcomes.
    """
    known = ~outcomes.unknown
    fit = _probit(runs, outcomes.exceed, known, options, interval=not runs.repeated)
    if fit.status == OK and runs.repeated:
        fit = _with_record_bootstrap(fit, runs, outcomes, options)
    everything = np.ones_like(known)
    bounds: dict[str, FragilityFit] = {"exclude": fit, "all_exceed": fit, "none_exceed": fit}
    if np.any(outcomes.unknown):
        for name, exceed in (
            ("all_exceed", outcomes.exceed | outcomes.unknown),
            ("none_exceed", outcomes.exceed),
        ):
            bounds[name] = _probit(runs, exceed, everything, options, interval=False)
    return judge_unknown(replace(fit, method="exceedance"), bounds, outcomes, options)


def _probit(
    runs: Runs,
    exceed: NDArray[np.bool_],
    used: NDArray[np.bool_],
    options: FitSettings,
    *,
    interval: bool,
) -> FragilityFit:
    count = int(np.sum(used))
    if count == 0:
        return FragilityFit(method="stripes", status="no_runs", level=options.level)
    return fit_stripes(
        runs.im[used],
        np.ones(count),
        exceed[used].astype(np.float64),
        level=options.level,
        assumed_beta=options.assumed_beta,
        n_records=int(np.unique(runs.records[used]).size),
        interval=interval,
    )


def _with_record_bootstrap(
    fit: FragilityFit, runs: Runs, outcomes: Outcomes, options: FitSettings
) -> FragilityFit:
    known = ~outcomes.unknown
    _, codes = np.unique(runs.records[known], return_inverse=True)
    rng = np.random.default_rng(options.seed)
    weights = record_weights(codes, options.replicates, rng)
    start = np.array([fit.details["a0"], fit.details["a1"]])
    again = refit_exceedance(
        np.log(runs.im[known]), weights, weights * outcomes.exceed[known], start
    )
    return bootstrapped(fit, again.intervals(options.level), again.theta, again.beta)


def fit_record_brackets(
    runs: Runs, outcomes: Outcomes, options: FitSettings
) -> tuple[FragilityFit, dict[str, float]]:
    """Fit brackets of the first exceedance per motion; unknown outcomes are left out."""
    known = ~outcomes.unknown
    lower, upper, odd = ida.brackets_of_runs(
        runs.im[known], outcomes.exceed[known].astype(np.float64), runs.records[known]
    )
    fit = ida.fit_brackets(lower, upper, level=options.level, assumed_beta=options.assumed_beta)
    if fit.status == ida.ALL_CENSORED:
        fit = replace(fit, status=existence.NO_EXCEEDANCE)
    if odd:
        fit = replace(
            fit,
            warnings=(*fit.warnings, "non_monotone_records"),
            details={**fit.details, "n_non_monotone": odd},
        )
    bounds = {"exclude": fit, "all_exceed": fit, "none_exceed": fit}
    for name, exceed in (
        ("all_exceed", outcomes.exceed | outcomes.unknown),
        ("none_exceed", outcomes.exceed),
    ):
        if np.any(outcomes.unknown):
            low, high, _ = ida.brackets_of_runs(runs.im, exceed.astype(np.float64), runs.records)
            bounds[name] = ida.fit_brackets(low, high, level=options.level)
    return judge_unknown(fit, bounds, outcomes, options)
