"""Names of variants."""

import re
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.axes import axes_of, axis
from skewbridge.variant.grid import GridConfig, expand_grid
from skewbridge.variant.variant import SLUG_PATTERN, Variant, parse_slug


def with_decimals(low: int, high: int, decimals: int = 3) -> st.SearchStrategy[float]:
    """Whole numbers, and numbers with up to so many decimals, between two limits."""
    factor = 10**decimals
    fine = st.integers(low * factor, high * factor).map(lambda count: count / factor)
    return st.integers(low, high) | fine


variants = st.builds(
    Variant,
    bridge=st.sampled_from(["osb1", "osb1_fixed", "bridge_a"]),
    abutment=st.sampled_from(sorted(ABUTMENTS)),
    skew_deg=with_decimals(-60, 60),
    gap_mm=with_decimals(0, 999),
    friction_pct=with_decimals(0, 150),
    options=st.dictionaries(
        st.sampled_from(["transverse_gap_mm", "wall_dashpot_ratio", "cohesion_n"]),
        st.floats(0.0, 1.0),
    ).map(lambda values: tuple(sorted(values.items()))),
)


@given(variants)
def test_a_name_contains_the_whole_variant(variant: Variant) -> None:
    assert parse_slug(variant.slug) == variant
    assert re.fullmatch(SLUG_PATTERN, variant.slug)
    assert "." not in variant.slug
    assert parse_slug(variant.slug).slug == variant.slug


NUMBERS = st.builds(
    "{}{}{}".format,
    st.sampled_from(["", "m"]),
    st.sampled_from(["0", "00", "7", "30", "51", "051", "999"]),
    st.sampled_from(["", "p", "p0", "p5", "p50", "p005"]),
)


@given(st.builds("osb1_cf_skew{}_gap{}_mu{}".format, NUMBERS, NUMBERS, NUMBERS))
def test_a_name_is_that_of_its_variant_or_refused(slug: str) -> None:
    try:
        variant = parse_slug(slug)
    except InputError:
        return
    assert variant.slug == slug


@given(with_decimals(0, 1, decimals=5))
def test_the_friction_of_a_variant_is_the_number_given(friction: float) -> None:
    values = {"skew_deg": 0, "gap_mm": 51, "friction": friction}
    variant = Variant.at("osb1", "contact_friction", values)
    assert variant.friction == friction
    assert parse_slug(variant.slug).friction == friction


@pytest.mark.parametrize(
    ("skew_deg", "gap_mm", "friction", "slug"),
    [
        (30, 51, 0.5, "osb1_cf_skew30_gap051_mu050"),
        (-30, 51, 0.5, "osb1_cf_skewm30_gap051_mu050"),
        (22.5, 25.4, 0.375, "osb1_cf_skew22p5_gap025p4_mu037p5"),
        (-30.0, 0, 0.29, "osb1_cf_skewm30_gap000_mu029"),
        (-22.5, 0.001, 1.00001, "osb1_cf_skewm22p5_gap000p001_mu100p001"),
        (-0.0, 999, 0.07, "osb1_cf_skew00_gap999_mu007"),
        (-0.5, 5.25, 0.005, "osb1_cf_skewm00p5_gap005p25_mu000p5"),
    ],
)
def test_decimals_are_coded_with_p(
    skew_deg: float, gap_mm: float, friction: float, slug: str
) -> None:
    grid = {"skew_deg": [skew_deg], "gap_mm": [gap_mm], "friction": [friction]}
    (variant,) = expand_grid(GridConfig.model_validate({"bridge": ["osb1"], **grid}))
    assert variant.slug == slug
    assert variant.values() == {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}


@pytest.mark.parametrize("kind", [int, float, np.int64, np.float64])
def test_whole_values_are_integers_whatever_their_type(kind: Any) -> None:
    """The digest of an analysis holds the numbers of its variant as text."""
    variant = Variant(
        bridge="osb1",
        abutment="contact_friction",
        skew_deg=kind(30),
        gap_mm=kind(51),
        friction_pct=kind(29),
    )
    own = {name: repr(value) for name, value in asdict(variant).items()}
    assert own == {
        "bridge": "'osb1'",
        "abutment": "'contact_friction'",
        "skew_deg": "30",
        "gap_mm": "51",
        "friction_pct": "29",
        "options": "()",
    }
    assert repr(variant.friction) == "0.29"


def test_values_that_differ_by_rounding_are_one_variant() -> None:
    grid = {"bridge": ["osb1"], "skew_deg": [0], "gap_mm": [51], "friction": [0.3, 0.1 + 0.2]}
    assert len(expand_grid(GridConfig.model_validate(grid))) == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("osb1_cf_skewm00_gap051_mu050", r": .* is named osb1_cf_skew"),
        ("osb1_cf_skew22p50_gap051_mu050", r": .* is named osb1_cf_skew"),
        ("osb1_cf_skew30p0_gap051_mu050", r": .* is named osb1_cf_skew"),
        ("", ""),
        ("osb1", ""),
        ("osb1_cf_skew7_gap051_mu050", ""),
        ("../x_cf_skew00", ""),
    ],
)
def test_an_invalid_or_second_name_of_a_variant_is_refused(text: str, words: str) -> None:
    with pytest.raises(InputError, match=f"not a variant name{words}"):
        parse_slug(text)


@pytest.mark.parametrize(
    ("field", "value", "words"),
    [
        ("friction_pct", -10, "friction must be within 0..1.5, got -0.1"),
        ("skew_deg", float("nan"), "skew_deg must be within -60..60, got nan"),
        ("gap_mm", 25.40001, "gap_mm must have at most 3 decimals, got 25.40001"),
        ("friction_pct", 37.5001, "friction must have at most 5 decimals, got 0.375001"),
        ("abutment", "seat", "abutment must be one of .* got 'seat'"),
    ],
)
def test_a_value_outside_its_limits_is_named(field: str, value: object, words: str) -> None:
    good = {"bridge": "osb1", "abutment": "contact", "skew_deg": 0, "gap_mm": 51}
    with pytest.raises(InputError, match=words):
        Variant(**{**good, "friction_pct": 0, field: value})


def test_any_numeric_modelling_option_may_be_an_axis() -> None:
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


def test_a_bridge_of_the_user_has_the_name_of_its_file() -> None:
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
