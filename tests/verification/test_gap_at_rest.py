"""The gap of a variant is the opening at rest, after dead load, normal to the backwall."""

import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, seated_bridges, variant
from skewbridge.analysis.pushover import push_abutment
from skewbridge.bridge.model import build, domain
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS

TOLERANCE_M = 5e-5  # a thousandth of the larger gap: far below any effect under study
GAP_MM = 25
KEY_GAP_M = 0.0064


def at_rest(skew_deg, abutment, bridge="osb1", gap_mm=GAP_MM):
    return variant(skew_deg, abutment, bridge, gap_mm).normalised()


@pytest.mark.parametrize("bridge", seated_bridges())
@pytest.mark.parametrize("abutment", ["contact", "contact_friction", "spring", "simplified"])
@pytest.mark.parametrize("skew_deg", [0, 60, -30])
def test_gaps_are_open_by_their_width_under_dead_load(bridge, abutment, skew_deg):
    with domain():
        model = build(at_rest(skew_deg, abutment, bridge), ModelOptions())
        if model.contacts is not None:
            model.contacts.start_from_rest()
        for side in model.abutments:
            for spring in (*side.wall_springs, *side.key_springs):
                moved = ops.basicDeformation(spring.element)[spring.component]
                assert moved == pytest.approx(0.0, abs=TOLERANCE_M)
            for units, gap_m in ((side.wall_units, GAP_MM / 1000), (side.key_units, KEY_GAP_M)):
                for unit in units:
                    assert model.contacts.openings_m[unit] == pytest.approx(gap_m, abs=TOLERANCE_M)
            count = ModelOptions().backwall_points if "contact" in abutment else 0
            assert len(side.wall_units) == count
            assert len(side.key_units) + len(side.key_springs) + len(side.wall_springs) > 0
        # the deck has turned at its ends: an opening counted from the undeformed model differs
        end = model.abutments[0].corners[0].node
        assert "contact" not in abutment or abs(ops.nodeDisp(end, 1)) > 2 * TOLERANCE_M


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact"])
@pytest.mark.parametrize("skew_deg", [0, 30])
def test_a_push_of_the_deck_end_meets_the_backfill_after_the_gap(abutment, skew_deg):
    """The soil acts from 25 mm along the normal, although dead load rotates the deck ends."""
    wide = ModelOptions(transverse_gap_mm=300.0)
    given = {"angle_deg": float(skew_deg), "max_disp_m": 0.03, "steps": 300}
    cases = (at_rest(skew_deg, abutment, gap_mm=gap_mm) for gap_mm in (GAP_MM, 300))
    near, far = (push_abutment(case, wide, **given) for case in cases)
    felt = near.force_n - far.force_n > 1e4
    assert near.disp_m[felt][0] == pytest.approx(GAP_MM / 1000, abs=2 * 0.03 / 300)


@pytest.mark.parametrize("abutment", [name for name in ABUTMENTS if ABUTMENTS[name].has_pads])
def test_analyses_with_keys_without_a_gap_finish(abutment):
    for skew_deg in (30, 60):
        options = ModelOptions(transverse_gap_mm=0.0)
        result = analysed(at_rest(skew_deg, abutment), options=options, duration_s=1.5)
        assert result.status == "ok"
        assert result.demands["shear_key_force_kn"] > 0.0


def test_a_gap_measured_along_the_bridge_is_narrower_normal_to_a_skew_wall():
    with domain():
        model = build(at_rest(60, "contact"), ModelOptions(gap_measured="longitudinal"))
        assert model.abutments[0].gap_m == pytest.approx(GAP_MM / 2000)
        assert model.contacts.openings_m[0] == pytest.approx(GAP_MM / 2000)
