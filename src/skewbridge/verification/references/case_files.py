"""Case files of `skewbridge contact` and `skewbridge deck`: typed, with clear errors."""

from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from skewbridge.errors import InputError
from skewbridge.reading import checked, read_mapping

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]

PATH_COLUMNS = ("t_s", "ux_m", "uy_m", "uz_m")


class _Case(BaseModel):
    # Strict: YAML reads 2e7 (without a point and a sign) as text, which must not pass unnoticed.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class ContactCase(_Case):
    """A unit process driven along a displacement path."""

    normal_stiffness_n_per_m: Positive
    tangent_stiffness_n_per_m: Positive
    friction: NotNegative
    cohesion_n: NotNegative = 0.0
    gap_m: NotNegative = 0.0
    scheme: Literal["vector", "componentwise", "elastic"] = "vector"
    coupling: Literal["extrapolated", "lagged"] = "extrapolated"
    substeps: Annotated[int, Field(ge=1, le=100_000)] = 10
    path: str


class PulseCase(_Case):
    """A cosine pulse of one period along the deck."""

    kind: Literal["cosine"]
    amplitude_g: Positive
    period_s: Positive


class DeckCase(_Case):
    """A rigid skew deck between two abutments; section 6 of the design and docs/theory."""

    length_m: Positive
    width_m: Positive
    skew_deg: Annotated[float, Field(ge=-80.0, le=80.0)]
    mass_kg: Positive
    period_x_s: Positive
    period_y_s: Positive
    period_theta_s: Positive
    damping_ratio: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.05
    gap_normal_m: NotNegative
    friction: NotNegative = 0.0
    cohesion_n: NotNegative = 0.0
    normal_stiffness_n_per_m: Positive
    tangent_stiffness_n_per_m: Positive | None = None
    restitution: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    solver: Literal["opensees", "penalty", "lcp"] = "opensees"
    coupling: Literal["extrapolated", "lagged"] = "extrapolated"
    integrator: Literal["newmark", "houbolt", "hht"] = "newmark"
    dt_s: Positive
    duration_s: Positive
    pulse: PulseCase | None = None
    motion: tuple[str, str] | None = Field(default=None, strict=False)

    @model_validator(mode="after")
    def _one_excitation(self) -> Self:
        if (self.pulse is None) == (self.motion is None):
            raise ValueError("give either pulse or motion")
        if self.dt_s > self.duration_s:
            raise ValueError(
                f"dt_s must be at most duration_s = {self.duration_s}, got {self.dt_s}"
            )
        return self

    @property
    def kt_n_per_m(self) -> float:
        """Tangential stiffness, that of the normal spring unless given."""
        return self.tangent_stiffness_n_per_m or self.normal_stiffness_n_per_m


def read_case[Case: _Case](file: Path, kind: type[Case]) -> Case:
    """Read a case file.

    Raises:
        InputError: The file is missing, is no YAML mapping, or a field is wrong.
    """
    return checked(kind, read_mapping(file), file)


def beside(case_file: Path, name: str) -> Path:
    """Return the file that a case names: beside the case, or from the working folder."""
    candidate = case_file.parent / name
    return candidate if candidate.exists() or not Path(name).exists() else Path(name)


def read_path(file: Path) -> NDArray[np.float64]:
    """Read a displacement path: columns t_s, ux_m, uy_m, uz_m; one row per time.

    Raises:
        InputError: The file is missing, a column is missing, a value is not a number, or the time
            does not increase.
    """
    try:
        table = pd.read_csv(file, skipinitialspace=True)
    except OSError as error:
        raise InputError(f"cannot read path {file}: {error.strerror}") from error
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise InputError(f"path {file} is not a table: {error}") from error
    missing = [column for column in PATH_COLUMNS if column not in table.columns]
    if missing:
        raise InputError(
            f"path {file} must have the columns {', '.join(PATH_COLUMNS)}; missing {missing}"
        )
    numbers = table[list(PATH_COLUMNS)].apply(pd.to_numeric, errors="coerce")
    values = numbers.to_numpy(dtype=np.float64)
    if len(values) < 2:
        raise InputError(f"path {file} needs at least two rows, got {len(values)}")
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, column = (int(index) for index in bad[0])
        raise InputError(
            f"path {file}, line {row + 2}: {PATH_COLUMNS[column]} is not a finite number",
            line=row + 2,
        )
    back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if len(back):
        line = int(back[0]) + 3
        raise InputError(
            f"path {file}, line {line}: t_s must increase, got {values[back[0] + 1, 0]:g}",
            line=line,
        )
    return values
