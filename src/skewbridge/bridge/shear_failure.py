"""Loss of shear strength of a column: a softening shear response of its top section."""

from dataclasses import dataclass
from math import radians, tan

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.dead_load import column_axial_n
from skewbridge.bridge.hinge import hinge_length_m, shear_span_m
from skewbridge.bridge.moment_curvature import section_response
from skewbridge.bridge.shear_capacity import ShearSection, hoop_strength_n, sdc_shear_strength
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import GPA
from skewbridge.variant.options import HingeRule

CRACK_ANGLE_DEG = 65.0  # source: Elwood and Moehle (2005)
SHEAR_AREA_RATIO = 0.8  # source: Caltrans SDC 1.7 section 3.6.2, effective over gross area
# ASSUME a broken column keeps a tenth of its shear strength: friction and hoops across the crack
RESIDUAL_SHEAR = 0.1
PLATEAU = 100.0  # length of the residual branch, in times the deformation where it starts
# ASSUME pinched loops: on reloading, 0.5 of the deformation at 0.4 of the force
PINCHING = (0.5, 0.4)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShearLoss:
    """Backbone of the shear of a column, the same in all directions.

    Attributes:
        strength_n: Shear at which the column fails.
        elastic_m: Shear deformation of the whole column there.
        failure_drift_ratio: Flexural drift at which a monotonic push reaches the strength; the
            displacement capacity's if it never does.
        residual_m: Shear deformation at which the residual strength is reached.
    """

    strength_n: float
    elastic_m: float
    failure_drift_ratio: float
    residual_m: float


def shear_loss(
    bridge: BridgeData, bent_number: int, section: ShearSection, hinge_rule: HingeRule = "sdc"
) -> ShearLoss:
    """Return when and how a column of a bent, numbered from 0, loses its shear strength.

    The strength is that where the shear of the flexural response, M(phi) over the shear span,
    meets the capacity of the criteria at the same ductility, under dead load. If they do not meet,
    it is the capacity at the ultimate curvature. From there the shear falls in a straight line to
    nothing at the drift of axial failure, cut off at the residual.

    References:
        Elwood and Moehle (2005), Earthquake Spectra 21(1), 71-89: drift at axial failure; Elwood
        (2004), Can. J. Civ. Eng. 31(5), 846-859: straight loss between the two drifts.
    """
    axial_n = column_axial_n(bridge, bent_number)
    curve = section_response(bridge.column, axial_n)
    span, height = shear_span_m(bridge, bent_number), bridge.bents[bent_number].clear_height_m
    hinge = hinge_length_m(bridge, bent_number, hinge_rule)
    yielded = curve.yield_curvature_per_m
    plastic = np.maximum(curve.curvature_per_m - yielded, 0.0)
    elastic_drift = np.minimum(curve.curvature_per_m, yielded) * span / 3
    drift = elastic_drift + plastic * hinge * (1.0 - hinge / 2 / span)
    capacity = sdc_shear_strength(section, axial_n, drift / (yielded * span / 3))
    shear = curve.moment_nm / span
    fails = shear >= capacity
    at = int(fails.argmax()) if fails.any() else -1
    strength = float(shear[at] if fails.any() else capacity[at])
    area_m2 = SHEAR_AREA_RATIO * section.gross_area_m2
    elastic_m = strength * height / (bridge.column.elastic_modulus_gpa * GPA / 2.4 * area_m2)
    lost_m = (axial_failure_drift(section, axial_n) - float(drift[at])) * height
    return ShearLoss(
        strength_n=strength,
        elastic_m=elastic_m,
        failure_drift_ratio=float(drift[at]),
        # never steeper than the elastic branch
        residual_m=elastic_m + (1.0 - RESIDUAL_SHEAR) * max(lost_m, elastic_m),
    )


def axial_failure_drift(section: ShearSection, axial_n: float) -> float:
    """Return the drift at which a column that failed in shear drops its axial load.

    References:
        Elwood and Moehle (2005), equation 3; the hoops' force across a crack is pi/2 A_b f_yh as in
        the shear strength of circular columns.
    """
    slope = tan(radians(CRACK_ANGLE_DEG))
    return 0.04 * (1.0 + slope**2) / (slope + axial_n / (hoop_strength_n(section) * slope))


def build_shear_section(fiber: int, loss: ShearLoss, tributary_m: float, tags: TagAllocator) -> int:
    """Add the shear response to a fiber section that stands for a length of column; return its tag.

    The two directions fail on their own, so that an oblique resultant can reach 1.41 times the
    strength.
    """
    material, section = tags.material(), tags.section()
    residual = RESIDUAL_SHEAR * loss.strength_n
    points = (
        (loss.strength_n, loss.elastic_m / tributary_m),
        (residual, loss.residual_m / tributary_m),
        (residual, PLATEAU * loss.residual_m / tributary_m),
    )
    branch = [value for point in points for value in point]
    opposite = [-value for value in branch]
    ops.uniaxialMaterial("Hysteretic", material, *branch, *opposite, *PINCHING, 0.0, 0.0)
    ops.section("Aggregator", section, material, "Vy", material, "Vz", "-section", fiber)
    return section
