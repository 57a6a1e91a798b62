"""How an analysis integrates in time, and when it stops: section ``analysis``."""

from dataclasses import replace
from typing import Final, Literal, Self

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from skewbridge.reading import Number, Whole
from skewbridge.variant.options import ModelOptions

type Scheme = Literal["default", "paper"]
Command = tuple[str | float | int, ...]

PAPER_DT_S: Final = 0.005  # source: Rahman & Mackie, section 5

# Houbolt damps what rattles at the contacts: results repeat to 1e-7 when rounding changes, where
# Newmark and HHT differ by percents (docs/theory, comparison of the schemes).
_INTEGRATOR: Final = ("Houbolt",)  # source: Rahman & Mackie, section 5
_KNOWN: Final = (("Houbolt",), ("Newmark",), ("HHT",))


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class AnalysisSettings:
    """Numbers of the transient analysis; each field is a key of the configuration.

    Raises:
        ValidationError: A value is outside its limits (`skewbridge.reading.checked` says it in
            words).
    """

    scheme: Scheme = Field(
        default="default",
        description="default (Houbolt), or paper: the same at the paper's step, with lagged "
        "friction bounds, corotational arrays and distributed plasticity",
    )
    dt_s: Number = Field(default=PAPER_DT_S, ge=1.0e-5, le=0.02, description="time step")
    duration_s: Number | None = Field(
        default=None,
        gt=0.0,
        le=1.0e4,
        description="cut every motion to this window; null for the whole motion",
    )
    free_vibration_s: Number = Field(
        default=0.0,
        ge=0.0,
        le=1.0e3,
        description="zeros after the motion (the shipped suite has its 5 s inside)",
    )
    collapse_drift_ratio: Number = Field(
        default=0.10,  # source: design criterion of the study
        ge=1.0e-4,
        le=0.5,
        description="column drift that counts as collapse",
    )
    collapse_deck_disp_m: Number = Field(
        default=2.0,  # source: design criterion of the study
        ge=1.0e-3,
        le=5.0,
        description="deck displacement that counts as collapse",
    )
    integrator: Command | None = Field(
        default=None,
        description="arguments of the OpenSees integrator that replaces the scheme's, for "
        "example [Newmark, 0.5, 0.25]; null for the scheme's",
    )
    tolerance_j: Number = Field(
        default=1.0e-8,
        ge=1.0e-16,
        le=1.0e3,
        description="convergence test on the energy of an increment; demands are insensitive to "
        "it, symmetry and repeatability under rounding are not",
    )
    max_iterations: Whole = Field(
        default=30, ge=2, le=1000, description="iterations of one attempt at one step"
    )
    mean_iterations: Number = Field(
        default=25.0,
        ge=1.0,
        le=1.0e4,
        description="budget of the whole analysis, in iterations per regular step; one that needs "
        "more ends with timeout (seconds would not repeat)",
    )
    energy: bool = Field(
        default=True,
        strict=True,
        description="whether to keep the energy balance (about 5 % of the time)",
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.duration_s is not None and self.duration_s < self.dt_s:
            raise ValueError(f"duration_s must be at least dt_s, got {self.duration_s:g}")
        if self.integrator is not None and self.integrator[:1] not in _KNOWN:
            raise ValueError(f"integrator must be Houbolt, Newmark or HHT, got {self.integrator}")
        if self.scheme == "paper" and self.dt_s != PAPER_DT_S:
            raise ValueError(f"dt_s is fixed at {PAPER_DT_S:g} in scheme paper, got {self.dt_s:g}")
        return self

    @property
    def integrator_command(self) -> Command:
        """Arguments of the integrator command."""
        return self.integrator or _INTEGRATOR

    def model_options(self, options: ModelOptions) -> ModelOptions:
        """Return the modelling options under the scheme: the paper's replace the given ones."""
        if self.scheme == "default":
            return options
        return replace(
            options, arrays="corotational", column_integration="lobatto5", coupling="lagged"
        )
