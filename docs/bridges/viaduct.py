"""Three-span viaduct on single columns of equal height; N, m. Without capacities of the columns."""

import openseespy.opensees as ops

SPANS = (35.0, 45.0, 35.0)
PARTS = 4  # elements of a span


def bridge():
    """Build the model; the last lines are those for skewbridge."""
    x, places = 0.0, [0.0]
    for span in SPANS:
        places += [x + span * part / PARTS for part in range(1, PARTS + 1)]
        x += span
    for node, place in enumerate(places, start=1):
        ops.node(node, place, 0.0, 10.0)
        before, after = places[max(node - 2, 0)], places[min(node, len(places) - 1)]
        mass = 16.0e3 * (after - before) / 2
        ops.mass(node, mass, mass, mass, 8.0 * mass, 0.3 * mass, 8.0 * mass)
    ops.geomTransf("Linear", 1, 0.0, 0.0, 1.0)
    for element in range(1, len(places)):
        section = (5.5, 30.0e9, 12.5e9, 7.0, 2.2, 45.0)
        ops.element("elasticBeamColumn", element, element, element + 1, *section, 1)
    ops.geomTransf("PDelta", 2, 1.0, 0.0, 0.0)
    for base, node in ((101, 5), (102, 9)):
        ops.node(base, places[node - 1], 0.0, 0.0)
        ops.fix(base, 1, 1, 1, 1, 1, 1)
        cracked = (2.54, 28.0e9, 11.7e9, 0.2, 0.23, 0.23)  # column of 1.8 m
        ops.element("elasticBeamColumn", base, base, node, *cracked, 2)

    import skewbridge as sb

    return sb.Frame(
        ends=(1, len(places)),
        width=10.0,
        soffit=1.1,
        columns=[sb.Column(101, 101, 5, height=8.9), sb.Column(102, 102, 9, height=8.9)],
    )
