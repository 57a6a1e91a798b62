"""Levels of shaking of a study: configuration, scale factors, stripes, search per record (IDA).

A factor belongs to the motion only: if it changed with the bridge variant, variants could not be
compared motion by motion.
"""

import logging
from collections.abc import Callable, Sequence
from math import ceil, log, log1p, log2
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.errors import InputError
from skewbridge.files.text import OPTIONS, FileName, Number, Whole
from skewbridge.motions.record import Vector

if TYPE_CHECKING:
    import pandas as pd

logger = logging.getLogger(__name__)

#: Intensity measure of ``level_range_g`` and ``stripes_g``.
LEVEL_MEASURE: Final = "im_saavg_rotd50_g"
#: source: trial runs of the default study, see config/config.yaml
LEVEL_RANGE_G: Final = (0.07, 2.25)
BLOCK: Final = 8
# ASSUME a motion stays credible when scaled by 0.25 to 4; larger factors distort spectral shape
FACTOR_LIMITS: Final = (0.25, 4.0)
IDA_TOLERANCE: Final = 0.01

#: Shipped suites in `SHIPPED_FOLDER`; the first one is the folder itself.
SHIPPED_SUITES: Final = ("near", "far", "pulse")
SHIPPED_FOLDER: Final = Path("motions")
RECORDS: Final = "records"

Level = Annotated[Number, Field(ge=1.0e-4, le=20.0)]
ScaleFactor = Annotated[Number, Field(ge=1.0e-4, le=1.0e4)]


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class MotionsConfig:
    """Ground motions of a study, their levels and their directions."""

    folder: FileName = Field(default="motions")
    """folder with an index.csv or with motions"""
    suites: tuple[FileName, ...] = Field(default=("near",), min_length=1, max_length=20)
    """near (folder), far, pulse (motions/README.md), records (SKEWBRIDGE_RECORDS), other folders"""
    count: Whole | None = Field(default=32, ge=1, le=100_000)
    """use this many motions of each suite, from its first; null: all motions"""
    design: Literal["scaled_cloud", "cloud", "stripes", "ida"] = Field(default="scaled_cloud")
    """one factor per motion; unscaled; every motion at every level; search for first exceedances"""
    level_range_g: tuple[Level, Level] = Field(default=LEVEL_RANGE_G)
    """range of Sa_avg of scaled_cloud and ida"""
    stripes_g: tuple[Level, ...] = Field(
        default=(0.1, 0.2, 0.35, 0.55, 0.8, 1.1, 1.5), min_length=2, max_length=100
    )
    """Sa_avg of stripes, rising"""
    factor_limits: tuple[ScaleFactor, ScaleFactor] = Field(default=(0.25, 4.0))
    """factors that stripes may use; levels that need others are left out"""
    ida_demand: str = Field(default="column_drift_ratio")
    """demand of ida"""
    ida_threshold: Number = Field(default=0.025, gt=0.0, le=1.0e9)
    """limit of ida_demand that the search looks for, in the unit of the column"""
    shaking_s: Number | None = Field(default=None, ge=0.1, le=1.0e4)
    """keep the strongest part of each motion, of this length; null: whole motions"""
    incidence_deg: tuple[Annotated[Number, Field(ge=0.0, lt=360.0)], ...] = Field(
        default=(0.0,), min_length=1, max_length=360
    )
    """angle from the bridge x axis to component 1"""

    @model_validator(mode="after")
    def _levels_rise(self) -> Self:
        for name in ("level_range_g", "stripes_g", "factor_limits"):
            values = getattr(self, name)
            if list(values) != sorted(set(values)):
                raise ValueError(f"{name} must rise, got {list(values)}")
        return self


def block_factors(
    level_at_1_g: Sequence[float], level_range_g: tuple[float, float] = LEVEL_RANGE_G
) -> Vector:
    """Return one scale factor per motion of a suite, in suite order.

    In each block of 8 consecutive motions, targets in equal logarithmic steps go to the motions in
    the order of their own levels, which keeps the factors near 1. The offset of block b is element
    b + 1 of the van der Corput sequence, so that any number of blocks fills the range evenly, and a
    longer suite keeps the factors of its full blocks.
    """
    from scipy.stats import qmc  # here: workers that read the configuration do without scipy

    low_g, high_g = level_range_g
    levels = np.asarray(level_at_1_g, dtype=np.float64)
    starts = range(0, levels.size, BLOCK)
    offsets = qmc.Halton(1, scramble=False).fast_forward(1).random(len(starts))[:, 0]
    factors = np.empty(levels.size)
    for start, offset in zip(starts, offsets, strict=True):
        of_block = levels[start : start + BLOCK]
        share = (np.arange(of_block.size) + offset) / of_block.size
        in_order = start + np.argsort(of_block, kind="stable")
        factors[in_order] = low_g * (high_g / low_g) ** share
    return factors / levels


def striped(
    suite: "pd.DataFrame",
    stripes_g: Sequence[float],
    *,
    factor_limits: tuple[float, float] = FACTOR_LIMITS,
) -> "pd.DataFrame":
    """Return a suite with a row for each motion and level of Sa_avg within the factor limits.

    The rows of `prepare_suite` are repeated, by stripe, with their `scale` and a column `stripe_g`.
    `InputError` if no row is left.
    """
    import pandas as pd  # here: workers that read the configuration do without pandas

    low, high = factor_limits
    at_1_g = suite[LEVEL_MEASURE]
    stripes = [suite.assign(scale=g / at_1_g, stripe_g=float(g)) for g in stripes_g]
    every = pd.concat(stripes, ignore_index=True)
    table = every[every["scale"].between(low, high)].reset_index(drop=True)
    if table.empty:
        raise InputError(
            f"no motion reaches a stripe of {list(stripes_g)} g with factors {low} to {high}"
        )
    if left_out := len(every) - len(table):
        logger.warning(
            "%d of %d scaled motions are left out: their factor is outside %g to %g",
            left_out, len(every), low, high,
        )  # fmt: skip
    return table


def most_trials(limits: tuple[float, float], tolerance: float = IDA_TOLERANCE) -> int:
    """Return the largest number of analyses of `bracket_capacity`, one of them at an end."""
    halvings = ceil(log2(log(limits[1] / limits[0]) / log1p(tolerance)))
    return max(halvings, 1) + 1


def bracket_capacity(
    exceeds: Callable[[float], bool],
    *,
    limits: tuple[float, float],
    tolerance: float = IDA_TOLERANCE,
) -> tuple[float, float]:
    """Bracket the factor at which a record first exceeds a limit, halving the logarithmic range.

    The number of analyses is at most `most_trials`: nine halvings of a range of 100 leave 0.9 %,
    and an end of the range that the search reached is tried once. Where the response is not
    monotonic (resurrection), one of the crossings is found. A run that collapses exceeds. The
    tolerance is the width of the bracket relative to its lower end. Returns the highest factor
    known not to exceed, 0 if the lowest one exceeds, and the lowest factor known to exceed, inf if
    the highest one does not.
    """
    low, high = lower, upper = limits
    while upper / lower > 1.0 + tolerance:
        middle = float(np.sqrt(lower * upper))
        if exceeds(middle):
            upper = middle
        else:
            lower = middle
    if upper == high and not exceeds(high):
        return high, float("inf")
    if lower == low and exceeds(low):
        return 0.0, low
    return lower, upper
