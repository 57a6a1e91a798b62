"""Skewed bents, against closed forms and rows of the earlier model.

The stiffness of a bent is a tensor in plan: a bent turned by an angle has the turned tensor. It is
exact up to rounding in the static analysis (1e-6). The stored rows were computed at commit
a144bb78 with constant steps of 5 ms, before bents were skewed, the dashpot of a wall was in
series with the plastic part of the backfill and softening columns lost their stiffness damping; the
same equations give the same numbers (1e-9)."""

from math import cos, radians, sin
from pathlib import Path

import numpy as np
import openseespy.opensees as ops
import pandas as pd
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.analysis import transient
from skewbridge.bridge import assembly, bent, catalogue, handles, structures, weights
from skewbridge.bridge import spine as spines
from skewbridge.bridge.model import build, column_axial_forces_n, domain, support_reactions_n
from skewbridge.bridge.spine import Spine, build_spine
from skewbridge.motions.intensity import cut_to_strongest
from skewbridge.variant.options import ModelOptions
from skewbridge.verification.studies.paper_runs import strongest_motions

ROWS = Path(__file__).parents[1] / "data" / "rows_of_square_bents.csv"
#: Options that restore the model of the stored rows.
EARLIER = {
    "bent_skew": "square", "backfill_dashpot": "parallel",
    "backfill_skew": "strength_and_stiffness", "wall_restoring_n_per_m": 3.0e5,
    "shear_model": "sdc_expected", "foundation": "fixed",
}  # fmt: skip
#: Steps that do not depend on contacts, because the policy of steps is not part of the model.
CONSTANT = {"dt_s": 0.005, "contact_dt_s": None, "event_dt_s": None}


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
    assert [ModelOptions(**given).skew_of_bents_deg(30.0) for given in options] == [0.0, 30.0, 12.0]


@pytest.mark.parametrize("row", pd.read_csv(ROWS).to_dict("records"), ids=lambda row: row["bridge"])
def test_rows_of_the_earlier_model_are_reproduced_by_its_options(monkeypatch, written, row):
    def squared(bridge, elements, skew_deg, tags):
        """Build the spine of the earlier model: a rectangular deck, diaphragms across it."""
        weight_kn = bridge.deck.diaphragm_weight_kn * np.cos(np.radians(skew_deg))
        deck = bridge.deck.model_copy(update={"diaphragm_weight_kn": weight_kn})
        return build_spine(bridge.model_copy(update={"deck": deck}), elements, 0.0, tags)

    # the stored peaks exceed the displacement capacity, where columns now lose their damping
    monkeypatch.setattr(transient.Watch, "softened", lambda _: [])
    monkeypatch.setattr(spines, "build_spine", squared)
    motion = cut_to_strongest(strongest_motions(4, 1.2)[3], 5.0, 0.0)
    names = ("bridge", "skew_deg", "gap_mm", "friction_pct", "abutment")
    place = {name: row.pop(name) for name in names}
    # rounding differs between processors: by 2e-7 of a value in this strong shaking, by 1.6e-3 for
    # bridge_a, in which a contact then closes one step later
    within = 3e-3 if place["bridge"] == "bridge_a" else 1e-6
    earlier = "title: earlier\nsource: 'd: a test'\ncolumn: {shear_span_ratio: 0.5}\n"
    place["bridge"] = written(f"extends: {place['bridge']}\n{earlier}")
    found = analysed(variant(**place), motion, ModelOptions(**EARLIER), **CONSTANT).whole_history
    assert {name: found[name] for name in row} == pytest.approx(row, rel=within)
