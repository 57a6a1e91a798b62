"""The shear of a leaning column's sections: base force, P-Delta and end moments by statics."""

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.peaks import column_base_shear_n, column_shear_n
from skewbridge.analysis.trace import Monitor
from skewbridge.bridge.gravity import open_linear_pattern
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions


def pushed(bridge, options, push_n=(3.0e6, 1.5e6)):
    """Push the deck of a roller bridge; return its columns and the two states read."""
    with domain():
        model = build(variant(0, "roller", bridge).normalised(), options)
        monitor = Monitor(model)
        monitor.start()
        open_linear_pattern(model.tags)
        ops.load(model.deck_centre_node, *push_n, 0.0, 0.0, 0.0, 0.0)
        ops.constraints("Transformation")
        ops.numberer("RCM")
        ops.system("BandGeneral")
        ops.test("NormDispIncr", 1e-9, 50)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 0.1)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(10) == 0
        return model.columns, monitor.trace().at([0, -1])


@pytest.mark.parametrize(
    ("bridge", "options"),
    [
        ("osb1", ModelOptions()),
        ("osb1_fixed", ModelOptions()),
        ("osb1", ModelOptions(elastic_columns=True)),
        ("osb2s", ModelOptions(elastic_columns=True)),
    ],
)
def test_the_shear_of_a_section_is_the_sum_of_end_moments_over_the_height(bridge, options):
    columns, trace = pushed(bridge, options)
    for column in columns:
        forces = trace.columns[column.element]
        # the end of the element is the joint above the top of the column
        at_top = forces[:, 9:] - np.cross(column.top.arm_m, forces[:, 6:9])
        about_x, about_y = forces[:, 3] + at_top[:, 0], forces[:, 4] + at_top[:, 1]
        by_moments = np.column_stack((about_y, -about_x)) / column.clear_height_m
        np.testing.assert_allclose(column_shear_n(column, trace), by_moments, rtol=1e-6, atol=1.0)


def test_p_delta_adds_the_hand_value_to_the_base_force():
    columns, trace = pushed("osb1", ModelOptions(elastic_columns=True), (3.0e6, 0.0))
    bases_n = 0.0
    for column in columns:
        base, section = column_base_shear_n(column, trace), column_shear_n(column, trace)
        # P = 6.008 MN (hand 5.997) over H = 5.64 m: 1.065 MN per metre of lean
        lean_m = trace.position(column.top)[1, 0]
        assert 0.02 < lean_m < 0.1
        added = abs(section[1, 0]) - abs(base[1, 0])
        assert added == pytest.approx(6.0e6 * lean_m / 5.64, rel=0.01)
        bases_n += abs(base[1, 0])
    assert bases_n == pytest.approx(3.0e6, rel=1e-3)  # rollers leave the push to the bases
