"""Handles of a built model for the analyses: tags, positions and data to compute demands.

Axes: x longitudinal, y transverse, z up, origin in plan at the middle of the deck. Every handle
is valid only inside the `domain()` in which the model was built.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.shear_capacity import ShearSection
from skewbridge.contact import ContactSet
from skewbridge.variant.options import ModelOptions, ShearModel
from skewbridge.variant.variant import Variant


def _tags_from_one() -> Callable[[], int]:
    return count(1).__next__


@dataclass(frozen=True, slots=True)
class TagAllocator:
    """Hands out consecutive tags per kind; works as the tag source of a `ContactSet`."""

    node: Callable[[], int] = field(default_factory=_tags_from_one)
    element: Callable[[], int] = field(default_factory=_tags_from_one)
    material: Callable[[], int] = field(default_factory=_tags_from_one)
    section: Callable[[], int] = field(default_factory=_tags_from_one)
    transformation: Callable[[], int] = field(default_factory=_tags_from_one)
    integration: Callable[[], int] = field(default_factory=_tags_from_one)
    parameter: Callable[[], int] = field(default_factory=_tags_from_one)
    series: Callable[[], int] = field(default_factory=_tags_from_one)
    pattern: Callable[[], int] = field(default_factory=_tags_from_one)
    region: Callable[[], int] = field(default_factory=_tags_from_one)


type PlanVector = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Point:
    """A point that moves rigidly with a node, at an arm along x, y and z from it."""

    node: int
    arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpringHandle:
    """One spring of a zeroLength element.

    Attributes:
        component: 0-based place in ``basicForce`` and ``basicDeformation``.
        direction: Plan unit vector of positive deformation (second node minus first).
        nodes: First (ground side) and second (deck side) node.
    """

    element: int
    component: int
    direction: PlanVector
    nodes: tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnHandle:
    """One column.

    Attributes:
        element: Tag; its end i is the base, ``eleResponse(element, "force")`` are 12 global
            components starting with the base.
        top: Top of the column at the soffit.
        clear_height_m: From the base node to the top.
        hinge_sections: 1-based integration points where plastic curvature is read, for
            ``eleResponse(element, "section", str(k), "deformation")`` = (axial, about z, about y,
            torsion); empty for elastic columns.
        yield_curvature_per_m: Idealised (elastic-perfectly-plastic) yield curvature under dead
            load.
        yield_drift_ratio: Idealised yield displacement over clear height, for the displacement
            ductility in the shear capacity.
        drift_capacity_ratio: Displacement capacity of its bent by the Caltrans criteria over clear
            height.
        shear: Data of its shear strength.
        shear_model: Rule of its shear strength.
        is_elastic: Whether the column has no strength, so that it never fails.
        loses_shear_strength: Whether the model includes its shear failure.
    """

    element: int
    base_node: int
    top: Point
    clear_height_m: float
    hinge_sections: tuple[int, ...]
    yield_curvature_per_m: float
    yield_drift_ratio: float
    drift_capacity_ratio: float
    shear: ShearSection
    shear_model: ShearModel = "sdc_expected"
    is_elastic: bool = False
    loses_shear_strength: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CornerHandle:
    """One corner of the deck at an abutment: its deck-level node and its position at rest.

    ``kind`` is ``acute`` or ``obtuse``; zero skew counts as positive.
    """

    node: int
    kind: str
    plan_m: PlanVector


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingHandle:
    """Pads, or a vertical support, from the fixed seat node below to the deck node above."""

    element: int
    seat_node: int
    deck_node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHandle:
    """One abutment with the deck end it supports.

    Attributes:
        side: ``left`` (negative x) or ``right``.
        normal: Outward normal of the deck end (towards the backfill), in plan.
        tangent: ``normal`` turned by +90 degrees: along the wall.
        gap_m: Opening of the joint at rest, normal to the wall.
        transverse_gap_m: Gap at the keys.
        seat_width_m: From the backwall to the edge of the seat, normal to it.
        centre: Middle of the bearing line at the top of the pads.
        corners: The two corners of the deck end.
        bearings: Pads (or supports), or elements that represent several pads.
        pads: Tops of the pads (or supports).
        wall_units: Indices of the backwall's contacts in `BridgeModel.contacts`, along
            ``tangent``; empty without contact.
        key_units: Indices of the keys' contacts.
        wall_nodes: Backwall nodes of the contacts, same order as ``wall_units``.
        key_nodes: Key nodes, same order as ``key_units``.
        wall_springs: Springs that push the deck away from the backfill: between ground and wall
            node with contact, between ground and deck without.
        key_springs: Backbones of the shear keys: between ground, or the body of `spring`, and key
            node; transverse springs of `simplified`.
        wing_springs: Wing-wall springs.
        other_springs: Weak restoring springs and dashpots as elements (no demand reads them).
        links: Stiff arms from the end node of the deck to the points of the joint.
    """

    side: str
    normal: PlanVector
    tangent: PlanVector
    gap_m: float
    transverse_gap_m: float
    seat_width_m: float
    centre: Point
    corners: tuple[CornerHandle, ...]
    bearings: tuple[BearingHandle, ...]
    pads: tuple[Point, ...]
    wall_units: tuple[int, ...]
    key_units: tuple[int, ...]
    wall_nodes: tuple[int, ...]
    key_nodes: tuple[int, ...]
    wall_springs: tuple[SpringHandle, ...]
    key_springs: tuple[SpringHandle, ...]
    wing_springs: tuple[SpringHandle, ...]
    other_springs: tuple[int, ...]
    links: tuple[int, ...] = ()

    @property
    def support_length_m(self) -> float:
        """Length of deck on the seat at rest, normal to it."""
        return self.seat_width_m - self.gap_m

    @property
    def springs(self) -> tuple[SpringHandle, ...]:
        """Springs of walls, keys and wing walls."""
        return (*self.wall_springs, *self.key_springs, *self.wing_springs)


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeModel:
    """A built model at rest under its dead load.

    Attributes:
        variant: The normalised variant.
        deck_nodes: Spine nodes, left to right.
        deck_centre_node: Spine node at the mass centre of the deck.
        deck_masses_kg: Horizontal masses of spine, caps and columns by node (vertical masses
            differ slightly).
        dead_loads_n: Downward nodal load by node.
        dead_moments_nm: Fixed-end moments of the dead load of deck and caps about x and y, by node.
        columns: Bent by bent.
        abutments: Left, right.
        contacts: The contact units, or None for models without contact.
        energy_elements: Element tags by group for the energy balance: ``columns, deck, bearings,
            backfill`` (wall, key, wing and restoring springs with their dashpots), ``contact``,
            ``links`` (stiff connections and foundation springs).
        damping_elements: Elements of the Rayleigh region: deck and columns only.
        tags: Allocator of the model, for the patterns, series and regions of an analysis.
    """

    variant: Variant
    bridge: BridgeData
    options: ModelOptions
    deck_nodes: tuple[int, ...]
    deck_centre_node: int
    deck_masses_kg: Mapping[int, float]
    dead_loads_n: Mapping[int, float]
    dead_moments_nm: Mapping[int, tuple[float, float]]
    columns: tuple[ColumnHandle, ...]
    abutments: tuple[AbutmentHandle, AbutmentHandle]
    contacts: ContactSet | None
    energy_elements: Mapping[str, tuple[int, ...]]
    damping_elements: tuple[int, ...]
    tags: TagAllocator

    @property
    def weight_n(self) -> float:
        """Total dead load."""
        return sum(self.dead_loads_n.values())
