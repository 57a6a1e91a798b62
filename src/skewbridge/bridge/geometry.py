"""Geometry of a built model as plain data, for drawings."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import openseespy.opensees as ops

from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import FloatArray
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelGeometry:
    """Geometry of a variant at rest, for drawings; positions in m."""

    title: str
    #: both ends of all elements of each group in the energy balance, shape (n, 2, 3); the ends of
    #: zero-length springs are equal
    members: Mapping[str, FloatArray]
    #: positions of the contact units (both nodes: they do not show the gap), shape (n, 3)
    surfaces: FloatArray
    normals: FloatArray  # outward normals of these surfaces: force on the deck, shape (n, 3)
    gaps_m: FloatArray  # gaps of the units, shape (n,)
    fixed: FloatArray  # positions of fully or partly fixed nodes, shape (n, 3)
    deck_outline: FloatArray  # corners of the deck in plan, counter-clockwise, shape (n, 2)


def model_geometry(variant: Variant, options: ModelOptions) -> ModelGeometry:
    """Build a variant and return its geometry."""
    with domain():
        model = build(variant, options)
        units = model.contacts.units if model.contacts else ()
        ends = reversed(model.abutments)  # corners along the tangent: right, then left end
        return ModelGeometry(
            title=model.variant.slug,
            members={
                group: np.array([list(map(ops.nodeCoord, ops.eleNodes(tag))) for tag in tags])
                for group, tags in model.energy_elements.items()
            },
            surfaces=np.array([ops.nodeCoord(unit.node_j) for unit in units]),
            normals=np.array([unit.normal for unit in units]),
            gaps_m=np.array([unit.gap_m for unit in units]),
            fixed=np.array(list(map(ops.nodeCoord, ops.getFixedNodes()))),
            deck_outline=np.array([corner.plan_m for end in ends for corner in end.corners]),
        )


def contact_column(name: str) -> str:
    """Return the prefix of the history columns of a contact."""
    return f"contact_{name.replace(' ', '_')}"
