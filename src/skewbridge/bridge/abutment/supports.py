"""What carries a deck end: elastomeric pads, or plain vertical supports."""

from math import sqrt

import openseespy.opensees as ops

from skewbridge.bridge.abutment.arrays import Arrays
from skewbridge.bridge.abutment.elements import elastic_material, grounded_node
from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.deck_plan import DeckEnd
from skewbridge.bridge.handles import BearingHandle
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import KN
from skewbridge.variant.options import ModelOptions

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

    Two elements stand where they turn with the stiffness of all pads.
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
    """Create elements for half of the pads each: their shear, and what carries them upright."""
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
    """Create the shear of some pads: a yield circle that moves with the plastic displacement.

    The same as in the bearing element, plastic rubber of the characteristic strength beside an
    elastic spring, for a tenth of its cost.
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
    """Create a vertical spring under each end of the bearing array: the pads', in two."""
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
