"""The shear of a leaning column's sections: base force, P-Delta and end moments by statics."""

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import variant
from skewbridge.analysis.peaks import column_shear_n
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
