"""Shapes of columns: sections against independent fibers, hand values, built and run bridges."""

from math import pi, tan

import numpy as np
import openseespy.opensees as ops
import pytest
from scipy.optimize import brentq

from bridge_variants import analysed, static_steps, variant
from skewbridge.bridge.assembly import open_linear_pattern
from skewbridge.bridge.bent import build_fiber_section
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.column import bent_directions
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import build, domain
from skewbridge.bridge.section import sdc_shear_strength, section_response, shear_strength
from skewbridge.variant.options import ModelOptions
from strong_motion import mirrored, strong_motion

#: A wall of 2.4 x 0.9 m; the ties are weaker against forces along the bent.
RECTANGLE = {
    "shape": "rectangular", "width_m": 2.4, "depth_m": 0.9, "bar_count": 44, "tie_legs": [4, 8],
}  # fmt: skip
OBLONG = {"shape": "oblong", "width_m": 2.4, "depth_m": 1.2, "bar_count": 44, "cross_ties": 2}
#: Bars of 35.8 mm (1006 mm2), ties of 15.9 mm (199 mm2) at 150 mm, cover 51 mm.
TIES = {"hoop_area_mm2": 199.0, "hoop_diameter_mm": 15.9, "hoop_spacing_mm": 150.0}
AXIAL_N = 6.0e6


def written(path, text: str, **column) -> str:
    """Write a bridge that extends another one and has such a column; return its path."""
    keys = "".join(
        f"  {key}: {value if key == 'shape' else f'{{v: {value}, src: "d: a test"}}'}\n"
        for key, value in column.items()
    )
    path.write_text(f"{text}\ncolumn:\n{keys}", encoding="utf-8")
    return str(path)


@pytest.fixture
def wall(tmp_path) -> str:
    return written(tmp_path / "wall.yaml", "extends: osb1", **RECTANGLE, **TIES)


def mander_chart(pressures: list[float]) -> float:
    """Return confined over plain strength from the surface behind Mander's chart.

    Willam and Warnke's surface with the meridians of Elwi and Murray (1979); compression negative.
    """

    def beyond(strength):
        first, second, third = -min(pressures), -max(pressures), -strength
        mean = (first + second + third) / 3
        shear = np.sqrt((first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2) / 3
        cos = (first - mean) / (np.sqrt(2) * shear)
        t = 0.069232 - 0.661091 * mean - 0.049350 * mean**2
        c = 0.122965 - 1.150502 * mean - 0.315545 * mean**2
        d = 4 * (c**2 - t**2) * cos**2
        root = np.sqrt(d + 5 * t**2 - 4 * t * c)
        return shear - c * (d / (2 * cos) + (2 * t - c) * root) / (d + (2 * t - c) ** 2)

    return brentq(beyond, 0.9, 5.0)


def independent_curve(along: bool, curvatures: np.ndarray) -> tuple[np.ndarray, float]:
    """Return moments (N m) of the rectangle at curvatures, and its ultimate curvature.

    A plain fiber section with formulas of its own; strains are positive in compression.
    """
    b, d = 2.4, 0.9
    inset = 0.051 + 0.0159 / 2
    bc, dc = b - 2 * inset, d - 2 * inset
    b0, d0 = bc - 0.0159 - 0.0358, dc - 0.0159 - 0.0358
    fc, ec, fy, es = 35.85e6, 28.34e9, 469e6, 200e9
    # 22 gaps on half of the perimeter: 17 along the width, 5 along the depth
    y = np.linspace(-b0 / 2, b0 / 2, 18)
    z = np.linspace(-d0 / 2, d0 / 2, 6)[1:-1]
    bars = [(u, s * d0 / 2) for u in y for s in (-1, 1)] + [
        (s * b0 / 2, w) for w in z for s in (-1, 1)
    ]
    assert len(bars) == 44
    # legs: 4 parallel to the width, 8 parallel to the depth
    ratio_y, ratio_z = 4 * 199e-6 / (0.15 * dc), 8 * 199e-6 / (0.15 * bc)
    clear_y, clear_z = b0 / 7 - 0.0358, d0 / 3 - 0.0358
    arches = (2 * 7 * clear_y**2 + 2 * 3 * clear_z**2) / 6
    hoop_gap = 0.15 - 0.0159
    held = (1 - arches / (bc * dc)) * (1 - hoop_gap / 2 / bc) * (1 - hoop_gap / 2 / dc)
    held /= 1 - 44 * 1006e-6 / (bc * dc)
    fcc = fc * mander_chart([held * ratio_y * fy / fc, held * ratio_z * fy / fc])
    strain_cc = 0.002 * (1 + 5 * (fcc / fc - 1))
    ultimate = 0.004 + 1.4 * (ratio_y + ratio_z) * fy * 0.09 / fcc

    def concrete(strain, peak, at, end):
        x = np.clip(strain, 0, None) / at
        r = ec / (ec - peak / at)
        return np.where(strain > end, 0, peak * x * r / (r - 1 + x**r))

    u, w = (((np.arange(n) + 0.5) / n - 0.5) * size for n, size in ((240, b), (180, d)))
    place = np.array([(p, q) for p in u for q in w])
    is_core = (abs(place[:, 0]) < bc / 2) & (abs(place[:, 1]) < dc / 2)
    height, bar_height = place[:, 0 if along else 1], np.array(bars)[:, 0 if along else 1]
    area = b * d / len(place)

    def forces(centre, phi):
        strain, bar = centre + phi * height, centre + phi * bar_height
        inner, outer = (
            concrete(strain, fcc, strain_cc, ultimate),
            concrete(strain, fc, 0.002, 0.005),
        )
        stress = np.where(is_core, inner, outer) * area
        steel = np.clip(bar, -fy / es, fy / es)
        steel = es * (steel + 0.01 * (bar - steel)) - concrete(bar, fcc, strain_cc, ultimate)
        return stress.sum() + 1006e-6 * steel.sum(), stress @ height + 1006e-6 * steel @ bar_height

    def at(phi):
        centre = brentq(lambda each: forces(each, phi)[0] - AXIAL_N, -0.09, 0.09)
        core = centre + phi * (bc if along else dc) / 2 - ultimate
        return forces(centre, phi)[1], max(core, phi * bar_height.max() - centre - 0.06)

    end = brentq(lambda phi: at(phi)[1], 1e-3, 0.3, xtol=1e-6)
    return np.array([at(phi)[0] for phi in curvatures]), end


@pytest.mark.parametrize("direction", [0, 1])
def test_a_rectangle_agrees_with_an_independent_fiber_section(wall, direction) -> None:
    curve = section_response(load_bridge(wall).column, AXIAL_N, direction)
    shown = curve.curvature_per_m[20:-1:6]
    moments, ultimate = independent_curve(direction == 1, shown)
    np.testing.assert_allclose(curve.moment_nm[20:-1:6], moments, rtol=0.01)
    # the curve ends at the first of its points beyond the ultimate curvature
    assert curve.curvature_per_m[-2] < ultimate <= curve.curvature_per_m[-1]


def test_shear_and_drift_capacity_of_a_wall_depend_on_the_direction(wall) -> None:
    normal, along = bent_directions(load_bridge(wall), 0)
    assert (normal.direction, along.direction) == ("normal", "along")
    gross_m2, psi = 2.4 * 0.9, 6894.757
    concrete_psi = (0.35 / 0.15 + 3.67 - 5.0) * np.sqrt(27.6e6 / psi)  # hoops at their limit
    steel = 0.5 + 20 * 44 * 1006e-6 / gross_m2
    for bent, legs, depth in ((normal, 8, 0.9), (along, 4, 2.4)):
        section, area_m2 = bent.shear, legs * 199e-6
        hoops_n = area_m2 * 414e6 * 0.8 * depth / 0.15
        expected = 0.8 * gross_m2 * concrete_psi * psi + hoops_n
        assert float(sdc_shear_strength(section, 0.0, 5.0)) == pytest.approx(expected, rel=1e-5)
        # aspect 5.64 / depth > 2: 1.0; not degraded: 0.29
        concrete = steel * 0.29 * np.sqrt(35.85) * 1e6 * 0.8 * gross_m2
        left = depth - section.neutral_axis_depth_m
        truss = area_m2 * 469e6 * (left - 0.051 - 0.0159 / 2) / tan(pi / 6) / 0.15
        expected = 0.99 * (concrete + truss + 6.0e6 * left / (2 * 5.64))
        assert float(shear_strength(section, "ucsd_tests", 6.0e6, 1.0, 1.0)) == pytest.approx(
            expected, rel=1e-6
        )
        # source: Priestley, Calvi and Kowalsky (2007), section 4.4.3: 2.1 eps_y / h of rectangles
        yields_per_m = bent.curve.yield_curvature_per_m
        assert yields_per_m == pytest.approx(2.1 * 469e6 / 200e9 / depth, rel=0.10)
        plastic_per_m = bent.curve.ultimate_curvature_per_m - yields_per_m
        hinge_m = 0.08 * 5.64 + 0.022 * 469 * 0.0358
        capacity_m = yields_per_m * 5.64**2 / 3 + hinge_m * plastic_per_m * (5.64 - hinge_m / 2)
        assert bent.capacity_m == pytest.approx(capacity_m, rel=1e-4)
    assert along.capacity_m < 0.5 * normal.capacity_m
    assert along.curve.plastic_moment_nm > 2 * normal.curve.plastic_moment_nm


@pytest.mark.parametrize(("shape", "error"), [(RECTANGLE, 0.002), (OBLONG, 0.01)])
@pytest.mark.parametrize("mesh", [(5, 20, 1), (12, 32, 3)])
def test_fibers_keep_areas_and_second_moments_of_both_directions(
    tmp_path, monkeypatch, shape, error, mesh
):
    column = load_bridge(written(tmp_path / "own.yaml", "extends: osb1", **shape, **TIES)).column
    given: list[tuple] = []
    with domain(), monkeypatch.context() as patch:
        patch.setattr(ops, "fiber", lambda *fiber: given.append(fiber))
        build_fiber_section(column, ModelOptions(column_fibers=mesh), TagAllocator())
    parts = [
        np.array([fiber[:3] for fiber in given if fiber[3] == material])
        for material in dict.fromkeys(fiber[3] for fiber in given)
    ]
    # second moments by integration of the shape
    w, d = column.width_m, column.depth_m
    inset = 2 * 0.051 + 0.0159

    def moments(width, depth):
        """Return area and second moments along the width and normal to it."""
        z = (np.arange(200_000) + 0.5) / 200_000 * depth - depth / 2
        is_oblong = column.shape == "oblong"
        half = width / 2 - (depth / 2 - np.sqrt(depth**2 / 4 - z**2) if is_oblong else 0.0 * z)
        step = depth / z.size
        return np.array([2 * half.sum(), 2 * (half**3).sum() / 3, 2 * (half * z**2).sum()]) * step

    gross, core = moments(w, d), moments(w - inset, d - inset)
    assert [column.outline.area_m2, *map(column.outline.inertia_m4, (1, 0))] == pytest.approx(gross)
    for part, expected in zip(parts, (core, core, gross - core), strict=False):
        y, z, area = part.T
        found = np.array([area.sum(), area @ y**2, area @ z**2])
        np.testing.assert_allclose(found, expected, rtol=error)
        assert [area @ y, area @ z, area @ (y * z)] == pytest.approx([0.0] * 3, abs=1e-12)
    *_, bars = parts
    assert len(bars) == column.bar_count
    y, z, area = bars.T
    assert area.sum() == pytest.approx(44 * 1006e-6)
    assert [area @ y, area @ z, area @ (y * z)] == pytest.approx([0.0] * 3, abs=1e-9)
    gaps = np.sort([np.sort(np.hypot(y - a, z - b))[1:3].max() for a, b in zip(y, z, strict=True)])
    assert gaps[-1] < 1.2 * column.bar_line.length_m / 44


@pytest.mark.parametrize("direction", [0, 1])
def test_a_wall_bends_about_the_axes_of_its_skewed_bent(wall, direction) -> None:
    """Bending has E I of the direction of the push, in which the column mainly bends."""
    angle = np.radians(30) + direction * pi / 2
    with domain():
        model = build(variant(30, "roller", wall).normalised(), ModelOptions(elastic_columns=True))
        open_linear_pattern(model.tags)
        push_n = 1e6 * np.array([np.cos(angle), np.sin(angle)])
        ops.load(model.frame.centre_node, *push_n, 0.0, 0.0, 0.0, 0.0)
        static_steps(5, "BandGeneral", 1e-9)
        column = model.columns[0]
        about_z, about_y = (
            float(value) for value in ops.eleResponse(column.element, "section", "3", "force")[1:3]
        )
        turned_z, turned_y = (
            float(value)
            for value in ops.eleResponse(column.element, "section", "3", "deformation")[1:3]
        )
    sizes = 2.4, 0.9
    inertia_m4 = sizes[direction] * sizes[1 - direction] ** 3 / 12
    moment, curvature = ((about_y, turned_y), (about_z, turned_z))[direction]
    assert moment / curvature == pytest.approx(0.45 * 28.34e9 * inertia_m4, rel=1e-6)
    assert abs(moment) > 3 * abs((about_z, about_y)[direction])


def test_a_bridge_of_a_pinned_column_and_a_fixed_wall_runs_and_mirrors(tmp_path) -> None:
    bents = [
        f"""  - columns: {{v: 1, src: "d: a test"}}
    clear_height_m: {{v: {height}, src: "d: a test"}}
    cap_width_m: {{v: 2.4, src: "d: a test"}}
    cap_depth_m: {{v: 2.0, src: "d: a test"}}
    cap_weight_kn: {{v: 1200, src: "d: a test"}}
"""
        for height in (9.0, 7.0)
    ]
    keys = {"width_m": 4.0, "depth_m": 1.2, "tie_legs": [4, 12], "bar_count": 60}
    own = "".join(f'      {key}: {{v: {value}, src: "d: a test"}}\n' for key, value in keys.items())
    text = (
        f"bents:\n{bents[0]}{bents[1]}    base: fixed\n    column:\n      shape: rectangular\n{own}"
    )
    path = tmp_path / "mixed.yaml"
    path.write_text(f"extends: osb2s\nfoundation: null\n{text}", encoding="utf-8")
    with domain():
        pinned, fixed = build(variant(30, bridge=str(path)), ModelOptions()).columns
        assert (pinned.is_pinned, fixed.is_pinned) == (True, False)
        held = [ops.getFixedDOFs(column.base_node) for column in (pinned, fixed)]
        assert held == [[1, 2, 3, 6], [1, 2, 3, 4, 5, 6]]
        assert len(pinned.hinge_sections) == 1
        assert len(fixed.hinge_sections) == 2
    assert pinned.capacities[0] == pinned.capacities[1]
    assert fixed.capacities[0].drift_capacity_ratio > 2 * fixed.capacities[1].drift_capacity_ratio
    tight = {"tolerance_j": 1e-8, "reuse_tangent": False, "dt_s": 0.005, "contact_dt_s": 0.005}
    tight |= {"event_dt_s": None, "duration_s": 2.5}
    motion = strong_motion(duration_s=2.5)
    one, other = (
        analysed(variant(skew, bridge=str(path)), given, **tight)
        for skew, given in ((30, motion), (-30, mirrored(motion)))
    )
    assert one.status == other.status == "ok"
    assert one.demands["contact_closures"] > 0
    assert one.demands["column_curvature_ductility"] > 1.0
    for name in ("drift_over_capacity", "column_shear_dcr", "column_drift_ratio", "unseating_m"):
        assert other.demands[name] == pytest.approx(one.demands[name], rel=1e-6), name
