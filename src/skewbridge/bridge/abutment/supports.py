"""What carries a deck end: elastomeric pads, or plain vertical supports."""

import openseespy.opensees as ops

from skewbridge.bridge.abutment.arrays import Arrays
from skewbridge.bridge.abutment.elements import grounded_node
from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.deck_plan import DeckEnd
from skewbridge.bridge.handles import BearingHandle
from skewbridge.bridge.tags import TagAllocator
from skewbridge.units import KN

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


def build_pads(
    end: DeckEnd, arrays: Arrays, pads: PadData, tags: TagAllocator
) -> tuple[BearingHandle, ...]:
    """Create the pads between fixed seat nodes and the bearing array, a pad height apart."""
    material, bend = tags.material(), tags.material()
    ops.uniaxialMaterial("Elastic", material, pads.vertical_stiffness_mn_per_m * 1e6)
    ops.uniaxialMaterial("Elastic", bend, PAD_ROTATION_NM_PER_RAD)
    elastic = pads.shear_stiffness_kn_per_m * KN, pads.yield_force_kn * KN
    shear = (*elastic, pads.hardening_ratio, PAD_QUADRATIC_HARDENING, PAD_HARDENING_EXPONENT)
    axes = ("-orient", *end.normal, 0.0)
    springs = ("-P", material, "-T", bend, "-My", bend, "-Mz", bend, *axes)
    handles: list[BearingHandle] = []
    for along in pad_stations(pads, end):
        deck_node = arrays.at("bearing", along)
        x, y, z = ops.nodeCoord(deck_node)
        seat, element = grounded_node((x, y, z - pads.height_m), tags), tags.element()
        nodes = (element, seat, deck_node)
        ops.element("elastomericBearingPlasticity", *nodes, *shear, *springs)
        handles.append(BearingHandle(element=element, seat_node=seat, deck_node=deck_node))
    return tuple(handles)


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
