"""Modes of a model under dead load with open gaps, and periods that a bridge file lacks."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from math import inf, isinf, pi, sqrt
from os import devnull
from typing import Literal

import openseespy.opensees as ops

from skewbridge.bridge.assembly import GravityError, assemble, domain
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.frame import BridgeModel
from skewbridge.bridge.structures import CatalogueBridge
from skewbridge.variant.axes import AXES
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

_MODES = 14


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
        ops.fix(node, *(int(dof == number) for number in range(1, 7)))
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


def bridge_period_s(bridge: BridgeData, which: Literal["t1", "long", "short"]) -> float:
    """Return the conditioning period, or the long or short period of Rayleigh damping, in s.

    T1 is that of the model with pads, open gaps and zero skew. The periods of damping are those of
    cracked columns on rollers, for the short one with ends held transversely; a bridge without
    columns has no longitudinal stiffness without its pads. Raises `ValueError` for a
    mechanism, or if the domain has a model, which would be lost.
    """
    if ops.getNodeTags():
        raise ValueError("the domain is in use")
    is_free = which != "t1" and bool(bridge.bents)
    values = {axis.name: axis.usual for axis in AXES} | {"skew_deg": 0}
    variant = Variant.at(bridge.name, "roller" if is_free else "contact_friction", values)
    ops.logFile(devnull, "-noEcho")
    try:
        with domain():
            build = CatalogueBridge(bridge).build
            model = assemble(build, variant, ModelOptions(elastic_columns=is_free))
            if is_free and which == "short":
                for end in model.frame.ends:
                    ops.fix(end.node, 0, 1, 0, 0, 0, 0)
            modes = modes_of(model, _MODES)
    except GravityError as error:
        raise ValueError(error) from error
    finally:
        ops.model("basic", "-ndm", 3, "-ndf", 6)  # of a domain in which a bridge is loaded
    x_s, y_s, z_s = (period_s(modes, axis) for axis in "xyz")
    if isinf(x_s + y_s + z_s):
        raise ValueError("the bridge is a mechanism")
    if which == "t1":
        return sqrt(x_s * y_s)
    return max(x_s, y_s) if which == "long" else min(y_s, z_s)
