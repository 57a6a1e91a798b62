"""Which ground motions a study takes: section ``motions`` of the configuration."""

from typing import Annotated, Final, Literal, Self

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.reading import FileName, Number, Whole

#: What the levels of a study are told in: ``level_range_g``, ``stripes_g``.
LEVEL_MEASURE: Final = "im_saavg_rotd50_g"
#: source: pilot of the default study (`skewbridge plan --pilot 8`), see config/config.yaml
LEVEL_RANGE_G: Final = (0.07, 2.25)
Level = Annotated[Number, Field(ge=1.0e-4, le=20.0)]
Factor = Annotated[Number, Field(ge=1.0e-4, le=1.0e4)]


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class MotionsConfig:
    """Which ground motions, how strong and from which direction."""

    folder: FileName = Field(
        default="motions", description="folder with an index.csv or with motions"
    )
    count: Whole | None = Field(
        default=32,
        ge=1,
        le=100_000,
        description="the first so many motions of the suite; null for all",
    )
    design: Literal["scaled_cloud", "cloud", "stripes", "ida"] = Field(
        default="scaled_cloud",
        description="scaled_cloud: one factor per motion; cloud: unscaled; stripes: every motion "
        "at every level; ida: search per motion for the first exceedance",
    )
    level_range_g: tuple[Level, Level] = Field(
        default=LEVEL_RANGE_G,
        description="range of Sa_avg that scaled_cloud spans and ida searches",
    )
    stripes_g: tuple[Level, ...] = Field(
        default=(0.1, 0.2, 0.35, 0.55, 0.8, 1.1, 1.5),
        min_length=2,
        max_length=100,
        description="levels of Sa_avg of design stripes, rising",
    )
    factor_limits: tuple[Factor, Factor] = Field(
        default=(0.25, 4.0),
        description="smallest and largest factor of design stripes; beyond, a motion is left out",
    )
    ida_demand: str = Field(
        default="column_drift_ratio", description="demand that design ida searches with"
    )
    ida_threshold: Number = Field(
        default=0.025, gt=0.0, le=1.0e9, description="its limit, in the unit of the demands table"
    )
    shaking_s: Number | None = Field(
        default=None,
        ge=0.1,
        le=1.0e4,
        description="keep only the strongest part of this length; null for all",
    )
    incidence_deg: tuple[Annotated[Number, Field(ge=0.0, lt=360.0)], ...] = Field(
        default=(0.0,),
        min_length=1,
        max_length=360,
        description="angle from the bridge x axis to component 1",
    )

    @model_validator(mode="after")
    def _levels_rise(self) -> Self:
        for name in ("level_range_g", "stripes_g", "factor_limits"):
            values = getattr(self, name)
            if list(values) != sorted(set(values)):
                raise ValueError(f"{name} must rise, got {list(values)}")
        return self
