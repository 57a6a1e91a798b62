"""Invariances of the response: repetition, mirror images, vanishing friction, open gaps, arrays."""

import numpy as np
import pytest

from bridge_variants import analysed, variant
from skewbridge.variant.options import ModelOptions
from strong_motion import mirrored, pulse_motion, strong_motion

FIRST_5_S = slice(0, 1001)
PEAKS = ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m")
MIRRORED = mirrored(strong_motion())
NOT_COMPARED = ("energy_residual_ratio", "numerical_dissipation_ratio", "contact_closures")


def test_two_runs_that_close_gaps_and_slip_give_identical_values():
    reference = analysed(variant())
    assert reference.status == "ok"
    assert reference.demands["contact_closures"] > 10
    assert reference.demands["backwall_force_kn"] > 1000.0
    assert reference.demands["slip_work_kj"] > 10.0
    again = analysed(variant())
    assert again.demands == reference.demands
    for name, values in reference.histories.items():
        np.testing.assert_array_equal(again.histories[name], values, err_msg=name)


def test_contact_equals_contact_friction_without_friction():
    frictionless = analysed(variant(friction_pct=0))
    plain = analysed(variant(abutment="contact", friction_pct=0))
    # Same equations, numbering and springs: only the updates are left out.
    for name, value in frictionless.demands.items():
        assert plain.demands[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    # Tangential springs that are a thousand times softer: as good as none.
    options = ModelOptions(tangent_stiffness_factor=1e-3)
    bare = analysed(variant(abutment="contact", friction_pct=0), options=options)
    for name in (*PEAKS, "deck_rotation_rad"):
        assert bare.demands[name] == pytest.approx(frictionless.demands[name], rel=0.01), name


def test_opposite_skew_mirrors_the_response():
    # steps of one size and a tight test: rounding, which differs between processors, then decides
    # neither on the size of a step nor on an iteration
    tight = {"tolerance_j": 1e-8, "reuse_tangent": False, "dt_s": 0.001, "contact_dt_s": 0.001}
    (one, other), rough = (
        (analysed(variant(60), **settings), analysed(variant(-60), MIRRORED, **settings))
        for settings in (tight | {"event_dt_s": None, "duration_s": 4.0}, {})
    )
    assert one.demands["contact_closures"] > 10
    for name, sign in (("deck_ux_m", 1.0), ("deck_uy_m", -1.0), ("deck_rot_rad", -1.0)):
        history, image = one.histories[name], sign * other.histories[name]
        # 1e-9: rounding, grown by contacts (measured 1e-14)
        np.testing.assert_allclose(
            image[FIRST_5_S], history[FIRST_5_S], rtol=0, atol=1e-9 * np.abs(history).max()
        )
    for name, value in one.demands.items():
        if name not in NOT_COMPARED:
            assert other.demands[name] == pytest.approx(value, rel=0.01, abs=1e-9), name
    for name in PEAKS:
        assert rough[1].demands[name] == pytest.approx(rough[0].demands[name], rel=0.01), name


def test_a_gap_that_nothing_closes_gives_no_contact_demands():
    # 0.6 m at the backwalls and 5 m at the keys, against a deck that moves by decimetres.
    wide = analysed(variant(gap_mm=600), options=ModelOptions(transverse_gap_mm=5000.0))
    assert wide.status == "ok"
    assert wide.demands["deck_disp_m"] > 0.05
    for name in (
        "contact_closures", "contact_time_s", "contact_max_penetration_m", "slip_work_kj",
        "backwall_force_kn", "shear_key_force_kn", "friction_force_kn", "cone_violation_ratio",
    ):  # fmt: skip
        assert wide.demands[name] == 0.0, name


def test_half_a_turn_equals_reversing_the_motion_and_friction_couples_the_axes_without_skew():
    motion = strong_motion(duration_s=3.0)
    reverse = motion.with_components(-motion.accel_1_mps2, -motion.accel_2_mps2)
    turned = analysed(variant(0), motion, incidence_deg=180.0).demands
    assert analysed(variant(0), reverse).demands == pytest.approx(turned, rel=1e-12)
    motion = strong_motion()
    longitudinal = motion.with_components(motion.accel_1_mps2, 1e-3 * motion.accel_2_mps2)
    with_friction = analysed(variant(0)).demands
    without = analysed(variant(0, friction_pct=0)).demands
    alone = analysed(variant(0), longitudinal).demands
    assert with_friction["deck_disp_y_m"] != pytest.approx(without["deck_disp_y_m"], rel=1e-3)
    assert alone["deck_disp_y_m"] < 0.01 * with_friction["deck_disp_y_m"]


@pytest.mark.parametrize("skew_deg", [0, 30])
def test_corotational_arrays_give_the_demands_of_rigid_links(skew_deg):
    rigid, elements = (
        analysed(variant(skew_deg), pulse_motion(), ModelOptions(arrays=arrays))
        for arrays in ("rigid", "corotational")
    )
    assert rigid.status == elements.status == "ok"
    for name in PEAKS:
        assert elements.demands[name] == pytest.approx(rigid.demands[name], rel=0.005), name
