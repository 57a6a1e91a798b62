"""Exceedance (probit) and bracket fits of one variant of a study; uncertain capacities.

References:
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533, for demand and
    capacity as independent lognormal variables; Papke and Wooldridge (1996), J. Applied
    Econometrics 11(6):619-632, for the quasi-likelihood of fractions.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import refit_exceedance, shared_weights
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray, predictor
from skewbridge.fragility.old_likelihood.parts import RunCounts
from skewbridge.fragility.methods import ida
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.settings import FitSettings
from skewbridge.fragility.tables.limit_states import LimitState, exceedance_probability
from skewbridge.fragility.tables.outcomes import Outcomes, Runs, bootstrapped


def fit_exceedance(
    runs: Runs, outcomes: Outcomes, settings: FitSettings, *, link: str = "probit"
) -> FragilityFit:
    """Fit the probability of exceedance to the known outcomes.

    The interval is of the profile where every motion ran once, by record bootstrap otherwise:
    runs of one motion are not independent.
    """
    known = ~outcomes.unknown
    fit = _binary(runs, outcomes.exceed, known, settings, link, interval=not runs.repeated)
    if fit.status == FITTED and runs.repeated:
        fit = with_record_bootstrap(
            fit, runs.im[known], outcomes.exceed[known], runs.records[known], settings
        )

    def assume(exceed: NDArray[np.bool_]) -> FragilityFit:
        return _binary(runs, exceed, np.ones_like(known), settings, link, interval=False)

    return outcomes.judge(replace(fit, method="exceedance"), settings, assume)


def _binary(
    runs: Runs,
    exceed: NDArray[np.bool_],
    used: NDArray[np.bool_],
    settings: FitSettings,
    link: str,
    *,
    interval: bool,
) -> FragilityFit:
    count = int(np.sum(used))
    if count == 0:
        return FragilityFit(method="stripes", status=existence.NO_RUNS, level=settings.confidence)
    return fit_stripes(
        runs.im[used],
        np.ones(count),
        exceed[used].astype(np.float64),
        link=link,
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

    ``exceed`` is 0 or 1, or the probability of exceedance, ``records`` the number of the motion of
    each run, shape (n,).
    """
    if fit.predictor is None or fit.predictor.a0 is None or fit.predictor.a1 is None:
        return fit
    weights = shared_weights(records, settings.bootstrap, settings.seed)[1:]
    link = fit.predictor.link or "probit"
    start = np.array([fit.predictor.a0 - predictor(0.5, link), fit.predictor.a1])
    return bootstrapped(fit, refit_exceedance(np.log(im), weights, weights * exceed, start, link))


def fit_record_brackets(runs: Runs, outcomes: Outcomes, settings: FitSettings) -> FragilityFit:
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

    def assume(exceed: NDArray[np.bool_]) -> FragilityFit:
        low, high, _ = ida.brackets_of_runs(runs.im, exceed.astype(np.float64), runs.records)
        return ida.fit_brackets(low, high, settings)

    return outcomes.judge(fit, settings, assume)


def fit_uncertain_capacity(
    runs: Runs,
    outcomes: Outcomes,
    state: LimitState,
    settings: FitSettings,
    *,
    link: str = "probit",
) -> FragilityFit:
    """Fit a curve to p_i = Phi[(ln D_i - ln C)/dispersion] in place of 0 or 1 per run.

    beta then holds the scatter of the motions and of the capacity; unlike the cloud it needs no
    line of ln D on ln x. The likelihood is a quasi-likelihood, so that the interval comes from the
    bootstrap over motions alone. A run that exceeds by definition has p = 1.
    """
    peak = np.nan_to_num(outcomes.demand, nan=0.0)
    with np.errstate(divide="ignore"):
        share = exceedance_probability(
            np.log(peak), float(np.log(state.threshold)), state.dispersion
        )
    p = np.where(outcomes.defined, 1.0, share)
    known = ~outcomes.unknown

    def fitted(values: FloatArray, used: NDArray[np.bool_]) -> FragilityFit:
        kept = values[used]
        found = fit_stripes(
            runs.im[used], np.ones(kept.size), kept, link=link, settings=settings, interval=False
        )
        # the link test and the deviance are of outcomes, not of probabilities
        return replace(found, method="stripes_uncertain_capacity", goodness=None)

    fit = fitted(p, known)
    if fit.status == FITTED:
        fit = with_record_bootstrap(fit, runs.im[known], p[known], runs.records[known], settings)
        left = tuple(name for name in fit.warnings if name != "fractional_counts_no_interval")
        fit = replace(fit, warnings=left)

    def assume(exceed: NDArray[np.bool_]) -> FragilityFit:
        return fitted(np.where(outcomes.unknown & exceed, 1.0, p), np.ones_like(known))

    return outcomes.judge(fit, settings, assume)
