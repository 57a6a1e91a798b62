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
    """One spring of a zeroLength element, from the ground side to the deck side."""

    element: int
    component: int  # 0-based index in ``basicForce`` and ``basicDeformation``
    direction: PlanVector  # plan unit vector of positive deformation (second node minus first)
    nodes: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnCapacity:
    """Capacity of a column in one horizontal direction; unknown values are nan or None."""

    yield_curvature_per_m: float  # idealised yield curvature under dead load
    #: idealised yield displacement over clear height, for the displacement ductility in the shear
    #: capacity
    yield_drift_ratio: float
    drift_capacity_ratio: float  # displacement capacity over clear height (Caltrans criteria)
    shear: ShearSection | Strength | None
    #: hinge length of the model (normal to the bent) / hinge length of this direction; the same
    #: rotation of a shorter hinge needs more curvature
    hinge_ratio: float = 1.0

    def shear_strength_n(
        self, model: ShearModel, axial_n: FloatArray, drift: FloatArray, curvature: FloatArray
    ) -> FloatArray:
        """Return the strength (N) at axial forces and ductilities, shape (n,); nan if unknown."""
        if self.shear is None:
            return np.full_like(axial_n, np.nan)
        if isinstance(self.shear, ShearSection):
            return shear_strength(self.shear, model, axial_n, drift, curvature)
        return self.shear(axial_n, drift, curvature)


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnHandle:
    """Tags, height and capacities of one column."""

    #: element tag; end i is at the base. ``eleResponse(element, "force")`` gives 12 global
    #: components, starting with the six at the base.
    element: int
    base_node: int
    top: Point  # top of the column at the soffit, ``clear_height_m`` above the base node
    clear_height_m: float
    #: 1-based integration points where plastic curvature is read, for ``eleResponse(element,
    #: "section", str(k), "deformation")`` = (axial, about z, about y, torsion); empty for elastic
    #: columns
    hinge_sections: tuple[int, ...]
    #: capacity in the direction ``normal`` and at +90 degrees to it. Local z of the element is
    #: ``normal``.
    capacities: tuple[ColumnCapacity, ColumnCapacity]
    normal: PlanVector = (1.0, 0.0)
    bent: int = 0  # number of its bent, from the left
    shear_model: ShearModel = DEFAULT_SHEAR_MODEL
    is_pinned: bool = False  # whether the column turns freely about its base
    is_elastic: bool = False  # whether the column is elastic, so that it never fails
    #: whether the column of the model softens at its shear failure
    loses_shear_strength: bool = False

    @property
    def foot(self) -> int | Point:
        """Reference of the drift: the base, or the top as moved by the rotation of a fixed base."""
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
    """Node of a deck corner above a point on a cap or ledge; ``normal`` is out of the deck."""

    corner: int
    holder: Point
    normal: PlanVector
    support_length_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PadsHandle:
    """Pads between a deck and a cap or ledge."""

    bearings: tuple[BearingHandle, ...]  # pad elements, from the cap or ledge up to the deck
    pads: tuple[tuple[Point, Point], ...]  # top and bottom of each pad
    links: tuple[int, ...]  # stiff arms


@dataclass(frozen=True, slots=True, kw_only=True)
class JointHandle(PadsHandle):
    """Seats, contacts and restrainers of one joint inside the bridge."""

    name: str  # ``joint 1`` and so on, from left to right
    gap_m: float  # opening at rest, normal to the faces
    seats: tuple[SeatHandle, ...]
    units: tuple[int, ...]  # indices of the contacts between the decks
    restrainers: tuple[int, ...]  # elements of the cables

    @property
    def column(self) -> str:
        """Prefix of the columns of the joint in tables and histories."""
        return self.name.replace(" ", "")


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHandle:
    """One abutment with the deck end it supports."""

    side: str  # ``left`` (negative x) or ``right``
    normal: PlanVector  # outward normal of the deck end (towards the backfill), in plan
    tangent: PlanVector  # ``normal`` turned by +90 degrees: along the wall
    centre: Point  # middle of the bearing line at the top of the pads
    corners: tuple[CornerHandle, ...]
    #: whether the deck end rests on a seat behind a gap, from which it can fall
    is_seat: bool = True
    gap_m: float = 0.0  # opening of the joint at rest, normal to the wall
    seat_width_m: float = nan  # distance from backwall to edge of the seat, normal to the wall
    #: elements of pads (each may represent several) or of supports
    bearings: tuple[BearingHandle, ...] = ()
    pads: tuple[Point, ...] = ()  # tops of all pads or supports
    holders: tuple[int, ...] = ()  # fixed nodes whose vertical reactions are that of the abutment
    #: stiff arms from the end node of the deck to the points of the joint
    links: tuple[int, ...] = ()
    #: indices of the backwall contacts in `BridgeModel.contacts`, in the direction of ``tangent``;
    #: empty in models without contact
    wall_units: tuple[int, ...] = ()
    key_units: tuple[int, ...] = ()  # indices of the key contacts, in the same order
    wall_nodes: tuple[int, ...] = ()
    key_nodes: tuple[int, ...] = ()
    #: backfill springs: between ground and wall node in contact models, otherwise between ground
    #: and deck
    wall_springs: tuple[SpringHandle, ...] = ()
    #: springs of the shear keys, from the ground (in `spring`: from the body) to the key node; in
    #: `simplified`, the transverse springs
    key_springs: tuple[SpringHandle, ...] = ()
    wing_springs: tuple[SpringHandle, ...] = ()  # wing-wall springs
    #: elements from the ground to an integral end: fill with wing walls, and piles
    ground_elements: tuple[int, ...] = ()
    #: gap elements at the keys of `spring`, and all elements of piles; no demand uses them
    other_springs: tuple[int, ...] = ()

    @property
    def support_length_m(self) -> float:
        """Length of the deck on the seat at rest, normal to the wall."""
        return self.seat_width_m - self.gap_m

    @property
    def springs(self) -> tuple[SpringHandle, ...]:
        """Springs of walls, keys and wing walls."""
        return (*self.wall_springs, *self.key_springs, *self.wing_springs)
