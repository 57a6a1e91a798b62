"""The pads of a deck end: two elements represent all of them."""

from math import hypot

import numpy as np
import openseespy.opensees as ops
import pytest
from numpy.typing import NDArray

from skewbridge.bridge.abutment.supports import build_arms, build_pads, pad_supports
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.catalogue.data import PadData
from skewbridge.bridge.deck import deck_end
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import domain
from skewbridge.variant.options import ModelOptions

PADS = load_bridge("osb1").abutment.pads
YIELD_M = PADS.yield_force_kn / PADS.shear_stiffness_kn_per_m


def pad_reactions(
    options: ModelOptions, motion: dict[int, float], pads: PadData = PADS
) -> NDArray[np.float64]:
    """Return forces and moments of the ground under the pads of a deck end that is moved.

    Motion of the middle of the bearing line: displacement by degree of freedom, 1 to 6.
    """
    with domain():
        tags = TagAllocator()
        end = deck_end("right", 90.0, 30.0, 14.0, 0.9)
        deck = tags.node()
        ops.node(deck, *end.point("bearing", 0.0), 1.0)
        stations = pad_supports(pads, end, options)
        arms = build_arms(end, deck, {"bearing": stations}, options, tags)
        bearings = build_pads(end, arms, pads, options, tags)
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        for dof in range(1, 7):
            # the deck node is 1 m above the middle of the bearing line, which moves
            lean = {1: motion.get(5, 0.0), 2: -motion.get(4, 0.0)}.get(dof, 0.0)
            ops.sp(deck, dof, motion.get(dof, 0.0) + lean)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("UmfPack")
        ops.test("NormDispIncr", 1e-9, 25)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 0.05)
        ops.analysis("Static")
        assert ops.analyze(20) == 0
        ops.reactions()
        total, middle = np.zeros(6), np.array((*ops.nodeCoord(deck)[:2], 0.0))
        for bearing in bearings:
            reaction = np.array(ops.nodeReaction(bearing.seat_node))
            arm = np.array(ops.nodeCoord(bearing.seat_node)) - middle
            reaction[3:] += np.cross(arm, reaction[:3])
            total += reaction
        return total


@pytest.mark.parametrize(
    "motion",
    [{1: 0.2 * YIELD_M}, {2: 0.2 * YIELD_M}, {3: -1e-3}, {4: 1e-5}, {5: 1e-5}, {6: 1e-5}],
)
def test_two_pads_are_as_stiff_as_all_of_them(motion: dict[int, float]) -> None:
    # pressed down first: pads take no tension
    moved = {3: -1e-3} | motion
    two, each = (pad_reactions(ModelOptions(pads=pads), moved) for pads in ("two", "each"))
    assert np.abs(each).max() > 100.0
    # the two have no height, which a bearing element multiplies with its shear, and no bending
    lever_nm = PADS.height_m * np.abs(each).max()
    # under a vertical force the arms to the pads bend by 0.02 % of the settlement
    assert two[:3] == pytest.approx(each[:3], rel=3e-4, abs=1e-5 * np.abs(each).max())
    assert two[3:] == pytest.approx(each[3:], rel=1e-4, abs=lever_nm)


@pytest.mark.parametrize("pads", ["two", "each"])
@pytest.mark.parametrize("factor", [0.5, 1.0])
def test_pads_yield_together_at_their_strength_in_every_direction(pads, factor: float) -> None:
    scaled = PADS.model_copy(update={"yield_force_kn": factor * PADS.yield_force_kn})
    ux, uy = 3 * YIELD_M, -4 * YIELD_M
    forces_n = pad_reactions(ModelOptions(pads=pads), {1: ux, 2: uy}, scaled)
    fx, fy = forces_n[:2] / PADS.count / 1e3
    # the arms above the pads bend by a ten-millionth of the displacement
    hardening_kn = PADS.hardening_ratio * PADS.shear_stiffness_kn_per_m * hypot(ux, uy)
    assert hypot(fx, fy) - hardening_kn == pytest.approx(factor * PADS.yield_force_kn, rel=1e-7)
    assert fx / fy == pytest.approx(ux / uy)
