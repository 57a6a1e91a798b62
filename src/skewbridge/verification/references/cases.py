"""Cases of `skewbridge contact` and `skewbridge deck`, and the tabulated deck cases C1 to C5.

The fields of a case file are checked when it is read. docs/theory/verification.md uses the same
names C1 to C5.
"""

from math import cos, pi, radians, sqrt
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from skewbridge.errors import InputError
from skewbridge.files.text import FileName, checked, read_csv, read_mapping
from skewbridge.units import G_MPS2

# Limits far outside physical cases keep powers of the numbers from overflowing.
Length = Annotated[float, Field(ge=1.0e-6, le=1.0e6)]
Gap = Annotated[float, Field(ge=0.0, le=1.0e6)]
Period = Annotated[float, Field(ge=1.0e-5, le=1.0e5)]
Stiffness = Annotated[float, Field(ge=1.0e-6, le=1.0e18)]
Force = Annotated[float, Field(ge=0.0, le=1.0e15)]
Friction = Annotated[float, Field(ge=0.0, le=1.0e3)]
MAX_STEPS = 5_000_000
MAX_PATH = 1.0e6  # s and m
PATH_COLUMNS = ("t_s", "ux_m", "uy_m", "uz_m")


class _Case(BaseModel):
    # Strict: YAML reads 2e7 (without a point and a sign) as text, which must not pass unnoticed.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class ContactCase(_Case):
    """A contact unit driven along a displacement path."""

    normal_stiffness_n_per_m: Stiffness
    tangent_stiffness_n_per_m: Stiffness
    friction: Friction
    cohesion_n: Force = 0.0
    gap_m: Gap = 0.0
    scheme: Literal["vector", "componentwise", "elastic"] = "vector"
    coupling: Literal["extrapolated", "lagged"] = "extrapolated"
    substeps: Annotated[int, Field(ge=1, le=100_000)] = 10
    path: FileName


class PulseCase(_Case):
    """A cosine pulse of one period along the deck."""

    kind: Literal["cosine"]
    amplitude_g: Annotated[float, Field(ge=1.0e-9, le=1.0e6)]
    period_s: Period


class DeckCase(_Case):
    """A rigid skew deck between two abutments (docs/theory/verification.md), skewed clockwise."""

    length_m: Length
    width_m: Length
    skew_deg: Annotated[float, Field(ge=-80.0, le=80.0)]
    mass_kg: Annotated[float, Field(ge=1.0e-6, le=1.0e12)]
    period_x_s: Period
    period_y_s: Period
    period_theta_s: Period
    damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.05
    gap_normal_m: Gap
    friction: Friction = 0.0
    cohesion_n: Force = 0.0
    normal_stiffness_n_per_m: Stiffness
    tangent_stiffness_n_per_m: Stiffness | None = None
    # a lower one needs dashpots that the steps of the penalty equation do not resolve
    restitution: Annotated[float, Field(ge=1.0e-3, le=1.0)] | None = None
    solver: Literal["opensees", "penalty", "lcp"] = "opensees"
    coupling: Literal["extrapolated", "lagged"] = "extrapolated"
    integrator: Literal["newmark", "houbolt", "hht"] = "newmark"
    dt_s: Annotated[float, Field(ge=1.0e-9, le=1.0e3)]
    duration_s: Annotated[float, Field(ge=1.0e-9, le=1.0e5)]
    pulse: PulseCase | None = None
    motion: tuple[FileName, FileName] | None = Field(default=None, strict=False)

    @model_validator(mode="after")
    def _one_excitation(self) -> Self:
        if (self.pulse is None) == (self.motion is None):
            raise ValueError("give either pulse or motion, not both or neither")
        if self.dt_s > self.duration_s:
            longest = f"duration_s = {self.duration_s}"
            raise ValueError(f"dt_s must be at most {longest}, got {self.dt_s}")
        if (steps := self.duration_s / self.dt_s) > MAX_STEPS:
            limit = f"at most {MAX_STEPS} steps"
            raise ValueError(f"duration_s / dt_s must be {limit}, got {steps:.3g}")
        return self

    @property
    def kt_n_per_m(self) -> float:
        """Tangential stiffness; the normal stiffness if it is not given."""
        return self.tangent_stiffness_n_per_m or self.normal_stiffness_n_per_m

    @property
    def contact_frequency_rad_per_s(self) -> float:
        """Circular frequency of the deck mass on the two normal springs of one end."""
        return (2.0 * self.normal_stiffness_n_per_m / self.mass_kg) ** 0.5


def read_case[Case: _Case](file: Path, kind: type[Case]) -> Case:
    """Read a case file; raises `InputError` for a missing or invalid file or field."""
    return checked(kind, read_mapping(file), file)


def file_of_case(case_file: Path, name: str) -> Path:
    """Return the path of a file of a case, in the folder of the case or the working folder."""
    candidate = case_file.parent / name
    return candidate if candidate.is_file() or not Path(name).is_file() else Path(name)


def read_path(file: Path) -> NDArray[np.float64]:
    """Read a displacement path, shape (rows, 4), with the columns t_s, ux_m, uy_m and uz_m.

    `InputError` names a missing column, or the line of an invalid value or time.
    """
    table = read_csv(file)
    if missing := [column for column in PATH_COLUMNS if column not in table.columns]:
        columns = ", ".join(PATH_COLUMNS)
        raise InputError(f"path {file} must have the columns {columns}; it lacks {missing}")
    numbers = table[list(PATH_COLUMNS)].apply(pd.to_numeric, errors="coerce")
    values = numbers.to_numpy(dtype=np.float64)
    if len(values) < 2:
        raise InputError(f"path {file} needs at least two rows, got {len(values)}")
    for row, column in np.argwhere(~(np.abs(values) <= MAX_PATH)).tolist():
        line, text = row + 2, f"{PATH_COLUMNS[column]} is not a number of at most {MAX_PATH:g}"
        raise InputError(f"path {file}, line {line}: {text}", line=line)
    for row in np.flatnonzero(np.diff(values[:, 0]) <= 0.0).tolist():
        line, text = row + 3, f"t_s must increase in every row, got {values[row + 1, 0]:g}"
        raise InputError(f"path {file}, line {line}: {text}", line=line)
    return values


# source: half of g = 9.81 m/s2 and the 0.5 s pulse of the paper's Fig 4. The reference values use
# the same pulse.
PULSE_MPS2: Final = 4.905
PULSE_PERIOD_S: Final = 0.5
LENGTH_M: Final = 30.0
# Displacements are divided by this length: pulse amplitude / (its circular frequency)^2.
SCALE_M: Final = PULSE_MPS2 / (2.0 * pi / PULSE_PERIOD_S) ** 2
# Width (m), skew (deg) and friction of the tabulated cases.
CASES: Final = {
    "C1": (15.0, 30.0, 0.0),
    "C2": (15.0, 30.0, 0.2),
    "C3": (10.0, 30.0, 0.0),
    "C4": (10.0, 30.0, 0.2),
    "C5": (10.0, 45.0, 0.2),
}


def bearing_fields(
    length_m: float, width_m: float, skew_deg: float, period_s: float
) -> dict[str, float]:
    """Return plan and periods (fields of `DeckCase`) of a deck on bearings at its skewed ends."""
    skew = radians(skew_deg)
    radius2 = (length_m**2 + (width_m / cos(skew)) ** 2) / 12.0
    spread2 = length_m**2 / 4.0 + (width_m / cos(skew)) ** 2 / 12.0
    plan = {"length_m": length_m, "width_m": width_m, "skew_deg": skew_deg}
    periods = {"period_x_s": period_s, "period_y_s": period_s}
    return plan | periods | {"period_theta_s": period_s * sqrt(radius2 / spread2)}


def deck_case(name: str, **changes: Any) -> DeckCase:
    """Return a tabulated case with 1000 kg, Kn = 1e7 N/m, bearing period 0.5 s and 5 % damping."""
    width_m, skew_deg, friction = CASES[name]
    # ASSUME mass, periods and damping: the paper does not give them.
    # ASSUME the dimensionless gap 0.1 of the paper is measured along the deck.
    fields: dict[str, Any] = {
        "mass_kg": 1000.0,
        "damping_ratio": 0.05,
        "gap_normal_m": 0.1 * SCALE_M * cos(radians(skew_deg)),
        "friction": friction,
        "normal_stiffness_n_per_m": 1.0e7,
        "dt_s": 1.0e-4,
        "duration_s": 2.0,
        "pulse": PulseCase(kind="cosine", amplitude_g=PULSE_MPS2 / G_MPS2, period_s=PULSE_PERIOD_S),
    }
    plan = bearing_fields(LENGTH_M, width_m, skew_deg, period_s=0.5)
    return DeckCase.model_validate(plan | fields | changes)
