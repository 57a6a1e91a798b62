"""Design checks against hand values of the project's reference page, sections 1 and 6."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from bridge_variants import variant
from skewbridge.analysis.sdc import (
    corner_moves_m,
    sdc_rows,
    seat_demand_aashto_m,
    seat_demand_sdc_m,
    summary_row,
)
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.hinge import bent_capacities, bent_capacity, hinge_length_m
from skewbridge.variant.options import HingeRule

VARIANT = variant()


@pytest.mark.parametrize(
    ("name", "yield_mm", "capacity_mm", "ductility"),
    [("osb1", 36.0, 211.0, 5.8), ("osb2s", 179.0, 908.0, 5.1)],
)
def test_displacement_capacity_agrees_with_the_hand_value(
    name: str, yield_mm: float, capacity_mm: float, ductility: float
) -> None:
    bent = bent_capacities(load_bridge(name))[0]
    assert 1e3 * bent.yield_disp_m == pytest.approx(yield_mm, rel=0.05)
    assert 1e3 * bent.capacity_m == pytest.approx(capacity_mm, rel=0.05)
    assert bent.capacity_m / bent.yield_disp_m == pytest.approx(ductility, rel=0.05)


@pytest.mark.parametrize(
    ("name", "bent", "rule", "length_m"),
    [
        # 0.08 x 5640 + 0.022 x 469 x 35.8 = 451.2 + 369.4 mm (0.817 m in the inch form of the rule)
        ("osb1", 0, "sdc", 0.8206),
        # 0.08 x 2820 + 369.4 = 595.0 mm; the lower limit 0.044 x 469 x 35.8 = 738.8 mm governs
        ("osb1_fixed", 0, "paulay_priestley", 0.5950),
        ("osb1_fixed", 0, "sdc", 0.7388),
        # bents of different height: 0.08 x 13410 or 14330 + 0.022 x 469 x 43.0 = 443.7 mm
        ("osb2s", 0, "sdc", 1.5165),
        ("osb2s", 1, "sdc", 1.5901),
    ],
)
def test_the_hinge_length_follows_from_height_and_base(
    name: str, bent: int, rule: HingeRule, length_m: float
) -> None:
    bridge = load_bridge(name)
    assert hinge_length_m(bridge, bent, rule) == pytest.approx(length_m, abs=1e-4)
    assert bent_capacity(bridge, bent, rule).hinge_length_m == pytest.approx(length_m, abs=1e-4)


def test_a_hinge_length_in_the_file_overrides_the_rule() -> None:
    bridge = load_bridge("osb2s")
    column = bridge.column.model_copy(update={"hinge_length_m": 0.9})
    given = bridge.model_copy(update={"column": column})
    assert [bent.hinge_length_m for bent in bent_capacities(given)] == [0.9, 0.9]
    assert bent_capacity(given, 0).capacity_m < bent_capacity(bridge, 0).capacity_m


@pytest.mark.parametrize(("skew_deg", "seat_m"), [(0, 0.59), (30, 0.66), (45, 0.74), (60, 0.86)])
def test_seat_width_of_aashto_agrees_with_the_hand_value(skew_deg: int, seat_m: float) -> None:
    found = seat_demand_aashto_m(load_bridge("osb1"), radians(skew_deg))
    assert found == pytest.approx(seat_m, abs=0.006)
    assert seat_demand_aashto_m(load_bridge("osb1"), radians(-skew_deg)) == found


def test_seat_width_of_the_criteria_has_a_minimum() -> None:
    bridge = load_bridge("osb1")
    assert seat_demand_sdc_m(bridge, 0.0) == pytest.approx(0.762)
    assert seat_demand_sdc_m(bridge, 1.0) == pytest.approx(1.0 + 0.1016 + 0.04572)


def test_the_table_names_what_fails() -> None:
    rows = sdc_rows(VARIANT, 0.30, {"left acute": 0.2, "right acute": 0.9})
    failed = {row["check"] for row in rows if not row["ok"]}
    assert failed == {
        "bent 1 displacement, hinge 0.821 m by rule (m)",
        "right acute seat, SDC (m)",
    }


def test_corner_moves_count_outward_normal_to_the_seat_only() -> None:
    still = np.zeros(2)
    histories = {
        f"abutment_{side}_{kind}_{axis}_m": still
        for side in ("left", "right")
        for kind in ("acute", "obtuse")
        for axis in "xy"
    }
    histories["abutment_right_acute_x_m"] = np.array([0.0, -0.1])
    histories["abutment_right_obtuse_x_m"] = np.array([0.0, 0.1])
    # along the wall: no move normal to the seat
    histories["abutment_left_acute_x_m"] = np.array([0.0, -0.1 * np.sin(radians(30))])
    histories["abutment_left_acute_y_m"] = np.array([0.0, 0.1 * np.cos(radians(30))])
    moves = corner_moves_m(VARIANT, histories)
    assert moves["right acute"] == pytest.approx(0.1 * np.cos(radians(30)))
    assert moves["right obtuse"] == 0.0
    assert moves["left acute"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("gap_mm", "support_m"), [(25, 0.889), (51, 0.863)])
def test_the_support_at_rest_is_the_seat_less_the_gap(gap_mm: int, support_m: float) -> None:
    variant = replace(VARIANT, gap_mm=gap_mm)
    bridge = load_bridge("osb1")
    rows = {row["check"]: row for row in sdc_rows(variant, 0.1, {"left acute": 0.2})}
    assert rows["left acute seat, SDC (m)"]["capacity"] == pytest.approx(support_m)
    assert rows["seat, AASHTO 1.5 N (m)"]["capacity"] == pytest.approx(support_m)
    summary = summary_row(variant, 0.1, 0.2, 0.9)
    demand_m = seat_demand_sdc_m(bridge, 0.9)
    assert summary["seat_worst_ratio"] == pytest.approx(demand_m / support_m)
