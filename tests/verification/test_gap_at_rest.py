"""The gap of a variant is the opening at rest, after dead load, normal to the backwall."""

import openseespy.opensees as ops
import pytest

from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.pushover import push_abutment
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.catalogue import bridge_names
from skewbridge.bridge.model import build, domain
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant
from strong_motion import strong_motion

TOLERANCE_M = 5e-5  # a thousandth of the larger gap: far below any effect under study
GAP_MM = 25
KEY_GAP_M = 0.0064
SKEWS_DEG = (0, 30, 60, -30)


def variant(abutment: str, skew_deg: int, bridge: str = "osb1", gap_mm: int = GAP_MM) -> Variant:
    return Variant(
        bridge=bridge, abutment=abutment, skew_deg=skew_deg, gap_mm=gap_mm, friction_pct=50
    ).normalised()


@pytest.mark.parametrize("bridge", bridge_names())
@pytest.mark.parametrize("abutment", ["contact", "contact_friction"])
def test_contacts_are_open_by_their_gap_under_dead_load(bridge: str, abutment: str) -> None:
    for skew_deg in SKEWS_DEG:
        with domain():
            model = build(variant(abutment, skew_deg, bridge), ModelOptions())
            assert model.contacts is not None
            model.contacts.start_from_rest()
            openings = model.contacts.openings_m
            for side in model.abutments:
                assert len(side.wall_units) == ModelOptions().backwall_points
                for unit in side.wall_units:
                    assert openings[unit] == pytest.approx(GAP_MM / 1000, abs=TOLERANCE_M)
                for unit in side.key_units:
                    assert openings[unit] == pytest.approx(KEY_GAP_M, abs=TOLERANCE_M)
            # the deck has turned at its ends: an opening counted from the undeformed model differs
            end = model.abutments[0].corners[0].node
            assert abs(ops.nodeDisp(end, 1)) > 2 * TOLERANCE_M


@pytest.mark.parametrize("bridge", bridge_names())
@pytest.mark.parametrize("abutment", ["spring", "simplified"])
def test_gap_springs_are_at_rest_under_dead_load(bridge: str, abutment: str) -> None:
    for skew_deg in SKEWS_DEG:
        with domain():
            model = build(variant(abutment, skew_deg, bridge), ModelOptions())
            for side in model.abutments:
                for spring in (*side.wall_springs, *side.key_springs):
                    moved = ops.basicDeformation(spring.element)[spring.component]
                    assert moved == pytest.approx(0.0, abs=TOLERANCE_M)


@pytest.mark.parametrize("abutment", ["simplified", "spring", "contact"])
@pytest.mark.parametrize("skew_deg", [0, 30])
def test_a_push_of_the_deck_end_meets_the_backfill_after_the_gap(
    abutment: str, skew_deg: int
) -> None:
    """The soil acts from 25 mm along the normal, although dead load rotates the deck ends."""
    curves = [
        push_abutment(
            variant(abutment, skew_deg, gap_mm=gap_mm),
            ModelOptions(transverse_gap_mm=300.0),
            angle_deg=float(skew_deg),
            max_disp_m=0.03,
            steps=300,
        )
        for gap_mm in (GAP_MM, 300)
    ]
    felt = curves[0].force_n - curves[1].force_n > 1e4
    assert curves[0].disp_m[felt][0] == pytest.approx(GAP_MM / 1000, abs=2 * 0.03 / 300)


@pytest.mark.parametrize("abutment", [name for name in ABUTMENTS if ABUTMENTS[name].has_pads])
@pytest.mark.parametrize("skew_deg", [30, 60])
def test_analyses_with_keys_without_a_gap_finish(abutment: str, skew_deg: int) -> None:
    result = analyse(
        variant(abutment, skew_deg),
        Excitation(motion=strong_motion()),
        AnalysisSettings(duration_s=1.5),
        ModelOptions(transverse_gap_mm=0.0),
    )
    assert result.status == "ok"
    assert result.demands["shear_key_force_kn"] > 0.0


def test_a_gap_measured_along_the_bridge_is_narrower_normal_to_a_skew_wall() -> None:
    with domain():
        model = build(variant("contact", 60), ModelOptions(gap_measured="longitudinal"))
        assert model.abutments[0].gap_m == pytest.approx(GAP_MM / 2000)
        assert model.contacts is not None
        assert model.contacts.openings_m[0] == pytest.approx(GAP_MM / 2000)
