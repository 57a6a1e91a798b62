"""The section of a column whose strengths and demands are worked out by hand."""

from skewbridge.bridge.section import ShearSection

SECTION = ShearSection(
    diameter_m=1.676,
    core_diameter_m=1.549,
    cover_m=0.064,
    hoop_area_m2=510e-6,
    hoop_spacing_m=0.127,
    hoop_yield_pa=414e6,
    expected_hoop_yield_pa=469e6,
    concrete_strength_pa=27.6e6,
    expected_concrete_strength_pa=35.85e6,
    longitudinal_ratio=0.02,
    shear_span_m=5.64,
    neutral_axis_depth_m=0.5,
)
