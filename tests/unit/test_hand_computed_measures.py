"""Demands, strengths, intensities and factors against numbers worked out by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hand_made_column import SECTION
from skewbridge.analysis import peaks
from skewbridge.analysis.trace import Layout, ResponseTrace
from skewbridge.bridge.handles import AbutmentHandle, CornerHandle, SpringHandle
from skewbridge.bridge.shear_capacity import (
    hoop_strength_n,
    kowalsky_priestley_strength,
    sdc_shear_strength,
)
from skewbridge.motions.intensity import housner_intensity, motion_measures
from skewbridge.motions.levels import block_factors
from skewbridge.motions.record import GroundMotion

CENTRE, WALL_1, WALL_2 = 1, 2, 3
PSI_PA = 6894.757293168


def abutment(**changes) -> AbutmentHandle:
    handle = AbutmentHandle(
        side="right",
        normal=(1.0, 0.0),
        tangent=(0.0, 1.0),
        gap_m=0.05,
        transverse_gap_m=0.0064,
        seat_width_m=0.9,
        centre_node=CENTRE,
        corners=tuple(
            CornerHandle(node=CENTRE, kind=kind, plan_m=(0.0, 0.0)) for kind in ("acute", "obtuse")
        ),
        bearings=(),
        pad_offsets_m=((0.0, 0.0),),
        wall_units=(),
        key_units=(),
        wall_nodes=(WALL_1, WALL_2),
        key_nodes=(),
        wall_springs=(),
        key_springs=(),
        wing_springs=(),
        other_springs=(),
    )
    return replace(handle, **changes)


def trace_of(**along_x_m) -> ResponseTrace:
    """Return a trace of three steps in which nodes move along x."""
    layout = Layout(
        nodes=(CENTRE, WALL_1, WALL_2),
        columns=(),
        sections=(),
        springs=(),
        bearings=(),
        units=0,
        centre_node=CENTRE,
    )
    rows = np.zeros((3, layout.width))
    for name, values in along_x_m.items():
        node = {"centre": CENTRE, "wall_1": WALL_1, "wall_2": WALL_2}[name]
        rows[:, layout.node(node)] = values
    return ResponseTrace(layout=layout, rows=rows)


def movements(trace: ResponseTrace, *handles: AbutmentHandle) -> dict[str, float]:
    return peaks._abutment_demands(SimpleNamespace(abutments=handles), trace)


def test_passive_is_into_the_fill_and_active_is_out_of_it():
    """The right wall has its fill at +x: 30 mm into it, 20 mm out of it."""
    trace = trace_of(wall_1=[0.0, 0.03, -0.01], wall_2=[0.0, 0.01, -0.02])
    right = movements(trace, abutment())
    assert right["abutment_passive_m"] == pytest.approx(0.03)
    assert right["abutment_active_m"] == pytest.approx(0.02)
    left = movements(trace, abutment(side="left", normal=(-1.0, 0.0)))
    assert left["abutment_passive_m"] == pytest.approx(0.02)
    assert left["abutment_active_m"] == pytest.approx(0.03)


def test_without_wall_nodes_the_fill_is_pushed_by_what_the_gap_leaves_and_never_pulled():
    spring = SpringHandle(element=9, component=0, direction=(1.0, 0.0), nodes=(99, CENTRE))
    bare = abutment(wall_nodes=(), wall_springs=(spring,))
    found = movements(trace_of(centre=[0.0, 0.08, -0.20]), bare)
    assert found["abutment_passive_m"] == pytest.approx(0.03)
    assert found["abutment_active_m"] == 0.0


def test_friction_of_a_wall_is_the_resultant_of_its_points():
    """Two points: 300 kN apart cancel, 400 kN along the wall add up to 800 kN."""
    layout = replace(trace_of().layout, units=2)
    rows = np.zeros((3, layout.width))
    rows[1, layout.contacts("tangentials")] = [3e5, 4e5, -3e5, 4e5]
    rows[2, layout.contacts("tangentials")] = [0.0, -5e5, 0.0, 0.0]
    model = SimpleNamespace(abutments=(abutment(wall_units=(0, 1)),), weight_n=1e7)
    found = peaks._force_demands(model, ResponseTrace(layout=layout, rows=rows))
    assert found["friction_force_kn"] == pytest.approx(800.0)


def test_every_number_of_a_row_belongs_to_one_reading():
    layout = Layout(
        nodes=(1, 2),
        columns=(3, 4),
        sections=((3, 1), (3, 2), (4, 1)),
        springs=((5, 2), (6, 3)),
        bearings=(7, 8, 9),
        units=2,
        centre_node=1,
    )
    handles = [
        SpringHandle(element=element, component=component, direction=(1.0, 0.0), nodes=(1, 2))
        for element, count in layout.springs
        for component in range(count)
    ]
    starts = {
        **{f"node {tag}": (layout.node(tag), 6) for tag in layout.nodes},
        **{f"column {tag}": (layout.column(tag), 12) for tag in layout.columns},
        **{f"section {place}": (layout.section(*place), 4) for place in layout.sections},
        **{f"spring {number}": (layout.spring(each), 1) for number, each in enumerate(handles)},
        **{f"pad {tag}": (layout.bearing(tag), 2) for tag in layout.bearings},
    }
    read = [0, 1, 2]  # time and two accelerations
    for start, count in starts.values():
        read += range(start, start + count)
    for part, count in (("openings", 2), ("normals", 2), ("tangentials", 4)):
        place = layout.contacts(part)
        assert place.stop - place.start == count
        read += range(place.start, place.stop)
    assert sorted(read) == list(range(layout.width))


def concrete_n(factor_1: float, factor_2: float = 1.0) -> float:
    """Return Vc of the criteria: factors times the root of the strength, in psi."""
    effective_m2 = 0.8 * np.pi * 1.676**2 / 4
    return factor_1 * factor_2 * np.sqrt(27.6e6 / PSI_PA) * PSI_PA * effective_m2


@pytest.mark.parametrize(
    ("ductility", "factor_1"),
    [
        # hoops: 4 x 510e-6 / (1.549 x 0.127) x 414 MPa = 4.293 MPa = 0.6227 ksi, at most 0.35
        (1.0, 3.0),  # 0.35 / 0.15 + 3.67 - 1 = 5.0
        (4.0, 0.35 / 0.15 + 3.67 - 4.0),
        (5.5, 0.35 / 0.15 + 3.67 - 5.5),
        (8.0, 0.3),  # -2: no less than 0.3
        (20.0, 0.3),
    ],
)
def test_concrete_shear_falls_with_ductility_down_to_a_tenth(ductility, factor_1):
    strength = sdc_shear_strength(SECTION, 0.0, ductility)
    assert float(strength) == pytest.approx(
        concrete_n(factor_1) + hoop_strength_n(SECTION), rel=1e-6
    )


def test_concrete_shear_grows_with_compression_and_is_none_under_tension():
    axial_n = 0.25 * 2000.0 * PSI_PA * np.pi * 1.676**2 / 4
    steel = hoop_strength_n(SECTION)
    assert float(sdc_shear_strength(SECTION, axial_n, 8.0)) == pytest.approx(
        concrete_n(0.3, 1.25) + steel, rel=1e-6
    )
    assert float(sdc_shear_strength(SECTION, 9.0 * axial_n, 8.0)) == pytest.approx(
        concrete_n(0.3, 1.5) + steel, rel=1e-6
    )
    assert float(sdc_shear_strength(SECTION, -1.0, 8.0)) == pytest.approx(steel, rel=1e-9)
    assert float(sdc_shear_strength(SECTION, 9.0 * axial_n, 1.0)) == pytest.approx(
        concrete_n(4.0) + steel, rel=1e-6
    )
    away = sdc_shear_strength(SECTION, 0.0, 8.0, inside_hinge=False)
    assert float(away) == pytest.approx(concrete_n(3.0) + steel, rel=1e-6)


def test_hoops_carry_what_their_force_and_number_give():
    # pi/2 x 510 mm2 x 414 MPa x 1.549 m / 0.127 m
    assert hoop_strength_n(SECTION) == pytest.approx(4.0452e6, rel=1e-4)


def test_revised_ucsd_strength_is_the_sum_of_its_three_parts():
    """Aspect 5.64/1.676 > 2: 1.0; steel 0.5 + 20 x 0.02 = 0.9; 0.29 up to 3, 0.05 from 15."""
    area_mm2 = 0.8 * np.pi * 1676.0**2 / 4
    truss_kn = np.pi / 2 * 0.510 * 469.0 * (1676 - 500 - 64) / np.tan(np.pi / 6) / 127.0
    for ductility, degraded in ((1.0, 0.29), (9.0, 0.17), (20.0, 0.05)):
        concrete_kn = 1.0 * 0.9 * degraded * np.sqrt(35.85) * area_mm2 / 1000.0
        strut_kn = 6000.0 * (1.676 - 0.5) / (2 * 5.64)
        expected = 1e3 * (concrete_kn + truss_kn + strut_kn)
        found = float(kowalsky_priestley_strength(SECTION, 6.0e6, ductility))
        assert found == pytest.approx(expected, rel=1e-6)


def test_one_value_per_pair_is_the_mean_of_its_components():
    """1 m/s2 to and fro for 2 s: CAV 2 m/s, Arias pi/(2 g) x 2; the other component is still."""
    accel = np.array([1.0, -1.0] * 100 + [1.0])
    motion = GroundMotion(
        motion_id="m", dt_s=0.01, accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel)
    )
    found = motion_measures(motion, None)
    assert found["im_cav_mps"] == pytest.approx(1.0)
    assert found["im_arias_mps"] == pytest.approx(0.5 * np.pi / (2.0 * 9.80665) * 2.0)
    twice = motion_measures(motion.with_components(accel, 3.0 * accel), None)
    assert twice["im_cav_mps"] == pytest.approx((2.0 + 6.0) / 2.0)


def test_the_median_over_directions_of_a_straight_motion_is_that_of_the_cosine():
    """Peaks 3 m/s2 and 3 x 0.21 s = 0.63 m/s along one axis: cos 45 degrees of them."""
    accel = np.array([0.0, *[3.0] * 21, 0.0])
    motion = GroundMotion(
        motion_id="m", dt_s=0.01, accel_1_mps2=accel, accel_2_mps2=np.zeros_like(accel)
    )
    found = motion_measures(motion, None)
    assert found["im_pga_rotd50_g"] == pytest.approx(3.0 * np.sqrt(0.5) / 9.80665, rel=0.01)
    assert found["im_pgv_rotd50_mps"] == pytest.approx(0.63 * np.sqrt(0.5), rel=0.01)


def test_two_blocks_interleave_and_a_cut_block_fills_the_range_alone():
    shares = np.log(block_factors(np.ones(20), (0.1, 1.5)) / 0.1) / np.log(15.0)
    steps = np.arange(8)
    both = np.concatenate([(steps + 1 / 2) / 8, (steps + 1 / 4) / 8])
    np.testing.assert_allclose(np.sort(shares[:16]), np.sort(both))
    np.testing.assert_allclose(shares[16:], (np.arange(4) + 3 / 4) / 4)


def test_the_spectrum_intensity_of_a_blow_is_its_velocity_times_the_range_of_periods():
    """A blow of 0.6 m/s: an oscillator swings to v/w exp[-xi/w_d atan(w_d/xi)] at any period."""
    dt_s, xi = 0.0005, 0.05
    accel = np.zeros(6001)
    accel[1] = 0.6 / dt_s
    damped = np.sqrt(1.0 - xi**2)
    reached = 0.6 * np.exp(-xi / damped * np.arctan(damped / xi))
    assert housner_intensity(accel, dt_s) == pytest.approx(reached * (2.5 - 0.1), rel=1e-3)
