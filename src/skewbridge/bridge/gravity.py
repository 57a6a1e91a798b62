"""Dead load, applied once and kept."""

from collections.abc import Mapping

import openseespy.opensees as ops

from skewbridge.bridge.handles import BridgeModel
from skewbridge.bridge.tags import TagAllocator
from skewbridge.errors import SolutionError

GRAVITY_STEPS = 5
TOLERANCE_M = 1.0e-10


class GravityError(SolutionError):
    """A model did not carry its own weight."""


def hold_dead_load(
    loads_n: Mapping[int, float],
    moments_nm: Mapping[int, tuple[float, float]],
    tags: TagAllocator,
) -> None:
    """Bring a fresh model under its dead load and hold it; the time is zero afterwards.

    The loads act downwards, the moments about x and y, by node.

    Nodal loads: the corotational transformation ignores element loads.

    Raises:
        GravityError: No equilibrium was found.
    """
    open_linear_pattern(tags)
    for node, load_n in loads_n.items():
        ops.load(node, 0.0, 0.0, -load_n, *moments_nm.get(node, (0.0, 0.0)), 0.0)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", TOLERANCE_M, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / GRAVITY_STEPS)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(GRAVITY_STEPS) != 0:
        raise GravityError("the model finds no equilibrium under its dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern that grows with time: the loads that follow belong to it."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)


def column_axial_forces_n(model: BridgeModel) -> list[float]:
    """Return the compression at the base of every column, from the element forces."""
    return [float(ops.eleResponse(column.element, "force")[2]) for column in model.columns]


def support_reactions_n(model: BridgeModel) -> list[float]:
    """Return the vertical force on each abutment (left, right) from its supports."""
    ops.reactions()
    return [
        sum(float(ops.nodeReaction(bearing.seat_node, 3)) for bearing in abutment.bearings)
        for abutment in model.abutments
    ]
