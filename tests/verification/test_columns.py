"""Columns: crushed and broken fibers, loss of shear strength, the shear of a leaning column."""

from itertools import pairwise

import numpy as np
import openseespy.opensees as ops
import pytest

from bridge_variants import analysed, static_steps, variant
from skewbridge.analysis.peaks import column_shear_n
from skewbridge.analysis.pushover import push_bridge
from skewbridge.analysis.trace import Monitor
from skewbridge.bridge.assembly import open_linear_pattern
from skewbridge.bridge.bent import bar_material, core_materials
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import axial_failure_drift, bent_capacity, shear_loss
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import core_concrete
from skewbridge.errors import InputError
from skewbridge.variant.options import ModelOptions
from strong_motion import strong_motion

COLUMN = load_bridge("osb1").column


def stresses_pa(material, strains):
    """Drive a material along a path of strains; return the stresses at its points."""
    ops.testUniaxialMaterial(material)
    found = []
    for start, end in pairwise((0.0, *strains)):
        for value in np.linspace(start, end, 40)[1:]:
            ops.setStrain(float(value))
        found.append(float(ops.getStress()))
    return found


def push(bridge, end_m, **options):
    case = variant(0, "roller", bridge).normalised()
    given = {"angle_deg": 0.0, "max_disp_m": end_m, "steps": 90}
    return push_bridge(case, ModelOptions(**options), **given)


@pytest.mark.parametrize("has_end", [True, False])
def test_a_crushed_core_keeps_a_fifth_of_its_strength(has_end):
    core = core_concrete(COLUMN)
    end = core.ultimate_strain
    with domain():
        parts = core_materials(COLUMN, TagAllocator(), has_end=has_end)
        stresses = [stresses_pa(part, [-0.99 * end, -1.3 * end, -1.5 * end]) for part in parts]
    before, *after = np.sum(stresses, axis=0)
    assert before == pytest.approx(-float(core.stress_pa(0.99 * end)), rel=0.01)
    expected = 0.2 * core.peak_pa if has_end else float(core.stress_pa(end))
    assert after == pytest.approx([-expected] * 2, rel=1e-3)


def test_a_bar_breaks_in_tension_and_buckles_when_the_core_crushes():
    crushed = core_concrete(COLUMN).ultimate_strain
    for path, is_broken in (
        ([0.055, 0.0], False),
        ([0.062, 0.05], True),  # reduced ultimate strain 0.06 of SDC 1.7, table 3.2.3
        ([-0.9 * crushed, 0.01], False),
        ([-1.1 * crushed, 0.01], True),  # buckled: hoops are gone
    ):
        with domain():
            stress = stresses_pa(bar_material(COLUMN, TagAllocator(), has_end=True), path)[-1]
        assert (abs(stress) < 1e-3 * 469e6) is is_broken


@pytest.mark.parametrize("bridge", ["osb1", "osb1_fixed"])
def test_a_bent_loses_strength_soon_after_its_displacement_capacity(bridge):
    capacity_m = bent_capacity(load_bridge(bridge), 0).capacity_m
    # fine enough that the two parts of a core that ends have nearly the same mesh
    fibers = (12, 32, 3)
    # the displacement capacity is that of columns on rigid ground
    given = {"column_fibers": fibers, "foundation": "fixed"}
    with_end = push(bridge, 2 * capacity_m, **given)
    without = push(bridge, 2 * capacity_m, fiber_end="none", **given)
    assert with_end.is_complete
    before = with_end.disp_m < capacity_m
    same = np.interp(with_end.disp_m[before], without.disp_m, without.force_n)
    np.testing.assert_allclose(with_end.force_n[before], same, rtol=1e-3)
    later = np.interp(1.5 * capacity_m, with_end.disp_m, with_end.force_n)
    assert later < 0.9 * with_end.peak_n
    assert with_end.force_n[-1] < 0.6 * with_end.peak_n
    assert without.force_n[-1] > 0.99 * without.peak_n


def test_drift_at_axial_failure_agrees_with_the_hand_value():
    # Elwood and Moehle, theta 65 degrees: tan 2.1445; hoops pi/2 x 510e-6 x 469e6 x 1.549/0.127
    # = 4.58 MN; 0.04 x 5.599/(2.1445 + 6.0/(4.58 x 2.1445)) = 0.0813
    section = bent_capacity(load_bridge("osb1_fixed"), 0).shear
    assert axial_failure_drift(section, 6.0e6) == pytest.approx(0.0813, rel=0.005)
    assert axial_failure_drift(section, 9.0e6) < axial_failure_drift(section, 6.0e6)


#: A shear-critical bridge for the default strength, and one for the design strength.
SHEAR_CRITICAL = [("osb1_fixed_era1", ModelOptions().shear_model), ("osb1_fixed", "sdc_expected")]


def test_a_push_loses_its_shear_strength_where_capacity_meets_demand():
    bent = bent_capacity(load_bridge("osb1_fixed"), 0)
    loss, height_m = shear_loss(bent, "sdc_expected"), bent.clear_height_m
    given = {"foundation": "fixed", "shear_model": "sdc_expected"}
    flagged = push("osb1_fixed", 0.30, **given)
    degraded = push("osb1_fixed", 0.30, shear_failure="degrade", **given)
    assert degraded.is_complete
    assert degraded.peak_n < 2 * loss.strength_n < flagged.peak_n  # of two columns
    assert degraded.disp_at_peak_m == pytest.approx(loss.failure_drift_ratio * height_m, rel=0.25)
    assert degraded.disp_at_peak_m < 0.5 * flagged.disp_at_peak_m
    assert degraded.force_n[-1] < 0.4 * degraded.peak_n


def test_a_bent_with_old_hoops_loses_the_mean_shear_strength_on_its_springs():
    bent = bent_capacity(load_bridge("osb1_fixed_era1"), 0)
    loss = shear_loss(bent)
    flagged = push("osb1_fixed_era1", 0.15)
    degraded = push("osb1_fixed_era1", 0.15, shear_failure="degrade")
    assert degraded.is_complete
    # nearly reached: the columns have equal shear, and P-Delta reduces the force on the deck
    assert 0.97 * 2 * loss.strength_n < degraded.peak_n < 2 * loss.strength_n < flagged.peak_n
    assert degraded.disp_at_peak_m < flagged.disp_at_peak_m
    assert degraded.force_n[-1] < 0.4 * degraded.peak_n


@pytest.mark.parametrize(("bridge", "model"), SHEAR_CRITICAL)
def test_a_strong_motion_cannot_exceed_the_shear_strength(bridge, model):
    loss = shear_loss(bent_capacity(load_bridge(bridge), 0), model)
    motion, shears_kn = strong_motion(duration_s=4.0, peak_g=1.2), {}
    for option in ("flag", "degrade"):
        case = variant(0, "roller", bridge).normalised()
        options = ModelOptions(shear_failure=option, shear_model=model)
        result = analysed(case, motion, options, scale=1.5)
        assert result.status in ("ok", "collapse")
        ends = ("_shear_x_kn", "_shear_y_kn")
        shears = [values for name, values in result.histories.items() if name.endswith(ends)]
        shears_kn[option] = np.abs(shears).max()
    assert shears_kn["degrade"] <= 1.001 * loss.strength_n / 1e3 < shears_kn["flag"]


def test_loss_of_shear_strength_needs_a_hinge_of_given_length():
    with pytest.raises(InputError, match="`shear_failure: degrade` requires"):
        push("osb1_fixed", 0.1, shear_failure="degrade", column_integration="lobatto5")


# --- the shear of a leaning column's sections: base force, P-Delta and end moments by statics
def pushed(bridge, options, push_n=(3.0e6, 1.5e6)):
    """Push the deck of a roller bridge; return its columns and the two states read."""
    with domain():
        model = build(variant(0, "roller", bridge).normalised(), options)
        monitor = Monitor(model)
        monitor.start()
        open_linear_pattern(model.tags)
        ops.load(model.frame.centre_node, *push_n, 0.0, 0.0, 0.0, 0.0)
        static_steps(10, "BandGeneral", 1e-9)
        return model.columns, monitor.trace().at([0, -1])


@pytest.mark.parametrize(
    ("bridge", "is_elastic"),
    [("osb1", False), ("osb1_fixed", False), ("osb1", True), ("osb2s", True)],
)
def test_the_shear_of_a_section_is_the_sum_of_end_moments_over_the_height(bridge, is_elastic):
    columns, trace = pushed(bridge, ModelOptions(elastic_columns=is_elastic))
    for column in columns:
        forces = trace.columns[column.element]
        # the end of the element is the joint above the top of the column
        at_top = forces[:, 9:] - np.cross(column.top.arm_m, forces[:, 6:9])
        about_x, about_y = forces[:, 3] + at_top[:, 0], forces[:, 4] + at_top[:, 1]
        by_moments = np.column_stack((about_y, -about_x)) / column.clear_height_m
        np.testing.assert_allclose(column_shear_n(column, trace), by_moments, rtol=1e-6, atol=1.0)
