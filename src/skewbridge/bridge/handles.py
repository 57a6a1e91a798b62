"""Handles of a built model for the analyses: tags, positions and data to compute demands.

Axes: x longitudinal, y transverse, z up, origin in plan at the middle of the deck. Every handle
is valid only inside the `domain()` in which the model was built.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count

from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.section import ShearSection
from skewbridge.contact import ContactSet
from skewbridge.variant.options import ModelOptions, ShearModel
from skewbridge.variant.variant import Variant


class TagAllocator:
    """Hands out consecutive tags per kind; works as the tag source of a `ContactSet`."""

    def __init__(self) -> None:
        self.node, self.element, self.region = (count(1).__next__ for _ in range(3))
        self.material, self.section, self.integration = (count(1).__next__ for _ in range(3))
        self.transformation, self.parameter = (count(1).__next__ for _ in range(2))
        self.series, self.pattern = (count(1).__next__ for _ in range(2))


type PlanVector = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Point:
    """A point that moves rigidly with a node, at an arm along x, y and z from it."""

    node: int
    arm_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpringHandle:
    """One spring of a zeroLength element, from the ground side to the deck side.

    Attributes:
        component: 0-based place in ``basicForce`` and ``basicDeformation``.
        direction: Plan unit vector of positive deformation (second node minus first).
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
        top: Top of the column at the soffit, ``clear_height_m`` above the base node.
        hinge_sections: 1-based integration points where plastic curvature is read, for
            ``eleResponse(element, "section", str(k), "deformation")`` = (axial, about z, about y,
            torsion); empty for elastic columns.
        yield_curvature_per_m: Idealised yield curvature under dead load.
        yield_drift_ratio: Idealised yield displacement over clear height, for the displacement
            ductility in the shear capacity; the drift capacity is by the Caltrans criteria.
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

    ``side`` is ``left`` or ``right``, ``kind`` ``acute`` or ``obtuse``; zero skew counts as
    positive.
    """

    node: int
    side: str
    kind: str
    plan_m: PlanVector

    @property
    def column(self) -> str:
        """Start of the names of its displacement columns in the histories."""
        return f"abutment_{self.side}_{self.kind}"


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingHandle:
    """Pads, or a vertical support, from the fixed seat node below to the deck node above."""

    element: int
    seat_node: int
    deck_node: int


@dataclass(frozen=True, slots=True, kw_only=True)
class AbutmentHandle:
    """One abutment with the deck end it supports; its lists fill while the joint is built.

    Attributes:
        side: ``left`` (negative x) or ``right``.
        normal: Outward normal of the deck end (towards the backfill), in plan.
        tangent: ``normal`` turned by +90 degrees: along the wall.
        gap_m: Opening of the joint at rest, normal to the wall; the transverse gap is at the keys.
        seat_width_m: From the backwall to the edge of the seat, normal to it.
        centre: Middle of the bearing line at the top of the pads.
        bearings: Elements of pads (each may represent several) or of supports; ``pads`` are the
            tops of all.
        links: Stiff arms from the end node of the deck to the points of the joint.
        wall_units: Indices of the backwall's contacts in `BridgeModel.contacts`, along
            ``tangent``; empty without contact. Those of the keys, and the nodes of both, likewise.
        wall_springs: Springs that push the deck away from the backfill: between ground and wall
            node with contact, between ground and deck without.
        key_springs: Backbones of the shear keys: between ground, or the body of `spring`, and key
            node; transverse springs of `simplified`.
        wing_springs: Wing-wall springs.
        other_springs: Elements of the gaps at the keys of `spring` (no demand reads them).
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
    links: tuple[int, ...] = ()
    wall_units: list[int] = field(default_factory=list[int])
    key_units: list[int] = field(default_factory=list[int])
    wall_nodes: list[int] = field(default_factory=list[int])
    key_nodes: list[int] = field(default_factory=list[int])
    wall_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    key_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    wing_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    other_springs: list[int] = field(default_factory=list[int])

    @property
    def support_length_m(self) -> float:
        """Length of deck on the seat at rest, normal to it."""
        return self.seat_width_m - self.gap_m

    @property
    def springs(self) -> tuple[SpringHandle, ...]:
        """Springs of walls, keys and wing walls."""
        return (*self.wall_springs, *self.key_springs, *self.wing_springs)


@dataclass(frozen=True, kw_only=True)
class Blueprint:
    """The variant to build, with the data that the parts of its model share.

    Attributes:
        variant: The normalised variant.
        bridge: Its data, with the factors of the options.
        tags: Allocator of the model, also for the patterns, series and regions of an analysis.
        contacts: The contact units, or None for models without contact.
    """

    variant: Variant
    bridge: BridgeData
    options: ModelOptions
    tags: TagAllocator
    contacts: ContactSet | None


@dataclass(frozen=True, kw_only=True)
class BridgeModel(Blueprint):
    """A built model at rest under its dead load.

    Attributes:
        deck_nodes: Spine nodes, left to right.
        deck_centre_node: Spine node at the mass centre of the deck.
        deck_masses_kg: Horizontal masses of spine, caps and columns by node (vertical masses
            differ slightly).
        dead_loads_n: Downward nodal load by node.
        dead_moments_nm: Fixed-end moments of the dead load of deck and caps about x and y, by node.
        columns: Bent by bent.
        abutments: Left, right.
        energy_elements: Element tags by group for the energy balance: ``columns, deck, bearings,
            backfill`` (wall, key, wing and restoring springs with their dashpots), ``contact``,
            ``links`` (stiff connections and foundation springs).
        damping_elements: Elements of the Rayleigh region: deck and columns only.
    """

    deck_nodes: tuple[int, ...]
    deck_centre_node: int
    deck_masses_kg: Mapping[int, float]
    dead_loads_n: Mapping[int, float]
    dead_moments_nm: Mapping[int, tuple[float, float]]
    columns: tuple[ColumnHandle, ...]
    abutments: tuple[AbutmentHandle, AbutmentHandle]
    energy_elements: Mapping[str, tuple[int, ...]]
    damping_elements: tuple[int, ...]

    @property
    def weight_n(self) -> float:
        """Total dead load."""
        return sum(self.dead_loads_n.values())
