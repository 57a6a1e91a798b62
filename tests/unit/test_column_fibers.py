"""Fibers of a column section for several meshes."""

from math import pi

import numpy as np
import openseespy.opensees as ops
import pytest

from skewbridge.bridge.catalogue import bridge_names, load_bridge
from skewbridge.bridge.column import build_fiber_section, gross_inertia_m4
from skewbridge.bridge.handles import TagAllocator
from skewbridge.bridge.model import domain
from skewbridge.units import MM
from skewbridge.variant.options import ModelOptions

type Fiber = tuple[float, float, float, int]  # y, z, area, material


def fibers_of(monkeypatch: pytest.MonkeyPatch, bridge: str, options: ModelOptions) -> list[Fiber]:
    """Return the fibers of a column that OpenSees receives."""
    given: list[Fiber] = []
    monkeypatch.setattr(ops, "fiber", lambda *fiber: given.append(fiber))
    with domain():
        build_fiber_section(load_bridge(bridge).column, options, TagAllocator())
    monkeypatch.undo()
    return given


@pytest.mark.parametrize("bridge", bridge_names())
@pytest.mark.parametrize("mesh", [(1, 3, 1), (4, 12, 1), (5, 20, 1), (12, 32, 3), (3, 50, 2)])
def test_every_mesh_keeps_area_and_second_moment_of_the_section(
    monkeypatch: pytest.MonkeyPatch, bridge: str, mesh: tuple[int, int, int]
) -> None:
    column = load_bridge(bridge).column
    fibers = fibers_of(monkeypatch, bridge, ModelOptions(column_fibers=mesh))
    *concrete, bars = [
        np.array([(y, z, area) for y, z, area, tag in fibers if tag == material])
        for material in dict.fromkeys(fiber[-1] for fiber in fibers)
    ]
    steel_m2 = column.bar_count * column.bar_area_mm2 * MM**2
    core_m = column.hoop_circle_m
    # the core twice: the part that ends and the part that is kept
    core_m2, core_m4 = pi * core_m**2 / 4, pi * core_m**4 / 64
    inertia_m4 = (core_m4, core_m4, gross_inertia_m4(column) - core_m4)
    area_m2 = (core_m2, core_m2, column.gross_area_m2 - core_m2)
    parts = (*zip(concrete, area_m2, inertia_m4, strict=True),)
    steel_m4 = steel_m2 * (column.bar_circle_m / 2) ** 2 / 2
    for part, total_m2, second_m4 in (*parts, (bars, steel_m2, steel_m4)):
        y, z, area = part.T
        assert area.sum() == pytest.approx(total_m2)
        assert area @ y**2 == pytest.approx(second_m4)
        assert area @ z**2 == pytest.approx(second_m4)
        assert [area @ y, area @ z, area @ (y * z)] == pytest.approx([0.0] * 3, abs=1e-12)


def test_bars_are_lumped_into_no_more_fibers_than_wedges(monkeypatch: pytest.MonkeyPatch) -> None:
    count = load_bridge("osb1").column.bar_count
    for wedges in (12, 20, 200):
        options = ModelOptions(column_fibers=(1, wedges, 1))
        tags = [fiber[-1] for fiber in fibers_of(monkeypatch, "osb1", options)]
        assert tags.count(tags[-1]) == min(count, wedges)
