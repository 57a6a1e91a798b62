"""A bridge as a script: two spans on one two-column bent; SI units (N, m, s, kg)."""

from math import cos, radians, sin

import openseespy.opensees as ops

import skewbridge as sb


def bridge(skew_deg: float) -> sb.Frame:
    """Build deck and bent, without supports at the deck ends, and say what is what."""
    deck = dict(enumerate((-40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0), start=1))
    for node, x in deck.items():
        ops.node(node, x, 0.0, 7.0)
        mass = 190.0e3 * (0.5 if abs(x) == 40.0 else 1.0)  # 19 t per metre
        ops.mass(node, mass, mass, mass, 20.0 * mass, 0.4 * mass, 20.0 * mass)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    for node in range(1, 9):
        section = (7.0, 25.0e9, 10.4e9, 11.0, 3.7, 110.0)  # A, E, G, J, Iy, Iz
        ops.element("elasticBeamColumn", node, node, node + 1, *section, 1)

    # columns of 1.6 m: concrete and 36 bars of 1000 mm2
    ops.uniaxialMaterial("Concrete01", 1, -45.0e6, -0.005, -38.0e6, -0.02)
    ops.uniaxialMaterial("Concrete01", 2, -35.0e6, -0.002, 0.0, -0.006)
    ops.uniaxialMaterial("Steel02", 3, 475.0e6, 200.0e9, 0.01, 18.0, 0.925, 0.15)
    ops.section("Fiber", 1, "-GJ", 2.0e9)
    ops.patch("circ", 1, 20, 8, 0.0, 0.0, 0.0, 0.72, 0.0, 360.0)
    ops.patch("circ", 2, 20, 2, 0.0, 0.0, 0.72, 0.80, 0.0, 360.0)
    ops.layer("circ", 3, 36, 1.0e-3, 0.0, 0.0, 0.70, 0.0, 350.0)
    ops.beamIntegration("Lobatto", 1, 1, 5)
    ops.geomTransf("PDelta", 2, 1.0, 0.0, 0.0)
    for side, base, top in ((-3.6, 21, 31), (3.6, 22, 32)):
        x, y = -side * sin(radians(skew_deg)), side * cos(radians(skew_deg))
        ops.node(base, x, y, 0.0)
        ops.node(top, x, y, 6.0)
        ops.fix(base, 1, 1, 1, 1, 1, 1)
        ops.mass(top, 40.0e3, 40.0e3, 40.0e3, 0.0, 0.0, 0.0)
        ops.rigidLink("beam", 5, top)
        ops.element("forceBeamColumn", base, base, top, 2, 1)

    # what skewbridge cannot see in the model
    return sb.Frame(
        ends=(1, 9),
        width=12.5,
        soffit=1.0,
        columns=[
            sb.Column(
                base,
                base,
                top,
                drift_capacity=0.045,
                shear_strength=5.0e6,
                yield_curvature=0.0037,
                hinges=(1, 5),
            )
            for base, top in ((21, 31), (22, 32))
        ],
        title="Two spans on a two-column bent",
    )
