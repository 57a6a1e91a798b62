"""Bridges of the catalogue that can be built."""

from dataclasses import dataclass
from math import cos, radians, sqrt
from typing import Any

from skewbridge.bridge.catalogue import BridgeData, load_bridge
from skewbridge.bridge.catalogue.data import AbutmentData
from skewbridge.bridge.column import bent_capacities
from skewbridge.bridge.frame import Damping, DeadLoad, Description, End, Frame
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.plan import DeckEnd
from skewbridge.files.digests import digest_of
from skewbridge.variant.options import ModelOptions


@dataclass(frozen=True, slots=True)
class CatalogueBridge:
    """Straight deck on bents, from a bridge file: a `Structure`."""

    data: BridgeData

    @property
    def name(self) -> str:
        """Name of its file."""
        return self.data.name

    @property
    def digest(self) -> str:
        """Digest of its numbers."""
        return digest_of(self.data.model_dump_json(exclude={"title", "sources"}))

    @property
    def t1_s(self) -> float:
        """Conditioning period."""
        return self.data.t1_s

    @property
    def ignored(self) -> frozenset[str]:
        """Modelling options that do not act: none."""
        return frozenset()

    @property
    def description(self) -> Description:
        """What pages say about it."""
        data = self.data
        seat_m = data.abutment.seat_width_m
        return Description(
            title=data.title,
            details=data.details,
            spans_m=data.spans_m,
            width_m=data.deck.width_m,
            bent_heights_m=tuple(bent.clear_height_m for bent in data.bents),
            bent_columns=tuple(bent.columns for bent in data.bents),
            columns_m=tuple(
                (x, (place - (bent.columns - 1) / 2) * bent.column_spacing_m)
                for x, bent in zip(data.bent_positions_m, data.bents, strict=True)
                for place in range(bent.columns)
            ),
            outlines_m=tuple(
                data.column_of(bent).outline.points(48).tolist()
                for bent in data.bents
                for _ in range(bent.columns)
            ),
            bent_bases=tuple(map(data.base_of, data.bents)),
            on_springs=data.foundation is not None,
            wall_m=data.abutment.wall_thickness_m,
            backfill_rule=data.abutment.backfill.rule,
            damping_ratio=data.damping.ratio,
            seats_m={"left": seat_m, "right": seat_m},
        )

    def build(self, skew_deg: float, options: ModelOptions, tags: TagAllocator) -> Frame:
        """Build spine and bents in the open domain; see `Structure`."""
        # Imported here: pages and digests need bridges but not OpenSees.
        from skewbridge.bridge.bent import build_bents
        from skewbridge.bridge.spine import build_spine

        bridge = built_bridge(self.data, options, skew_deg)
        spine = build_spine(bridge, options.deck_elements_per_span, tags)
        bent_skew_deg = options.skew_of_bents_deg(skew_deg)
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
                End(node=node, plan=plan, abutment=bridge.abutment)
                for node, plan in zip(
                    (spine.nodes[0], spine.nodes[-1]), deck_ends(bridge, skew_deg), strict=True
                )
            ),
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
    size = skew_deg, deck.width_m, deck.diaphragm_thickness_m
    return (
        DeckEnd("left", (-half, 0.0), (-1.0, 0.0), *size),
        DeckEnd("right", (half, 0.0), (1.0, 0.0), *size),
    )


def built_bridge(bridge: BridgeData, options: ModelOptions, skew_deg: float = 0.0) -> BridgeData:
    """Return a bridge with materials, mass, pads and keys multiplied by the option factors.

    Bents of a skewed bridge get the column spacing along the bent and the weight of their longer
    cap. The factors on damping and backfill are applied where damping and backfill are computed.
    """
    # the cap of a skewed bent ends at the edges of the deck
    stretch = 1.0 / cos(radians(options.skew_of_bents_deg(skew_deg)))
    spacing = stretch if options.column_spacing == "normal" else 1.0
    concrete, steel = options.concrete_strength_factor, options.steel_strength_factor
    mass = options.deck_mass_factor
    column = {
        "concrete_strength_mpa": concrete,
        "expected_concrete_strength_mpa": concrete,
        "elastic_modulus_gpa": sqrt(concrete),
        "steel_strength_factor": steel,
        "hoop_yield_mpa": steel,
    }
    bents = {"cap_weight_kn": mass * stretch, "column_spacing_m": spacing, "column": column}
    factors = {
        "column": column,
        "deck": {"line_load_kn_per_m": mass, "diaphragm_weight_kn": mass},
        "bents": bents,
    }
    abutment = built_abutment(abutment_of(bridge.deck.width_m, options) or bridge.abutment, options)
    return _scaled(bridge, factors).model_copy(update={"abutment": abutment})


def built_abutment(abutment: AbutmentData, options: ModelOptions) -> AbutmentData:
    """Return the data of an abutment with pads and keys multiplied by the option factors."""
    key = {"force_kn": options.key_strength_factor}
    factors = {
        # ASSUME a softer rubber keeps its vertical stiffness, which hardly affects demands
        "pads": {
            "shear_stiffness_kn_per_m": options.pad_stiffness_factor,
            "yield_force_kn": options.pad_strength_factor,
        },
        "sacrificial_key": key,
        "monolithic_key": key,
    }
    return _scaled(abutment, factors)


def abutment_of(width_m: float, options: ModelOptions) -> AbutmentData | None:
    """Return the abutment of the bridge in the option ``abutment_of``, if set, for a deck width."""
    if options.abutment_of is None:
        return None
    donor = load_bridge(options.abutment_of)
    return widened(donor.abutment, width_m / donor.deck.width_m)


def widened(abutment: AbutmentData, ratio: float) -> AbutmentData:
    """Return the data of an abutment for a wider deck: the same per metre, and the same wings."""
    # ASSUME dead load, and with it pads and keys, is proportional to the width of the deck
    key = {"force_kn": ratio}
    factors = {
        "wall_width_m": ratio,
        "key_mass_t": ratio,
        "pads": {
            "spacing_m": ratio,
            "shear_stiffness_kn_per_m": ratio,
            "yield_force_kn": ratio,
            "vertical_stiffness_mn_per_m": ratio,
        },
        "sacrificial_key": key,
        "monolithic_key": key,
        "wing_length_ratio": 1.0 / ratio,
    }
    if abutment.backfill.rule == "k50":  # of the whole wall, the other rule is per metre
        factors["backfill"] = {"stiffness_mn_per_m": ratio, "ultimate_kn": ratio}
    return _scaled(abutment, factors)


def _scaled(value: Any, factors: Any) -> Any:
    """Return a number, tuple items or the named fields of a part, multiplied by the factors."""
    if value is None:
        return None
    if isinstance(value, tuple):
        return tuple(_scaled(item, factors) for item in value)
    if isinstance(factors, dict):
        update = {name: _scaled(getattr(value, name), each) for name, each in factors.items()}
        return value.model_copy(update=update)
    return factors * value
