"""The whole configuration: the sections of the packages below, in one place."""

from pydantic import BaseModel, ConfigDict, Field
from pydantic.dataclasses import dataclass

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.fragility.settings import FitSettings
from skewbridge.motions.settings import MotionsConfig
from skewbridge.reading import Whole
from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.variant.grid import GridConfig
from skewbridge.variant.options import ModelOptions


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class SensitivityConfig:
    """Numerical check: penalties and time step halved and doubled on a few analyses."""

    motions: Whole = Field(
        default=3,
        ge=0,
        description="strongest so many motions, on the most skewed frictional variant; 0 for none",
    )


class StudyConfig(BaseModel):
    """The whole configuration."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    results: str = Field(
        default=DEFAULT_ROOT, min_length=1, description="folder of everything that the study writes"
    )
    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelOptions = Field(default_factory=ModelOptions)
    analysis: AnalysisSettings = Field(default_factory=AnalysisSettings)
    fragility: FitSettings = Field(default_factory=FitSettings)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)
