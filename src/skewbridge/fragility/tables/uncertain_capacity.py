"""Exceedance fits with an uncertain capacity: every run exceeds with a probability.

References:
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533, for demand and
    capacity as independent lognormal variables; Papke and Wooldridge (1996), J. Applied
    Econometrics 11(6):619-632, for the quasi-likelihood of fractions.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skewbridge.fragility.likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.likelihood.validate import positive, same_length
from skewbridge.fragility.methods.stripes import fit_stripes
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.limit_states import exceedance_probability
from skewbridge.fragility.tables.variant_exceedance import with_record_bootstrap


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
