"""The typed configuration: these models are the one source of the schema and of the key table."""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import MAX_FRICTION_PCT, MAX_GAP_MM, MAX_SKEW_DEG


def _whole_hundredths(value: float) -> float:
    if abs(value * 100 - round(value * 100)) > 1e-9:
        raise ValueError(
            "friction must be a whole number of hundredths, so that it can be part of a name"
        )
    return value


def _known_abutment(value: str) -> str:
    name = value.replace("-", "_")
    if name not in ABUTMENTS:
        raise ValueError(f"unknown abutment model; known: {', '.join(ABUTMENTS)}")
    return name


Skew = Annotated[int, Field(ge=-MAX_SKEW_DEG, le=MAX_SKEW_DEG)]
Gap = Annotated[int, Field(ge=0, le=MAX_GAP_MM)]
Friction = Annotated[
    float, Field(ge=0.0, le=MAX_FRICTION_PCT / 100), AfterValidator(_whole_hundredths)
]
Abutment = Annotated[str, AfterValidator(_known_abutment)]
Positive = Annotated[float, Field(gt=0.0)]


class _Section(BaseModel):
    # strict: "2e7", which YAML 1.1 reads as text, must not pass as a number
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class GridConfig(_Section):
    """The axes of the study; every combination is one bridge variant."""

    bridge: list[str] = Field(default=["osb1"], min_length=1, description="catalogue names")
    abutment: list[Abutment] = Field(
        default=["contact_friction"], min_length=1, description=f"of {', '.join(ABUTMENTS)}"
    )
    skew_deg: list[Skew] = Field(
        default=[0, 30, 60], min_length=1, description="skew, whole degrees"
    )
    gap_mm: list[Gap] = Field(
        default=[25, 51], min_length=1, description="longitudinal gap, whole mm"
    )
    friction: list[Friction] = Field(
        default=[0.0, 0.5], min_length=1, description="Coulomb coefficient, whole hundredths"
    )


class MotionsConfig(_Section):
    """Which ground motions, how strong and from which direction."""

    folder: str = Field(default="motions", description="folder with an index.csv or with motions")
    count: int | None = Field(
        default=16, ge=1, description="the first so many motions of the suite; null for all"
    )
    design: Literal["scaled_cloud", "cloud", "stripes", "ida"] = Field(
        default="scaled_cloud",
        description="scaled_cloud: one factor per motion; cloud: unscaled; stripes: every motion "
        "at every level; ida: search per motion for the first exceedance",
    )
    level_range_g: list[Positive] = Field(
        default=[0.1, 1.5],
        min_length=2,
        max_length=2,
        description="range of Sa_avg that scaled_cloud spans and ida searches, g",
    )
    stripes_g: list[Positive] = Field(
        default=[0.1, 0.2, 0.35, 0.55, 0.8, 1.1, 1.5],
        min_length=2,
        description="levels of Sa_avg of design stripes, rising, g",
    )
    factor_limits: list[Positive] = Field(
        default=[0.25, 4.0],
        min_length=2,
        max_length=2,
        description="smallest and largest factor of design stripes; beyond, a motion is left out",
    )
    ida_demand: str = Field(
        default="column_drift_ratio", description="demand that design ida searches with"
    )
    ida_threshold: Positive = Field(
        default=0.025, description="its limit, in the unit of the demands table"
    )
    shaking_s: Positive | None = Field(
        default=None, description="keep only the strongest part of this length, s; null for all"
    )
    incidence_deg: list[Annotated[float, Field(ge=0.0, lt=360.0)]] = Field(
        default=[0.0],
        min_length=1,
        description="angle from the bridge x axis to component 1, degrees",
    )

    @model_validator(mode="after")
    def _levels_rise(self) -> "MotionsConfig":
        for name in ("level_range_g", "stripes_g", "factor_limits"):
            values = getattr(self, name)
            if values != sorted(set(values)):
                raise ValueError(f"{name} must rise, got {values}")
        return self


class ModelConfig(_Section):
    """Modelling choices that are the same for every variant."""

    arrays: Literal["rigid", "corotational"] = Field(
        default="rigid", description="transverse arrays: rigid links or stiff corotational elements"
    )
    column_integration: Literal["hinge_radau", "lobatto5"] = Field(
        default="hinge_radau",
        description="column plasticity: hinge_radau, or lobatto5 as in the paper",
    )
    transverse_gap_mm: Annotated[float, Field(ge=0.0, le=500.0)] = Field(
        default=6.4, description="gap at the shear keys, mm"
    )
    cohesion_n: Annotated[float, Field(ge=0.0)] = Field(
        default=0.0, description="cohesion per contact, N"
    )
    backwall_points: Annotated[int, Field(ge=2, le=15)] = Field(
        default=5, description="contact points along one backwall, the corners included"
    )


class AnalysisConfig(_Section):
    """The transient analysis."""

    scheme: Literal["default", "paper"] = Field(
        default="default",
        description="default, or the paper's integrator, coupling, arrays and columns",
    )
    dt_s: Annotated[float, Field(gt=0.0, le=0.02)] = Field(
        default=0.005, description="time step, s"
    )
    duration_s: Positive | None = Field(
        default=None, description="cut every motion to this window, s; null for the whole motion"
    )
    free_vibration_s: Annotated[float, Field(ge=0.0)] = Field(
        default=0.0, description="zeros after the motion, s (the shipped suite has its 5 s inside)"
    )
    collapse_drift_ratio: Positive = Field(
        default=0.10, description="column drift that counts as collapse"
    )
    collapse_deck_disp_m: Positive = Field(
        default=2.0, description="deck displacement that counts as collapse, m"
    )


class FragilityConfig(_Section):
    """The fits."""

    im: str = Field(
        default="im_saavg_rotd50_g", description="intensity measure: an im_ column of demands"
    )
    limit_states: str = Field(
        default="config/limit_states.yaml", description="file with the limit states"
    )
    confidence: Annotated[float, Field(gt=0.5, lt=1.0)] = Field(
        default=0.95, description="confidence level of the intervals of the fits"
    )
    bootstrap: Annotated[int, Field(ge=99)] = Field(
        default=999, description="record-bootstrap replicates for the paired effects"
    )
    seed: int = Field(default=20261120, ge=0, description="seed of the bootstrap")


class SensitivityConfig(_Section):
    """Numerical check: penalties and time step halved and doubled on a few analyses."""

    motions: Annotated[int, Field(ge=0)] = Field(
        default=3,
        description="strongest so many motions, on the most skewed frictional variant; 0 for none",
    )


class StudyConfig(_Section):
    """The whole configuration."""

    results: Annotated[str, Field(min_length=1)] = Field(
        default=DEFAULT_ROOT, description="folder of everything that the study writes"
    )
    grid: GridConfig = Field(default_factory=GridConfig)
    motions: MotionsConfig = Field(default_factory=MotionsConfig)
    model: ModelConfig = Field(default_factory=ModelConfig)
    analysis: AnalysisConfig = Field(default_factory=AnalysisConfig)
    fragility: FragilityConfig = Field(default_factory=FragilityConfig)
    sensitivity: SensitivityConfig = Field(default_factory=SensitivityConfig)
