"""A two-component ground motion in SI units, with its metadata."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from skewbridge.errors import InputError

type Vector = NDArray[np.float64]

#: Metadata columns of a motion in tables.
TEXT_FIELDS: Final = ("motion_id", "sha256", "event", "station", "source")
NUMBER_FIELDS: Final = (
    "dt_s", "magnitude", "distance_km", "vs30_mps", "azimuth_1_deg", "azimuth_2_deg",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundMotion:
    """Two horizontal acceleration components of equal length and time step.

    Component 1 is applied along the bridge axis x (longitudinal) and component 2 along y
    (transverse) at incidence 0. The arrays, shape (npts,), are read-only. Unknown numbers of the
    metadata are nan. Raises `InputError` for components of different length, a time step that is
    not positive, or a value that is not finite.
    """

    motion_id: str
    dt_s: float
    accel_1_mps2: Vector
    accel_2_mps2: Vector
    event: str = ""  #: name of the earthquake, or of the model for a synthetic motion
    magnitude: float = nan
    distance_km: float = nan  #: closest distance to the rupture
    vs30_mps: float = nan  #: average shear-wave velocity of the upper 30 m
    station: str = ""
    azimuth_1_deg: float = nan  #: compass direction of component 1
    azimuth_2_deg: float = nan
    source: str = ""  #: licence and origin
    sha256: str = ""  #: SHA-256 of the bytes of both component files, component 1 first
    files: tuple[str, ...] = ()
    messages: tuple[str, ...] = ()  #: messages of the reader

    def __post_init__(self) -> None:
        if not (np.isfinite(self.dt_s) and self.dt_s > 0.0):
            raise InputError(f"motion {self.motion_id}: dt_s must be positive, got {self.dt_s}")
        for name in ("accel_1_mps2", "accel_2_mps2"):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.ndim != 1 or values.size < 2:
                raise InputError(f"motion {self.motion_id}: {name} needs at least 2 values")
            if (bad := np.flatnonzero(~np.isfinite(values))).size:
                wrong = f"{name}[{bad[0]}] is {values[bad[0]]}"
                raise InputError(f"motion {self.motion_id}: {wrong}; every value must be finite")
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        npts_1, npts_2 = (accel.size for accel in self.components)
        if npts_1 != npts_2:
            text = f"the components have {npts_1} and {npts_2} values; both need the same number"
            raise InputError(f"motion {self.motion_id}: {text}")

    @property
    def npts(self) -> int:
        """Number of values per component."""
        return int(self.accel_1_mps2.size)

    @property
    def components(self) -> tuple[Vector, Vector]:
        """Both components in m/s2."""
        return self.accel_1_mps2, self.accel_2_mps2

    @property
    def duration_s(self) -> float:
        """Time of the last value in s; the first value is at 0."""
        return (self.npts - 1) * self.dt_s

    def npts_until(self, time_s: float) -> int:
        """Return how many values a motion keeps that is cut at a time: up to the next value."""
        return ceil(time_s / self.dt_s - 1e-9) + 1

    def scaled(self, factor: float) -> "GroundMotion":
        """Return the motion multiplied by a factor, which must be positive and finite."""
        if not (np.isfinite(factor) and factor > 0.0):
            raise InputError(f"scale must be a positive number, got {factor}")
        return self.mapped(lambda accel: accel * factor)

    def along_axes(self, incidence_deg: float = 0.0) -> tuple[Vector, Vector]:
        """Return the accelerations along the bridge axes x and y in m/s2, each of shape (npts,).

        The motion is rotated counter-clockwise by the incidence, seen from above: component 1 is
        along x at 0 degrees and along y at 90 degrees.
        """
        quarter = incidence_deg % 360.0 / 90.0
        if quarter == int(quarter):  # exact at right angles: no 6e-17 of the other component
            cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[int(quarter)]
        else:
            angle_rad = np.deg2rad(incidence_deg)
            cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
        accel_1, accel_2 = self.components
        return cosine * accel_1 - sine * accel_2, sine * accel_1 + cosine * accel_2

    def mapped(self, treat: Callable[[Vector], Vector]) -> "GroundMotion":
        """Return the motion with a function applied to each component."""
        return self.with_components(*map(treat, self.components))

    def with_components(self, accel_1_mps2: Vector, accel_2_mps2: Vector) -> "GroundMotion":
        """Return a copy of the motion with new accelerations and the same metadata."""
        return replace(self, accel_1_mps2=accel_1_mps2, accel_2_mps2=accel_2_mps2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SuiteMotion:
    """An unscaled motion, its scale factor, and the intensity measures of the scaled motion.

    All variants use the same factor. `number` is the position in the suite, from 0.
    """

    motion: GroundMotion
    scale: float
    measures: dict[str, float]
    suite: str = ""
    number: int = 0
