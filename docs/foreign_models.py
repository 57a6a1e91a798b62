"""Two example user models without contact, in kN, m and s."""

import openseespy.opensees as ops


def portal_frame() -> None:
    """Build a plane portal frame; node 4 is its right corner, node 9 a fixed point there."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, x, y in ((1, 0.0, 0.0), (2, 6.0, 0.0), (3, 0.0, 4.0), (4, 6.0, 4.0), (9, 6.0, 4.0)):
        ops.node(node, x, y)
    for node in (1, 2, 9):
        ops.fix(node, 1, 1, 1)
    ops.geomTransf("Linear", 1)
    for element, (i, j) in enumerate(((1, 3), (2, 4), (3, 4)), start=1):
        ops.element("elasticBeamColumn", element, i, j, 0.16, 3.0e7, 2.1e-3, 1)
    for node in (3, 4):
        ops.mass(node, 40.0, 40.0, 0.0)
    ops.rayleigh(0.3, 0.0, 1.0e-3, 0.0)
    prepare((1,))


def tower() -> None:
    """Build a 3D cantilever; node 2 is its top, node 9 a fixed point there."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    for node, z in ((1, 0.0), (2, 10.0), (9, 10.0)):
        ops.node(node, 0.0, 0.0, z)
    for node in (1, 9):
        ops.fix(node, *[1] * 6)
    ops.geomTransf("PDelta", 1, 1.0, 0.0, 0.0)
    ops.element("elasticBeamColumn", 1, 1, 2, 0.5, 3.0e7, 1.2e7, 0.04, 0.02, 0.02, 1)
    ops.mass(2, 100.0, 100.0, 100.0, 1.0, 1.0, 1.0)
    ops.rayleigh(0.3, 0.0, 1.0e-3, 0.0)
    prepare((1, 2))


def prepare(directions: tuple[int, ...]) -> None:
    """Apply a sine acceleration of 0.3 g in the directions and set up a transient analysis."""
    ops.timeSeries("Trig", 1, 0.0, 4.0, 0.4, "-factor", 3.0)
    for direction in directions:
        ops.pattern("UniformExcitation", direction, direction, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-10, 30)
    ops.algorithm("NewtonLineSearch")
    ops.integrator("Newmark", 0.6, 0.3025)
    ops.analysis("Transient")
