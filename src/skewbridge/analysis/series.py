"""Largest values of series."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

type Series = NDArray[np.float64]


def peak(series: Iterable[Series]) -> float:
    """Return the largest magnitude of all series, 0 without any."""
    return max((float(np.abs(values).max()) for values in series), default=0.0)


def highest(series: Iterable[Series]) -> float:
    """Return the largest value of all series, at least 0."""
    return max(0.0, *(float(values.max()) for values in series))
