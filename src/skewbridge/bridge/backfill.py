"""Passive resistance of the backfill and of the wing walls: pure functions."""

from dataclasses import dataclass, replace
from math import atan, degrees, exp, sqrt

import numpy as np
from numpy.typing import ArrayLike

from skewbridge.bridge.catalogue.data import WallData
from skewbridge.bridge.plan import DeckEnd
from skewbridge.bridge.section import FloatArray
from skewbridge.units import FOOT, INCH, KIP, KN
from skewbridge.variant.options import LARGEST_SKEW_DEG, BackfillSkew

# source: Shamsabadi, Khalili-Tehrani, Stewart and Taciroglu (2010), J. Bridge Eng. 15(3):233-246:
# 1.56 for granular backfill, 1.05 for cohesive; 1.57 for SDC 2.0 at 1.7 m
STRENGTH_EXPONENT = 1.5
LARGEST_TESTED_SKEW_DEG = 45.0  # source: tests in verification/skew_passive.csv
FULL_VARIATION_SKEW_DEG = 60.0  # source: Kaviani et al. (2012), 30 % at 60 degrees
SOIL_KG_PER_M3 = 1760.0  # source: compacted structure backfill, 110 pcf
# A hyperbola with failure ratio 1 never reaches its ultimate force; it has 99.9 % of it at this
# multiple of the closure ultimate / stiffness.
_LONGEST_HYPERBOLA = 1.0e3


@dataclass(frozen=True, slots=True, kw_only=True)
class Passive:
    """Passive resistance in N as a function of the closure d in m.

    The hyperbola ``d / (1/stiffness + failure_ratio d / ultimate)`` of an initial stiffness, up to
    the ultimate force; bilinear if ``failure_ratio`` is zero.

    References:
        Shamsabadi, Rollins and Kapuskar (2007), J. Geotech. Geoenviron. Eng. 133(6):707-720.
    """

    stiffness_n_per_m: float
    ultimate_n: float
    failure_ratio: float

    def force_n(self, closure_m: ArrayLike) -> FloatArray:
        """Return the force in N at a closure that is reached for the first time."""
        closure = np.maximum(np.asarray(closure_m, dtype=np.float64), 0.0)
        flexibility = 1.0 / self.stiffness_n_per_m
        hyperbola = closure / (flexibility + self.failure_ratio * closure / self.ultimate_n)
        return np.minimum(hyperbola, self.ultimate_n)

    def polygon(self, chords: int) -> tuple[FloatArray, FloatArray]:
        """Return closures (m) and forces (N) of a polygon of chords with equal relative errors."""
        ratio = self.failure_ratio
        yield_m = self.ultimate_n / self.stiffness_n_per_m
        longest = min(1.0 / max(1.0 - ratio, 1e-12), _LONGEST_HYPERBOLA)
        # with force sin^2(t) / ratio, the error of every chord is dt^2 / 4
        angles = np.linspace(0.0, atan(sqrt(ratio * longest)), chords + 1)
        closures = np.tan(angles) ** 2 / ratio * yield_m
        return closures, self.force_n(closures)

    def scaled(self, factor: float, stiffness_factor: float | None = None) -> "Passive":
        """Return the curve scaled by one factor, or by one for strength and one for stiffness."""
        stiffness = self.stiffness_n_per_m * (
            factor if stiffness_factor is None else stiffness_factor
        )
        return replace(self, stiffness_n_per_m=stiffness, ultimate_n=self.ultimate_n * factor)


def skew_reduction(skew_rad: float, rule: BackfillSkew = "strength") -> float:
    """Return the reduction factor exp(-|skew| / 45 deg), or 1 with the rule ``none``.

    References:
        Caltrans SDC 2.0 section 6.3.1.2 (Shamsabadi and Rollins), limited to 66 degrees.
    """
    if rule == "none":
        return 1.0
    return exp(-min(abs(degrees(skew_rad)), LARGEST_SKEW_DEG) / 45.0)


def sdc_backfill(abutment: WallData) -> Passive:
    """Return the bilinear curve of Caltrans SDC 2.0 section 6.3.1.2 at zero skew.

    K = w (5.5 h + 20) kip/in and F = w 5.5 h^2.5 / (1 + 2.37 h) kip, w and h in ft.
    """
    w, h = abutment.wall_width_m / FOOT, abutment.wall_height_m / FOOT
    return Passive(
        stiffness_n_per_m=w * (5.5 * h + 20.0) * KIP / INCH,
        ultimate_n=w * 5.5 * h**2.5 / (1.0 + 2.37 * h) * KIP,
        failure_ratio=0.0,
    )


def hyperbolic_backfill(abutment: WallData, height_exponent: float) -> Passive:
    """Return the hyperbola at zero skew; rule ``ucsd``: strength ~ height^``height_exponent``."""
    data, width = abutment.backfill, abutment.wall_width_m
    if data.rule == "ucsd":
        height_ratio = abutment.wall_height_m / data.reference_height_m
        return Passive(
            # source: Caltrans SDC 1.7 section 7.8.1: stiffness linear in height
            stiffness_n_per_m=data.stiffness_mn_per_m * 1e6 * width * height_ratio,
            ultimate_n=data.ultimate_kn * KN * width * height_ratio**height_exponent,
            failure_ratio=data.failure_ratio,
        )
    # source: PyPBEE, hyperbola through (F / 2, F / 2 K50) and (F, y_max), where it ends
    secant_n_per_m, ultimate_n = data.stiffness_mn_per_m * 1e6, data.ultimate_kn * KN
    ultimate_m = data.ultimate_closure_ratio * abutment.wall_height_m
    stiffness = 2.0 * secant_n_per_m - ultimate_n / ultimate_m
    return Passive(
        stiffness_n_per_m=stiffness,
        ultimate_n=ultimate_n,
        failure_ratio=2.0 * (secant_n_per_m - ultimate_n / ultimate_m) / stiffness,
    )


def wall_backfill(
    abutment: WallData,
    kind: str,
    skew_rad: float,
    height_exponent: float = STRENGTH_EXPONENT,
    skew_rule: BackfillSkew = "strength",
) -> Passive:
    """Return the curve of the full wall, reduced for skew; ``kind`` is hyperbolic or sdc."""
    if kind == "sdc":
        zero_skew = sdc_backfill(abutment)
    else:
        zero_skew = hyperbolic_backfill(abutment, height_exponent)
    return reduced_for_skew(zero_skew, skew_rad, skew_rule)


def reduced_for_skew(passive: Passive, skew_rad: float, rule: BackfillSkew) -> Passive:
    """Return the curve of a skewed wall from the curve ``passive`` of a wall at zero skew.

    With ``strength``, a hyperbola keeps its initial stiffness and its closure at full strength, as
    in tests (verification/skew_passive.csv). ``strength_and_stiffness`` reduces all forces.
    """
    reduction = skew_reduction(skew_rad, rule)
    if rule == "strength_and_stiffness":
        return passive.scaled(reduction)
    ratio = passive.failure_ratio
    if ratio > 0.0:  # closure at full strength: ultimate / stiffness / (1 - ratio)
        ratio += (1.0 - reduction) * (1.0 - ratio)
    return replace(passive, ultimate_n=passive.ultimate_n * reduction, failure_ratio=ratio)


def variation_factors(end: DeckEnd, stations: list[float], variation: float) -> list[float]:
    """Return factors on the backfill at stations (m): 1 in the middle, linear along the wall.

    At 60 degrees of skew they are 1 + ``variation`` at the acute corner, less at smaller skews.

    References:
        Kaviani, Zareian and Taciroglu (2012): 30 % from the middle to the ends at 60 degrees.
    """
    half_length_m = max(abs(along_m) for along_m in stations)
    slope = variation * min(abs(degrees(end.skew_rad)) / FULL_VARIATION_SKEW_DEG, 1.0)
    return [1.0 + slope * end.acute_sign * along_m / half_length_m for along_m in stations]


def radiation_n_s_per_m(abutment: WallData, vs_mps: float) -> float:
    """Return the radiation-damping coefficient rho Vs A of the full wall in N s/m.

    References:
        Lysmer and Kuhlemeyer (1969), J. Eng. Mech. Div. ASCE 95(4), 859-877; Gazetas (1991), J.
        Geotech. Eng. 117(9), 1363-1381: Vs is a lower bound on the wave velocity for pushing.
    """
    # ASSUME skew does not change it: the area normal to the bridge counts, as for the backfill
    return SOIL_KG_PER_M3 * vs_mps * abutment.wall_width_m * abutment.wall_height_m


def wing_share(abutment: WallData) -> float:
    """Return the ratio of wing-wall to backwall resistance of one abutment.

    References:
        Aviram, Mackie and Stojadinovic (2008), PEER 2008/03.
    """
    return abutment.wing_length_ratio * abutment.wing_participation * abutment.wing_effectiveness


def wing_wall(abutment: WallData) -> Passive:
    """Return the transverse resistance of the wing walls: `wing_share` of the SDC curve."""
    # ASSUME no reduction for skew: the wings bear on the soil at a right angle
    return sdc_backfill(abutment).scaled(wing_share(abutment))
