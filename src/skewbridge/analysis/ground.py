"""Excitation of an analysis: motion, scale factor, and direction relative to the bridge axes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil, isfinite
from typing import Final

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.handles import TagAllocator
from skewbridge.errors import InputError
from skewbridge.motions.record import GroundMotion

MAX_SCALED_ACCEL_MPS2: Final = 1.0e3  # 100 g: a larger value means a wrong unit


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Excitation:
    """Ground motion of an analysis, with its factor and direction.

    At incidence 0, component 1 points along x; incidence is counter-clockwise. With `supports`,
    each support has the motion of its name (`skewbridge.analysis.supports`), along the axes of the
    bridge, and `motion` is that of the support of the mass centre. Raises `InputError` if a number
    is not finite or the scale is not positive.
    """

    motion: GroundMotion
    scale: float = 1.0
    incidence_deg: float = 0.0
    supports: Mapping[str, GroundMotion] = field(default_factory=dict[str, GroundMotion])

    def __post_init__(self) -> None:
        if not (isfinite(self.scale) and self.scale > 0.0):
            raise InputError(f"scale must be a positive number, got {self.scale}")
        if not isfinite(self.incidence_deg):
            raise InputError(f"incidence_deg must be a number, got {self.incidence_deg}")
        if self.supports and self.incidence_deg:
            raise InputError("incidence_deg must be 0 with support motions: they are along x and y")


class GroundInput:
    """Ground acceleration of one analysis along the bridge axes, linear between samples.

    `InputError` if it is so large that its unit must be wrong.
    """

    def __init__(self, excitation: Excitation, settings: AnalysisSettings) -> None:
        motion = excitation.motion
        accel = excitation.scale * np.column_stack(motion.along_axes(excitation.incidence_deg))
        largest = float(np.abs(accel).max())
        if not largest <= MAX_SCALED_ACCEL_MPS2:
            raise InputError(
                f"motion {motion.motion_id}: peak acceleration must be at most "
                f"{MAX_SCALED_ACCEL_MPS2:g} m/s2, got {largest:g}"
            )
        shaken_s = min(settings.duration_s or motion.duration_s, motion.duration_s)
        self.dt_s, self.scale, self.shaken_s = motion.dt_s, excitation.scale, shaken_s
        self.accel_mps2 = accel[: ceil(shaken_s / motion.dt_s - 1e-9) + 1]
        self.steps = ceil((shaken_s + settings.free_vibration_s) / settings.dt_s - 1e-9)
        self.duration_s = self.steps * settings.dt_s
        self._times_s = np.arange(len(self.accel_mps2)) * motion.dt_s

    def apply(self, tags: TagAllocator) -> None:
        """Add uniform excitation along x and y to the domain."""
        # ASSUME abutments and bent move alike: no wave passage, no vertical component
        for direction, values in enumerate(self.accel_mps2.T, start=1):
            series = tags.series()
            ops.timeSeries("Path", series, "-dt", self.dt_s, "-values", *values.tolist())
            ops.pattern("UniformExcitation", tags.pattern(), direction, "-accel", series)

    def at(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ground acceleration along x and y at given times, shape (n, 2)."""
        return np.column_stack(
            [np.interp(times_s, self._times_s, values, right=0.0) for values in self.accel_mps2.T]
        )
