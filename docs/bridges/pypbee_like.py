"""Two-span bridge in the manner of PyPBEE models, in kip and inch, with a load pattern."""

import openseespy.opensees as ops

FT, KSI, G = 12.0, 1.0, 386.09
SPAN, HEIGHT, WIDTH, DEPTH = 150.0 * FT, 22.0 * FT, 47.0 * FT, 6.0 * FT
WEIGHT = 14.0 / FT  # kip per inch of deck
DC, SPACING = 5.5 * FT, 24.0 * FT
FC, EC = 5.2 * KSI, 4110.0 * KSI


def bridge(skew_deg):
    """Build deck, cap and columns with masses and a load pattern."""
    number = 10
    step = 2 * SPAN / number
    for node in range(number + 1):
        share = step if 0 < node < number else step / 2
        mass = WEIGHT * share / G
        ops.node(100 + node, -SPAN + node * step, 0.0, HEIGHT + DEPTH / 2)
        turning = mass * WIDTH**2 / 12
        ops.mass(100 + node, mass, mass, mass, turning, mass * DEPTH**2 / 12, turning)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    for node in range(number):
        section = (79.6 * FT**2, 3600.0, 1500.0, 1280.0 * FT**4, 437.0 * FT**4, 13260.0 * FT**4)
        ops.element("elasticBeamColumn", 100 + node, 100 + node, 101 + node, *section, 1)

    ops.uniaxialMaterial("Concrete01", 1, -1.4 * FC, -0.006, -1.2 * FC, -0.02)
    ops.uniaxialMaterial("Concrete01", 2, -FC, -0.002, 0.0, -0.005)
    ops.uniaxialMaterial("ReinforcingSteel", 3, 68.0, 95.0, 29000.0, 1200.0, 0.015, 0.12)
    ops.section("Fiber", 1, "-GJ", 0.2 * 0.4 * EC * 3.1416 * DC**4 / 32)
    core = DC / 2 - 2.0
    ops.patch("circ", 1, 16, 6, 0.0, 0.0, 0.0, core, 0.0, 360.0)
    ops.patch("circ", 2, 16, 2, 0.0, 0.0, core, DC / 2, 0.0, 360.0)
    ops.layer("circ", 3, 44, 1.56, 0.0, 0.0, core - 1.7, 0.0, 360.0 - 360.0 / 44)
    ops.beamIntegration("Lobatto", 1, 1, 4)
    ops.geomTransf("PDelta", 2, 1.0, 0.0, 0.0)
    ops.geomTransf("Linear", 3, 0.0, 0.0, 1.0)
    middle = 100 + number // 2
    for column, side in ((1, -0.5), (2, 0.5)):
        base, top, cap = column, 10 + column, 20 + column
        ops.node(base, 0.0, side * SPACING, 0.0)
        ops.node(top, 0.0, side * SPACING, HEIGHT)
        ops.node(cap, 0.0, side * SPACING, HEIGHT + DEPTH / 2)
        ops.fix(base, 1, 1, 1, 0, 0, 1)
        ops.mass(cap, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0)
        ops.rigidLink("beam", cap, top)
        ops.element("dispBeamColumn", column, base, top, 2, 1)
        stiff = (50.0 * FT**2, EC, 0.4 * EC, 1e3 * FT**4, 1e3 * FT**4, 1e3 * FT**4)
        ops.element("elasticBeamColumn", 20 + column, middle, cap, *stiff, 3)

    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for node in range(number + 1):
        share = step if 0 < node < number else step / 2
        ops.load(100 + node, 0.0, 0.0, -WEIGHT * share, 0.0, 0.0, 0.0)
    for cap in (21, 22):
        ops.load(cap, 0.0, 0.0, -0.5 * G, 0.0, 0.0, 0.0)

    import skewbridge as sb

    return sb.Frame(
        ends=(100, 100 + number),
        width=WIDTH,
        soffit=DEPTH / 2,
        units="kip-in",
        abutment={"seat_width_m": 0.8, "pads": {"count": 6, "spacing_m": 2.4}},
        columns=[
            sb.Column(
                column,
                column,
                10 + column,
                drift_capacity=(0.05, 0.045),
                shear_strength=lambda axial, drift, curvature: 900.0 + 0.1 * axial,
                yield_curvature=0.0001,
                hinges=(4,),
            )
            for column in (1, 2)
        ],
    )
