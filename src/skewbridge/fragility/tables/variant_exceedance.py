"""Exceedance (probit) and bracket fits of one variant of a study."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_exceedance
from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.parts import RunCounts
from skewbridge.fragility.methods import ida
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.outcomes import Outcomes
from skewbridge.fragility.tables.runs import Runs, bootstrapped, judge_unknown


def fit_exceedance(
    runs: Runs, outcomes: Outcomes, settings: FitSettings
) -> tuple[FragilityFit, dict[str, float]]:
    """Fit the probability of exceedance to the known outcomes.

    The interval is of the profile where every motion ran once, by record bootstrap otherwise:
    runs of one motion are not independent.

    Returns:
        The fit, and median and dispersion of the three treatments of unknown outcomes.
    """
    known = ~outcomes.unknown
    fit = _probit(runs, outcomes.exceed, known, settings, interval=not runs.repeated)
    if fit.status == FITTED and runs.repeated:
        fit = with_record_bootstrap(
            fit, runs.im[known], outcomes.exceed[known], runs.records[known], settings
        )
    everything = np.ones_like(known)
    bounds: dict[str, FragilityFit] = {"exclude": fit, "all_exceed": fit, "none_exceed": fit}
    if np.any(outcomes.unknown):
        for name, exceed in (
            ("all_exceed", outcomes.exceed | outcomes.unknown),
            ("none_exceed", outcomes.exceed),
        ):
            bounds[name] = _probit(runs, exceed, everything, settings, interval=False)
    return judge_unknown(replace(fit, method="exceedance"), bounds, outcomes, settings)


def _probit(
    runs: Runs,
    exceed: NDArray[np.bool_],
    used: NDArray[np.bool_],
    settings: FitSettings,
    *,
    interval: bool,
) -> FragilityFit:
    count = int(np.sum(used))
    if count == 0:
        return FragilityFit(method="stripes", status="no_runs", level=settings.confidence)
    return fit_stripes(
        runs.im[used],
        np.ones(count),
        exceed[used].astype(np.float64),
        settings=settings,
        n_records=int(np.unique(runs.records[used]).size),
        interval=interval,
    )


def with_record_bootstrap(
    fit: FragilityFit,
    im: FloatArray,
    exceed: FloatArray | NDArray[np.bool_],
    records: NDArray[np.intp],
    settings: FitSettings,
) -> FragilityFit:
    """Replace the interval of an exceedance fit by that of the record bootstrap.

    Args:
        fit: A fit of single runs that has an estimate.
        im: Intensities, shape (n,).
        exceed: Outcomes, or probabilities of exceedance, shape (n,).
        records: Number of the motion of each run.
        settings: Replicates and seed.
    """
    if fit.predictor is None or fit.predictor.a0 is None or fit.predictor.a1 is None:
        return fit
    _, codes = np.unique(records, return_inverse=True)
    weights = record_weights(codes, settings.bootstrap, np.random.default_rng(settings.seed))
    start = np.array([fit.predictor.a0, fit.predictor.a1])
    return bootstrapped(fit, refit_exceedance(np.log(im), weights, weights * exceed, start))


def fit_record_brackets(
    runs: Runs, outcomes: Outcomes, settings: FitSettings
) -> tuple[FragilityFit, dict[str, float]]:
    """Fit brackets of the first exceedance per motion; unknown outcomes are left out."""
    known = ~outcomes.unknown
    lower, upper, odd = ida.brackets_of_runs(
        runs.im[known], outcomes.exceed[known].astype(np.float64), runs.records[known]
    )
    fit = ida.fit_brackets(lower, upper, settings)
    if fit.status == ida.ALL_CENSORED:
        fit = replace(fit, status=existence.NO_EXCEEDANCE)
    if odd:
        fit = replace(
            fit,
            warnings=(*fit.warnings, "non_monotone_records"),
            counts=replace(fit.counts or RunCounts(), n_non_monotone=odd),
        )
    bounds = {"exclude": fit, "all_exceed": fit, "none_exceed": fit}
    for name, exceed in (
        ("all_exceed", outcomes.exceed | outcomes.unknown),
        ("none_exceed", outcomes.exceed),
    ):
        if np.any(outcomes.unknown):
            low, high, _ = ida.brackets_of_runs(runs.im, exceed.astype(np.float64), runs.records)
            bounds[name] = ida.fit_brackets(low, high, settings)
    return judge_unknown(fit, bounds, outcomes, settings)
