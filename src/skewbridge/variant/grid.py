"""Expansion of the grid into variants."""

from itertools import product

from skewbridge.study.config import GridConfig
from skewbridge.variant.variant import Variant


def expand_grid(grid: GridConfig) -> list[Variant]:
    """Return the variants of a grid, sorted, without duplicates.

    Axes that an abutment model lacks are set to zero first (a roller has no gap), so that the
    same bridge is never analysed twice.
    """
    variants = {
        Variant(
            bridge=bridge,
            abutment=abutment,
            skew_deg=skew_deg,
            gap_mm=gap_mm,
            friction_pct=round(friction * 100),
        ).normalised()
        for bridge, abutment, skew_deg, gap_mm, friction in product(
            grid.bridge, grid.abutment, grid.skew_deg, grid.gap_mm, grid.friction
        )
    }
    return sorted(variants)
