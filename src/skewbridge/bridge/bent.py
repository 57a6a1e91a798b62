"""Bents: integral cap, columns, bases and optional foundation springs."""

from itertools import pairwise

import openseespy.opensees as ops

from skewbridge.bridge.abutment.elements import elastic_material, grounded_node
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.bridge.column import (
    COLUMN_ITERATIONS,
    build_integration,
    column_handle,
    shear_modulus_pa,
)
from skewbridge.bridge.deck import Deck, add_moment, add_weight
from skewbridge.bridge.gravity import column_weight_n, deck_reaction_n
from skewbridge.bridge.handles import ColumnHandle, Point, TagAllocator
from skewbridge.errors import InputError
from skewbridge.units import G_MPS2, GPA, KN
from skewbridge.variant.options import ModelOptions

RIGID_TWIST = 100.0  # times the polar moment of the cap
RIGID_BENDING = 1000.0  # times the second moment of area of the cap


def build_bents(
    bridge: BridgeData, spine: Deck, options: ModelOptions, tags: TagAllocator
) -> tuple[tuple[ColumnHandle, ...], tuple[int, ...]]:
    """Create caps, columns and bases, and put their weight on the spine and cap nodes.

    Returns:
        All columns, and the elements of the foundation springs under them.
    """
    upright, level = tags.transformation(), tags.transformation()
    # a column ends at the soffit, rigidly below its joint at the deck's centroid
    below = (0.0, 0.0, -bridge.deck.centroid_above_soffit_m)
    ops.geomTransf("PDelta", upright, 1.0, 0.0, 0.0, "-jntOffset", 0.0, 0.0, 0.0, *below)
    ops.geomTransf("Linear", level, 0.0, 0.0, 1.0)
    columns: list[ColumnHandle] = []
    foundations: list[int] = []
    for number, (bent, x) in enumerate(zip(bridge.bents, bridge.bent_positions_m, strict=True)):
        integration, hinges = build_integration(bridge, number, options, tags)
        joints = _build_cap(bridge, number, spine, x, level, tags)
        if options.cap_load == "spread" and len(joints) > 1:
            _spread_deck_load(bridge, number, spine, joints)
        for joint, y in joints:
            base = tags.node()
            ops.node(base, x, y, -bent.clear_height_m)
            nodes = base, joint
            foundations.extend(_support(bridge, base, options, tags))
            element = tags.element()
            numerics = (upright, integration, "-iter", *COLUMN_ITERATIONS)
            ops.element("forceBeamColumn", element, *nodes, *numerics)
            columns.append(
                column_handle(
                    bridge,
                    number,
                    element=element,
                    base_node=base,
                    top=Point(joint, below),
                    hinge_sections=hinges,
                    options=options,
                )
            )
            # ASSUME the base section, which governs, carries the whole weight of the column;
            # half of its mass moves with the cap
            weight = column_weight_n(bridge, bent)
            add_weight(spine, joint, weight, weight / 2 / G_MPS2)
    return tuple(columns), tuple(foundations)


def _build_cap(
    bridge: BridgeData, number: int, spine: Deck, x: float, transformation: int, tags: TagAllocator
) -> list[tuple[int, float]]:
    """Create the cap; return its joints above the columns with their y."""
    bent, centre = bridge.bents[number], spine.bent_nodes[number]
    add_weight(spine, centre, bent.cap_weight_kn * KN, bent.cap_weight_kn * KN / G_MPS2)
    deck = bridge.deck
    modulus = deck.elastic_modulus_gpa * GPA
    width, depth = bent.cap_width_m, bent.cap_depth_m
    # ASSUME webs and slabs between the columns carry the column moments straight into the deck:
    # an integral cap does not twist against it
    torsion = RIGID_TWIST * width * depth * (width**2 + depth**2) / 12
    upright = width * depth**3 / 12
    if bent.columns > 2:
        # ASSUME webs spread the deck's load over all columns; through the spine alone the middle
        # column would carry nearly all of it, so the cap does not bend vertically
        upright *= RIGID_BENDING
    joints: list[tuple[int, float]] = []
    middle = (bent.columns - 1) / 2
    for i in range(bent.columns):
        y = (i - middle) * bent.column_spacing_m
        if y == 0.0:
            joints.append((centre, y))
            continue
        node = tags.node()
        ops.node(node, x, y, deck.centroid_above_soffit_m)
        joints.append((node, y))
    inertias = (torsion, upright, depth * width**3 / 12)
    section = (width * depth, modulus, shear_modulus_pa(modulus), *inertias)
    chain = sorted({(centre, 0.0), *joints}, key=lambda joint: joint[1])
    for (i, _), (j, _) in pairwise(chain):
        spine.elements.append(tags.element())
        ops.element("elasticBeamColumn", spine.elements[-1], i, j, *section, transformation)
    return joints


def _spread_deck_load(
    bridge: BridgeData, number: int, spine: Deck, joints: list[tuple[int, float]]
) -> None:
    """Spread the dead load of the deck over the width of a cap.

    The spine applies it at the middle of the cap, which would bend the cap and push the column
    bases apart. The loads added here are self-equilibrated: the fixed-end forces of the cap
    between its nodes under a uniform load, less the load of the spine.
    """
    bent, width = bridge.bents[number], bridge.deck.width_m
    load_n = deck_reaction_n(bridge, number) + bent.cap_weight_kn * KN
    centre = spine.bent_nodes[number]
    nodes = sorted({(centre, 0.0), *joints}, key=lambda joint: joint[1])
    spine.loads_n[centre] -= load_n
    per_m, ends = load_n / width, ((-width / 2), *(y for _, y in nodes), width / 2)
    for i, (node, y) in enumerate(nodes):
        # left and right of the node: an overhang beyond the last one, else half of a span
        for sign, other, is_end in (
            (-1.0, ends[i], i == 0),
            (1.0, ends[i + 2], i == len(nodes) - 1),
        ):
            length = abs(other - y)
            spine.loads_n[node] += per_m * length / (1.0 if is_end else 2.0)
            moment = per_m * length**2 / (2.0 if is_end else 12.0)
            add_moment(spine, node, about_x_nm=-sign * moment)


def _support(bridge: BridgeData, base: int, options: ModelOptions, tags: TagAllocator) -> list[int]:
    """Fix a base or support it on springs; a pinned base still resists torsion."""
    bends = 0 if bridge.base == "pinned" else 1
    if options.foundation == "springs" and bridge.foundation is None:
        raise InputError(f"option foundation: {bridge.name} has no foundation springs")
    if options.foundation == "fixed" or bridge.foundation is None:
        ops.fix(base, 1, 1, 1, bends, bends, 1)
        return []
    ground = grounded_node(ops.nodeCoord(base), tags)
    # The fields of the foundation are in the order of the degrees of freedom.
    stiffness = enumerate(bridge.foundation.model_dump().values(), start=1)
    held = {dof: 1e6 * value for dof, value in stiffness if bends or dof not in (4, 5)}
    materials = [elastic_material(value, tags) for value in held.values()]
    element = tags.element()
    ops.element("zeroLength", element, ground, base, "-mat", *materials, "-dir", *held)
    return [element]
