"""Uncertainty by motion: every motion left out once, and the bootstrap over motions.

A fit hands over the share of each motion in its score and information. One Newton step with other
weights of the motions then gives the estimate of a replicate: exact where the model is linear. A
probit that few motions decide is not: it is fitted again without each of those.

References:
    Bell and McCaffrey (2002), Survey Methodology 28(2):169-181: with few clusters the jackknife is
    the robust covariance that does not come out too small.
"""

from dataclasses import dataclass

import numpy as np

from skewbridge.fragility.old_likelihood.links import FloatArray

#: A line through the motions takes two of them: its level and its slope.
LINE_PARAMETERS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSums:
    """An estimate and what each of G motions adds to it.

    Attributes:
        params: Shape (p,).
        score: First derivatives of the log-likelihood by motion, shape (G, p).
        information: Minus its second derivatives, shape (G, p, p).
        squares: Mean square of the residuals of a motion, shape (G,); None where the model has no
            scatter of its own (probit).
        slopes: Mean of x times residual, shape (G, p).
        products: Mean of x x', shape (G, p, p).
        refitted: Parameters without each motion, shape (G, p), where one step is not enough.
    """

    params: FloatArray
    score: FloatArray
    information: FloatArray
    squares: FloatArray | None = None
    slopes: FloatArray | None = None
    products: FloatArray | None = None
    refitted: FloatArray | None = None

    def reweighted(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return parameters (R, p) and scatter squared (R,) at weights of the motions (R, G)."""
        count, size = self.score.shape
        total = (weights @ self.information.reshape(count, -1)).reshape(-1, size, size)
        inverse = np.linalg.pinv(total, hermitian=True)
        step = np.einsum("rpq,rq->rp", inverse, weights @ self.score)
        params = self.params + step
        if self.squares is None or self.slopes is None or self.products is None:
            return params, np.ones(weights.shape[0])
        product = (weights @ self.products.reshape(count, -1)).reshape(-1, size, size)
        square = weights @ self.squares - 2.0 * np.einsum("rp,rp->r", step, weights @ self.slopes)
        square += np.einsum("rp,rpq,rq->r", step, product, step)
        freedom = np.maximum(np.sum(weights, axis=1) - LINE_PARAMETERS, 1.0)
        return params, np.maximum(square, 0.0) / freedom

    def best(self) -> tuple[FloatArray, FloatArray]:
        """Return the estimate itself, shapes (1, p) and (1,)."""
        count, size = self.score.shape
        if self.squares is None:
            return self.params[None, :], np.ones(1)
        scatter = np.sum(self.squares) / max(count - LINE_PARAMETERS, 1)
        return self.params.reshape(1, size), np.array([scatter])

    def one_left_out(self) -> tuple[FloatArray, FloatArray]:
        """Return parameters (G, p) and scatter squared (G,) without each motion."""
        count = self.score.shape[0]
        if self.refitted is not None:
            return self.refitted, np.ones(count)
        return self.reweighted(np.ones((count, count)) - np.eye(count))


def jackknife_covariance(values: FloatArray) -> FloatArray:
    """Return the covariance of an estimate from its values without each motion, shape (G, q)."""
    count = values.shape[0]
    deviation = values - np.mean(values, axis=0)
    return deviation.T @ deviation * (count - 1) / count
