"""How an analysis integrates in time, and when it stops."""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

from skewbridge.bridge.options import ModelOptions
from skewbridge.errors import InputError

type Scheme = Literal["default", "paper"]
type Command = tuple[str | float | int, ...]

PAPER_DT_S: Final = 0.005  # source: Rahman & Mackie, section 5

# Houbolt damps what rattles at the contacts: results repeat to 1e-7 when rounding changes, where
# Newmark and HHT differ by percents (docs/theory, comparison of the schemes).
_INTEGRATORS: Final[dict[str, Command]] = {
    "default": ("Houbolt",),
    "paper": ("Houbolt",),  # source: Rahman & Mackie, section 5
}


@dataclass(frozen=True, slots=True, kw_only=True)
class AnalysisSettings:
    """Numbers of the transient analysis.

    Attributes:
        scheme: ``default`` (Houbolt), or ``paper`` for the same at the paper's step, with lagged
            friction bounds, corotational arrays and distributed plasticity.
        dt_s: Time step.
        duration_s: Cut the motion to this window; None for the whole motion.
        free_vibration_s: Time without excitation after the motion.
        collapse_drift_ratio: Column drift that counts as collapse.
        collapse_deck_disp_m: Deck displacement that counts as collapse.
        integrator: Command that replaces the scheme's, for studies of the integrators.
        tolerance_j: Convergence test on the energy of an increment. Demands are insensitive to
            it, but symmetry and repeatability under rounding are not.
        max_iterations: Of one attempt at one step.
        mean_iterations: Budget of the whole analysis, in iterations per regular step: an analysis
            that needs more ends with ``timeout``. Seconds would not repeat.
        energy: Whether to keep the energy balance (about 5 % of the time).

    Raises:
        InputError: A number is outside its limits.
    """

    scheme: Scheme = "default"
    dt_s: float = PAPER_DT_S
    duration_s: float | None = None
    free_vibration_s: float = 0.0
    collapse_drift_ratio: float = 0.10  # source: design criterion of the study
    collapse_deck_disp_m: float = 2.0  # source: design criterion of the study
    integrator: Command | None = None
    tolerance_j: float = 1.0e-8
    max_iterations: int = 30
    mean_iterations: float = 25.0
    energy: bool = True

    def __post_init__(self) -> None:
        if self.scheme not in _INTEGRATORS:
            raise InputError(f"scheme must be default or paper, got {self.scheme!r}")
        duration_s = self.dt_s if self.duration_s is None else self.duration_s
        for field, value, low, high in (
            ("dt_s", self.dt_s, 1.0e-5, 0.02),
            ("duration_s", duration_s, self.dt_s, 1.0e4),
            ("free_vibration_s", self.free_vibration_s, 0.0, 1.0e3),
            ("collapse_drift_ratio", self.collapse_drift_ratio, 1.0e-4, 0.5),
            ("collapse_deck_disp_m", self.collapse_deck_disp_m, 1.0e-3, 5.0),
            ("tolerance_j", self.tolerance_j, 1.0e-16, 1.0e3),
            ("max_iterations", self.max_iterations, 2, 1000),
            ("mean_iterations", self.mean_iterations, 1.0, 1.0e4),
        ):
            if not (math.isfinite(value) and low <= value <= high):
                raise InputError(f"{field} must be within {low:g}..{high:g}, got {value:g}")
        if self.scheme == "paper" and self.dt_s != PAPER_DT_S:
            raise InputError(f"dt_s is fixed at {PAPER_DT_S:g} in scheme paper, got {self.dt_s:g}")

    @property
    def integrator_command(self) -> Command:
        """Arguments of the integrator command."""
        return self.integrator or _INTEGRATORS[self.scheme]

    def model_options(self, options: ModelOptions) -> ModelOptions:
        """Return the modelling options under the scheme: the paper's replace the given ones."""
        if self.scheme == "default":
            return options
        return replace(
            options, arrays="corotational", column_integration="lobatto5", coupling="lagged"
        )
