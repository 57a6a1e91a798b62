"""Scale factors: one per motion, spread over the levels of the study.

A factor belongs to the motion and to nothing else: were it to change with the bridge variant, the
paired comparison of variants would be lost.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from skewbridge.errors import InputError
from skewbridge.motions.record import Vector
from skewbridge.motions.settings import LEVEL_RANGE_G

BLOCK: Final = 8
# ASSUME a motion stays credible when scaled by 0.25 to 4; larger factors distort spectral shape
FACTOR_LIMITS: Final = (0.25, 4.0)


def block_targets(block: int, size: int, level_range_g: tuple[float, float]) -> Vector:
    """Return ascending target levels in g of one block of motions, log-uniformly spread.

    Each block covers the whole range in equal steps; the offset of block b is element b + 1 of
    the van der Corput sequence, so that any number of blocks fills the range evenly.
    """
    low_g, high_g = level_range_g
    sequence = qmc.Halton(1, scramble=False).fast_forward(block + 1)
    share = (np.arange(size) + float(sequence.random(1)[0, 0])) / size
    return low_g * (high_g / low_g) ** share


def block_factors(
    level_at_1_g: Sequence[float], level_range_g: tuple[float, float] = LEVEL_RANGE_G
) -> Vector:
    """Return one scale factor per motion of a suite, in suite order.

    In each block of 8 consecutive motions the targets go to the motions in the order of their own
    levels, which keeps the factors near 1. A block does not depend on the others: a longer suite
    keeps the factors of its full blocks.

    Raises:
        InputError: A range that is not ascending and positive.
    """
    low_g, high_g = level_range_g
    if not 0.0 < low_g < high_g:
        raise InputError(
            f"level_range_g must be two ascending positive levels, got {level_range_g}"
        )
    levels = np.asarray(level_at_1_g, dtype=np.float64)
    factors = np.empty(levels.size)
    for block, start in enumerate(range(0, levels.size, BLOCK)):
        own = levels[start : start + BLOCK]
        targets = block_targets(block, own.size, level_range_g)
        factors[start + np.argsort(own, kind="stable")] = targets
    return factors / levels


def stripe_factors(
    level_at_1_g: Sequence[float],
    stripes_g: Sequence[float],
    limits: tuple[float, float] = FACTOR_LIMITS,
) -> tuple[Vector, NDArray[np.bool_]]:
    """Return the factors that bring each motion to each stripe, and which are within the limits.

    Returns:
        Factors and their admissibility, each of shape (motions, stripes).
    """
    levels = np.asarray(level_at_1_g, dtype=np.float64)
    stripes = np.asarray(stripes_g, dtype=np.float64)
    if stripes.size == 0 or not (np.isfinite(stripes).all() and (stripes > 0.0).all()):
        raise InputError(f"stripes_g must be positive levels, got {list(stripes_g)}")
    factors = stripes[None, :] / levels[:, None]
    return factors, (factors >= limits[0]) & (factors <= limits[1])
