"""Names of variants."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import axes_of, axis
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.variant import SLUG_PATTERN, Variant, parse_slug

variants = st.builds(
    Variant,
    bridge=st.sampled_from(["osb1", "osb1_fixed", "bridge_a"]),
    abutment=st.sampled_from(sorted(ABUTMENTS)),
    skew_deg=st.integers(-60, 60),
    gap_mm=st.integers(0, 999),
    friction_pct=st.integers(0, 150),
    options=st.dictionaries(
        st.sampled_from(["transverse_gap_mm", "wall_dashpot_ratio", "cohesion_n"]),
        st.floats(0.0, 1.0),
    ).map(lambda values: tuple(sorted(values.items()))),
)


@given(variants)
def test_a_name_tells_the_whole_variant(variant: Variant) -> None:
    assert parse_slug(variant.slug) == variant
    assert re.fullmatch(SLUG_PATTERN, variant.slug)
    assert "." not in variant.slug


def test_the_name_is_the_documented_one() -> None:
    variant = Variant(
        bridge="osb1", abutment="contact_friction", skew_deg=-30, gap_mm=51, friction_pct=50
    )
    assert variant.slug == "osb1_cf_skewm30_gap051_mu050"


def test_axes_that_an_abutment_lacks_are_zero() -> None:
    roller = Variant(bridge="osb1", abutment="roller", skew_deg=30, gap_mm=51, friction_pct=50)
    contact = Variant(bridge="osb1", abutment="contact", skew_deg=30, gap_mm=51, friction_pct=50)
    assert roller.normalised().slug == "osb1_ro_skew30_gap000_mu000"
    assert contact.normalised().slug == "osb1_co_skew30_gap051_mu000"


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("skew_deg", 75, "skew_deg must be within -60..60, got 75"),
        ("gap_mm", -1, "gap_mm must be within 0..999, got -1"),
        ("friction_pct", -10, "friction must be within 0..1.5, got -0.1"),
        ("abutment", "seat", "abutment must be one of .* got 'seat'"),
    ],
)
def test_a_value_outside_its_limits_is_named(field: str, value: object, words: str) -> None:
    good = {
        "bridge": "osb1",
        "abutment": "contact",
        "skew_deg": 0,
        "gap_mm": 51,
        "friction_pct": 0,
    }
    with pytest.raises(InputError, match=words):
        Variant(**{**good, field: value})


@pytest.mark.parametrize("text", ["", "osb1", "osb1_cf_skew7_gap051_mu050", "../x_cf_skew00"])
def test_a_text_that_is_no_name_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="not a variant name"):
        parse_slug(text)


def test_any_numeric_modelling_option_is_an_axis_by_being_named() -> None:
    raw = {"transverse_gap_mm": [6.4, 25.4], "backwall_points": [5, 9], "skew_deg": [30]}
    one = {"bridge": ["osb1"], "gap_mm": [51], "friction": [0.5]}
    variants = expand_grid(GridConfig.model_validate(raw | one))
    names = [variant.slug for variant in variants]
    assert len(set(names)) == 4
    assert "osb1_cf_skew30_gap051_mu050_backwall-points5_transverse-gap-mm25p4" in names
    assert [parse_slug(name) for name in names] == variants
    first = variants[0].values()
    assert first == {
        **{"skew_deg": 30, "gap_mm": 51, "friction": 0.5},
        **{"backwall_points": 5, "transverse_gap_mm": 6.4},
    }
    assert type(first["backwall_points"]) is int


def test_the_axes_of_a_table_begin_with_the_core_ones() -> None:
    columns = ["transverse_gap_mm", "deck_disp_m", "friction", "skew_deg"]
    assert [axis.name for axis in axes_of(columns)] == ["skew_deg", "friction", "transverse_gap_mm"]
    assert axis("transverse_gap_mm").label_with_unit == "Transverse gap (mm)"
    with pytest.raises(InputError, match=r"axis must be one of .* got 'arrays'"):
        axis("arrays")


def test_normalising_keeps_the_modelling_options() -> None:
    variant = parse_slug("osb1_ro_skew30_gap051_mu050_cohesion-n1000")
    assert variant.normalised().slug == "osb1_ro_skew30_gap000_mu000_cohesion-n1000"


def test_a_bridge_of_an_own_file_is_named_by_the_file() -> None:
    grid = GridConfig.model_validate({"bridge": ["some/folder/mine.yaml"]})
    variant = expand_grid(grid)[0]
    assert variant.bridge == "some/folder/mine.yaml"
    assert variant.slug == "mine_cf_skew00_gap025_mu000"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ("arrays1", "got 'arrays'"),
        ("wall-dashpot-ratio2", "wall_dashpot_ratio must be within 0..1, got 2"),
        ("backwall-points5p5", "backwall_points must be whole, got 5.5"),
    ],
)
def test_a_name_with_a_wrong_option_is_refused(part: str, words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        parse_slug(f"osb1_cf_skew30_gap051_mu050_{part}")
