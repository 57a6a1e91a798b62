"""Handles of a built model for the analyses: tags, positions and data to compute demands.

Axes: x longitudinal, y transverse, z up, origin in plan at the middle of the deck. Every handle
is valid only inside the `domain()` in which the model was built.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
from math import nan

import numpy as np

from skewbridge.bridge.plan import PlanVector
from skewbridge.bridge.section import FloatArray, ShearSection, shear_strength
from skewbridge.variant.options import DEFAULT_SHEAR_MODEL, ShearModel

#: Shear strength (N) of a column of a script at axial forces (N, compression positive) and
#: ductilities of drift and curvature, shapes (n,).
type Strength = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


class TagAllocator:
    """Source of consecutive tags for each kind of object; a `ContactSet` can use it."""

    def __init__(self) -> None:
        self.node, self.element, self.region = (count(1).__next__ for _ in range(3))
        self.material, self.section, self.integration = (count(1).__next__ for _ in range(3))
        self.transformation, self.parameter = (count(1).__next__ for _ in range(2))
        self.series, self.pattern = (count(1).__next__ for _ in range(2))

    def start_above(self, largest: Mapping[str, int]) -> None:
        """Continue above the largest tags that a script has used, by kind of object."""
        for kind, tag in largest.items():
            setattr(self, kind, count(tag + 1).__next__)


@dataclass(frozen=True, slots=True)
class Point:
    """Point rigidly connected to a node, at a distance along x, y and z from it."""

    node: int
    arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpringHandle:
    """One spring of a zeroLength element, from the ground side to the deck side.

    Attributes:
        component: 0-based index in ``basicForce`` and ``basicDeformation``.
        direction: Plan unit vector of positive deformation (second node minus first).
    """

    element: int
    component: int
    direction: PlanVector
    nodes: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnCapacity:
    """Capacity of a column in one horizontal direction; what is not stated is nan or None.

    Attributes:
        yield_curvature_per_m: Idealised yield curvature under dead load.
        yield_drift_ratio: Idealised yield displacement over clear height, for the displacement
            ductility in the shear capacity.
        drift_capacity_ratio: Displacement capacity over clear height (Caltrans criteria).
    """

    yield_curvature_per_m: float
    yield_drift_ratio: float
    drift_capacity_ratio: float
    shear: ShearSection | Strength | None

    def shear_strength_n(
        self, model: ShearModel, axial_n: FloatArray, drift: FloatArray, curvature: FloatArray
    ) -> FloatArray:
        """Return the strength at axial forces and ductilities, (n,); nan if not stated."""
        if self.shear is None:
            return np.full_like(axial_n, np.nan)
        if isinstance(self.shear, ShearSection):
            return shear_strength(self.shear, model, axial_n, drift, curvature)
        return self.shear(axial_n, drift, curvature)


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnHandle:
    """One column.

    Attributes:
        element: Element tag; end i is at the base. ``eleResponse(element, "force")`` gives 12
            global components, starting with the six at the base.
        top: Top of the column at the soffit, ``clear_height_m`` above the base node.
        hinge_sections: 1-based integration points where plastic curvature is read, for
            ``eleResponse(element, "section", str(k), "deformation")`` = (axial, about z, about y,
            torsion); empty for elastic columns.
        capacities: Capacity in the direction ``normal`` and at +90 degrees to it. Local z of the
            element is ``normal``.
        is_pinned: Whether the column turns freely about its base.
        is_elastic: Whether the column is elastic, so that it never fails.
        loses_shear_strength: Whether the column of the model softens at its shear failure.
    """

    element: int
    base_node: int
    top: Point
    clear_height_m: float
    hinge_sections: tuple[int, ...]
    capacities: tuple[ColumnCapacity, ColumnCapacity]
    normal: PlanVector = (1.0, 0.0)
    shear_model: ShearModel = DEFAULT_SHEAR_MODEL
    is_pinned: bool = False
    is_elastic: bool = False
    loses_shear_strength: bool = False

    @property
    def foot(self) -> int | Point:
        """Origin of the drift: the base, or a point at the top that moves with a fixed base."""
        arm_m = (0.0, 0.0, self.clear_height_m)
        return self.base_node if self.is_pinned else Point(self.base_node, arm_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerHandle:
    """One corner of the deck at an abutment: its node at the soffit and its position at rest.

    ``side`` is left or right, ``kind`` acute or obtuse; zero skew counts as positive.
    """

    node: int
    side: str
    kind: str
    plan_m: PlanVector

    @property
    def column(self) -> str:
        """Prefix of the displacement columns of this corner in the histories."""
        return f"abutment_{self.side}_{self.kind}"


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingHandle:
    """Element of pads or of a support, from a fixed seat node up to a deck node."""

    element: int
    seat_node: int
    deck_node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SeatHandle:
    """Corner of a deck end above a ``holder`` on a cap or ledge; ``normal`` is out of the deck."""

    corner: int
    holder: Point
    normal: PlanVector
    support_length_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class JointHandle:
    """One joint inside the bridge.

    Attributes:
        name: ``joint 1`` and so on, from left to right.
        gap_m: Opening at rest, normal to the faces.
        units: Indices of the contacts between the decks.
        bearings: Pad elements, from the cap or ledge up to the deck.
        pads: Top and bottom of each pad.
        restrainers: Elements of the cables.
        links: Stiff arms.
    """

    name: str
    gap_m: float
    seats: tuple[SeatHandle, ...]
    units: tuple[int, ...]
    bearings: tuple[BearingHandle, ...]
    pads: tuple[tuple[Point, Point], ...]
    restrainers: tuple[int, ...]
    links: tuple[int, ...]

    @property
    def column(self) -> str:
        """Prefix of its columns in tables and histories."""
        return self.name.replace(" ", "")


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHandle:
    """One abutment with the deck end it supports.

    Attributes:
        side: ``left`` (negative x) or ``right``.
        is_seat: Whether the deck end rests on a seat behind a gap, from which it can fall.
        normal: Outward normal of the deck end (towards the backfill), in plan.
        tangent: ``normal`` turned by +90 degrees: along the wall.
        gap_m: Opening of the joint at rest, normal to the wall; the transverse gap is at the keys.
        seat_width_m: Distance from backwall to edge of the seat, normal to the wall.
        centre: Middle of the bearing line at the top of the pads.
        bearings: Elements of pads (each may represent several) or of supports.
        pads: Tops of all pads or supports.
        holders: Fixed nodes whose vertical reactions are that of the abutment.
        links: Stiff arms from the end node of the deck to the points of the joint.
        wall_units: Indices of the backwall contacts in `BridgeModel.contacts`, in the direction of
            ``tangent``; empty in models without contact.
        key_units: Indices of the key contacts, in the same order.
        wall_springs: Backfill springs: between ground and wall node in contact models, otherwise
            between ground and deck.
        key_springs: Springs of the shear keys, from the ground (in `spring`: from the body) to the
            key node; in `simplified`, the transverse springs.
        wing_springs: Wing-wall springs.
        other_springs: Gap elements at the keys of `spring`, and piles; no demand uses them.
    """

    side: str
    normal: PlanVector
    tangent: PlanVector
    centre: Point
    corners: tuple[CornerHandle, ...]
    is_seat: bool = True
    gap_m: float = 0.0
    transverse_gap_m: float = 0.0
    seat_width_m: float = nan
    bearings: tuple[BearingHandle, ...] = ()
    pads: tuple[Point, ...] = ()
    holders: tuple[int, ...] = ()
    links: tuple[int, ...] = ()
    wall_units: tuple[int, ...] = ()
    key_units: tuple[int, ...] = ()
    wall_nodes: tuple[int, ...] = ()
    key_nodes: tuple[int, ...] = ()
    wall_springs: tuple[SpringHandle, ...] = ()
    key_springs: tuple[SpringHandle, ...] = ()
    wing_springs: tuple[SpringHandle, ...] = ()
    other_springs: tuple[int, ...] = ()

    @property
    def support_length_m(self) -> float:
        """Length of the deck on the seat at rest, normal to the wall."""
        return self.seat_width_m - self.gap_m

    @property
    def springs(self) -> tuple[SpringHandle, ...]:
        """Springs of walls, keys and wing walls."""
        return (*self.wall_springs, *self.key_springs, *self.wing_springs)
