"""Link functions of the binomial models: log-probabilities and their first two derivatives."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from skewbridge.errors import InputError

type FloatArray = NDArray[np.float64]

HALF_LOG_2PI: Final = 0.5 * np.log(2.0 * np.pi)
_SQRT_2_OVER_PI: Final = np.sqrt(2.0 / np.pi)
MAX_LOG: Final = 700.0  # exp() of more overflows a double


@dataclass(frozen=True, slots=True)
class LinkTerms:
    """Log-probability of exceedance and of non-exceedance at a linear predictor.

    ``d_`` is the first and ``d2_`` the second derivative by the predictor, never positive.
    """

    log_p: FloatArray
    log_q: FloatArray
    d_log_p: FloatArray
    d_log_q: FloatArray
    d2_log_p: FloatArray
    d2_log_q: FloatArray


def mills_ratio(eta: FloatArray) -> FloatArray:
    """Return phi/Phi(eta) = sqrt(2/pi)/erfcx(-eta/sqrt 2), which neither underflows nor cancels."""
    return np.asarray(_SQRT_2_OVER_PI / special.erfcx(-eta / np.sqrt(2.0)))


def probit_terms(eta: FloatArray) -> LinkTerms:
    """Return the terms of the standard normal distribution function.

    References:
        Baker (2015), Earthquake Spectra 31(1), Eq. 11, for the likelihood these terms serve.
    """
    log_p, ratio_p, slope_p = probit_side(eta)
    log_q, ratio_q, slope_q = probit_side(-eta)
    return LinkTerms(log_p, log_q, ratio_p, -ratio_q, slope_p, slope_q)


def probit_side(eta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return ln Phi(eta) with its first two derivatives, where the other side does not count."""
    ratio = mills_ratio(eta)
    with np.errstate(divide="ignore"):
        log_p = np.where(ratio > 0.0, -0.5 * eta * eta - HALF_LOG_2PI - np.log(ratio), 0.0)
    return log_p, ratio, -ratio * (eta + ratio)


def logit_terms(eta: FloatArray) -> LinkTerms:
    """Return the terms of the logistic distribution function."""
    p = special.expit(eta)
    q = special.expit(-eta)
    return LinkTerms(special.log_expit(eta), special.log_expit(-eta), q, -p, -p * q, -p * q)


def cloglog_terms(eta: FloatArray) -> LinkTerms:
    """Return the terms of P = 1 - exp(-exp(eta)), the complementary log-log link."""
    u = np.exp(np.minimum(eta, np.log(MAX_LOG)))
    ratio = np.where(u > 0.0, u / np.expm1(np.maximum(u, 1e-300)), 1.0)
    log_p = np.where(u > 1e-290, np.log(-np.expm1(-np.maximum(u, 1e-300))), eta)
    return LinkTerms(log_p, -u, ratio, -u, ratio * (1.0 - u - ratio), -u)


_TERMS: Final[dict[str, Callable[[FloatArray], LinkTerms]]] = {
    "probit": probit_terms,
    "logit": logit_terms,
    "cloglog": cloglog_terms,
}


def link_terms(link: str) -> Callable[[FloatArray], LinkTerms]:
    """Return the function of a link by name.

    Raises:
        InputError: The link is not one of probit, logit, cloglog.
    """
    if link not in _TERMS:
        raise InputError(f"link must be one of {', '.join(_TERMS)}, got {link!r}")
    return _TERMS[link]


def probability(eta: FloatArray, link: str = "probit") -> FloatArray:
    """Return P(exceed) at the linear predictor."""
    if link == "probit":
        return np.asarray(special.ndtr(eta))
    if link == "logit":
        return np.asarray(special.expit(eta))
    return np.asarray(-np.expm1(-np.exp(np.minimum(eta, MAX_LOG))))


def predictor(p: float, link: str = "probit") -> float:
    """Return the linear predictor at which P(exceed) equals ``p``."""
    if link == "probit":
        return float(special.ndtri(p))
    if link == "logit":
        return float(special.logit(p))
    return float(np.log(-np.log1p(-p)))


def half_width(link: str) -> float:
    """Return half the distance of the predictors of 16 and 84 %, 1 for the probit link."""
    return 0.5 * (
        predictor(float(special.ndtr(1.0)), link) - predictor(float(special.ndtr(-1.0)), link)
    )
