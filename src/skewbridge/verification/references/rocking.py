"""A rigid block on two corners in OpenSees: slides, tips or rocks."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, sin
from typing import Final

import numpy as np
import openseespy.opensees as ops
from numpy.typing import NDArray

from skewbridge.contact import ContactSet
from skewbridge.verification.references.block import BlockError
from skewbridge.verification.references.unit_path import clean_domain

type Array = NDArray[np.float64]

_CENTRE: Final = 1
_FOOT: Final = 2
_CORNERS: Final = (3, 4)
_FLOOR: Final = (5, 6)
# Stiffness of the members of the block over the penalty: rigid for these purposes.
_RIGIDITY: Final = 1.0e3


@dataclass(frozen=True, slots=True, kw_only=True)
class UprightBlock:
    """A rectangular block on a floor.

    Attributes:
        half_width_m: b.
        half_height_m: h.
        mass_kg: Mass.
        friction: Coulomb coefficient of both corners.
        penalty_n_per_m: Normal and tangential penalty.
        angle_rad: Initial angle, at rest on its left corner when it leans to the left.
        gravity_mps2: g.
    """

    half_width_m: float
    half_height_m: float
    mass_kg: float
    friction: float
    penalty_n_per_m: float
    gravity_mps2: float
    angle_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class UprightHistory:
    """Response; n times.

    Attributes:
        t_s: Shape (n,).
        angle_rad: Rotation, initial angle included, positive to the left (counter-clockwise).
        feet_m: Horizontal displacement of the left and right corner, shape (n, 2).
        openings_m: Shape (n, 2).
    """

    t_s: Array
    angle_rad: Array
    feet_m: Array
    openings_m: Array


def run_upright(
    block: UprightBlock,
    dt_s: float,
    duration_s: float,
    base_mps2: Callable[[Array], Array] | None = None,
) -> UprightHistory:
    """Run a block by the trapezoidal rule, with large rotations.

    Args:
        block: The block.
        dt_s: Step.
        duration_s: Duration.
        base_mps2: Horizontal acceleration of the floor.

    Raises:
        BlockError: A step does not converge.
    """
    times = np.arange(round(duration_s / dt_s) + 1, dtype=np.float64) * dt_s
    with clean_domain():
        contacts = _model(block)
        _load(block, times, dt_s, base_mps2)
        rows = np.zeros((len(times), 5))
        rows[0, 0], rows[0, 3:] = block.angle_rad, contacts.openings_m
        for k in range(1, len(times)):
            if ops.analyze(1, dt_s) != 0:
                raise BlockError(f"OpenSees stopped at {times[k]:.6g} s")
            contacts.after_step(dt_s)
            feet = [ops.nodeDisp(corner, 1) for corner in _CORNERS]
            angle = block.angle_rad + ops.nodeDisp(_CENTRE, 3)
            rows[k] = [angle, *feet, *contacts.openings_m]
    return UprightHistory(
        t_s=times, angle_rad=rows[:, 0], feet_m=rows[:, 1:3], openings_m=rows[:, 3:]
    )


def _model(block: UprightBlock) -> ContactSet:
    b, h, angle = block.half_width_m, block.half_height_m, block.angle_rad
    pivot = -b if angle >= 0.0 else b
    turned = {
        node: (
            pivot + cos(angle) * (x - pivot) - sin(angle) * y,
            sin(angle) * (x - pivot) + cos(angle) * y,
        )
        for node, (x, y) in (
            (_CENTRE, (0.0, h)),
            (_FOOT, (0.0, 0.0)),
            (_CORNERS[0], (-b, 0.0)),
            (_CORNERS[1], (b, 0.0)),
        )
    }
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, position in turned.items():
        ops.node(node, *position)
    ops.mass(_CENTRE, block.mass_kg, block.mass_kg, block.mass_kg * hypot(b, h) ** 2 / 3.0)
    ops.geomTransf("Corotational", 1)
    stiffness = _RIGIDITY * block.penalty_n_per_m
    for element, (i, j) in enumerate(
        ((_CENTRE, _FOOT), (_FOOT, _CORNERS[0]), (_FOOT, _CORNERS[1])), start=1
    ):
        ops.element("elasticBeamColumn", element, i, j, 1.0, stiffness, 1.0, 1)
    contacts = ContactSet()
    for floor, corner in zip(_FLOOR, _CORNERS, strict=True):
        ops.node(floor, *turned[corner])
        ops.fix(floor, 1, 1, 1)
        contacts.add(
            *(floor, corner, (0.0, 1.0), max(0.0, turned[corner][1]), block.friction),
            kn=block.penalty_n_per_m,
            kt=block.penalty_n_per_m,
        )
    return contacts


def _load(
    block: UprightBlock, times: Array, dt_s: float, base_mps2: Callable[[Array], Array] | None
) -> None:
    weight = block.mass_kg * block.gravity_mps2
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(_CENTRE, 0.0, -weight, 0.0)
    push = np.zeros_like(times) if base_mps2 is None else -block.mass_kg * base_mps2(times)
    ops.timeSeries("Path", 2, "-dt", dt_s, "-values", *push.tolist(), float(push[-1]))
    ops.pattern("Plain", 2, 2)
    ops.load(_CENTRE, 1.0, 0.0, 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-11, 50)
    ops.algorithm("KrylovNewton")
    # Some numerical damping quiets the penalty after touch-down; the rocking itself is far slower.
    ops.integrator("HHT", 0.8)
    ops.analysis("Transient")
