"""The transverse arrays of a deck end: what pads, walls and keys touch.

Three arrays along the skewed line, at the pads' top: inner face, bearing line and outer face of
the end diaphragm. A link between deck and arrays lets the deck rotate about the arrays' axis,
while the arrays themselves cannot rotate about it.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import openseespy.opensees as ops

from skewbridge.bridge.abutment.elements import elastic_material
from skewbridge.bridge.deck_plan import DeckEnd
from skewbridge.bridge.tags import TagAllocator
from skewbridge.variant.options import ModelOptions

type Line = Literal["inner", "bearing", "outer"]

# Links far stiffer than the deck's end element (1e10 N/m), soft enough for double precision.
LINK_N_PER_M = 1.0e12
LINK_NM_PER_RAD = 1.0e13
# source: measured on OSB1, from this bending stiffness on stiff arrays agree with rigid links at
# skew 60 within 0.6 % of column drift
ARRAY_MODULUS_PA = 2.5e11
ARRAY_AREA_M2 = 10.0
ARRAY_INERTIA_M4 = 10.0
SAME_PLACE_M = 1e-6
_FAR_M = 1e6  # beyond the ends of any array


@dataclass(slots=True, kw_only=True)
class Arrays:
    """The arrays of one deck end.

    Attributes:
        centre_node: Middle of the bearing line; all array points follow it.
        nodes: Node by line and position along the wall.
        links: Stiff elements.
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
    """Create the arrays of a deck end and hang them on the spine's end node, at the centroid.

    Stations are the positions along the wall where each array needs a node.
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
    """Create the middle of the arrays under the spine's end, free to let the deck rotate.

    The deck hangs on the arrays by stiff springs in all directions but the rotation about the
    arrays' axis, and that rotation of the arrays is held to the ground.
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
    """Join the nodes of each array, and the arrays at their middles and corners."""
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
