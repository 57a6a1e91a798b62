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

from skewbridge.fragility.old_joint.by_motion import MotionSums
from skewbridge.fragility.old_joint.mixed import outer_by, sum_by
from skewbridge.fragility.old_likelihood.existence import NOT_CONVERGED
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.links import FloatArray, link_terms, probit_side
from skewbridge.fragility.old_likelihood.newton import (
    BinomialKernel,
    Derivatives,
    maximise,
    row_products,
)

SEPARATION: Final = "separation"
# A motion that moves the estimate by more than this many standard errors is left out by a new fit.
_MOVES_MUCH: Final = 0.1
# Less than this share of the information in some direction: the maximum may lie at infinity.
_THIN_INFORMATION: Final = 1e-5
# Replicates times runs treated at once: they stay in the cache, and 10^3 motions in the memory.
_CHUNK_ELEMENTS: Final = 50_000


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
    distance = np.einsum("gp,pq,gq->g", moved, information, moved)
    far = np.flatnonzero(distance > _MOVES_MUCH**2)
    if far.size:
        near = distance[far] < 1.0  # else one step may lead anywhere
        start = np.where(near[:, None], params[far], fit.sums.params)
        kernel = _WithoutMotions(design, exceed, motion, far)
        params[far] = maximise(kernel, start, covariance=False).params
    return replace(fit.sums, refitted=params)


class _WithoutMotions:
    """The probit of single runs without one motion each: as many replicates as motions left out.

    Args:
        design: Shape (n, p).
        exceed: 0 or 1, shape (n,).
        motion: Number of the motion, shape (n,).
        left_out: The motion that each replicate lacks, shape (R,).
    """

    def __init__(
        self,
        design: FloatArray,
        exceed: FloatArray,
        motion: NDArray[np.intp],
        left_out: NDArray[np.intp],
    ) -> None:
        sign = np.where(exceed > 0.0, 1.0, -1.0)
        self._signed = design * sign[:, None]
        self._products = row_products(design, design)
        self._motion, self._left_out = motion, left_out

    def derivatives(self, params: FloatArray, rows: NDArray[np.intp] | None = None) -> Derivatives:
        """Evaluate the batch; see `skewbridge.fragility.old_likelihood.newton.Kernel`."""
        left_out = self._left_out if rows is None else self._left_out[rows]
        blocks = 1 + params.shape[0] * self._motion.size // _CHUNK_ELEMENTS
        parts = [
            self._block(params[part], left_out[part])
            for part in np.array_split(np.arange(params.shape[0]), min(blocks, params.shape[0]))
        ]
        return Derivatives(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def _block(
        self, params: FloatArray, left_out: NDArray[np.intp]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        size = params.shape[1]
        kept = self._motion != left_out[:, None]
        log_p, first, second = (part * kept for part in probit_side(params @ self._signed.T))
        return (
            np.sum(log_p, axis=1),
            first @ self._signed,
            (second @ self._products).reshape(-1, size, size),
        )


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
