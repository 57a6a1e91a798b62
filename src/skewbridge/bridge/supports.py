"""Supports of a deck end: stiff arms to the points of the joint, and pads or vertical supports.

The arms run from the end node of the spine to the tops of the pads on the bearing line, and to the
points of the outer face of the end diaphragm that touch walls and keys. All these points are at the
level of the soffit.
"""

from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.deck import DeckEnd, Line
from skewbridge.bridge.handles import BearingHandle, TagAllocator
from skewbridge.bridge.springs import elastic_material, grounded_node
from skewbridge.contact.element import uniaxial
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions

# Far stiffer than the deck's end element (1e10 N/m), soft enough for double precision. A hundredth
# of it needs 8 to 15 % more iterations.
ARM_MODULUS_PA = 2.5e13
ARM_AREA_M2 = 10.0
ARM_INERTIA_M4 = 10.0


#: Nodes of the joint at one deck end, by line and position along the wall.
type Points = dict[tuple[Line, float], int]


def build_arms(
    end: DeckEnd,
    deck_node: int,
    stations: dict[Line, list[float]],
    options: ModelOptions,
    tags: TagAllocator,
) -> tuple[Points, list[int]]:
    """Create the points of a deck end and stiff arms to them from the end node of the spine.

    Stations are the positions along the wall at which each line needs a node. Returns points and
    elements.
    """
    transformation = tags.transformation()
    geometry = "Corotational" if options.arrays == "corotational" else "Linear"
    # no arm is parallel to the normal of the wall
    ops.geomTransf(geometry, transformation, *end.normal, 0.0)
    # the points do not turn: an arm has a ball joint there, and no torsion
    section = (ARM_AREA_M2, ARM_MODULUS_PA, 1.0, 1.0, ARM_INERTIA_M4, ARM_INERTIA_M4)
    joint = ("-releasez", 2, "-releasey", 2)
    points: Points = {}
    arms: list[int] = []
    for line, positions in stations.items():
        for along in positions:
            node, element = tags.node(), tags.element()
            ops.node(node, *end.point(line, along), 0.0)
            ops.fix(node, 0, 0, 0, 1, 1, 1)
            nodes = (element, deck_node, node)
            ops.element("elasticBeamColumn", *nodes, *section, transformation, *joint)
            points[line, along] = node
            arms.append(element)
    return points, arms


# ASSUME bending and twisting of a pad are too soft to matter
PAD_ROTATION_NM_PER_RAD = 1.0e5
# source: PyPBEE, no quadratic hardening of the pads
PAD_HARDENING = (0.0, 3.0)  # quadratic share and its exponent


def pad_stations(pads: PadData, end: DeckEnd) -> list[float]:
    """Return positions of the pads along the wall, equally spaced across the deck."""
    stretch = end.wall_length_m / end.width_m
    middle = (pads.count - 1) / 2
    return [(i - middle) * pads.spacing_m * stretch for i in range(pads.count)]


def bearing_stations(
    pads: PadData, end: DeckEnd, options: ModelOptions, *, has_pads: bool = True
) -> list[float]:
    """Return the positions along the wall of pad elements, or of supports at both ends.

    Two pad elements are placed so that they have the rotational stiffness of all pads.
    """
    if not has_pads:
        return [-end.wall_length_m / 2, end.wall_length_m / 2]
    stations = pad_stations(pads, end)
    if options.pads == "each":
        return stations
    arm = sqrt(sum(along**2 for along in stations) / len(stations))
    return [-arm, arm]


def build_bearings(
    end: DeckEnd,
    points: Points,
    pads: PadData,
    options: ModelOptions,
    tags: TagAllocator,
    *,
    has_pads: bool = True,
) -> tuple[BearingHandle, ...]:
    """Create pads, or vertical supports, between fixed seat nodes and the bearing line.

    Vertical springs are elastic in compression and open in tension. A bearing element per pad is a
    pad height long; elements that are half of the pads, or a support, have no length.
    """
    is_each = has_pads and options.pads == "each"
    number, height_m = (1, pads.height_m) if is_each else (pads.count / 2, 0.0)
    upright = uniaxial(tags, "ENT", number * (pads.vertical_stiffness_mn_per_m * 1e6))
    if not has_pads:
        kind, values = "zeroLength", ("-mat", upright, "-dir", 3)
    elif is_each:
        bend = elastic_material(PAD_ROTATION_NM_PER_RAD, tags)
        elastic = pads.shear_stiffness_kn_per_m * KN, pads.yield_force_kn * KN
        springs = ("-P", upright, "-T", bend, "-My", bend, "-Mz", bend, "-orient", *end.normal, 0.0)
        kind = "elastomericBearingPlasticity"
        values = (*elastic, pads.hardening_ratio, *PAD_HARDENING, *springs)
    else:
        # ASSUME the pads do not resist rotation: their stiffness is too small to matter
        # axial force along z, shear along x and y of the model
        axes = ("-orient", 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
        kind, values = "zeroLengthSection", (_pad_section(pads, number, upright, tags), *axes)
    handles: list[BearingHandle] = []
    for deck_node in (node for (line, _), node in points.items() if line == "bearing"):
        x, y, z = ops.nodeCoord(deck_node)
        seat, element = grounded_node((x, y, z - height_m), tags), tags.element()
        ops.element(kind, element, seat, deck_node, *values)
        handles.append(BearingHandle(element=element, seat_node=seat, deck_node=deck_node))
    return tuple(handles)


def _pad_section(pads: PadData, number: float, upright: int, tags: TagAllocator) -> int:
    """Create the section of some pads: vertical spring, and a yield circle of the shear force.

    The shear law is that of the bearing element, a plastic spring of the characteristic strength in
    parallel with an elastic one, at a tenth of the cost.
    """
    plastic = 1.0 - pads.hardening_ratio
    stiffness = number * pads.shear_stiffness_kn_per_m * KN
    hardening = stiffness * pads.hardening_ratio / plastic
    shear, section = tags.section(), tags.section()
    strength_n, directions = number * pads.yield_force_kn * KN / plastic, ("Vy", "Vz")
    ops.section("Bidirectional", shear, stiffness, strength_n, 0.0, hardening, *directions)
    ops.section("Aggregator", section, upright, "P", "-section", shear)
    return section
