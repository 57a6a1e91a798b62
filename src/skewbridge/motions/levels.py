"""Suites for the other ways to a fragility: unscaled cloud, stripes, per-record search (IDA)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, log, log1p, log2
from typing import Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.motions.scaling import FACTOR_LIMITS, stripe_factors
from skewbridge.motions.settings import LEVEL_MEASURE

IDA_LIMITS: Final = (0.1, 10.0)
IDA_TOLERANCE: Final = 0.01


def unscaled_cloud(suite: pd.DataFrame) -> pd.DataFrame:
    """Return a suite with every motion as recorded (factor 1)."""
    return suite.assign(scale=1.0)


def striped(
    suite: pd.DataFrame,
    stripes_g: Sequence[float],
    *,
    factor_limits: tuple[float, float] = FACTOR_LIMITS,
) -> pd.DataFrame:
    """Return a suite with a row for each motion and level of Sa_avg within the factor limits.

    Returns:
        The rows of `prepare_suite`, repeated, with their `scale` and a column `stripe_g`; by
        stripe, then in suite order. `attrs["left_out"]` counts the rows outside the limits.

    Raises:
        InputError: Levels or limits that are not positive and ascending, no row left.
    """
    low, high = factor_limits
    if not 0.0 < low < high:
        raise InputError(f"factor_limits must be two ascending positive factors, got {low}, {high}")
    if list(stripes_g) != sorted(set(stripes_g)):
        raise InputError(f"stripes_g must ascend, got {list(stripes_g)}")
    factors, allowed = stripe_factors(suite[LEVEL_MEASURE].to_list(), stripes_g, factor_limits)
    parts = [
        suite[allowed[:, column]].assign(
            scale=factors[allowed[:, column], column], stripe_g=float(level_g)
        )
        for column, level_g in enumerate(stripes_g)
    ]
    table = pd.concat(parts, ignore_index=True)
    if table.empty:
        raise InputError(
            f"no motion reaches a stripe of {list(stripes_g)} g with factors {low} to {high}"
        )
    table.attrs["left_out"] = int((~allowed).sum())
    return table


@dataclass(frozen=True, slots=True, kw_only=True)
class CapacityBracket:
    """Where the first exceedance of one record lies.

    Attributes:
        lower: Highest factor known not to exceed; 0 if the lowest one tried exceeds.
        upper: Lowest factor known to exceed; inf if the highest one tried does not.
        analyses: How many analyses it took.
    """

    lower: float
    upper: float
    analyses: int

    @property
    def capacity(self) -> float:
        """Middle of the bracket (geometric), nan where it is open at an end."""
        if self.lower == 0.0 or np.isinf(self.upper):
            return float("nan")
        return float(np.sqrt(self.lower * self.upper))


def most_trials(limits: tuple[float, float], tolerance: float = IDA_TOLERANCE) -> int:
    """Return how many analyses `bracket_capacity` takes at most, one of them at an end."""
    low, high = limits
    halvings = ceil(log2(log(high / low) / log1p(tolerance)))
    return max(halvings, 1) + 1


def bracket_capacity(
    exceeds: Callable[[float], bool],
    *,
    limits: tuple[float, float] = IDA_LIMITS,
    tolerance: float = IDA_TOLERANCE,
) -> CapacityBracket:
    """Bracket the factor at which a record first exceeds a limit, halving the logarithmic range.

    Ten analyses at most for the default limits and tolerance: nine halvings of a range of 100 leave
    0.9 %, and an end of the range that the search ran into is tried once. Where the response is
    not monotonic (resurrection), one of the crossings is found. A run that collapses exceeds. The
    tolerance is the width of the bracket relative to its lower end.

    Raises:
        InputError: Limits or tolerance that make no sense.
    """
    low, high = limits
    if not 0.0 < low < high or not np.isfinite(high):
        raise InputError(f"limits must be two ascending positive factors, got {limits}")
    if not 1.0e-6 <= tolerance < 1.0:
        raise InputError(f"tolerance must be within 1e-6 and below 1, got {tolerance}")
    trials: list[bool] = []

    def trial(factor: float) -> bool:
        trials.append(bool(exceeds(factor)))
        return trials[-1]

    lower, upper = low, high
    while upper / lower > 1.0 + tolerance:
        middle = float(np.sqrt(lower * upper))
        if trial(middle):
            upper = middle
        else:
            lower = middle
    if upper == high and not trial(high):
        lower, upper = high, float("inf")
    elif lower == low and trial(low):
        lower, upper = 0.0, low
    return CapacityBracket(lower=lower, upper=upper, analyses=len(trials))
