"""Settings of the time integration and of its end: section ``analysis``."""

from dataclasses import replace
from math import ceil, log2
from typing import Final, Literal, Self

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from skewbridge.files.text import Flag, Number, Whole
from skewbridge.variant.options import ModelOptions

type AnalysisScheme = Literal["default", "paper"]
OpenSeesCommand = tuple[str | float | int, ...]

PAPER_DT_S: Final = 0.005  # source: Rahman & Mackie, section 5

# A one-step method may change its step at every event. With velocities as unknowns, a step starts
# from the continued motion of the last one, which needs fewer iterations than a start from rest.
_INTEGRATOR: Final = ("Newmark", 0.5, 0.25, "-form", "V")
_PAPER_INTEGRATOR: Final = ("Houbolt",)  # source: Rahman & Mackie, section 5
_KNOWN: Final = (("Houbolt",), ("Newmark",), ("HHT",))


@dataclass(frozen=True, slots=True, kw_only=True, config=ConfigDict(extra="forbid"))
class AnalysisSettings:
    """Numbers of the transient analysis; each field is a key of the configuration.

    Raises:
        ValidationError: A value is outside its limits (`files.text.checked` turns it into
            an `InputError`).
    """

    scheme: AnalysisScheme = Field(
        default="default",
        description="paper: numerics and wall model of the paper",
    )
    dt_s: Number = Field(
        default=0.010,
        ge=1.0e-5,
        le=0.02,
        description=f"regular time step; fixed at {PAPER_DT_S:g} in scheme paper",
    )
    contact_dt_s: Number | None = Field(
        default=0.005,
        ge=1.0e-5,
        le=0.02,
        description="largest step in contact, the regular step over a power of two; null (scheme "
        "paper): the regular step",
    )
    event_dt_s: Number | None = Field(
        default=0.0003125,
        ge=1.0e-5,
        le=0.02,
        description="largest step when a contact opens or closes",
    )
    max_friction_error: Number = Field(
        default=0.02,
        ge=1.0e-4,
        le=1.0e9,
        description="excess of friction over its limit above which steps in contact are halved",
    )
    duration_s: Number | None = Field(
        default=None,
        gt=0.0,
        le=1.0e4,
        description="shorten motions to this length; null: whole motions",
    )
    free_vibration_s: Number = Field(
        default=0.0,
        ge=0.0,
        le=1.0e3,
        description="zeros after the motion",
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
    integrator: OpenSeesCommand | None = Field(
        default=None,
        description="such as [Newmark, 0.5, 0.25]; null: the integrator of the scheme",
    )
    tolerance_j: Number = Field(
        default=1.0e-4,
        ge=1.0e-16,
        le=1.0e3,
        description="convergence test on the energy of an increment",
    )
    reuse_tangent: Flag = Field(
        default=True,
        description="far from contact, use an earlier tangent and converge to 0.1 J",
    )
    max_iterations: Whole = Field(
        default=15, ge=2, le=1000, description="iterations of one attempt at one step"
    )
    mean_iterations: Number = Field(
        default=40.0,
        ge=1.0,
        le=1.0e4,
        description="iterations per regular step above which the status is timeout",
    )
    energy: Flag = Field(
        default=True,
        description="keep the energy balance (2 to 3 % of the time)",
    )

    @model_validator(mode="before")
    @classmethod
    def _paper(cls, given: ArgsKwargs | dict[str, object] | object) -> object:
        """Let the scheme of the paper bring its one step."""
        if not isinstance(given, ArgsKwargs | dict):
            return given
        values = dict(given.kwargs or {}) if isinstance(given, ArgsKwargs) else dict(given)
        if values.get("scheme") == "paper":
            steps = {"dt_s": PAPER_DT_S, "contact_dt_s": None, "event_dt_s": None}
            values = {**steps, "reuse_tangent": False, **values}
        return ArgsKwargs((), values) if isinstance(given, ArgsKwargs) else values

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
    def integrator_command(self) -> OpenSeesCommand:
        """Arguments of the integrator command."""
        return self.integrator or (_PAPER_INTEGRATOR if self.scheme == "paper" else _INTEGRATOR)

    @property
    def contact_halvings(self) -> int:
        """How often a regular step is halved while a contact is closed."""
        return _halvings(self.dt_s, self.contact_dt_s)

    @property
    def event_halvings(self) -> int:
        """How often a regular step is halved where a contact is about to open or to close."""
        return max(_halvings(self.dt_s, self.event_dt_s), self.contact_halvings)

    def increment_s(self, dt_s: float) -> float:
        """Return the factor from the unknowns to displacements: 1, or a time for velocities."""
        if self.integrator_command[-2:] != ("-form", "V"):
            return 1.0
        gamma, beta = self.integrator_command[1:3]
        return float(beta) / float(gamma) * dt_s

    def model_options(self, options: ModelOptions) -> ModelOptions:
        """Return the modelling options under the scheme: the paper's replace the given ones."""
        if self.scheme == "default":
            return options
        return replace(
            options,
            arrays="corotational",
            column_integration="lobatto5",
            coupling="lagged",
            wall_mass=True,
            backfill_vs_mps=None,  # the paper names no radiation damping
            backfill_height_exponent=1.0,
            key_along_face="elastic",
            key_frame="skewed",  # the paper's loops are in the local axes of the abutment
            # strains of distributed plasticity localise in a twentieth of the height
            fiber_end="none",
        )


def _halvings(step_s: float, largest_s: float | None) -> int:
    """Return the fewest halvings of a step that leave no more than the largest one."""
    return 0 if largest_s is None else max(0, ceil(log2(step_s / largest_s) - 1e-9))
