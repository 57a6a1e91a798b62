"""Random properties of a bridge and alternative models: one draw of all of them per motion.

Material strengths, mass, damping, soil, pads, keys, gap and direction of the motion are drawn once
per motion; all variants use the same draw of a motion. Effects therefore stay paired, and no
analyses are added. The scatter of the properties becomes part of the scatter between motions.

Each property is the modelling option (a factor or an offset) of the same name. A draw is therefore
part of the key of its analyses, and a property can be an axis of the grid instead. An alternative
is a value of any other modelling option, which another engineer could choose; all values of an
option are equally likely.

Pan et al. (2007), Journal of Bridge Engineering 12(6):689, sample material strengths, mass, bearing
friction and joint gap from a Latin hypercube.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from math import exp, log
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.errors import did_you_mean
from skewbridge.files.text import OPTIONS, Flag, Number, checked, read_mapping
from skewbridge.variant.options import ModelOptions

#: Prefix of the columns of the demands table with the draws of properties.
DRAW_PREFIX: Final = "draw_"
#: Prefix of the columns of the demands table with the drawn values of modelling options.
CHOICE_PREFIX: Final = "choice_"
#: Entry in the provenance of a table of fits: the properties that were drawn, or none.
RANDOM_PROPERTIES: Final = "random_properties"
DIRECTION: Final = "incidence_deg"
#: Drawn random properties and modelling options of one motion, keyed by name.
type Draw = Mapping[str, Any]
#: Motions whose draws form one Latin hypercube. A draw does not depend on later motions.
BLOCK: Final = 16
_SEED: Final = 1  # first seed of a hypercube; its suite and block follow
_TRIALS: Final = 200  # trial hypercubes of a block; the least correlated one is used


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class RandomProperty:
    """Distribution of one property: a factor on its value in the model, or an offset."""

    distribution: Literal["normal", "lognormal", "uniform"] = Field()
    """distribution between the limits low and high"""
    median: Number = Field(default=1.0)
    """median before truncation; not used by uniform"""
    spread: Annotated[Number, Field(gt=0.0, le=100.0)] = Field(default=1.0)
    """standard deviation, of the logarithm if lognormal; not used by uniform"""
    low: Number = Field(ge=-1.0e3)
    """lower limit of the values (truncation)"""
    high: Number = Field(le=1.0e3)
    """upper limit of the values (truncation)"""
    source: Annotated[str, Field(min_length=1, max_length=500)] = Field()
    """source of the distribution"""

    @model_validator(mode="after")
    def _has_values(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low must be below high, got {self.low:g} and {self.high:g}")
        if self.distribution == "lognormal" and self.low <= 0.0:
            raise ValueError(f"low of a lognormal property must be positive, got {self.low:g}")
        if self.distribution != "uniform" and not self.low < self.median < self.high:
            limits = f"low {self.low:g} and high {self.high:g}"
            raise ValueError(f"median must be between {limits}, got {self.median:g}")
        return self

    def quantile(self, share: float) -> float:
        """Return the quantile of the truncated distribution at a probability ``share`` (0 to 1)."""
        if self.distribution == "uniform":
            value = self.low + share * (self.high - self.low)
        else:
            transform, inverse = (log, exp) if self.distribution == "lognormal" else (float, float)
            normal = NormalDist(transform(self.median), self.spread)
            low, high = normal.cdf(transform(self.low)), normal.cdf(transform(self.high))
            probability = min(max(low + share * (high - low), 1.0e-12), 1.0 - 1.0e-12)
            value = inverse(normal.inv_cdf(probability))
        # the last digits of exp depend on the processor; keys of analyses must not
        return float(f"{min(max(value, self.low), self.high):.6g}")

    @property
    def as_text(self) -> str:
        """Distribution in words, for the methods text and the page."""
        limits = f"{self.low:g} to {self.high:g}"
        if self.distribution == "uniform":
            return f"uniform, {limits}"
        return f"{self.distribution}, median {self.median:g}, spread {self.spread:g}, {limits}"


_DEFAULTS: Final = read_mapping(Path(__file__).with_suffix(".yaml"))
_Drawn = RandomProperty | None


def _default(name: str) -> Any:
    default = RandomProperty(**_DEFAULTS[name])
    return Field(default=default, description="distribution; null: the value of the model")


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class UncertaintyConfig:
    """Random properties: one draw per motion, the same in every variant.

    Factors multiply the values of the bridge file and of ``model``; offsets are added to them.
    """

    enabled: Flag = Field(default=False)
    """random properties, one draw per motion for all variants"""
    concrete_strength_factor: _Drawn = _default("concrete_strength_factor")
    steel_strength_factor: _Drawn = _default("steel_strength_factor")
    damping_factor: _Drawn = _default("damping_factor")
    deck_mass_factor: _Drawn = _default("deck_mass_factor")
    backfill_strength_factor: _Drawn = _default("backfill_strength_factor")
    backfill_stiffness_factor: _Drawn = _default("backfill_stiffness_factor")
    pad_stiffness_factor: _Drawn = _default("pad_stiffness_factor")
    pad_strength_factor: _Drawn = _default("pad_strength_factor")
    gap_offset_mm: _Drawn = _default("gap_offset_mm")
    key_strength_factor: _Drawn = _default("key_strength_factor")
    # null by default: the shipped suites already rotate every pair by a random angle, and a second
    # random angle adds no scatter
    incidence_deg: _Drawn = Field(default=None)
    """added to motions.incidence_deg"""
    alternatives: dict[str, tuple[bool | int | float | str, ...]] = Field(default={})
    """keys of model with values; each motion draws one value"""

    @model_validator(mode="after")
    def _alternatives_are_values_of_options(self) -> Self:
        options = {field.name for field in fields(ModelOptions)} - self.properties.keys()
        for name, values in self.alternatives.items():
            if name in self.properties:
                raise ValueError(f"alternatives: {name} has a distribution: uncertainty.{name}")
            if name not in options:
                suggestion = did_you_mean(name, options)
                raise ValueError(f"alternatives: {name} is not a key of model{suggestion}")
            if not 2 <= len(set(values)) == len(values):
                raise ValueError(f"alternatives.{name} needs two or more values, all different")
            for value in values:
                checked(ModelOptions, {name: value}, "alternatives")
        return self

    @model_validator(mode="after")
    def _factors_are_positive(self) -> Self:
        for name, distribution in self.properties.items():
            if distribution is not None and name.endswith("_factor") and distribution.low < 0.01:
                raise ValueError(f"{name}.low must be at least 0.01, got {distribution.low:g}")
        return self

    @property
    def properties(self) -> dict[str, RandomProperty | None]:
        """Distributions keyed by property name."""
        return {name: getattr(self, name) for name in PROPERTIES}

    @property
    def drawn(self) -> dict[str, RandomProperty]:
        """Distributions of the properties that are drawn; empty if drawing is not enabled."""
        configured = self.properties.items() if self.enabled else ()
        return {name: distribution for name, distribution in configured if distribution is not None}

    def draws(self, motion_ids: Sequence[str], suite: str = "") -> dict[str, dict[str, Any]]:
        """Return the drawn values, keyed by motion and property or option; empty if not enabled.

        A draw depends on the suite and the position of the motion in it. The properties
        of 16 motions form a Latin hypercube, their alternatives another one.
        """
        drawn, options = self.drawn, self.alternatives if self.enabled else {}
        if not drawn and not options:
            return {}
        suite_number, blocks = int.from_bytes(suite.encode()), range(-(-len(motion_ids) // BLOCK))
        seeds = [(_SEED, suite_number, block) for block in blocks]
        level_rows = np.vstack([_hypercube(len(PROPERTIES), seed) for seed in seeds])
        choice_rows = np.vstack([_hypercube(len(options) or 1, (*seed, 1)) for seed in seeds])
        return {
            motion_id: {
                **{
                    name: law.quantile(float(level))
                    for name, level in zip(PROPERTIES, levels, strict=True)
                    if (law := drawn.get(name)) is not None
                },
                **{
                    name: values[int(choice * len(values))]
                    for (name, values), choice in zip(options.items(), choices, strict=False)
                },
            }
            for motion_id, levels, choices in zip(motion_ids, level_rows, choice_rows, strict=False)
        }


#: Names of the properties, in the order of the hypercube columns.
PROPERTIES: Final = tuple(
    field.name
    for field in fields(UncertaintyConfig)
    if field.name not in ("enabled", "alternatives")
)


def draw_columns(draw: Draw) -> dict[str, float | str]:
    """Return a draw as columns of the demands table: properties as numbers, options as texts."""
    return {
        **{f"{DRAW_PREFIX}{name}": draw[name] for name in draw if name in PROPERTIES},
        **{
            f"{CHOICE_PREFIX}{name}": f"{value:g}" if isinstance(value, float) else f"{value}"
            for name, value in draw.items()
            if name not in PROPERTIES
        },
    }


def drawn_properties(columns: Iterable[str]) -> tuple[str, ...]:
    """Return the names in words of the random properties among columns of a demands table."""
    names = (name.removeprefix(DRAW_PREFIX) for name in columns if name.startswith(DRAW_PREFIX))
    return tuple(property_name(name) for name in names)


def drawn_options(columns: Iterable[str]) -> tuple[str, ...]:
    """Return the modelling options drawn per motion, from the columns of a demands table."""
    return tuple(
        name.removeprefix(CHOICE_PREFIX) for name in columns if name.startswith(CHOICE_PREFIX)
    )


def property_name(name: str) -> str:
    """Return the name of a random property in words, such as deck mass for deck_mass_factor."""
    words = {DIRECTION: "direction of the motion", "gap_offset_mm": "joint gap"}
    return words.get(name, name.removesuffix("_factor").replace("_", " "))


def _hypercube(width: int, seed: tuple[int, ...]) -> Any:
    """Return a Latin hypercube in 0..1, shape (BLOCK, width): the least correlated of many."""
    rng = np.random.default_rng(seed)
    strata = np.tile(np.arange(BLOCK), (width, 1))
    trials = [rng.permuted(strata, axis=1) for _ in range(_TRIALS)]
    best = min(trials, key=lambda trial: float(np.abs(np.corrcoef(trial) - np.eye(width)).max()))
    return ((best + rng.random(best.shape)) / BLOCK).T


def with_draw(options: ModelOptions, draw: Draw) -> ModelOptions:
    """Return modelling options changed by the values drawn for a motion.

    Factors multiply options, offsets are added to them, and alternatives replace them.
    """
    drawn: dict[str, Any] = {name: draw[name] for name in draw if name != DIRECTION}
    for name in drawn.keys() & {*PROPERTIES}:
        option = getattr(options, name)
        is_factor = name.endswith("_factor")
        drawn[name] = option * drawn[name] if is_factor else option + drawn[name]
    return replace(options, **drawn)
