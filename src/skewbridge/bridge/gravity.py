"""Dead load of a model, applied and held."""

from collections.abc import Mapping

import openseespy.opensees as ops

from skewbridge.bridge.handles import TagAllocator
from skewbridge.errors import SolutionError

GRAVITY_STEPS = 5
_TOLERANCE_M = 1.0e-10


class GravityError(SolutionError):
    """The gravity analysis of a model did not converge."""


def hold_dead_load(
    loads_n: Mapping[int, float], moments_nm: Mapping[int, tuple[float, float]], tags: TagAllocator
) -> None:
    """Apply and hold downward loads and moments about x and y at nodes; set the time to zero.

    Loads are nodal: the corotational transformation ignores element loads. `GravityError` without
    equilibrium.
    """
    open_linear_pattern(tags)
    for node, load_n in loads_n.items():
        ops.load(node, 0.0, 0.0, -load_n, *moments_nm.get(node, (0.0, 0.0)), 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("ProfileSPD")
    ops.test("NormDispIncr", _TOLERANCE_M, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / GRAVITY_STEPS)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(GRAVITY_STEPS) != 0:
        raise GravityError("the gravity analysis did not converge: no equilibrium under dead load")
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()


def open_linear_pattern(tags: TagAllocator) -> None:
    """Open a load pattern that grows with time; loads created afterwards belong to it."""
    series = tags.series()
    ops.timeSeries("Linear", series)
    ops.pattern("Plain", tags.pattern(), series)
