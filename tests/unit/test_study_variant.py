"""Names of variants."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skewbridge.errors import InputError
from skewbridge.variant.abutments import ABUTMENTS
from skewbridge.variant.variant import Variant, parse_slug

variants = st.builds(
    Variant,
    bridge=st.sampled_from(["osb1", "osb1_fixed", "bridge_a"]),
    abutment=st.sampled_from(sorted(ABUTMENTS)),
    skew_deg=st.integers(-60, 60),
    gap_mm=st.integers(0, 999),
    friction_pct=st.integers(0, 150),
)


@given(variants)
def test_a_name_tells_the_whole_variant(variant: Variant) -> None:
    assert parse_slug(variant.slug) == variant


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
        ("friction_pct", -10, "friction .* got -10"),
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
