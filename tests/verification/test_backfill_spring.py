"""One backfill spring on paths: capped hyperbola, unloading, gap behind the wall, reloading.

Limits: 0.5 % of the force on first loading (the polygon misses 0.1 %), 2 micrometres where a gap
closes, and no force to speak of while a gap is open.
"""

from itertools import pairwise

import numpy as np
import openseespy.opensees as ops
import pytest

from skewbridge.bridge.abutment.backfill import wall_backfill
from skewbridge.bridge.abutment.elements import elastic_material, gap_material, passive_material
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import domain

OSB1 = wall_backfill(load_bridge("osb1").abutment, "hyperbolic", 0.0)
STIFFNESS = OSB1.stiffness_n_per_m
CLOSES_M = 2.0e-6
STIFF = 1.0e6  # of the driver over the spring: it gives way by a hundredth of a micrometre


def spring_in_series(spring, driver, values, step):
    """Push two springs in a row along a path of prescribed closures, ready for static steps."""
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (1, 2, 3):
        ops.node(node, 0.0)
    ops.fix(1, 1)
    ops.element("zeroLength", 1, 1, 2, "-mat", *spring, "-dir", *[1] * len(spring))
    ops.element("zeroLength", 2, 2, 3, "-mat", driver, "-dir", 1)
    moves = [-float(value) for value in values]
    ops.timeSeries("Path", 1, "-dt", 1.0, "-values", *moves, "-useLast")
    ops.pattern("Plain", 1, 1)
    ops.sp(3, 1, 1.0)
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("ProfileSPD")
    ops.algorithm("Newton")
    ops.integrator("LoadControl", step)


def forces(closures_m, *, gap_m=0.0, passive=OSB1):
    """Return the compressive force of the spring at successive closures, driven step by step."""
    tags, out = TagAllocator(), []
    with domain():
        spring = passive_material(passive, gap_m, tags)
        driver = elastic_material(STIFF * passive.stiffness_n_per_m, tags)
        spring_in_series([spring], driver, [0.0, *closures_m], 1.0)
        ops.test("NormDispIncr", 1.0e-12, 50)
        ops.analysis("Static", "-noWarnings")
        for _ in closures_m:
            assert ops.analyze(1) == 0
            out.append(-ops.basicForce(1)[0])
    return np.array(out)


def path(*turns_m, steps=100):
    return np.concatenate([np.linspace(a, b, steps + 1)[1:] for a, b in pairwise((0.0, *turns_m))])


@pytest.mark.parametrize("gap_m", [0.0, 0.025, 0.051])
@pytest.mark.parametrize("bridge", ["osb1", "bridge_a", "bridge_b", "bridge_c"])
def test_first_loading_is_the_hyperbola_and_ends_at_the_ultimate_force(bridge, gap_m):
    passive = wall_backfill(load_bridge(bridge).abutment, "hyperbolic", 0.0)
    closures = np.geomspace(1e-3, 1.0, 200)
    found = forces(gap_m + closures, gap_m=gap_m, passive=passive)
    np.testing.assert_allclose(found, passive.force_n(closures), rtol=0.005)
    assert found.max() == pytest.approx(passive.ultimate_n, rel=0.002)


@pytest.mark.parametrize("reached_m", [0.005, 0.02, 0.05, 0.3])
def test_unloading_has_the_initial_stiffness_and_opens_a_gap(reached_m):
    loading = path(reached_m)
    peak_n = forces(loading)[-1]
    gap_starts_m = reached_m - peak_n / STIFFNESS
    back = np.linspace(reached_m, 0.0, 200)
    found = forces([*loading, *back])[loading.size :]
    expected = np.maximum(peak_n - STIFFNESS * (reached_m - back), 0.0)
    np.testing.assert_allclose(found, expected, atol=CLOSES_M * STIFFNESS)
    assert np.abs(found[back < gap_starts_m - CLOSES_M]).max() < 1e-5 * OSB1.ultimate_n


@pytest.mark.parametrize("away_m", [0.01, 0.0, -0.1])
def test_reloading_meets_the_curve_where_it_was_left(away_m):
    loading = path(0.04, away_m)
    again = np.linspace(away_m, 0.3, 400)
    found = forces([*loading, *again])[loading.size :]
    peak_n = float(OSB1.force_n(0.04))
    starts_m = 0.04 - peak_n / STIFFNESS
    reload = np.clip(STIFFNESS * (again - starts_m), 0.0, None)
    expected = np.where(again < 0.04, np.minimum(reload, peak_n), OSB1.force_n(again))
    np.testing.assert_allclose(found, expected, rtol=0.005, atol=0.002 * peak_n)


def test_a_massless_node_that_a_contact_pushes_is_solved_through_all_branches():
    with domain():
        tags = TagAllocator()
        weak = elastic_material(1e-4 * STIFFNESS, tags)
        contact = gap_material(10 * STIFFNESS, 0.02, tags)
        spring = passive_material(OSB1, 0.0, tags)
        turns_m = 0.15 * np.array([0, 1, 0, -0.2, 1.2, 0, 0.9, 0])
        spring_in_series([spring, weak], contact, turns_m, 0.01)
        ops.test("EnergyIncr", 1e-8, 10)
        ops.analysis("Static", "-noWarnings")
        assert ops.analyze(700) == 0
        assert ops.nodeDisp(2, 1) == pytest.approx(0.0, abs=1e-3)
