"""Mean annual frequency of a limit state from its fragility curve and a hazard table.

lambda = int P(LS | x) |dH(x)|. Between the points of the table the hazard is a power law (a line
in log-log), for which the integral has a closed form; nothing is discretised.

References:
    Cornell, Jalayer, Hamburger and Foutch (2002), J. Struct. Eng. 128(4):526-533.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from skewbridge.fragility.old_likelihood.validate import positive, require, same_length


@dataclass(frozen=True, slots=True, kw_only=True)
class AnnualFrequency:
    """Mean annual frequency with what lies outside the hazard table.

    Attributes:
        frequency: Per year, from the range of the table alone.
        above: What intensities above the table can add at most, H(last).
        above_least: What they add at least, P(LS | last) H(last).
        below: P(LS | first): intensities below the table add at most that times their rate, which
            the table does not give.
        probability_50y: 1 - exp(-50 lambda).
    """

    frequency: float
    above: float
    above_least: float
    below: float
    probability_50y: float


def annual_frequency(theta: float, beta: float, im: ArrayLike, rate: ArrayLike) -> AnnualFrequency:
    """Integrate a lognormal curve over a hazard table.

    ``im`` increases, in the unit of theta; ``rate`` is the mean annual frequency of exceeding each
    and does not increase. Give the total dispersion if it is to count.

    Raises:
        InputError: A value is not positive, or the table is not monotone; names the row.
    """
    x, h = positive(im, "im"), positive(rate, "rate")
    same_length(im=x, rate=h)
    require(np.append(True, np.diff(x) > 0.0), "im", "must increase", x)
    require(np.append(True, np.diff(h) <= 0.0), "rate", "must not increase", h)
    u = (np.log(x) - np.log(theta)) / beta
    curve = special.ndtr(u)
    k = -np.diff(np.log(h)) / np.diff(np.log(x))
    # int P |dH| = -[P H] + int H dP, with H = H1 (x/x1)^-k on each segment
    scale = np.exp(np.log(h[:-1]) + k * beta * u[:-1] + 0.5 * (k * beta) ** 2)
    weight = special.ndtr(u[1:] + k * beta) - special.ndtr(u[:-1] + k * beta)
    segments = curve[:-1] * h[:-1] - curve[1:] * h[1:] + scale * weight
    total = float(np.sum(segments))
    return AnnualFrequency(
        frequency=total,
        above=float(h[-1]),
        above_least=float(curve[-1] * h[-1]),
        below=float(curve[0]),
        probability_50y=float(-np.expm1(-50.0 * total)),
    )
