"""Skewed bents, against closed forms.

The stiffness of a bent is a tensor in plan: a bent turned by an angle has the turned tensor. It is
exact up to rounding in the static analysis (1e-6)."""

from math import cos, radians, sin

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import static_steps, variant
from skewbridge.bridge import assembly, bent, catalogue, handles, structures, weights
from skewbridge.bridge.model import build, column_axial_forces_n, domain, support_reactions_n
from skewbridge.bridge.spine import Spine
from skewbridge.variant.options import ModelOptions


def plan_stiffness(name, skew_deg, **given):
    """Return the stiffness (N/m) in plan of the only bent of a bridge, its cap held upright."""
    given |= {"bent_skew_deg": skew_deg, "column_spacing": "along_bent", "elastic_columns": True}
    options = ModelOptions(**given)
    bridge = structures.built_bridge(catalogue.load_bridge(name), options)
    flexibility = []
    for dof in (1, 2):
        with domain():
            tags = handles.TagAllocator()
            centre = tags.node()
            ops.node(centre, bridge.bent_positions_m[0], 0.0, bridge.deck.centroid_above_soffit_m)
            ops.fix(centre, 0, 0, 0, 1, 1, 1)
            one = [centre]
            one = {"nodes": [centre], "decks": [[centre]], "bent_nodes": [centre]}
            spine = Spine(**one, heavy=[], centre_node=centre, elements=[])
            bent.build_bents(bridge, spine, skew_deg, options, tags)
            assembly.open_linear_pattern(tags)
            ops.load(centre, *(1.0e3 * (i == dof) for i in range(1, 7)))
            static_steps(1, "UmfPack", 1e-14)
            flexibility.append(np.array(ops.nodeDisp(centre)[:2]) / 1.0e3)
    return np.linalg.inv(np.array(flexibility).T)


@pytest.mark.parametrize(("name", "foundation"), [("osb1", "fixed"), ("bridge_b", "springs")])
@pytest.mark.parametrize("skew_deg", [30.0, -52.5])
def test_the_stiffness_of_a_bent_turns_with_its_skew(name, foundation, skew_deg):
    straight = plan_stiffness(name, 0.0, foundation=foundation)
    c, s = cos(radians(skew_deg)), sin(radians(skew_deg))
    turn = np.array([[c, -s], [s, c]])
    assert abs(straight[0, 0] / straight[1, 1] - 1.0) > 0.01  # not the same in all directions
    found = plan_stiffness(name, skew_deg, foundation=foundation)
    limit = straight.max() * 1e-6
    np.testing.assert_allclose(found, turn @ straight @ turn.T, rtol=1e-6, atol=limit)


@pytest.mark.parametrize(
    ("spacing", "across_m", "along_m"), [("normal", 7.32, 14.64), ("along_bent", 3.66, 7.32)]
)
def test_columns_of_a_skewed_bent_are_in_line_with_its_cap(spacing, across_m, along_m):
    options = ModelOptions(column_spacing=spacing)
    with domain():
        model = build(variant(60), options)
        (x1, y1, _), (x2, y2, _) = (ops.nodeCoord(each.base_node) for each in model.columns)
        held_n = sum(column_axial_forces_n(model)) + sum(support_reactions_n(model))
    assert y2 - y1 == pytest.approx(across_m)
    assert np.hypot(x2 - x1, y2 - y1) == pytest.approx(along_m)
    assert (x2 - x1) / (y2 - y1) == pytest.approx(-np.tan(np.pi / 3))  # counter-clockwise
    # cap and diaphragms end at the edges of the deck: twice as long and heavy at 60 degrees
    bridge = catalogue.load_bridge("osb1")
    (longer,) = structures.built_bridge(bridge, options, 60.0).bents
    assert longer.cap_weight_kn == pytest.approx(2 * bridge.bents[0].cap_weight_kn)
    added_kn = bridge.bents[0].cap_weight_kn + 2 * bridge.deck.diaphragm_weight_kn
    assert held_n == pytest.approx(weights.total_weight_n(bridge) + added_kn * 1e3, rel=1e-6)


def test_the_skew_of_bents_is_the_abutments_unless_an_option_says_otherwise():
    options = [{"bent_skew": "square"}, {}, {"bent_skew_deg": 12.0}]
    found = [ModelOptions(**given).skew_of_bents_deg(30.0) for given in options]
    assert found == [0.0, 30.0, 12.0]
