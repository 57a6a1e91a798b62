"""What must hold exactly or nearly so: mirrored skew, vanishing friction, gaps never closed."""

import numpy as np
import pytest

from bridge_motions import pulse_motion
from skewbridge.analysis.ground import Excitation
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import AnalysisResult, analyse
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

DURATION_S = 5.0


def run(
    abutment: str,
    *,
    skew_deg: int = 30,
    friction_pct: int = 50,
    gap_mm: int = 51,
    mirrored: bool = False,
    options: ModelOptions | None = None,
) -> AnalysisResult:
    variant = Variant(
        bridge="osb1",
        abutment=abutment,
        skew_deg=skew_deg,
        gap_mm=gap_mm,
        friction_pct=friction_pct,
    )
    result = analyse(
        variant,
        Excitation(motion=pulse_motion(duration_s=DURATION_S, mirrored=mirrored)),
        AnalysisSettings(),
        options or ModelOptions(),
        histories=True,
    )
    assert result.status == "ok"
    return result


def test_opposite_skew_under_the_mirrored_motion_gives_the_mirrored_response() -> None:
    plus = run("contact_friction", skew_deg=30)
    minus = run("contact_friction", skew_deg=-30, mirrored=True)
    assert plus.demands["contact_closures"] > 10
    assert plus.histories is not None
    assert minus.histories is not None
    for name, sign in (("deck_ux_m", 1), ("deck_uy_m", -1), ("deck_rot_rad", -1)):
        a, b = plus.histories[name], sign * minus.histories[name]
        assert np.abs(a - b).max() < 1e-6 * np.abs(a).max(), name  # rounding, grown by contact
    for name in ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m"):
        assert minus.demands[name] == pytest.approx(plus.demands[name], rel=0.01), name


def test_contact_without_friction_equals_contact_friction_at_zero_friction() -> None:
    plain = run("contact").demands
    zero = run("contact_friction", friction_pct=0).demands
    assert zero == pytest.approx(plain, rel=1e-9)  # same elements, same equations


def test_friction_springs_at_zero_bound_do_nothing() -> None:
    # a model without tangential springs: their stiffness is 1 N/m instead of 1e8
    without = run("contact", options=ModelOptions(tangent_stiffness_n_per_m=1.0)).demands
    plain = run("contact").demands
    for name in ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "deck_rotation_rad"):
        assert plain[name] == pytest.approx(without[name], rel=0.01), name


def test_a_gap_no_motion_can_close_gives_no_contact_demands() -> None:
    demands = run(
        "contact_friction", gap_mm=600, options=ModelOptions(transverse_gap_mm=5000.0)
    ).demands
    for name in (
        *("backwall_force_kn", "shear_key_force_kn", "friction_force_kn", "contact_closures"),
        *("contact_time_s", "contact_max_penetration_m", "slip_work_kj", "cone_violation_ratio"),
    ):
        assert demands[name] == 0.0, name


@pytest.mark.parametrize("skew_deg", [0, 30])
def test_corotational_arrays_give_the_demands_of_rigid_ones(skew_deg: int) -> None:
    rigid = run("contact_friction", skew_deg=skew_deg).demands
    options = ModelOptions(arrays="corotational")
    elements = run("contact_friction", skew_deg=skew_deg, options=options).demands
    for name in ("column_shear_kn", "column_drift_ratio", "deck_disp_m", "unseating_m"):
        assert elements[name] == pytest.approx(rigid[name], rel=0.005), name
