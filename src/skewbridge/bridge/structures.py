"""Bridges of the catalogue that can be built."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, radians, sqrt
from typing import TYPE_CHECKING, Any

from skewbridge.bridge.catalogue import BridgeData
from skewbridge.bridge.catalogue.data import AbutmentData, EndData
from skewbridge.bridge.column import bent_capacities
from skewbridge.bridge.frame import (
    BearingLine,
    Damping,
    DeadLoad,
    Description,
    End,
    Frame,
    InnerJoint,
)
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.plan import DeckEnd
from skewbridge.files.digests import digest_of
from skewbridge.units import GPA
from skewbridge.variant.options import ModelOptions

if TYPE_CHECKING:
    from skewbridge.bridge.spine import Spine


@dataclass(frozen=True, slots=True)
class CatalogueBridge:
    """Straight deck on bents, from a bridge file: a `Structure`."""

    data: BridgeData

    @property
    def name(self) -> str:
        """Name of the bridge file without ending."""
        return self.data.name

    @property
    def digest(self) -> str:
        """Digest of all numbers of the bridge."""
        return digest_of(self.data.model_dump_json(exclude={"title", "sources"}))

    @property
    def t1_s(self) -> float:
        """Conditioning period in s."""
        return self.data.t1_s

    @property
    def ignored(self) -> frozenset[str]:
        """Modelling options without effect: none."""
        return frozenset()

    @property
    def description(self) -> Description:
        """Description for pages, printed tables and checks."""
        data = self.data
        joints = {f"joint {number}": joint for number, joint in enumerate(data.joints, start=1)}
        return Description(
            title=data.title,
            details=data.details,
            spans_m=data.spans_m,
            width_m=data.deck.width_m,
            bent_heights_m=tuple(bent.clear_height_m for bent in data.bents),
            bent_columns=tuple(bent.columns for bent in data.bents),
            columns_m=tuple(
                (x, (column - (bent.columns - 1) / 2) * bent.column_spacing_m)
                for x, bent in zip(data.bent_positions_m, data.bents, strict=True)
                for column in range(bent.columns)
            ),
            outlines_m=tuple(
                data.column_of(bent).outline.points(48).tolist()
                for bent in data.bents
                for _ in range(bent.columns)
            ),
            bent_bases=tuple(map(data.base_of, data.bents)),
            on_springs=data.foundation is not None,
            pads_at=tuple(f"bent {n}" for n, bent in enumerate(data.bents, 1) if bent.pads),
            end_kinds={name: end.type for name, end in data.ends.items()},
            skews_deg={
                name: skewed_part.skew_deg
                for name, skewed_part in {**data.ends, **joints}.items()
                if skewed_part.skew_deg is not None
            },
            gaps_mm={
                name: support.gap_mm
                for name, support in {**data.seats, **joints}.items()
                if support.gap_mm is not None
            },
            joints_m={
                joint.at or f"{joint.from_left_m:g} m from the left": x
                for joint, x in zip(data.joints, data.joint_positions_m, strict=True)
            },
            keys_at={name: seat.keys_at for name, seat in data.seats.items()},
            wall_m=max((seat.wall_thickness_m for seat in data.seats.values()), default=0.0),
            backfill_rule="".join({seat.backfill.rule for seat in data.seats.values()}),
            damping_ratio=data.damping.ratio,
            seats_m={name: seat.seat_width_m for name, seat in data.seats.items()}
            | {name: joint.seat_width_m for name, joint in joints.items()},
        )

    def build(self, skew_deg: float, options: ModelOptions, tags: TagAllocator) -> Frame:
        """Build spine and bents in the open domain; see `Structure`."""
        # Imported here: pages and digests need bridges but not OpenSees.
        from skewbridge.bridge.bent import build_bents
        from skewbridge.bridge.spine import build_spine

        bridge = built_bridge(self.data, options, skew_deg)
        spine = build_spine(bridge, options.deck_elements_per_span, skew_deg, tags)
        bent_skew_deg = options.skew_of_bents_deg(skew_deg)
        deck_nodes = list(spine.bent_nodes)  # bents with bearings have another node of their cap
        columns, foundations = build_bents(bridge, spine, bent_skew_deg, options, tags)
        elements = tuple(column.element for column in columns)
        damping = bridge.damping
        return Frame(
            centre_node=spine.centre_node,
            loads=DeadLoad(
                forces_n=dict(spine.loads_n),
                moments_nm=spine.moments_nm,
                masses_kg=spine.masses_kg(),
            ),
            ends=tuple(
                End(node=node, plan=plan, abutment=bridge.ends[plan.name])
                for node, plan in zip(
                    (spine.nodes[0], spine.nodes[-1]), deck_ends(bridge, skew_deg), strict=True
                )
            ),
            joints=tuple(_inner_joints(bridge, spine, options, skew_deg)),
            bearing_lines=tuple(_bearing_lines(bridge, deck_nodes, spine, bent_skew_deg)),
            columns=columns,
            damping=Damping(
                ratio=damping.ratio,
                long_period_s=damping.long_period_s,
                short_period_s=damping.short_period_s,
                elements=(*spine.elements, *elements),
            ),
            elements={"columns": elements, "deck": tuple(spine.elements), "links": foundations},
            bents=tuple(bent_capacities(bridge, options.hinge_rule)),
        )


def deck_ends(bridge: BridgeData, skew_deg: float) -> tuple[DeckEnd, DeckEnd]:
    """Return the left and the right end of the deck of a bridge in plan."""
    half, deck = bridge.length_m / 2, bridge.deck

    def end(name: str, sign: float) -> DeckEnd:
        end_skew_deg = bridge.ends[name].skew_deg
        skew = skew_deg if end_skew_deg is None else end_skew_deg
        skew_and_size = skew, deck.width_m, deck.diaphragm_thickness_m
        return DeckEnd(name, (sign * half, 0.0), (sign, 0.0), *skew_and_size)

    return end("left", -1.0), end("right", 1.0)


def _bearing_lines(
    bridge: BridgeData, deck_nodes: Sequence[int], spine: "Spine", skew_deg: float
) -> Iterator[BearingLine]:
    """Yield the bearings of the bents with pads, for a skew of the bents."""
    skew_and_size = skew_deg, bridge.deck.width_m, bridge.deck.diaphragm_thickness_m
    bents = zip(bridge.bents, bridge.bent_positions_m, deck_nodes, spine.bent_nodes, strict=True)
    for number, (bent, x, node, cap) in enumerate(bents, start=1):
        if bent.pads:
            plan = DeckEnd(f"bent {number}", (x, 0.0), (1.0, 0.0), *skew_and_size)
            yield BearingLine(plan=plan, node=node, cap=cap, pads=bent.pads)


def _inner_joints(
    bridge: BridgeData, spine: "Spine", options: ModelOptions, skew_deg: float
) -> Iterator[InnerJoint]:
    """Yield the joints between the decks of a spine whose bents are built."""
    deck, half_m = bridge.deck, bridge.length_m / 2
    ranges_m = pairwise((-half_m, *bridge.joint_positions_m, half_m))
    ea_n = deck.elastic_modulus_gpa * GPA * deck.area_m2
    # the stiffness of two decks in series, from the sum of their lengths
    axial_n_per_m = [ea_n / (left + right) for left, right in pairwise(b - a for a, b in ranges_m)]
    for number, data in enumerate(bridge.joints):
        default_deg = skew_deg if data.bent is None else options.skew_of_bents_deg(skew_deg)
        joint_deg = default_deg if data.skew_deg is None else data.skew_deg
        name, x = f"joint {number + 1}", bridge.joint_positions_m[number]
        to_bearing_m = deck.diaphragm_thickness_m / 2 / cos(radians(joint_deg))
        skew_and_size = joint_deg, deck.width_m, deck.diaphragm_thickness_m
        left = DeckEnd(f"{name} left", (x - to_bearing_m, 0.0), (1.0, 0.0), *skew_and_size)
        right = DeckEnd(f"{name} right", (x + to_bearing_m, 0.0), (-1.0, 0.0), *skew_and_size)
        nodes = spine.decks[number][-1], spine.decks[number + 1][0]
        holders = (None, nodes[0]) if data.ledge == "left" else (nodes[1], None)
        if data.bent is not None:
            holders = (spine.bent_nodes[data.bent], spine.bent_nodes[data.bent])
        yield InnerJoint(
            name=name,
            ends=(left, right),
            nodes=nodes,
            holders=holders,
            data=data,
            axial_n_per_m=axial_n_per_m[number],
        )


def built_bridge(bridge: BridgeData, options: ModelOptions, skew_deg: float = 0.0) -> BridgeData:
    """Return the bridge as built: multiplied by the option factors, with skewed bents.

    Diaphragms and caps along the skew are longer and heavier; columns are, by the option, further
    apart. Factors on damping and backfill are applied where damping and backfill are computed.
    """
    # the cap of a skewed bent ends at the edges of the deck
    stretch = 1.0 / cos(radians(options.skew_of_bents_deg(skew_deg)))
    spacing = stretch if options.column_spacing == "normal" else 1.0
    concrete, steel = options.concrete_strength_factor, options.steel_strength_factor
    mass = options.deck_mass_factor
    column_factors = {
        "concrete_strength_mpa": concrete,
        "expected_concrete_strength_mpa": concrete,
        "elastic_modulus_gpa": sqrt(concrete),
        "steel_strength_factor": steel,
        "hoop_yield_mpa": steel,
    }
    pads = _pad_factors(options)
    factors = {
        "joints": {"pads": pads},
        "column": column_factors,
        # ASSUME the weight of a diaphragm is that at zero skew, and all have the skew of the bridge
        "deck": {"line_load_kn_per_m": mass, "diaphragm_weight_kn": mass / cos(radians(skew_deg))},
        "bents": {
            "cap_weight_kn": mass * stretch,
            "column_spacing_m": spacing,
            "column": column_factors,
            "pads": pads,
        },
    }
    built_ends = {name: built_end(end, options) for name, end in bridge.ends.items()}
    if bridge.abutments is None:
        ends = {"abutment": built_ends["left"]}
    else:
        ends = {"abutments": bridge.abutments.model_copy(update=built_ends)}
    return _scaled(bridge, factors).model_copy(update=ends)


def _pad_factors(options: ModelOptions) -> dict[str, float]:
    # ASSUME a softer rubber keeps its vertical stiffness, which hardly affects demands
    return {
        "shear_stiffness_kn_per_m": options.pad_stiffness_factor,
        "yield_force_kn": options.pad_strength_factor,
    }


def built_end(abutment: EndData, options: ModelOptions) -> EndData:
    """Return an end with the data of pads and keys multiplied by the option factors."""
    if not isinstance(abutment, AbutmentData):
        return abutment
    key_factors = {"force_kn": options.key_strength_factor}
    factors = {
        "pads": _pad_factors(options),
        "sacrificial_key": key_factors,
        "monolithic_key": key_factors,
    }
    return _scaled(abutment, factors)


def widened(abutment: AbutmentData, ratio: float) -> AbutmentData:
    """Return an abutment for a deck ``ratio`` times as wide, equal per metre, same wing walls."""
    # ASSUME dead load, and with it pads and keys, is proportional to the width of the deck
    key_factors = {"force_kn": ratio}
    factors = {
        "wall_width_m": ratio,
        "key_mass_t": ratio,
        "pads": {
            "spacing_m": ratio,
            "shear_stiffness_kn_per_m": ratio,
            "yield_force_kn": ratio,
            "vertical_stiffness_mn_per_m": ratio,
        },
        "sacrificial_key": key_factors,
        "monolithic_key": key_factors,
        "wing_length_ratio": 1.0 / ratio,
    }
    if abutment.backfill.rule == "k50":  # of the whole wall, the other rule is per metre
        factors["backfill"] = {"stiffness_mn_per_m": ratio, "ultimate_kn": ratio}
    return _scaled(abutment, factors)


def _scaled(value: Any, factors: Any) -> Any:
    """Return a number, the items of a tuple or fields of a model, multiplied by the factors."""
    if value is None:
        return None
    if isinstance(value, tuple):
        return tuple(_scaled(element, factors) for element in value)
    if isinstance(factors, dict):
        scaled = {name: _scaled(getattr(value, name), factor) for name, factor in factors.items()}
        return value.model_copy(update=scaled)
    return factors * value
