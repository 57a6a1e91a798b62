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

from skewbridge.fragility.likelihood.links import FloatArray

#: Gain of the criterion below which the straight line stays: 600 simulated straight clouds of 16 or
#: 32 runs passed it in about 5 % of cases.
MIN_GAIN: Final = 4.0
_LEAST: Final = 4  # runs on either side of the knee
_KNEES: Final = 16
_ROUNDS: Final = 4
_SMALLEST_SCATTER: Final = 0.01  # a plateau without scatter would have an infinite likelihood
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
    straight = _residual_variance(x, y, np.ones(n))[0]
    splits = np.unique(np.linspace(_LEAST, n - _LEAST, min(_KNEES, n - 2 * _LEAST + 1)).astype(int))
    tried = [_with_knee(x, y, int(split), straight) for split in splits]
    rising = [plateau for plateau in tried if plateau is not None]
    return max(rising, key=lambda plateau: plateau.gain, default=None)


def _with_knee(x: FloatArray, y: FloatArray, split: int, straight: float) -> Plateau | None:
    """Return the plateau of the runs from ``split`` on; None unless the line below rises."""
    n = x.size
    knee = 0.5 * (x[split - 1] + x[split])
    beyond = np.arange(n) >= split
    z, weights = np.minimum(x, knee), np.ones(n)
    if np.ptp(z) == 0.0:
        return None
    _, intercept, slope = _residual_variance(z, y, weights)
    above = 1.0
    for _ in range(_ROUNDS):
        residual = y - intercept - slope * z
        below, above = (
            max(float(np.mean(residual[part] ** 2)), _SMALLEST_SCATTER**2)
            for part in (~beyond, beyond)
        )
        weights = np.where(beyond, 1.0 / above, 1.0 / below)
        _, intercept, slope = _residual_variance(z, y, weights)
    if not slope > 0.0:
        return None
    residual = y - intercept - slope * z
    twice = np.sum(np.log(weights)) - np.sum(weights * residual**2)
    return Plateau(
        level=float(np.exp(intercept + slope * knee)),
        scatter=float(np.sqrt(above)),
        knee=float(np.exp(knee)),
        gain=float(twice + n * np.log(straight) + n - 2 * _MORE_PARAMETERS),
    )


def _residual_variance(
    z: FloatArray, y: FloatArray, weights: FloatArray
) -> tuple[float, float, float]:
    """Return the mean squared residual, intercept and slope of a weighted line."""
    total = float(np.sum(weights))
    mean_z, mean_y = float(weights @ z) / total, float(weights @ y) / total
    u = z - mean_z
    slope = float((weights * u) @ y) / float((weights * u) @ u)
    residual = y - mean_y - slope * u
    variance = max(float(np.mean(residual**2)), _SMALLEST_SCATTER**2)
    return variance, mean_y - slope * mean_z, slope
