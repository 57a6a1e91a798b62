"""A bridge as analyses see it: a frame with deck ends, columns and damping, before its joints.

A `Structure` is a file of the catalogue or a script of the user. It builds a `Frame` in the empty
domain: everything except the joints at its deck ends, before dead load. `bridge.model` then applies
the dead load, adds joints and contacts, and returns a `BridgeModel`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from skewbridge.bridge.catalogue.data import EndData, JointData, PadData
from skewbridge.bridge.column import BentCapacity
from skewbridge.bridge.handles import (
    AbutmentHandle,
    ColumnHandle,
    JointHandle,
    PadsHandle,
    TagAllocator,
)
from skewbridge.bridge.plan import DeckEnd, PlanVector
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

if TYPE_CHECKING:
    from skewbridge.bridge.script_units import UnitSystem
    from skewbridge.contact import ContactSet  # pages and digests need no OpenSees


@dataclass(frozen=True, slots=True, kw_only=True)
class Blueprint:
    """Data that all parts of the model of a variant share."""

    variant: Variant  # the normalised variant
    options: ModelOptions
    #: tag allocator of the model, also for the patterns, series and regions of an analysis
    tags: TagAllocator
    contacts: "ContactSet | None"  # the contact units, or None for models without contact


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadLoad:
    """Dead load and mass by node."""

    forces_n: Mapping[int, float]  # downward force
    moments_nm: Mapping[int, tuple[float, float]]  # fixed-end moments about x and y
    #: horizontal mass of deck, caps and columns; the masses are already in the domain
    masses_kg: Mapping[int, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Rayleigh damping of ``elements`` and their nodes: one ratio at two periods."""

    ratio: float
    long_period_s: float
    short_period_s: float
    elements: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """Deck end at an abutment, before its joint is built."""

    node: int  # end node at the centroid of the deck
    plan: DeckEnd  # position, skew and size in plan
    abutment: EndData  # data of its abutment, of any kind in `skewbridge.bridge.joints`


@dataclass(frozen=True, slots=True, kw_only=True)
class InnerJoint:
    """Joint inside a bridge, before it is built: two deck ends that face each other."""

    name: str  # ``joint 1`` and so on
    #: end of the left deck and of the right deck, with outer faces at the same place
    ends: tuple[DeckEnd, DeckEnd]
    nodes: tuple[int, int]  # end nodes of both decks at their centroid
    #: node that carries the pads of each end, or None for an end without pads
    holders: tuple[int | None, int | None]
    data: JointData
    axial_n_per_m: float  # axial stiffness of both decks in series


@dataclass(frozen=True, slots=True, kw_only=True)
class BearingLine:
    """Bearings below a deck that runs over a bent, before they are built."""

    plan: DeckEnd  # position, skew and width of the line in plan, named as its bent
    node: int  # node of the deck at its centroid
    cap: int  # node of the cap, at the bottom of the bearings
    pads: PadData


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """A bridge in the open domain without joints, before dead load."""

    centre_node: int  # node at the mass centre of the deck; its displacements are those of the deck
    loads: DeadLoad  # dead load and masses
    ends: tuple[End, ...]  # deck ends at abutments, left to right
    columns: tuple[ColumnHandle, ...]  # all columns, in the order of the bents
    damping: Damping  # Rayleigh damping of deck and columns
    #: elements of the energy-balance groups ``columns``, ``deck`` and ``links`` (stiff connections
    #: and foundation springs). Elements of columns are recorded; those of deck and links are
    #: elastic beams or springs.
    elements: Mapping[str, tuple[int, ...]]
    joints: tuple[InnerJoint, ...] = ()  # joints inside the bridge, left to right
    bearing_lines: tuple[BearingLine, ...] = ()  # at bents without a joint, left to right
    #: capacities of the bents under a rigid deck; empty if the bridge does not state them
    bents: tuple[BentCapacity, ...] = ()
    #: units of the domain behind its SI view; None if it has SI units
    units: "UnitSystem | None" = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """Description of a bridge for pages, printed tables and checks; lengths in m."""

    title: str
    details: str  # ``surrogate`` or ``published`` details, or a ``script``
    spans_m: tuple[float, ...]
    width_m: float
    bent_heights_m: tuple[float, ...]  # clear height of each bent
    bent_columns: tuple[int, ...]  # number of columns of each bent
    bent_bases: tuple[str, ...]  # how the columns of each bent stand; empty if it is not known
    #: positions of the columns at zero skew: along the bridge from its middle, and across
    columns_m: tuple[PlanVector, ...]
    #: points of the outline of each column: along its bent, and normal to it
    outlines_m: tuple[Sequence[Sequence[float]], ...]
    seats_m: Mapping[str, float]  # seat width of each seat end and inner joint by its name
    end_kinds: Mapping[str, str]  # kind of each end by its name, such as ``seat`` or ``integral``
    keys_at: Mapping[str, str]  # sides with a shear key of each seat end, such as ``both``
    wall_m: float  # thickness of the backwalls
    backfill_rule: str  # rule of the backfill
    damping_ratio: float  # ratio of the Rayleigh damping
    on_springs: bool = False  # whether the columns stand on foundation springs
    pads_at: tuple[str, ...] = ()  # bents (``bent 1``) over which the deck runs on bearings
    bents_turn: bool = True  # whether bents take the skew of the variant
    #: skew of the ends and inner joints that do not take that of the variant
    skews_deg: Mapping[str, float] = field(default_factory=dict[str, float])
    #: gap of the seats and inner joints that do not take that of the variant
    gaps_mm: Mapping[str, float] = field(default_factory=dict[str, float])
    #: position of each inner joint along the bridge from its middle, by its location in words
    joints_m: Mapping[str, float] = field(default_factory=dict[str, float])

    @property
    def end_seats_m(self) -> dict[str, float]:
        """Seat width of each seat end by its name."""
        return {name: self.seats_m[name] for name in self.end_kinds if name in self.seats_m}

    def support_lengths_m(self, gaps_m: Mapping[str, float]) -> dict[str, float]:
        """Return the length on the seat at rest (m), normal to it, by end or joint with a gap."""
        # on a cap, the middle of the gap is the end of both seats
        lost_m = {
            name: gap_m / (2.0 if name in self._joints_at_bents else 1.0)
            for name, gap_m in gaps_m.items()
        }
        return {name: self.seats_m[name] - lost_m[name] for name in gaps_m}

    @property
    def _joints_at_bents(self) -> set[str]:
        return {f"joint {n}" for n, at in enumerate(self.joints_m, start=1) if at[:4] == "bent"}

    def gaps_m(self, variant: Variant, options: ModelOptions) -> dict[str, float]:
        """Return the gap at rest (m), normal to its faces, of each seat end and inner joint.

        `InputError` if the gap of a joint is missing.
        """
        has_gap, gaps_m = "gap_mm" in variant.traits.axes, dict[str, float]()
        for name in self.seats_m:
            own_mm = self.gaps_mm.get(name) if has_gap or name not in self.end_kinds else 0.0
            if own_mm is None and not has_gap:
                reason = f"abutment model {variant.abutment} has no gap; or choose another"
                raise InputError(f"{name}: gap_mm must be in the bridge file, because {reason}")
            skew_deg = variant.skew_deg
            if name in self._joints_at_bents:
                skew_deg = options.skew_of_bents_deg(skew_deg)
            gap_mm = variant.gap_mm if own_mm is None else own_mm
            gaps_m[name] = options.normal_gap_m(gap_mm, self.skews_deg.get(name, skew_deg))
        return gaps_m

    def require_seats(self, variant: Variant, options: ModelOptions) -> None:
        """Raise an `InputError` if a gap is missing or leaves nothing of a seat."""
        gaps_m = self.gaps_m(variant, options)
        for name, length_m in self.support_lengths_m(gaps_m).items():
            if length_m <= 0.0:
                raise InputError(
                    f"{variant.bridge_name}: gap_mm must leave some of the {name} seat of "
                    f"{self.seats_m[name] * 1e3:g} mm, got {gaps_m[name] * 1e3:g} normal to it"
                    + f", with gap_offset_mm {options.gap_offset_mm:g}"
                    * bool(options.gap_offset_mm)
                )

    @property
    def takes_gap(self) -> bool:
        """Whether a seat end or an inner joint takes the gap of the variant."""
        return bool(self.seats_m.keys() - self.gaps_mm.keys())

    @property
    def takes_skew(self) -> bool:
        """Whether an end, an inner joint or a bent takes the skew of the variant."""
        supports = {*self.end_kinds, *self.seats_m} - self.skews_deg.keys()
        return bool(supports) or (self.bents_turn and bool(self.bent_columns))

    @property
    def axis_notes(self) -> list[str]:
        """Sentences on skew and gap that the bridge sets itself, or that it has no joint."""
        notes: list[str] = []
        if skews := ", ".join(f"{deg:g} deg ({name})" for name, deg in self.skews_deg.items()):
            others = "turns the other supports" if self.takes_skew else "has no effect"
            notes.append(f"the bridge file sets the skew: {skews}; skew_deg {others}")
        if not self.bents_turn and any(count > 1 for count in self.bent_columns):
            notes.append("skew_deg does not turn its bents: its function has no such parameter")
        if not self.seats_m:
            notes.append("gap_mm and friction have no effect: the bridge has no seats, no joints")
        own_gaps = self.own_values("gap_mm").items()
        if own := ", ".join(f"{gap_mm:g} mm at {at}" for at, gap_mm in own_gaps):
            others = "acts on the other joints" if self.takes_gap else "has no effect"
            if self.details == "script" and not self.takes_gap:
                others += ", though names of variants have it"
            notes.append(f"the bridge file sets the gap: {own}; gap_mm {others}")
        return notes

    def own_values(self, axis_name: str) -> dict[str, float]:
        """Return skews or gaps in the bridge file, keyed by ``the left end``, ``joint 1``, ..."""
        values = {"skew_deg": self.skews_deg, "gap_mm": self.gaps_mm}[axis_name]
        return {
            f"the {name} end" if name in self.end_kinds else name: value
            for name, value in values.items()
        }

    @property
    def bases(self) -> str:
        """Bases of all bents in words, such as ``fixed and pinned``."""
        return " and ".join(sorted({*self.bent_bases} - {""}))

    @property
    def without_effect(self) -> frozenset[str]:
        """Modelling options that do not act because there is no bent cap or foundation spring."""
        has_cap = any(count > 1 for count in self.bent_columns)
        cap_options = () if has_cap else ("cap_load", "column_spacing")
        return frozenset((*cap_options, *(() if self.on_springs else ("foundation",))))

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
        """Digest of all data of the bridge that change analyses."""
        ...

    @property
    def t1_s(self) -> float:
        """Conditioning period in s."""
        ...

    @property
    def description(self) -> Description:
        """Description for pages, printed tables and checks."""
        ...

    @property
    def ignored(self) -> frozenset[str]:
        """Modelling options without effect on the bridge."""
        ...

    def build(self, skew_deg: float, options: ModelOptions, tags: TagAllocator) -> Frame:
        """Build the frame in the open, empty domain, for a skew of the abutments."""
        ...


def require_options(bridge: Structure, names: Iterable[str]) -> None:
    """Raise an `InputError` for modelling options that do not act on a bridge."""
    if ignored := sorted(bridge.ignored.intersection(names)):
        raise InputError(
            f"{', '.join(ignored)} cannot act on the elements of the script {bridge.name}.py: add "
            "parameters of that name to its function, or leave the bridge or these options out"
        )


@dataclass(frozen=True, kw_only=True)
class BridgeModel(Blueprint):
    """A built model at rest under its dead load: frame, joints and contacts of a variant."""

    frame: Frame
    abutments: tuple[AbutmentHandle, ...]
    joints: tuple[JointHandle, ...] = ()
    bearing_lines: tuple[PadsHandle, ...] = ()

    @property
    def inner_pads(self) -> tuple[PadsHandle, ...]:
        """Pads at inner joints and at bents without a joint."""
        return (*self.joints, *self.bearing_lines)

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
        other_springs = {element for end in ends for element in end.other_springs}
        arms = (arm for end in (*ends, *self.inner_pads) for arm in end.links)
        pads = (bearing for end in (*ends, *self.inner_pads) for bearing in end.bearings)
        cables = (cable for joint in self.joints for cable in joint.restrainers)
        return {
            **self.frame.elements,
            "bearings": (*(pad.element for pad in pads), *cables),
            "backfill": tuple(sorted(springs | other_springs)),
            "contact": tuple(unit.element for unit in units),
            "links": (*self.frame.elements.get("links", ()), *arms),
        }
