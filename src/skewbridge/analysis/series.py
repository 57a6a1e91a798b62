"""Largest values and regular rows of series."""

from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

type Series = NDArray[np.float64]

STEP_ROUNDING: Final = 1.0e-6  # of a step, in a time that is a sum of steps


def peak(series: Iterable[Series]) -> float:
    """Return the largest magnitude of all series, 0 without any."""
    return max((float(np.abs(values).max()) for values in series), default=0.0)


def highest(series: Iterable[Series]) -> float:
    """Return the largest value of all series, at least 0."""
    return max(0.0, *(float(values.max()) for values in series))


def at_regular_steps(time_s: Series, dt_s: float) -> NDArray[np.bool_]:
    """Return which rows end a regular step, so that histories have one spacing; and the last one.

    Steps in contact and retries come between; peaks are taken from all rows.
    """
    steps = time_s / dt_s
    kept = np.abs(steps - np.round(steps)) < STEP_ROUNDING
    kept[-1] = True
    return kept
