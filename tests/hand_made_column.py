"""The section of a column whose strengths and demands are worked out by hand."""

from math import pi

from skewbridge.bridge.section import ShearSection

SECTION = ShearSection(
    depth_m=1.676, gross_area_m2=pi * 1.676**2 / 4, cover_m=0.064, hoop_area_m2=pi / 2 * 510e-6,
    hoop_depth_m=1.549, hoop_ratio=4 * 510e-6 / (1.549 * 0.127), hoop_spacing_m=0.127,
    hoop_yield_pa=414e6, expected_hoop_yield_pa=469e6, concrete_strength_pa=27.6e6,
    expected_concrete_strength_pa=35.85e6, longitudinal_ratio=0.02, shear_span_m=5.64,
    neutral_axis_depth_m=0.5,
)  # fmt: skip
