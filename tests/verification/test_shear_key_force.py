"""The force of a shear key is that of its backbone, never that of the penalty before it."""

from types import SimpleNamespace

import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, variant
from skewbridge.bridge.abutment.elements import KEY_FACE_HARDENING, grounded_node, plane_node
from skewbridge.bridge.abutment.parts import SideContext
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import domain
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion


@pytest.mark.parametrize("abutment", ["spring", "contact"])
def test_a_key_that_breaks_has_given_its_strength_and_no_more(abutment):
    case = variant(abutment=abutment, gap_mm=25, friction_pct=0)
    found = analysed(case, strong_motion(peak_g=1.6), duration_s=3.0).demands
    key = load_bridge("osb1").abutment.sacrificial_key
    assert found["shear_key_disp_m"] > key.displacement_mm[1] / 1e3
    assert found["shear_key_force_kn"] == pytest.approx(max(key.force_kn), rel=0.02)


@pytest.mark.parametrize("option", ["backbone", "elastic"])
def test_a_key_pushed_along_its_face_has_no_more_than_its_strength(option):
    """50 mm along the face: beyond the strength, 69 MN/m times 50 mm without a limit."""
    key, tags = load_bridge("osb1").abutment.sacrificial_key, TagAllocator()
    options = ModelOptions(key_along_face=option)
    context = SimpleNamespace(key=key, key_mass_kg=6.0e3, options=options, tags=tags)
    with domain():
        nodes = grounded_node((0.0, 0.0), tags), plane_node((0.0, 0.0), 0.0, tags)
        SideContext.key_spring(context, nodes, (0.0, 1.0))
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        ops.load(nodes[1], 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        ops.integrator("DisplacementControl", nodes[1], 1, 0.001)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(50) == 0
        force_kn = ops.getLoadFactor(1) / 1e3
    expected = elastic_kn = 50.0 * key.force_kn[0] / key.displacement_mm[0]
    if option == "backbone":
        expected = key.force_kn[1] + KEY_FACE_HARDENING * (elastic_kn - key.force_kn[1])
        assert key.force_kn[1] < expected < 1.01 * key.force_kn[1]
    assert force_kn == pytest.approx(expected, rel=1e-6)
