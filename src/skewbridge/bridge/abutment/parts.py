"""Common parts of the abutment models: context of one side, wall points, keys and the handle."""

from dataclasses import dataclass, field
from typing import Any

import openseespy.opensees as ops

from skewbridge.bridge.abutment.backfill import (
    Passive,
    radiation_n_s_per_m,
    variation_factors,
    wall_backfill,
    wing_share,
)
from skewbridge.bridge.abutment.elements import (
    damping_n_s_per_m,
    elastic_material,
    key_face_material,
    key_material,
    key_stiffness_n_per_m,
    spring_element,
)
from skewbridge.bridge.abutment.supports import Arms
from skewbridge.bridge.catalogue.data import AbutmentData, KeyData
from skewbridge.bridge.deck import DeckEnd, PlanVector, tributary_shares
from skewbridge.bridge.handles import (
    AbutmentHandle,
    BearingHandle,
    CornerHandle,
    Point,
    SpringHandle,
    TagAllocator,
)
from skewbridge.contact import ContactSet
from skewbridge.units import TONNE
from skewbridge.variant.options import ModelOptions

CONCRETE_KG_PER_M3 = 2400.0  # source: usual density of reinforced concrete


@dataclass(frozen=True, slots=True, kw_only=True)
class SideContext:
    """Data for building the joint of one side, with its deck end at rest."""

    end: DeckEnd
    arms: Arms
    bearings: tuple[BearingHandle, ...]
    pad_stations_m: tuple[float, ...]  # along the wall
    data: AbutmentData
    options: ModelOptions
    tags: TagAllocator
    gap_m: float
    friction: float
    contacts: ContactSet | None

    @property
    def key(self) -> KeyData:
        """Backbone of the shear keys under option ``keys``."""
        if self.options.keys == "monolithic":
            return self.data.monolithic_key
        return self.data.sacrificial_key

    def soil(self, passive: Passive) -> Passive:
        """Return the resistance of a soil with the factors of the options."""
        options = self.options
        return passive.scaled(options.backfill_strength_factor, options.backfill_stiffness_factor)

    def wall_parts(self) -> list[tuple[float, float, Passive]]:
        """Return position, share of the wall and backfill of each wall point."""
        options, end = self.options, self.end
        soil = options.backfill, end.skew_rad, options.backfill_height_exponent
        whole = self.soil(wall_backfill(self.data, *soil))
        stations = end.wall_stations(options.backwall_points)
        shares = tributary_shares(len(stations))
        factors = variation_factors(
            stations, end.skew_rad, options.backfill_variation, end.acute_sign
        )
        return [
            (along, share, whole.scaled(share * factor))
            for along, share, factor in zip(stations, shares, factors, strict=True)
        ]

    def key_inward_normal(self, sign: float) -> PlanVector:
        """Return the normal of a key's face, from the key towards the deck.

        Across the deck's edge by default, or along the skewed wall.

        Args:
            sign: +1 for the key at the end of the wall's tangent, -1 for the other.
        """
        along = self.end.tangent
        # ASSUME the face of a key is parallel to the edge of the deck
        if self.options.key_frame == "skewed":
            return (-sign * along[0], -sign * along[1])
        return (0.0, -sign if along[1] > 0.0 else sign)

    def key_spring(self, nodes: tuple[int, int], inward: PlanVector) -> SpringHandle:
        """Create the spring of a key: its backbone across the face and along it."""
        stiffness, mass_kg = key_stiffness_n_per_m(self.key), self.key_mass_kg
        dashpot_n_s_per_m = damping_n_s_per_m(self.options.wall_dashpot_ratio, stiffness, mass_kg)
        damped = elastic_material(0.0, self.tags, dashpot_n_s_per_m=dashpot_n_s_per_m)
        across = [key_material(self.key, self.tags), damped]
        # ASSUME elastic up to the same strength along the face, independent of the force across
        # it: a broken key gets friction from its residual force only, which is below the strength
        if self.options.key_along_face == "backbone":
            along = [key_face_material(self.key, self.tags), damped]
        else:
            along = [elastic_material(stiffness, self.tags, dashpot_n_s_per_m=dashpot_n_s_per_m)]
        return spring_element(nodes, inward, across, along, self.tags)[0]

    def wall_dashpot_n_s_per_m(
        self, stiffness_n_per_m: float, mass_kg: float, share: float = 1.0
    ) -> float:
        """Return the dashpot of a share of the wall, against the fill."""
        vs_mps = self.options.backfill_vs_mps
        if vs_mps is None:
            return damping_n_s_per_m(self.options.wall_dashpot_ratio, stiffness_n_per_m, mass_kg)
        return share * radiation_n_s_per_m(self.data, vs_mps)

    def wing_dashpot_n_s_per_m(self, wing: Passive, mass_kg: float, share: float = 1.0) -> float:
        """Return the dashpot of a share of the wing walls, along the backwall."""
        radiating = share * wing_share(self.data)
        return self.wall_dashpot_n_s_per_m(wing.stiffness_n_per_m, mass_kg, radiating)

    def moving_mass_kg(self, mass_kg: float) -> float:
        """Return the mass of a wall or key node: the given mass, or zero without ``wall_mass``."""
        return mass_kg if self.options.wall_mass else 0.0

    @property
    def wall_mass_kg(self) -> float:
        """Mass of the backwall."""
        data = self.data
        volume = self.end.wall_length_m * data.wall_height_m * data.wall_thickness_m
        return volume * CONCRETE_KG_PER_M3

    @property
    def key_mass_kg(self) -> float:
        """Mass of one exterior key."""
        return self.data.key_mass_t * TONNE


@dataclass(kw_only=True)
class SideParts:
    """Parts that an abutment model built on one side, named as in `AbutmentHandle`."""

    wall_units: list[int] = field(default_factory=list[int])
    key_units: list[int] = field(default_factory=list[int])
    wall_nodes: list[int] = field(default_factory=list[int])
    key_nodes: list[int] = field(default_factory=list[int])
    wall_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    key_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    wing_springs: list[SpringHandle] = field(default_factory=list[SpringHandle])
    other_springs: list[int] = field(default_factory=list[int])


def side_handle(context: SideContext, parts: SideParts) -> AbutmentHandle:
    """Return the handle of a built side."""
    end, half = context.end, context.end.wall_length_m / 2
    corners = tuple(
        CornerHandle(
            node=context.arms.at("outer", sign * half),
            kind="acute" if sign == end.acute_sign else "obtuse",
            plan_m=end.point("outer", sign * half),
        )
        for sign in (-1.0, 1.0)
    )
    built: dict[str, Any] = {name: tuple(part) for name, part in vars(parts).items()}
    return AbutmentHandle(
        side=end.side,
        normal=end.normal,
        tangent=end.tangent,
        gap_m=context.gap_m,
        transverse_gap_m=context.options.transverse_gap_m,
        seat_width_m=context.data.seat_width_m,
        centre=_point_of_end(context, 0.0),
        corners=corners,
        bearings=context.bearings,
        pads=tuple(_point_of_end(context, along) for along in context.pad_stations_m),
        links=tuple(context.arms.elements),
        **built,
    )


def _point_of_end(context: SideContext, along_m: float) -> Point:
    """Return the point of the deck end on the bearing line at a position along the wall."""
    node, tangent = context.arms.deck_node, context.end.tangent
    z_m = float(ops.nodeCoord(node, 3))
    return Point(node, (along_m * tangent[0], along_m * tangent[1], -z_m))
