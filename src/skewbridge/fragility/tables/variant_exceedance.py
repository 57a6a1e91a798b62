"""Exceedance (probit) and bracket fits of one variant of a study; uncertain capacities.

References:
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533, for demand and
    capacity as independent lognormal variables; Papke and Wooldridge (1996), J. Applied
    Econometrics 11(6):619-632, for the quasi-likelihood of fractions.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.fragility.likelihood import existence
from skewbridge.fragility.likelihood.bootstrap import record_weights, refit_exceedance
from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.likelihood.parts import RunCounts
from skewbridge.fragility.likelihood.validate import positive, same_length
from skewbridge.fragility.methods import ida
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.limit_states import exceedance_probability
from skewbridge.fragility.tables.outcomes import Outcomes, Runs, bootstrapped


def fit_exceedance(runs: Runs, outcomes: Outcomes, settings: FitSettings) -> FragilityFit:
    """Fit the probability of exceedance to the known outcomes.

    The interval is of the profile where every motion ran once, by record bootstrap otherwise:
    runs of one motion are not independent.
    """
    known = ~outcomes.unknown
    fit = _probit(runs, outcomes.exceed, known, settings, interval=not runs.repeated)
    if fit.status == FITTED and runs.repeated:
        fit = with_record_bootstrap(
            fit, runs.im[known], outcomes.exceed[known], runs.records[known], settings
        )

    def assume(exceed: NDArray[np.bool_]) -> FragilityFit:
        return _probit(runs, exceed, np.ones_like(known), settings, interval=False)

    return outcomes.judge(replace(fit, method="exceedance"), settings, assume)


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

    ``exceed`` is 0 or 1, or the probability of exceedance, ``records`` the number of the motion of
    each run, shape (n,).
    """
    if fit.predictor is None or fit.predictor.a0 is None or fit.predictor.a1 is None:
        return fit
    weights = record_weights(records, settings.bootstrap, settings.seed)
    start = np.array([fit.predictor.a0, fit.predictor.a1])
    return bootstrapped(fit, refit_exceedance(np.log(im), weights, weights * exceed, start))


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
    im: ArrayLike,
    edp: ArrayLike,
    capacity: float,
    dispersion: float,
    *,
    records: NDArray[np.intp] | None = None,
    settings: FitSettings = DEFAULTS,
) -> FragilityFit:
    """Fit a curve to p_i = Phi[(ln D_i - ln C)/beta_c] in place of 0 or 1 per run.

    beta then holds the scatter of the motions and of the capacity; unlike the cloud it needs no
    line of ln D on ln x. The likelihood is a quasi-likelihood, so that the interval comes from the
    bootstrap over motions alone.

    Args:
        im: Intensities, shape (n,).
        edp: Demands in the unit of ``capacity``, shape (n,), positive.
        capacity: Median capacity.
        dispersion: Dispersion of the capacity; 0 gives the plain exceedance fit.
        records: Number of the motion of each run; None: every run has its own.
        settings: Level, replicates and seed of the bootstrap.

    Raises:
        InputError: A value is missing or not positive; names the rows.
    """
    x, demand = positive(im, "im"), positive(edp, "edp")
    same_length(im=x, edp=demand)
    p = exceedance_probability(np.log(demand), float(np.log(capacity)), dispersion)
    fit = fit_stripes(x, np.ones(x.size), p, settings=settings, interval=False)
    fit = replace(fit, method="stripes_uncertain_capacity")
    if fit.status != FITTED:
        return fit
    codes = np.arange(x.size) if records is None else records
    fit = with_record_bootstrap(fit, x, p, codes, settings)
    kept = tuple(name for name in fit.warnings if name != "fractional_counts_no_interval")
    return replace(fit, warnings=kept)
