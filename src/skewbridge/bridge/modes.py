"""Modes of a model under dead load with open gaps."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from math import inf, pi, sqrt

import openseespy.opensees as ops

from skewbridge.bridge.frame import BridgeModel


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """Period of one mode, and its shares of the free mass along x, y, z and about z."""

    period_s: float  # infinite for a mechanism
    mass_x: float
    mass_y: float
    mass_z: float
    mass_rz: float


def modes_of(model: BridgeModel, count: int) -> tuple[Mode, ...]:
    """Return the modes of a model under dead load with open gaps; the model is left as it was.

    Friction springs are made soft, walls and keys are held: their local modes would fill the list.
    """
    ends = model.abutments
    held = {node for end in ends for node in end.key_nodes}
    held |= {spring.nodes[1] for end in ends for spring in end.wing_springs}
    free = [(node, dof) for node in held for dof in {1, 2}.difference(ops.getFixedDOFs(node))]
    soft = nullcontext() if model.contacts is None else model.contacts.soft_tangents()
    for node, dof in free:
        ops.fix(node, *(int(dof == each) for each in range(1, 7)))
    try:
        with soft:
            squares = [float(value) for value in ops.eigen(count)]
            ratios = ops.modalProperties("-return")
    finally:
        for node, dof in free:
            ops.remove("sp", node, dof)
    names = {"mass_x": "MX", "mass_y": "MY", "mass_z": "MZ", "mass_rz": "RMZ"}
    return tuple(
        Mode(
            period_s=2 * pi / sqrt(square) if square > 0.0 else inf,
            **{name: ratios[f"partiMassRatios{key}"][i] / 100 for name, key in names.items()},
        )
        for i, square in enumerate(squares)
    )


def period_s(modes: Sequence[Mode], direction: str) -> float:
    """Return the period of the mode with the most mass along ``x, y, z`` or ``rz``."""
    return max(modes, key=lambda mode: getattr(mode, f"mass_{direction}")).period_s
