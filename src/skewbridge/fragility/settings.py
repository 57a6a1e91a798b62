"""How fragility is fitted: section ``fragility`` of the configuration."""

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.reading import Number, Whole


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class FragilityConfig:
    """The fits."""

    im: str = Field(
        default="im_saavg_rotd50_g", description="intensity measure: an im_ column of demands"
    )
    limit_states: str = Field(
        default="config/limit_states.yaml", description="file with the limit states"
    )
    confidence: Number = Field(
        default=0.95, gt=0.5, lt=1.0, description="confidence level of the intervals of the fits"
    )
    bootstrap: Whole = Field(
        default=999, ge=99, description="record-bootstrap replicates for the paired effects"
    )
    seed: Whole = Field(default=20261120, ge=0, description="seed of the bootstrap")
