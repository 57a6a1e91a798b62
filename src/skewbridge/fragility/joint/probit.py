"""Exceeded or not over intensity and axes: a probit with the motions as clusters.

References:
    Ghosh, Padgett and Duenas-Osorio (2013), Probabilistic Engineering Mechanics 34:189-199, for
    parameterised curves; Liang and Zeger (1986), Biometrika 73(1):13-22, for the clusters.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from skewbridge.fragility.joint.by_motion import MotionSums
from skewbridge.fragility.joint.mixed import outer_by, sum_by
from skewbridge.fragility.likelihood.existence import NOT_CONVERGED
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.likelihood.links import FloatArray, link_terms
from skewbridge.fragility.likelihood.newton import BinomialKernel, maximise

SEPARATION: Final = "separation"
# A motion that moves the estimate by more than this many standard errors is left out by a new fit.
_MOVES_MUCH: Final = 0.1
# Less than this share of the information in some direction: the maximum may lie at infinity.
_THIN_INFORMATION: Final = 1e-5


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbitFit:
    """A fitted probit.

    Attributes:
        status: ``ok``, ``separation`` or ``not_converged``; only ``ok`` has an estimate.
        sums: Estimate with the share of each motion in score and information.
        loglik: Log-likelihood.
        score: By run, shape (n, p).
        curve: Minus the second derivative by the predictor of each run, shape (n,).
    """

    status: str
    sums: MotionSums
    loglik: float
    score: FloatArray
    curve: FloatArray


def fit_probit(design: FloatArray, exceed: FloatArray, motion: NDArray[np.intp]) -> ProbitFit:
    """Fit the probit to single runs: design (n, p), 0 or 1 and number of the motion, shape (n,)."""
    size = design.shape[1]
    kernel = BinomialKernel(design, np.ones(exceed.size), exceed)
    best = maximise(kernel, np.zeros((1, size)), covariance=False)
    params = best.params[0]
    terms = link_terms("probit")(design @ params)
    score = design * (exceed * terms.d_log_p + (1.0 - exceed) * terms.d_log_q)[:, None]
    curve = -(exceed * terms.d2_log_p + (1.0 - exceed) * terms.d2_log_q)
    information = outer_by(motion, design * np.sqrt(np.maximum(curve, 0.0))[:, None])
    status = FITTED if best.converged[0] else NOT_CONVERGED
    if (status != FITTED or _is_thin(design, information)) and separated(design, exceed):
        status = SEPARATION
    sums = MotionSums(params=params, score=sum_by(motion, score), information=information)
    return ProbitFit(
        status=status, sums=sums, loglik=float(best.loglik[0]), score=score, curve=curve
    )


def refitted_without_motions(
    fit: ProbitFit, design: FloatArray, exceed: FloatArray, motion: NDArray[np.intp]
) -> MotionSums:
    """Return the shares of the motions with the estimates without each of them, iterated.

    One Newton step is kept for the motions that hardly move the estimate. Where the outcomes are
    separated without a motion its slope is very large: beta then has no lower bound to speak of.

    Args:
        fit: A fit with an estimate.
        design: What it was made of, shape (n, p).
        exceed: 0 or 1, shape (n,).
        motion: Number of the motion, shape (n,).
    """
    params, _ = fit.sums.one_left_out()
    moved = params - fit.sums.params
    information = np.sum(fit.sums.information, axis=0)
    far = np.einsum("gp,pq,gq->g", moved, information, moved) > _MOVES_MUCH**2
    kept = (motion != np.flatnonzero(far)[:, None]).astype(np.float64)
    if far.any():
        kernel = BinomialKernel(design, kept, kept * exceed)
        start = np.broadcast_to(fit.sums.params, (len(kept), design.shape[1]))
        params[far] = maximise(kernel, start, covariance=False).params
    return replace(fit.sums, refitted=params)


def _is_thin(design: FloatArray, information: FloatArray) -> bool:
    """Return whether some direction of the design has hardly any information."""
    full = np.linalg.cholesky(design.T @ design)
    half = np.linalg.solve(full, np.sum(information, axis=0))
    return bool(np.linalg.eigvalsh(np.linalg.solve(full, half.T))[0] < _THIN_INFORMATION)


def separated(matrix: FloatArray, exceed: FloatArray) -> bool:
    """Return whether some linear predictor separates the outcomes, by linear programming.

    The estimate exists iff no c has s_i x_i c >= 0 for all i, with > 0 for some, s = +-1.

    References:
        Albert and Anderson (1984); Konis (2007), for the linear programme.
    """
    signed = matrix * np.where(exceed > 0.0, 1.0, -1.0)[:, None]
    found = optimize.linprog(
        -np.sum(signed, axis=0),
        A_ub=-signed,
        b_ub=np.zeros(signed.shape[0]),
        bounds=(-1.0, 1.0),
        method="highs",
    )
    return found.fun is None or -float(found.fun) > 1e-8 * signed.shape[0]
