"""A bridge as analyses see it: a frame with deck ends, columns and damping, before its joints.

A `Structure` is a file of the catalogue or a script of the user. It builds a `Frame` in the empty
domain: everything except the joints at its deck ends, before dead load. `bridge.model` then applies
the dead load, adds joints and contacts, and returns a `BridgeModel`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from skewbridge.bridge.catalogue.data import EndData, JointData
from skewbridge.bridge.column import BentCapacity
from skewbridge.bridge.handles import AbutmentHandle, ColumnHandle, JointHandle, TagAllocator
from skewbridge.bridge.plan import DeckEnd, PlanVector
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

if TYPE_CHECKING:
    from skewbridge.bridge.script_units import UnitSystem
    from skewbridge.contact import ContactSet  # pages and digests need no OpenSees


@dataclass(frozen=True, slots=True, kw_only=True)
class Blueprint:
    """What all parts of the model of a variant use.

    Attributes:
        variant: The normalised variant.
        tags: Tag allocator of the model, also for the patterns, series and regions of an analysis.
        contacts: The contact units, or None for models without contact.
    """

    variant: Variant
    options: ModelOptions
    tags: TagAllocator
    contacts: "ContactSet | None"


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadLoad:
    """Dead load and mass by node.

    Attributes:
        forces_n: Downward force.
        moments_nm: Fixed-end moments about x and y.
        masses_kg: Horizontal mass of deck, caps and columns; the masses are already in the domain.
    """

    forces_n: Mapping[int, float]
    moments_nm: Mapping[int, tuple[float, float]]
    masses_kg: Mapping[int, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Rayleigh damping: one ratio at two periods, of these elements and their nodes."""

    ratio: float
    long_period_s: float
    short_period_s: float
    elements: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """One end of a deck that will get a joint.

    Attributes:
        node: End node at the centroid of the deck.
        plan: Position, skew and size in plan.
        abutment: Data of its abutment, of any kind in `skewbridge.bridge.ends`.
    """

    node: int
    plan: DeckEnd
    abutment: EndData


@dataclass(frozen=True, slots=True, kw_only=True)
class InnerJoint:
    """Two deck ends that face each other.

    Attributes:
        name: ``joint 1`` and so on.
        ends: End of the left deck and of the right deck, with outer faces at the same place.
        nodes: End nodes of both decks at their centroid.
        holders: Node that carries the pads of each end, or None for an end without pads.
        axial_n_per_m: Axial stiffness of both decks in series.
    """

    name: str
    ends: tuple[DeckEnd, DeckEnd]
    nodes: tuple[int, int]
    holders: tuple[int | None, int | None]
    data: JointData
    axial_n_per_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A bridge in the open domain without joints, before dead load.

    Attributes:
        centre_node: Node at the mass centre of the deck; its displacements are those of the deck.
        loads: Dead load and masses.
        ends: Deck ends at abutments, left to right.
        joints: Joints inside the bridge, left to right.
        columns: All columns, in the order of the bents.
        damping: Rayleigh damping of deck and columns.
        elements: Elements of the energy-balance groups ``columns``, ``deck`` and ``links`` (stiff
            connections and foundation springs). Elements of columns are recorded; those of deck
            and links are elastic beams or springs.
        units: Units of the domain behind its SI view; None if it has SI units.
        bents: Capacities of the bents under a rigid deck; empty if the bridge does not state them.
    """

    centre_node: int
    loads: DeadLoad
    ends: tuple[End, ...]
    columns: tuple[ColumnHandle, ...]
    damping: Damping
    elements: Mapping[str, tuple[int, ...]]
    joints: tuple[InnerJoint, ...] = ()
    bents: tuple[BentCapacity, ...] = ()
    units: "UnitSystem | None" = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """What a bridge says about itself, for pages, answers and checks; lengths in m.

    Attributes:
        details: ``surrogate`` or ``published`` details, or a ``script``.
        bent_heights_m: Clear height of each bent.
        bent_columns: Number of columns of each bent.
        bent_bases: How the columns of each bent stand; empty if it is not known.
        columns_m: Places of the columns at zero skew: along the bridge from its middle, and across.
        outlines_m: Points of the outline of each column: along its bent, and normal to it.
        seats_m: Seat width of each seat end and inner joint by its name.
        end_kinds: Kind of each end by its name, such as ``seat`` or ``integral``.
        skews_deg: Own skew of the ends and inner joints that have one.
        joints_m: Place of each inner joint along the bridge from its middle, by its place in words.
        wall_m: Thickness of the backwalls.
        backfill_rule: Rule of the backfill.
        damping_ratio: Ratio of the Rayleigh damping.
        on_springs: Whether the columns stand on foundation springs.
    """

    title: str
    details: str
    spans_m: tuple[float, ...]
    width_m: float
    bent_heights_m: tuple[float, ...]
    bent_columns: tuple[int, ...]
    bent_bases: tuple[str, ...]
    columns_m: tuple[PlanVector, ...]
    outlines_m: tuple[Sequence[Sequence[float]], ...]
    seats_m: Mapping[str, float]
    end_kinds: Mapping[str, str]
    wall_m: float
    backfill_rule: str
    damping_ratio: float
    on_springs: bool = False
    skews_deg: Mapping[str, float] = field(default_factory=dict[str, float])
    joints_m: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def bases(self) -> str:
        """Bases of all bents in words."""
        return " and ".join(sorted({*self.bent_bases} - {""}))

    @property
    def length_m(self) -> float:
        """Total length."""
        return sum(self.spans_m)


class Structure(Protocol):
    """A bridge that can be built: a file of the catalogue or a script."""

    @property
    def name(self) -> str:
        """Name in tables and file names."""
        ...

    @property
    def digest(self) -> str:
        """Digest of everything that its analyses depend on."""
        ...

    @property
    def t1_s(self) -> float:
        """Conditioning period in s."""
        ...

    @property
    def description(self) -> Description:
        """What it says about itself."""
        ...

    @property
    def ignored(self) -> frozenset[str]:
        """Modelling options that do not act on it."""
        ...

    def build(self, skew_deg: float, options: ModelOptions, tags: TagAllocator) -> Frame:
        """Build the frame in the open, empty domain, for a skew of the abutments."""
        ...


def require_options(bridge: Structure, names: Iterable[str]) -> None:
    """Raise an `InputError` for modelling options that do not act on a bridge."""
    if useless := sorted(bridge.ignored.intersection(names)):
        raise InputError(
            f"{', '.join(useless)} cannot act on the elements of the script {bridge.name}.py: add "
            "parameters of that name to its function, or leave the bridge or these options out"
        )


@dataclass(frozen=True, kw_only=True)
class BridgeModel:
    """A built model at rest under its dead load: frame, joints and contacts of a variant."""

    blueprint: Blueprint
    frame: Frame
    abutments: tuple[AbutmentHandle, ...]
    joints: tuple[JointHandle, ...] = ()

    @property
    def variant(self) -> Variant:
        """The normalised variant."""
        return self.blueprint.variant

    @property
    def options(self) -> ModelOptions:
        """Modelling options of the variant."""
        return self.blueprint.options

    @property
    def tags(self) -> TagAllocator:
        """Tags of the domain."""
        return self.blueprint.tags

    @property
    def contacts(self) -> "ContactSet | None":
        """The contact units, or None."""
        return self.blueprint.contacts

    @property
    def columns(self) -> tuple[ColumnHandle, ...]:
        """All columns, in the order of the bents."""
        return self.frame.columns

    @property
    def seats(self) -> tuple[AbutmentHandle, ...]:
        """Abutments with a seat, from which the deck can fall."""
        return tuple(end for end in self.abutments if end.is_seat)

    @property
    def weight_n(self) -> float:
        """Total dead load."""
        return sum(self.frame.loads.forces_n.values())

    @property
    def energy_elements(self) -> dict[str, tuple[int, ...]]:
        """Element tags of each energy-balance group.

        ``bearings`` include restrainers; ``backfill`` all springs of walls, keys and wings with
        their dashpots; ``links`` stiff connections and foundation springs.
        """
        ends, units = self.abutments, self.contacts.units if self.contacts else ()
        springs = {spring.element for end in ends for spring in end.springs}
        others = {element for end in ends for element in end.other_springs}
        arms = (arm for end in (*ends, *self.joints) for arm in end.links)
        pads = (bearing for end in (*ends, *self.joints) for bearing in end.bearings)
        cables = (cable for joint in self.joints for cable in joint.restrainers)
        return {
            **self.frame.elements,
            "bearings": (*(pad.element for pad in pads), *cables),
            "backfill": tuple(sorted(springs | others)),
            "contact": tuple(unit.element for unit in units),
            "links": (*self.frame.elements.get("links", ()), *arms),
        }
