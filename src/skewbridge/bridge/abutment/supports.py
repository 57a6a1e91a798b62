"""Supports of a deck end: its transverse arrays, and elastomeric pads or vertical supports.

The three arrays run along the skewed line at the top of the pads: inner face, bearing line and
outer face of the end diaphragm. A link between deck and arrays lets the deck rotate about the axis
of the arrays; the arrays themselves cannot rotate about it.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import sqrt
from typing import Literal

import openseespy.opensees as ops

from skewbridge.bridge.abutment.elements import elastic_material, grounded_node
from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.deck import DeckEnd
from skewbridge.bridge.handles import BearingHandle, TagAllocator
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions

type Line = Literal["inner", "bearing", "outer"]

# Links far stiffer than the deck's end element (1e10 N/m), soft enough for double precision.
LINK_N_PER_M = 1.0e12
LINK_NM_PER_RAD = 1.0e13
# source: measured on OSB1: at this bending stiffness, arrays agree with rigid links within 0.6 %
# of column drift at skew 60
ARRAY_MODULUS_PA = 2.5e11
ARRAY_AREA_M2 = 10.0
ARRAY_INERTIA_M4 = 10.0
SAME_PLACE_M = 1e-6
_FAR_M = 1e6  # beyond the ends of any array


@dataclass(slots=True, kw_only=True)
class Arrays:
    """The arrays of one deck end.

    Attributes:
        centre_node: Node in the middle of the bearing line; all array points follow it.
        nodes: Nodes by line and position along the wall.
        links: Tags of the stiff elements.
    """

    centre_node: int
    nodes: dict[tuple[Line, float], int]
    links: list[int]

    def at(self, line: Line, along_m: float) -> int:
        """Return the node of a line nearest to a position along the wall."""
        stations = [along for name, along in self.nodes if name == line]
        nearest = min(stations, key=lambda along: abs(along - along_m))
        return self.nodes[line, nearest]


def build_arrays(
    end: DeckEnd,
    deck_node: int,
    stations: dict[Line, list[float]],
    options: ModelOptions,
    tags: TagAllocator,
) -> Arrays:
    """Create the arrays of a deck end and link them to the end node of the spine.

    Stations are the positions along the wall at which each array needs a node.
    """
    centre, links = _build_hinge(end, deck_node, tags)
    arrays = Arrays(centre_node=centre, nodes={("bearing", 0.0): centre}, links=links)
    for line, positions in stations.items():
        needed = sorted({0.0, *positions}) if options.arrays == "corotational" else positions
        for along in needed:
            if line == "bearing" and abs(along) < SAME_PLACE_M:
                continue
            node = tags.node()
            ops.node(node, *end.point(line, along), 0.0)
            arrays.nodes[line, along] = node
            if options.arrays == "rigid":
                ops.rigidLink("beam", centre, node)
    if options.arrays == "corotational":
        _build_stiff_elements(arrays, tags)
    return arrays


def _build_hinge(end: DeckEnd, deck_node: int, tags: TagAllocator) -> tuple[int, list[int]]:
    """Create the middle of the arrays and its hinge to the end of the spine.

    Stiff springs connect deck and arrays in all directions except the rotation about the axis of
    the arrays. That rotation of the arrays is restrained to the ground.
    """
    below, centre, ground = tags.node(), tags.node(), tags.node()
    for node in (below, centre, ground):
        ops.node(node, *end.point("bearing", 0.0), 0.0)
    ops.rigidLink("beam", deck_node, below)
    ops.fix(ground, 1, 1, 1, 1, 1, 1)
    push, turn = elastic_material(LINK_N_PER_M, tags), elastic_material(LINK_NM_PER_RAD, tags)
    orientation = ("-orient", *end.normal, 0.0, *end.tangent, 0.0)
    link, hold = tags.element(), tags.element()
    springs = ("-mat", push, push, push, turn, turn, "-dir", 1, 2, 3, 4, 6)
    ops.element("zeroLength", link, below, centre, *springs, *orientation)
    ops.element("zeroLength", hold, ground, centre, "-mat", turn, "-dir", 5, *orientation)
    return centre, [link, hold]


def _build_stiff_elements(arrays: Arrays, tags: TagAllocator) -> None:
    """Connect the nodes of each array, and the arrays at their middles and corners."""
    transformation = tags.transformation()
    ops.geomTransf("Corotational", transformation, 0.0, 0.0, 1.0)
    lines: list[Line] = ["inner", "bearing", "outer"]
    pairs: list[tuple[int, int]] = []
    for line in lines:
        along = sorted(station for name, station in arrays.nodes if name == line)
        pairs.extend(pairwise(arrays.nodes[line, station] for station in along))
    for place in (-_FAR_M, 0.0, _FAR_M):
        pairs.extend(pairwise(arrays.at(line, place) for line in lines))
    moduli, inertias = [ARRAY_MODULUS_PA] * 2, [ARRAY_INERTIA_M4] * 3
    section = (ARRAY_AREA_M2, *moduli, *inertias)
    for i, j in pairs:
        element = tags.element()
        ops.element("elasticBeamColumn", element, i, j, *section, transformation)
        arrays.links.append(element)


# ASSUME bending and twisting of a pad are too soft to matter
PAD_ROTATION_NM_PER_RAD = 1.0e5
# source: PyPBEE, no quadratic hardening of the pads
PAD_QUADRATIC_HARDENING = 0.0
PAD_HARDENING_EXPONENT = 3.0


def pad_stations(pads: PadData, end: DeckEnd) -> list[float]:
    """Return positions of the pads along the wall, equally spaced across the deck."""
    stretch = end.wall_length_m / end.width_m
    middle = (pads.count - 1) / 2
    return [(i - middle) * pads.spacing_m * stretch for i in range(pads.count)]


def pad_supports(pads: PadData, end: DeckEnd, options: ModelOptions) -> list[float]:
    """Return the positions of the pad elements along the wall.

    Two elements are placed so that they have the rotational stiffness of all pads.
    """
    stations = pad_stations(pads, end)
    if options.pads == "each":
        return stations
    arm = sqrt(sum(along**2 for along in stations) / len(stations))
    return [-arm, arm]


def build_pads(
    end: DeckEnd, arrays: Arrays, pads: PadData, options: ModelOptions, tags: TagAllocator
) -> tuple[BearingHandle, ...]:
    """Create the pads between fixed seat nodes and the bearing array."""
    deck_nodes = [arrays.at("bearing", along) for along in pad_supports(pads, end, options)]
    if options.pads == "each":
        return _bearing_elements(deck_nodes, end, pads, tags)
    return _halves(deck_nodes, pads, tags)


def _bearing_elements(
    deck_nodes: list[int], end: DeckEnd, pads: PadData, tags: TagAllocator
) -> tuple[BearingHandle, ...]:
    """Create one bearing element of OpenSees per pad, a pad height long."""
    material = elastic_material(pads.vertical_stiffness_mn_per_m * 1e6, tags)
    bend = elastic_material(PAD_ROTATION_NM_PER_RAD, tags)
    elastic = pads.shear_stiffness_kn_per_m * KN, pads.yield_force_kn * KN
    shear = (*elastic, pads.hardening_ratio, PAD_QUADRATIC_HARDENING, PAD_HARDENING_EXPONENT)
    axes = ("-orient", *end.normal, 0.0)
    springs = ("-P", material, "-T", bend, "-My", bend, "-Mz", bend, *axes)
    handles: list[BearingHandle] = []
    for deck_node in deck_nodes:
        x, y, z = ops.nodeCoord(deck_node)
        seat, element = grounded_node((x, y, z - pads.height_m), tags), tags.element()
        nodes = (element, seat, deck_node)
        ops.element("elastomericBearingPlasticity", *nodes, *shear, *springs)
        handles.append(BearingHandle(element=element, seat_node=seat, deck_node=deck_node))
    return tuple(handles)


def _halves(deck_nodes: list[int], pads: PadData, tags: TagAllocator) -> tuple[BearingHandle, ...]:
    """Create two elements, each for half of the pads: shear and vertical stiffness."""
    # ASSUME the pads do not resist rotation: their stiffness is too small to matter
    number = pads.count / 2
    section = _shear_section(pads, number, tags)
    upright = elastic_material(number * pads.vertical_stiffness_mn_per_m * 1e6, tags)
    springs = ("-mat", upright, "-dir", 3)
    handles: list[BearingHandle] = []
    for deck_node in deck_nodes:
        seat = grounded_node(ops.nodeCoord(deck_node), tags)
        element, support = tags.element(), tags.element()
        # shear along the local y and z of a section: here x and y of the model
        axes = ("-orient", 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
        ops.element("zeroLengthSection", element, seat, deck_node, section, *axes)
        ops.element("zeroLength", support, seat, deck_node, *springs)
        handles.append(
            BearingHandle(element=element, upright=support, seat_node=seat, deck_node=deck_node)
        )
    return tuple(handles)


def _shear_section(pads: PadData, number: float, tags: TagAllocator) -> int:
    """Create the shear section of some pads: a yield circle that moves with plastic displacement.

    The law is that of the bearing element, a plastic spring of the characteristic strength in
    parallel with an elastic one, at a tenth of the cost.
    """
    plastic = 1.0 - pads.hardening_ratio
    stiffness = number * pads.shear_stiffness_kn_per_m * KN
    hardening = stiffness * pads.hardening_ratio / plastic
    section = tags.section()
    strength_n, directions = number * pads.yield_force_kn * KN / plastic, ("Vy", "Vz")
    ops.section("Bidirectional", section, stiffness, strength_n, 0.0, hardening, *directions)
    return section


def build_vertical_supports(
    end: DeckEnd, arrays: Arrays, pads: PadData, tags: TagAllocator
) -> tuple[BearingHandle, ...]:
    """Create a vertical spring under each end of the bearing array, each for half of the pads."""
    material = tags.material()
    half = pads.vertical_stiffness_mn_per_m * 1e6 * pads.count / 2
    ops.uniaxialMaterial("Elastic", material, half)
    handles: list[BearingHandle] = []
    for along in (-end.wall_length_m / 2, end.wall_length_m / 2):
        deck_node = arrays.at("bearing", along)
        seat, element = grounded_node(ops.nodeCoord(deck_node), tags), tags.element()
        ops.element("zeroLength", element, seat, deck_node, "-mat", material, "-dir", 3)
        handles.append(BearingHandle(element=element, seat_node=seat, deck_node=deck_node))
    return tuple(handles)
