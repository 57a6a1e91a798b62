"""Demands that level off: a line up to a knee and a plateau beyond, against one straight line.

What limits a demand (a plastic hinge limits the shear) takes its scatter away as well, so that the
plateau has a scatter of its own.

References:
    Akaike (1974), IEEE Trans. Automatic Control 19(6):716-723, for the criterion; Hinkley (1971),
    Biometrika 58(2):255-262, for lines of two phases.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.fragility.old_likelihood.links import FloatArray

#: Gain of the criterion below which the straight line stays: 600 simulated straight clouds of 16 or
#: 32 runs passed it in about 5 % of cases.
MIN_GAIN: Final = 4.0
_LEAST: Final = 4  # runs on either side of the knee
_KNEES: Final = 16
_ROUNDS: Final = 4
_SMALLEST: Final = 0.01**2  # a plateau without scatter would have an infinite likelihood
_MORE_PARAMETERS: Final = 2  # the knee and the scatter of the plateau


@dataclass(frozen=True, slots=True, kw_only=True)
class Plateau:
    """A rising line with a plateau beyond a knee, the best of those tried.

    Attributes:
        level: Median demand on the plateau.
        scatter: Standard deviation of ln demand there.
        knee: Intensity at which it begins.
        gain: Akaike's criterion of the straight line less that of this one.
    """

    level: float
    scatter: float
    knee: float
    gain: float

    @property
    def found(self) -> bool:
        """Whether the data prefer it to the straight line."""
        return self.gain > MIN_GAIN

    @property
    def top(self) -> float:
        """The demand that 5 % of the runs on the plateau pass."""
        return float(self.level * np.exp(1.645 * self.scatter))


def fit_plateau(im: FloatArray, demand: FloatArray) -> Plateau | None:
    """Fit ln D = a + b min(ln x, knee) with one scatter below the knee and one beyond.

    Both are positive, shape (n,). None if there are too few runs, or no line rises to a knee.
    """
    order = np.argsort(im, kind="stable")
    x, y = np.log(im[order]), np.log(demand[order])
    n = x.size
    if n < 2 * _LEAST or np.ptp(x) == 0.0:
        return None
    straight = float(_lines(x[None], y, np.ones((1, n)))[0][0])
    splits = np.unique(np.linspace(_LEAST, n - _LEAST, min(_KNEES, n - 2 * _LEAST + 1)).astype(int))
    knees = 0.5 * (x[splits - 1] + x[splits])
    rises = knees > x[0]  # else all runs below the knee have one intensity
    tried = _with_knees(x, y, splits[rises], knees[rises], straight)
    rising = [plateau for plateau in tried if plateau is not None]
    return max(rising, key=lambda plateau: plateau.gain, default=None)


def _with_knees(
    x: FloatArray, y: FloatArray, splits: NDArray[np.int_], knees: FloatArray, straight: float
) -> list[Plateau | None]:
    """Return the plateaus of the runs from each split on; None unless the line below rises."""
    n, k = x.size, splits.size
    beyond = np.arange(n) >= splits[:, None]
    z, weights = np.minimum(x, knees[:, None]), np.ones((k, n))
    _, intercept, slope = _lines(z, y, weights)
    above = np.ones(k)
    for _ in range(_ROUNDS):
        square = (y - intercept[:, None] - slope[:, None] * z) ** 2
        below, above = (
            np.maximum(np.sum(square, axis=1, where=part) / np.sum(part, axis=1), _SMALLEST)
            for part in (~beyond, beyond)
        )
        weights = np.where(beyond, 1.0 / above[:, None], 1.0 / below[:, None])
        _, intercept, slope = _lines(z, y, weights)
    square = (y - intercept[:, None] - slope[:, None] * z) ** 2
    twice = np.sum(np.log(weights), axis=1) - np.sum(weights * square, axis=1)
    gain = twice + n * np.log(straight) + n - 2 * _MORE_PARAMETERS
    return [
        Plateau(
            level=float(np.exp(intercept[i] + slope[i] * knees[i])),
            scatter=float(np.sqrt(above[i])),
            knee=float(np.exp(knees[i])),
            gain=float(gain[i]),
        )
        if slope[i] > 0.0
        else None
        for i in range(k)
    ]


def _lines(
    z: FloatArray, y: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mean squared residuals, intercepts and slopes of K weighted lines, z of shape (K, n).

    y is common to all, shape (n,).
    """
    total = np.sum(weights, axis=1)
    mean_z, mean_y = np.sum(weights * z, axis=1) / total, weights @ y / total
    u = z - mean_z[:, None]
    weighted = weights * u
    slope = weighted @ y / np.sum(weighted * u, axis=1)
    residual = y - mean_y[:, None] - slope[:, None] * u
    variance = np.maximum(np.mean(residual**2, axis=1), _SMALLEST)
    return variance, mean_y - slope * mean_z, slope
