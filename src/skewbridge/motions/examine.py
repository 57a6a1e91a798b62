"""Checks of a recorded component before it is used: impossible ones are refused."""

from typing import Final

import numpy as np

from skewbridge.errors import InputError
from skewbridge.motions.formats.trace import Trace
from skewbridge.motions.record import Vector
from skewbridge.units import G_MPS2

MIN_VALUES: Final = 10
DT_LIMITS_S: Final = (1.0e-4, 0.2)
# ASSUME no horizontal record exceeds 4 g (the largest published ones are near 3 g): more is a
# unit error; below 0.002 g no bridge notices.
PGA_LIMITS_G: Final = (0.002, 4.0)
_SAY_UNIT: Final = "Name it in index.csv (skewbridge motions check DIR --write --unit UNIT)"
MAX_OFFSET_OF_PGA: Final = 0.02
MAX_END_VELOCITY_OF_PGV: Final = 0.25


def refuse_impossible(trace: Trace) -> None:
    """Refuse a component no calculation should see.

    Raises:
        InputError: Too few values, a time step or a peak outside the limits, all zero.
    """
    name = trace.path.name
    low_s, high_s = DT_LIMITS_S
    if not low_s <= trace.dt_s <= high_s:
        raise InputError(f"{name}: dt = {trace.dt_s} s, allowed {low_s} to {high_s}")
    if trace.accel_mps2.size < MIN_VALUES:
        raise InputError(f"{name}: {trace.accel_mps2.size} values, at least {MIN_VALUES} needed")
    if not np.isfinite(trace.accel_mps2).all():
        raise InputError(f"{name}: values must be finite")
    pga_g = peak_g(trace.accel_mps2)
    if pga_g == 0.0:
        raise InputError(f"{name}: all values are zero")
    if pga_g > PGA_LIMITS_G[1]:
        raise InputError(
            f"{name}: PGA = {pga_g:.4g} g with the values in {trace.unit}, "
            f"allowed {PGA_LIMITS_G[1]} g: wrong unit? {_SAY_UNIT}"
        )


def doubts(trace: Trace) -> list[str]:
    """Return warnings on the values of a component that passed `refuse_impossible`."""
    found: list[str] = []
    accel_mps2 = trace.accel_mps2
    pga_mps2 = float(np.abs(accel_mps2).max())
    if pga_mps2 / G_MPS2 < PGA_LIMITS_G[0]:
        found.append(
            f"PGA = {pga_mps2 / G_MPS2:.3g} g is below {PGA_LIMITS_G[0]} g: wrong unit? {_SAY_UNIT}"
        )
    offset = abs(float(accel_mps2.mean())) / pga_mps2
    if offset > MAX_OFFSET_OF_PGA:
        found.append(f"mean is {offset:.1%} of the PGA: baseline not corrected?")
    velocity_mps = np.cumsum(accel_mps2) * trace.dt_s
    pgv_mps = float(np.abs(velocity_mps).max())
    if pgv_mps > 0.0 and abs(velocity_mps[-1]) > MAX_END_VELOCITY_OF_PGV * pgv_mps:
        share = abs(float(velocity_mps[-1])) / pgv_mps
        found.append(f"velocity at the end is {share:.0%} of the PGV: baseline not corrected?")
    return found


def peak_g(accel_mps2: Vector) -> float:
    """Return the largest absolute acceleration in g."""
    return float(np.abs(accel_mps2).max()) / G_MPS2
