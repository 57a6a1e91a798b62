"""What friction changes, cycle by cycle: two runs of the same motion compared."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from skewbridge.verification.references.live_model import Array

# Half cycles smaller than this share of the largest one say nothing.
SMALLEST_CYCLE = 0.15


@dataclass(frozen=True, slots=True, kw_only=True)
class HalfCycle:
    """One half cycle of the run without friction.

    Attributes:
        start_s: First zero crossing; `end_s` the second.
        peak_without_m: Largest magnitude without friction.
        peak_with_m: Largest magnitude with friction, in the same time.
        together: Largest product of longitudinal and transverse displacement at one time, over
            the product of their largest values of the run: 1 when both peaks coincide.
        has_contact: Whether a backwall carried normal force, in either run.
    """

    start_s: float
    end_s: float
    peak_without_m: float
    peak_with_m: float
    together: float
    has_contact: bool

    @property
    def change(self) -> float:
        """Relative change of the peak by friction; negative is a reduction."""
        return self.peak_with_m / self.peak_without_m - 1.0


def half_cycles(
    t_s: Array,
    without_m: Array,
    with_m: Array,
    other_axis_m: Array,
    in_contact: NDArray[np.bool_],
) -> list[HalfCycle]:
    """Return the half cycles between zero crossings of a displacement without friction.

    All arrays have the shape (n,); the displacement along the other axis is without friction, too,
    and in contact is where a backwall carries force.
    """
    crossings = np.flatnonzero(np.diff(np.signbit(without_m))) + 1
    bounds = np.concatenate([[0], crossings, [len(t_s)]])
    largest = float(np.abs(without_m).max())
    scale = largest * float(np.abs(other_axis_m).max())
    cycles: list[HalfCycle] = []
    for start, end in pairwise(bounds.tolist()):
        part = slice(start, end)
        peak_m = float(np.abs(without_m[part]).max())
        if end - start < 2 or peak_m < SMALLEST_CYCLE * largest:
            continue
        cycles.append(
            HalfCycle(
                start_s=float(t_s[start]),
                end_s=float(t_s[end - 1]),
                peak_without_m=peak_m,
                peak_with_m=float(np.abs(with_m[part]).max()),
                together=float(np.abs(without_m[part] * other_axis_m[part]).max()) / scale,
                has_contact=bool(in_contact[part].any()),
            )
        )
    return cycles
