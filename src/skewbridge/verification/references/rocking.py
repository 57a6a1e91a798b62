"""A rigid block on two corners in OpenSees: slides, tips or rocks."""

from dataclasses import dataclass
from math import cos, hypot, sin
from typing import Final

import numpy as np
import openseespy.opensees as ops

from skewbridge.contact import ContactSet
from skewbridge.verification.references.live_model import (
    Array,
    History,
    Solver,
    clean_domain,
    even_times,
    hold_load,
    load_node,
    march,
)

_CENTRE: Final = 1
_FOOT: Final = 2
_CORNERS: Final = (3, 4)
_FLOOR: Final = (5, 6)
# Stiffness of the members of the block over the penalty: rigid for these purposes.
_RIGIDITY: Final = 1.0e3
# Some numerical damping quiets the penalty after touch-down; the rocking itself is far slower.
_SOLVER: Final = Solver(
    constraints="Plain",
    numberer="RCM",
    tolerance_m=1e-11,
    algorithm="KrylovNewton",
    integrator=("HHT", 0.8),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class UprightBlock:
    """A rectangular block on a floor.

    Attributes:
        half_width_m: b.
        half_height_m: h.
        friction: Coulomb coefficient of both corners.
        penalty_n_per_m: Normal and tangential penalty.
        angle_rad: Initial angle, at rest on its left corner when it leans to the left.
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
        angle_rad: Rotation, initial angle included, positive to the left (counter-clockwise).
        feet_m: Horizontal displacement of the left and right corner, shape (n, 2).
        openings_m: Shape (n, 2).
    """

    t_s: Array
    angle_rad: Array
    feet_m: Array
    openings_m: Array


def run_upright(
    block: UprightBlock, dt_s: float, duration_s: float, base_mps2: History | None = None
) -> UprightHistory:
    """Run a block with large rotations, at rest or under a horizontal acceleration of the floor.

    Raises:
        SolutionError: A step does not converge.
    """
    times = even_times(duration_s, dt_s)
    with clean_domain():
        contacts = _model(block)
        hold_load(_CENTRE, 1, (0.0, -block.mass_kg * block.gravity_mps2, 0.0))
        push = np.zeros_like(times) if base_mps2 is None else -block.mass_kg * base_mps2(times)
        load_node(_CENTRE, 2, dt_s, push, (1.0, 0.0, 0.0))
        _SOLVER.prepare()
        rows = np.zeros((len(times), 5))
        rows[0, 0], rows[0, 3:] = block.angle_rad, contacts.openings_m
        for k in march(contacts, times, dt_s):
            feet = [ops.nodeDisp(corner, 1) for corner in _CORNERS]
            angle = block.angle_rad + ops.nodeDisp(_CENTRE, 3)
            rows[k] = [angle, *feet, *contacts.openings_m]
    return UprightHistory(
        t_s=times, angle_rad=rows[:, 0], feet_m=rows[:, 1:3], openings_m=rows[:, 3:]
    )


def _model(block: UprightBlock) -> ContactSet:
    b, h, angle = block.half_width_m, block.half_height_m, block.angle_rad
    pivot = -b if angle >= 0.0 else b
    plan = {_CENTRE: (0.0, h), _FOOT: (0.0, 0.0), _CORNERS[0]: (-b, 0.0), _CORNERS[1]: (b, 0.0)}
    turned = {
        node: (
            pivot + cos(angle) * (x - pivot) - sin(angle) * y,
            sin(angle) * (x - pivot) + cos(angle) * y,
        )
        for node, (x, y) in plan.items()
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
        gap_m, penalty = max(0.0, turned[corner][1]), block.penalty_n_per_m
        contacts.add(floor, corner, (0.0, 1.0), gap_m, block.friction, kn=penalty, kt=penalty)
    return contacts
