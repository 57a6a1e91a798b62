"""Shaking levels of a study: configuration, scale factors, stripes and the search of an IDA.

The scale factor of a motion is the same for all variants, which are compared motion by motion.
"""

from collections.abc import Callable, Sequence
from math import ceil, log, log1p, log2
from pathlib import Path
from typing import Annotated, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.errors import InputError
from skewbridge.files.text import OPTIONS, FileName, Number, Whole
from skewbridge.motions.record import Vector

#: Intensity measure of ``level_range_g`` and ``stripes_g``.
LEVEL_MEASURE: Final = "im_saavg_rotd50_g"
#: source: trial runs of the default study, see config/config.yaml
LEVEL_RANGE_G: Final = (0.07, 2.25)
BLOCK: Final = 8
# ASSUME motions scaled by 0.25 to 4 stay realistic; larger factors distort the spectral shape
FACTOR_LIMITS: Final = (0.25, 4.0)
IDA_TOLERANCE: Final = 0.01  # width of the bracket relative to its lower end

#: Shipped suites in `SHIPPED_FOLDER`; the first one is the folder itself.
SHIPPED_SUITES: Final = ("near", "far", "pulse")
SHIPPED_FOLDER: Final = Path("motions")

#: Lowest and highest Sa_avg in g of each band of levels.
type Bands = tuple[tuple[float, float], ...]

Level = Annotated[Number, Field(ge=1.0e-4, le=20.0)]


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class BlocksConfig:
    """Part of the variants that a motion runs (`motions.blocks`)."""

    within: tuple[str, ...] = Field(default=("skew_deg",), min_length=1)
    """axes of the grid of which a motion runs all values"""
    cells_per_motion: Whole = Field(default=1, ge=1, le=2)
    """combinations of the other axes that a motion runs at each incidence"""
    complete_share: Number = Field(default=0.17, ge=0.0, le=1.0)
    """share of the motions that run all combinations at one incidence"""


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class BandsConfig:
    """Levels around the medians of the headline limit states (`motions.bands`)."""

    medians_g: tuple[Level, ...] = Field(default=(), max_length=100)
    """Sa_avg of the medians; empty: from `study`, or the first 8 motions"""
    study: FileName | None = Field(default=None)
    """results folder of an earlier study with the medians"""
    ratio: Number = Field(default=1.6, gt=1.0, le=10.0)
    """bands reach from median / ratio to median x ratio, inside level_range_g"""


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class SelectionConfig:
    """Selection of pairs that follow conditional spectra (`motions.selection`)."""

    target: FileName = Field(default="target.yaml")
    """conditional spectra: YAML by hand, or a disaggregation of OpenQuake or the USGS"""
    values: dict[str, str | Number] = Field(default={}, max_length=4)
    """keys of the target that its file lacks: measure, vs30_mps, mechanism, t1_s"""
    candidates: tuple[FileName, ...] = Field(default=("p695",), min_length=1, max_length=20)
    """p695, p695_far, p695_near or folders"""
    without: FileName | None = Field(default=None)
    """folder of an earlier selection, whose pairs are left out"""
    count: Whole = Field(default=16, ge=2, le=10_000)
    """pairs at each level; replaces motions.count"""


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class MotionsConfig:
    """Ground motions of a study, their levels and their directions."""

    folder: FileName | None = Field(default=None)
    """folder with index.csv or motion files, instead of suites"""
    selection: SelectionConfig | None = Field(default=None)
    """pairs selected for a target, used instead of suites"""
    suites: tuple[FileName, ...] = Field(default=("near",), min_length=1, max_length=20)
    """near, far, pulse, p695, p695_far, p695_near (motions/README.md), or folders"""
    count: Whole | None = Field(default=32, ge=1, le=100_000)
    """number of motions per suite; null: all"""
    design: Literal["scaled_cloud", "cloud", "stripes", "ida"] = Field(default="scaled_cloud")
    """scaled_cloud: one factor per motion; cloud: unscaled; stripes: all levels; ida: search"""
    level_range_g: tuple[Level, Level] = Field(default=LEVEL_RANGE_G)
    """Sa_avg range for scaled_cloud and ida"""
    bands: BandsConfig | None = Field(default=None)
    """levels around the medians of headline states; null: the whole range"""
    stripes_g: tuple[Level, ...] = Field(
        default=(0.1, 0.2, 0.35, 0.55, 0.8, 1.1, 1.5), min_length=2, max_length=100
    )
    """increasing Sa_avg of the stripes; motions that need factors outside 0.25 to 4 are left out"""
    ida_demand: str = Field(default="column_drift_ratio")
    """demand of the ida search"""
    ida_threshold: Number = Field(default=0.025, gt=0.0, le=1.0e9)
    """limit of ida_demand, in its unit"""
    # windows of 2 s or less are refused by `intensity.cut_to_strongest`: the tapers would fill them
    shaking_s: Number | None = Field(default=None, gt=2.0, le=1.0e4)
    """strongest seconds of each motion to keep; null: all"""
    tail_ratio: Number | None = Field(default=None, gt=0.0, lt=1.0)
    """analyses end when elastic displacements stay below this share of their peaks; null: never"""
    incidence_deg: tuple[Annotated[Number, Field(ge=0.0, lt=360.0)], ...] = Field(
        default=(0.0,), min_length=1, max_length=360
    )
    """angle from the x axis to component 1"""
    blocks: BlocksConfig | None = Field(default=None)
    """variants that each motion runs; null: all variants at all angles"""

    @model_validator(mode="after")
    def _levels_rise(self) -> Self:
        for name in ("level_range_g", "stripes_g"):
            values = getattr(self, name)
            if list(values) != sorted(set(values)):
                raise ValueError(f"{name} must be in increasing order, got {list(values)}")
        if len(set(self.incidence_deg)) < len(self.incidence_deg):
            raise ValueError(f"incidence_deg must differ, got {list(self.incidence_deg)}")
        if self.selection and (self.bands or self.design != "scaled_cloud"):
            raise ValueError("selection sets the levels: set bands: null, design: scaled_cloud")
        if self.bands and self.design != "scaled_cloud":
            raise ValueError(f"bands need the design scaled_cloud, got {self.design}")
        if self.blocks and len(self.incidence_deg) > 2:
            raise ValueError(f"blocks need 1 or 2 incidence_deg, got {len(self.incidence_deg)}")
        return self


def bands_around(motions: MotionsConfig, medians_g: Sequence[float]) -> Bands:
    """Return the bands of Sa_avg in g around medians, cut at the ends of the range.

    Without `motions.bands` or medians, the range is the band.
    """
    low, high = motions.level_range_g
    if motions.bands is None or not medians_g:
        return (motions.level_range_g,)
    ratio = motions.bands.ratio
    bands = [(max(median / ratio, low), min(median * ratio, high)) for median in sorted(medians_g)]
    in_range = tuple((lower, upper) for lower, upper in bands if lower < upper)
    # medians of runs may be outside the range; stated ones are there by mistake
    if len(in_range) == len(bands) or (in_range and not motions.bands.medians_g):
        return in_range
    text = f"a band of {list(medians_g)} g is outside level_range_g, {low:g} to {high:g} g"
    raise InputError(f"motions.bands: {text}: widen this range")


def has_pilot(motions: MotionsConfig) -> bool:
    """Return whether trial runs find the medians: bands without ``medians_g`` and ``study``."""
    bands = motions.bands
    return bands is not None and not bands.medians_g and bands.study is None


def block_factors(
    level_at_1_g: Sequence[float], bands_g: Bands = (LEVEL_RANGE_G,), first_g: Bands | None = None
) -> Vector:
    """Return one scale factor per motion of a suite, in suite order.

    Target levels are equally spaced in the logarithm within a band of Sa_avg, and each band has the
    same share of the motions; bands may overlap. In each block of 8 consecutive motions, the motion
    with the lowest unscaled level gets the lowest target, and so on; this keeps factors near 1.
    Block b is offset by element b + 1 of the van der Corput sequence, so any number of blocks
    covers the bands evenly. If motions are added, the factors of full blocks do not change.
    ``first_g`` are other bands for the first block (trial runs).
    """
    from scipy.stats import qmc  # here: workers that read the configuration do without scipy

    levels = np.asarray(level_at_1_g, dtype=np.float64)
    starts = range(0, levels.size, BLOCK)
    offsets = qmc.Halton(1, scramble=False).fast_forward(1).random(len(starts))[:, 0]
    factors = np.empty(levels.size)
    for start, offset in zip(starts, offsets, strict=True):
        ln_g = np.log(bands_g if start or first_g is None else first_g)
        edges = np.unique(ln_g)
        # distribution of the logarithm of the levels: the mean of uniform ones
        level_cdf = np.clip((edges[:, None] - ln_g[:, 0]) / np.diff(ln_g).T, 0.0, 1.0).mean(axis=1)
        block_levels = levels[start : start + BLOCK]
        targets = (np.arange(block_levels.size) + offset) / block_levels.size
        by_level = start + np.argsort(block_levels, kind="stable")
        factors[by_level] = np.exp(np.interp(targets, level_cdf, edges))
    return factors / levels


def most_trials(limits: tuple[float, float]) -> int:
    """Return the largest number of analyses of `bracket_capacity`, including one at a range end."""
    halvings = ceil(log2(log(limits[1] / limits[0]) / log1p(IDA_TOLERANCE)))
    return max(halvings, 1) + 1


def bracket_capacity(
    exceeds: Callable[[float], bool], *, limits: tuple[float, float]
) -> tuple[float, float]:
    """Bracket the scale factor at which a motion first exceeds a limit, by bisection in ln factor.

    Returns the highest tried factor at which the limit is not exceeded, and the lowest at which it
    is. If it is exceeded at the lower end of the range, the first is 0; if it is not exceeded at
    the upper end, the second is inf. A collapse counts as an exceedance. There are at most
    `most_trials` analyses: nine halvings reduce a factor range of 100 to 0.9 %, and an end of the
    range is tried once. If the response is not monotonic, the bracket contains one crossing.
    """
    low, high = lower, upper = limits
    while upper / lower > 1.0 + IDA_TOLERANCE:
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
