"""Numerical settings of an analysis (section ``analysis``), and named sets of settings."""

from collections.abc import Mapping
from dataclasses import replace
from math import ceil, log2
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self, get_args

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from skewbridge.errors import InputError
from skewbridge.files.text import OPTIONS, Flag, Number, merged, read_mapping
from skewbridge.variant.options import ModelOptions

type AnalysisScheme = Literal["default", "paper"]
type Accuracy = Literal["reference", "default", "fast"]
OpenSeesCommand = tuple[str | float | int, ...]
Step = Annotated[Number, Field(ge=1.0e-5, le=0.02)]

PAPER_DT_S: Final = 0.005  # source: Rahman & Mackie, section 5

# A one-step method allows a different step size at every event. With velocities as unknowns, a step
# is predicted at the last velocity, which needs fewer iterations than a prediction at rest.
_INTEGRATOR: Final = ("Newmark", 0.5, 0.25, "-form", "V")
_PAPER_INTEGRATOR: Final = ("Houbolt",)  # source: Rahman & Mackie, section 5

#: Named sets of numerics: the keys of sections ``analysis`` and ``model`` that each set changes.
NUMERICS: Final = read_mapping(Path(__file__).with_name("numerics.yaml"))


@dataclass(frozen=True, slots=True, kw_only=True, config=OPTIONS)
class AnalysisSettings:
    """Settings of the transient analysis; each field is a key of the configuration."""

    scheme: AnalysisScheme = Field(default="default")
    """paper: numerics and wall model of the paper"""
    dt_s: Step = Field(default=0.010)
    """regular time step; fixed at 0.005 in scheme paper"""
    contact_dt_s: Step | None = Field(default=0.005)
    """largest step in contact, rounded down to dt_s / 2^k; null (scheme paper): dt_s"""
    event_dt_s: Step | None = Field(default=0.0003125)
    """largest step when a contact opens or closes"""
    max_friction_error: Number = Field(default=0.015, ge=1.0e-4, le=1.0e9)
    """relative error of sliding friction above which steps in contact are halved"""
    duration_s: Number | None = Field(default=None, gt=0.0, le=1.0e4)
    """shorten motions to this length; null: full length"""
    free_vibration_s: Number = Field(default=0.0, ge=0.0, le=1.0e3)
    """time without input after the motion"""
    # source: design criterion of the study, for both collapse limits
    collapse_drift_ratio: Number = Field(default=0.10, ge=1.0e-4, le=0.5)
    """column drift that counts as collapse"""
    collapse_deck_disp_m: Number = Field(default=2.0, ge=1.0e-3, le=5.0)
    """deck displacement that counts as collapse"""
    integrator: OpenSeesCommand | None = Field(default=None)
    """OpenSees command, such as [Newmark, 0.5, 0.25]; null: set by the scheme"""
    tolerance_j: Number = Field(default=1.0e-4, ge=1.0e-16, le=1.0e3)
    """tolerance of the convergence test on energy increments"""
    reuse_tangent: Flag = Field(default=True)
    """far from contact, use an earlier tangent and converge to 0.1 J"""

    @model_validator(mode="before")
    @classmethod
    def _paper(cls, raw: ArgsKwargs | dict[str, object] | object) -> object:
        """Fill in the constant step of scheme paper for keys that are not given."""
        if not isinstance(raw, ArgsKwargs | dict):
            return raw
        values = dict(raw.kwargs or {}) if isinstance(raw, ArgsKwargs) else dict(raw)
        if values.get("scheme") == "paper":
            paper_steps = {"dt_s": PAPER_DT_S, "contact_dt_s": None, "event_dt_s": None}
            values = {**paper_steps, "reuse_tangent": False, **values}
        return ArgsKwargs((), values) if isinstance(raw, ArgsKwargs) else values

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.duration_s is not None and self.duration_s < self.dt_s:
            raise ValueError(f"duration_s must be at least dt_s, got {self.duration_s:g}")
        if self.integrator is not None and not _is_known(self.integrator):
            allowed = "[Houbolt], [Newmark, gamma >= 0.5, beta > 0] or [HHT, alpha from 2/3 to 1]"
            raise ValueError(f"integrator must be {allowed}, got {list(self.integrator)}")
        if self.scheme == "paper" and self.dt_s != PAPER_DT_S:
            raise ValueError(f"dt_s is fixed at {PAPER_DT_S:g} in scheme paper, got {self.dt_s:g}")
        return self

    @property
    def integrator_command(self) -> OpenSeesCommand:
        """Arguments of the integrator command."""
        return self.integrator or (_PAPER_INTEGRATOR if self.scheme == "paper" else _INTEGRATOR)

    @property
    def contact_halvings(self) -> int:
        """Number of halvings of a regular step while a contact is closed."""
        return _halvings(self.dt_s, self.contact_dt_s)

    @property
    def event_halvings(self) -> int:
        """Number of halvings of a regular step when a contact is about to open or close."""
        return max(_halvings(self.dt_s, self.event_dt_s), self.contact_halvings)

    def increment_s(self, dt_s: float) -> float:
        """Return displacement per unknown: 1, or beta dt / gamma (s) if velocities are unknowns."""
        if self.integrator_command[-2:] != ("-form", "V"):
            return 1.0
        gamma, beta = self.integrator_command[1:3]
        return float(beta) / float(gamma) * dt_s

    def model_options(self, options: ModelOptions) -> ModelOptions:
        """Return the modelling options; scheme paper overrides the options that the paper fixes."""
        if self.scheme == "default":
            return options
        return replace(
            options,
            arrays="corotational",
            column_integration="lobatto5",
            coupling="lagged",
            wall_mass=True,
            backfill_vs_mps=None,  # the paper names no radiation damping
            backfill_dashpot="parallel",
            wall_restoring_n_per_m=3.0e5,
            backfill_height_exponent=1.0,
            backfill_skew="strength_and_stiffness",
            key_along_face="elastic",
            key_frame="skewed",  # the paper's loops are in the local axes of the abutment
            # with distributed plasticity, strains localise in a twentieth of the height
            fiber_end="none",
        )


def _halvings(step_s: float, largest_s: float | None) -> int:
    """Return the smallest number of halvings of a step that makes it at most ``largest_s``."""
    return 0 if largest_s is None else max(0, ceil(log2(step_s / largest_s) - 1e-9))


def under_explicit_keys(raw: Mapping[str, Any], accuracy: object) -> dict[str, Any]:
    """Return configuration sections filled with a set of numerics; explicit keys override it."""
    if accuracy not in NUMERICS:
        accuracies = ", ".join(get_args(Accuracy.__value__))
        raise InputError(f"accuracy must be one of {accuracies}, got {accuracy!r}")
    return merged(NUMERICS[str(accuracy)], raw)


def at_accuracy(
    settings: AnalysisSettings, options: ModelOptions, accuracy: Accuracy
) -> tuple[AnalysisSettings, ModelOptions]:
    """Return settings and options with the keys of a set of numerics replaced."""
    numerics = NUMERICS[accuracy]
    return replace(settings, **numerics["analysis"]), replace(options, **numerics["model"])


def _is_known(integrator: OpenSeesCommand) -> bool:
    """Return whether a command has its parameters: OpenSees replaces others by its default."""
    match integrator:
        case ("Houbolt",):
            return True
        case ("Newmark", (float() | int()) as gamma, (float() | int()) as beta, *form):
            is_form = form in ([], *(["-form", unknown] for unknown in "DV"))
            return gamma >= 0.5 and beta > 0.0 and is_form
        case ("HHT", (float() | int()) as alpha):
            return 2.0 / 3.0 <= alpha <= 1.0
        case _:
            return False
