"""The configuration and the variants of its grid: defaults, limits, names, pages made from it."""

import json
import re
from dataclasses import asdict
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from reference_pages import PAGES, ROOT

from reference_data import BAD
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.abutments import BUILDERS
from skewbridge.cli.output import VariantOptions
from skewbridge.errors import InputError
from skewbridge.files.text import read_mapping, read_yaml
from skewbridge.fragility.limit_states import limit_states_of, load_limit_states
from skewbridge.motions.folder import list_motions
from skewbridge.report.methods import methods_of
from skewbridge.study.config import load_config, parse_config
from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.study.inputs import axis_warnings
from skewbridge.variant.grid import GridConfig, cells_of, expand_grid
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, Variant

SCHEMA = jsonschema.Draft202012Validator(json.loads((ROOT / "config/schema.json").read_text()))
SHIPPED = ("config", "smoke", "real", "full", "stripes", "ida", "suites", "alternatives")


def test_shipped_configurations_have_variants_defaults_and_results_of_their_own() -> None:
    base = ROOT / "config/config.yaml"
    studies = {name: load_config(ROOT / f"config/{name}.yaml", base=base) for name in SHIPPED}
    assert all(expand_grid(each.grid) for each in studies.values())
    assert studies["config"].results == DEFAULT_ROOT
    assert len({each.results for each in studies.values()}) == len(SHIPPED)
    assert studies["full"].motions.count <= len(list_motions(ROOT / "motions"))
    default = studies["config"].model_copy(update={"motions": parse_config({}).motions})
    assert default == parse_config({"uncertainty": {"enabled": True}})
    # the design of the default study is not inherited
    for name in set(SHIPPED) - {"config", "alternatives"}:
        motions = studies[name].motions
        assert (motions.blocks, motions.bands, motions.incidence_deg) == (None, None, (0.0,))


@pytest.mark.parametrize(("raw", "words"), BAD["studies"])
def test_a_bad_value_is_named_with_its_limit(raw: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_config(raw)


def test_plain_values_are_read_back_as_they_were() -> None:
    default = parse_config({})
    assert (default.model, default.analysis) == (ModelOptions(), AnalysisSettings())
    raw = {"grid": {"transverse_gap_mm": [6.4, 25.4], "backwall_points": [5]}}
    raw["model"] = {"column_fibers": [6, 12, 1], "keys": "monolithic"}
    raw["analysis"] = {"integrator": ["Newmark", 0.5, 0.25]}
    config = parse_config(raw)
    assert parse_config(json.loads(json.dumps(config.model_dump(mode="json")))) == config
    assert config.analysis.integrator_command == ("Newmark", 0.5, 0.25)


def test_every_choice_of_the_assumptions_is_a_key() -> None:
    page = (ROOT / "docs/assumptions.md").read_text()
    bridge = page.split("### Bridge and abutments")[1].split("### ")[0]
    choices = dict(re.findall(r"`(\w+): ([\w.]+)`", bridge))
    assert {"foundation", "backfill_variation", "key_frame"} <= set(choices)
    for key, text in choices.items():
        value = yaml.safe_load(text)
        assert parse_config({"model": {key: value}}).model_dump(mode="json")["model"][key] == value
    for key in re.findall(r"`analysis\.(\w+)`", page):
        assert key in parse_config({}).model_dump(mode="json")["analysis"]


def test_the_schema_of_editors_accepts_every_shipped_configuration_and_no_bad_value() -> None:
    for path in (ROOT / "config").glob("*.yaml"):
        if "limit" not in path.name:
            assert path.read_text().startswith("# yaml-language-server: $schema=schema.json\n")
            SCHEMA.validate(read_mapping(path))
    grids = {"skew_degg": [0]}, {"skew_deg": [75]}, {"transverse_gap_mm": ["wide"]}
    others = {"model": {"backfill": "clay"}}, {"analysis": {"dt_s": "fast"}}
    for raw in (*({"grid": grid} for grid in grids), *others):
        with pytest.raises(InputError):
            parse_config(raw)
        assert not SCHEMA.is_valid(raw)


@pytest.mark.parametrize("name", sorted(PAGES))
def test_pages_written_from_the_code_are_current(name: str) -> None:
    assert (ROOT / name).read_text() == PAGES[name](), "run `make docs`"


@pytest.mark.parametrize("name", ["limit_states.yaml", "limit_states_template.yaml"])
def test_limit_states_fit_their_schema_and_load(name: str) -> None:
    """A demand brings its own unit, so the schema cannot list the units: loading checks them."""
    path = ROOT / "config" / name
    assert path.read_text().startswith("# yaml-language-server: $schema=limit_states.schema.json\n")
    schema = json.loads((ROOT / "config/limit_states.schema.json").read_text())
    entries = read_yaml(path)
    jsonschema.validate(entries, schema)
    assert not jsonschema.Draft202012Validator(schema).is_valid([entries[0] | {"units": "m"}])
    assert load_limit_states(path)
    with pytest.raises(InputError, match="unit: must be one of m, mm, in, ft, kn"):
        limit_states_of([entries[0] | {"unit": "furlong"}])


def with_decimals(low: int, high: int, decimals: int = 3) -> st.SearchStrategy[float]:
    factor = 10**decimals
    fine = st.integers(low * factor, high * factor).map(lambda count: count / factor)
    return st.integers(low, high) | fine


OPTIONS = st.sampled_from(["transverse_gap_mm", "backfill_vs_mps", "cohesion_n"])
variants = st.builds(
    Variant, bridge=st.sampled_from(["osb1", "osb1_fixed", "bridge_a"]),
    abutment=st.sampled_from(sorted(ABUTMENTS)), skew_deg=with_decimals(-66, 66),
    gap_mm=with_decimals(0, 999), friction_pct=with_decimals(0, 150),
    options=st.dictionaries(OPTIONS, st.floats(0.0, 1.0)).map(lambda x: tuple(sorted(x.items()))),
)  # fmt: skip


@given(variants, variants, with_decimals(0, 1, decimals=5))
def test_variants_have_names_of_their_own_and_the_friction_given(one, other, friction) -> None:
    assert (one.slug == other.slug) == (one == other)
    assert re.fullmatch(r"[a-z0-9_-]+", one.slug)
    assert Variant.of_row({"bridge": one.bridge, "abutment": one.abutment, **one.values()}) == one
    values = {"skew_deg": 0, "gap_mm": 51, "friction": friction}
    assert Variant.at("osb1", "contact_friction", values).friction == friction


@pytest.mark.parametrize(
    ("skew_deg", "gap_mm", "friction", "slug"),
    [
        (30, 51, 0.5, "skew30_gap051_mu050"), (-30.0, 0, 0.29, "skewm30_gap000_mu029"),
        (22.5, 25.4, 0.375, "skew22p5_gap025p4_mu037p5"),
        (-22.5, 0.001, 1.00001, "skewm22p5_gap000p001_mu100p001"),
        (-0.0, 999, 0.07, "skew00_gap999_mu007"),
        (-0.5, 5.25, 0.005, "skewm00p5_gap005p25_mu000p5"),
    ],
)  # fmt: skip
def test_decimals_are_coded_with_p(skew_deg, gap_mm, friction, slug):
    grid = {"skew_deg": [skew_deg], "gap_mm": [gap_mm], "friction": [friction]}
    (variant,) = expand_grid(GridConfig.model_validate({"bridge": ["osb1"], **grid}))
    assert variant.slug == f"osb1_cf_{slug}"
    assert variant.values() == {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}


@pytest.mark.parametrize("kind", [int, float, np.int64, np.float64])
def test_whole_values_are_integers_whatever_their_type(kind: Any) -> None:
    """The digest of an analysis holds the numbers of its variant as text."""
    values = {"skew_deg": kind(30), "gap_mm": kind(51), "friction_pct": kind(29)}
    model = {"bridge": "osb1", "abutment": "contact_friction"}
    variant = Variant(**model, **values)
    whole = {"skew_deg": 30, "gap_mm": 51, "friction_pct": 29, "options": ()}
    assert (repr(asdict(variant)), repr(variant.friction)) == (repr(model | whole), "0.29")


def test_any_numeric_modelling_option_may_be_an_axis_within_its_limits() -> None:
    one = {"bridge": ["osb1"], "gap_mm": [51], "friction": [0.3, 0.1 + 0.2], "skew_deg": [30]}
    raw = {"transverse_gap_mm": [6.4, 25.4], "backwall_points": [5, 9]}
    variants = expand_grid(GridConfig.model_validate(raw | one))
    assert len({variant.slug for variant in variants}) == len(variants) == 4  # friction 0.3 once
    assert variants[1].slug == "osb1_cf_skew30_gap051_mu030_backwall-points5_transverse-gap-mm25p4"
    first = {"skew_deg": 30, "gap_mm": 51, "friction": 0.3, "backwall_points": 5}
    assert repr(variants[0].values()) == repr(first | {"transverse_gap_mm": 6.4})  # 5 is an integer
    good = {"bridge": "osb1", "abutment": "contact", "skew_deg": 0, "gap_mm": 51}
    for field, value, words in (
        ("friction_pct", -10, "friction must be within 0..1.5, got -0.1"),
        ("skew_deg", np.nan, "skew_deg must be within -66..66, got nan"),
        ("gap_mm", 25.40001, "gap_mm must have at most 3 decimals, got 25.40001"),
        ("friction_pct", 37.5001, "friction must have at most 5 decimals, got 0.375001"),
        ("abutment", "seat", "abutment must be one of .* got 'seat'"),
    ):
        with pytest.raises(InputError, match=words):
            Variant(**{**good, "friction_pct": 0, field: value})


def test_normalised_bridges_are_analysed_once_and_keep_options_and_file_names() -> None:
    grid = {"bridge": ["osb1"], "abutment": ["roller"], "gap_mm": [25, 51], "friction": [0, 0.5]}
    assert [one.skew_deg for one in expand_grid(parse_config({"grid": grid}).grid)] == [0, 30, 60]
    values = {"skew_deg": 30, "gap_mm": 51, "friction": 0.5, "cohesion_n": 1000.0}
    variant = Variant.at("osb1", "roller", values)
    assert variant.normalised().slug == "osb1_ro_skew30_gap000_mu000_cohesion-n1000"
    variant = expand_grid(GridConfig.model_validate({"bridge": ["some/folder/mine.yaml"]}))[0]
    assert variant.bridge == "some/folder/mine.yaml"
    assert variant.slug == "mine_cf_skew00_gap025_mu000"


def test_a_skew_or_gap_without_effect_is_named(written):
    own = written("extends: osb1\nsource: plan\nabutment: {gap_mm: 40, skew_deg: 5}\n")
    skew, gap = axis_warnings(parse_config({"grid": {"bridge": [own, "osb1"]}}))
    assert skew.startswith("made: the bridge file sets the skew: 5 deg (left), 5 deg (right);")
    assert gap.endswith("40 mm at the left end, 40 mm at the right end; gap_mm has no effect")
    one = {"bridge": ["tests/data/drawings/one_span.yaml"], "skew_deg": [0, 30]}
    (skew,) = axis_warnings(one_span := parse_config({"grid": one}))
    assert skew.endswith("35 deg (left), 35 deg (right); skew_deg has no effect")
    assert {variant.skew_deg for variant in expand_grid(one_span.grid)} == {35.0}
    spans, models = "docs/bridges/simple_spans.yaml", ["roller", "contact_friction"]
    (text,) = axis_warnings(parse_config({"grid": {"bridge": [spans], "abutment": models}}))
    assert text == "inner joints of simple_spans have no friction with abutment model roller"
    in_radians = {"bridge": ["osb1"], "skew_deg": [0, 0.26, -0.52]}
    for gaps, words in (([0, 2.5], "2.5 cm would be 25"), ([0.025, 0.051], "0.051 m would be 51")):
        skew, gap = axis_warnings(parse_config({"grid": in_radians | {"gap_mm": gaps}}))
        assert skew == "skew_deg is in degrees: 0.52 rad would be 29.79"
        assert gap == f"gap_mm is in mm: {words}"
    states = written("[{component: a, demand: unseating_m, unit: m, dispersion: 0.3, citation: b, "
                     "states: {c: 1.5, d: 38}}]")  # fmt: skip
    ida = {"design": "ida", "ida_threshold": 2.5, "suites": ["p695_far"], "count": 32}
    count, of_ida = axis_warnings(parse_config({"motions": ida}))
    assert count == "motions.count = 32, but p695_far has 22 motions"
    assert "ida_threshold: column_drift_ratio of 2.5 is outside the usual 0.001 to 0.2" in of_ida
    twice = {"model": {"pad_strength_factor": 0.8}, "grid": {"pad_strength_factor": [0.5, 1.5]}}
    assert "model.pad_strength_factor has no" in "".join(axis_warnings(parse_config(twice)))
    (text,) = axis_warnings(parse_config({"fragility": {"limit_states": states}}))
    assert text.startswith("limit state a/d: unseating_m of 38 is outside the usual 0.001 to 5")
    (text,) = axis_warnings(parse_config({"accuracy": "fast"}))
    assert text.startswith("accuracy fast is for trials: its rows are often suspect")
    assert not list(axis_warnings(parse_config({"grid": in_radians | {"skew_deg": [0, 1, 30]}})))
    along = {"uncertainty": {"enabled": True}, "model": {"gap_measured": "longitudinal"}}
    grid = {"bridge": ["osb1"], "gap_mm": [18, 25]}  # half of it is normal to a wall at skew 60
    (text,) = axis_warnings(parse_config({"grid": grid} | along))
    assert text.startswith("osb1: random gap offsets of -10 to 10 mm close its gap of 9 mm in some")
    assert not list(axis_warnings(parse_config({"grid": grid | {"abutment": ["roller"]}} | along)))


def test_variants_have_the_gap_that_their_bridge_states(written):
    own = written("extends: osb1\nsource: plan\nabutment: {gap_mm: 38.1}\n")
    ends = "{left: {type: seat, gap_mm: 30}, right: {type: seat}}"
    one_end = written(f"extends: osb1\nsource: plan\nabutments: {ends}\n")
    stiff = written("extends: osb1\nabutments: {left: {type: integral}, right: {type: fixed}}\n")
    grid = {"bridge": [own, one_end, stiff], "gap_mm": [25, 51], "skew_deg": [30]}
    grid |= {"friction": [0, 0.5], "abutment": ["contact_friction", "roller"]}
    study = parse_config({"grid": grid})
    ends = {f"made1_cf_skew30_gap{gap}_mu{mu}" for gap in ("025", "051") for mu in ("000", "050")}
    assert {variant.slug for variant in expand_grid(study.grid)} == ends | {
        "made_cf_skew30_gap038p1_mu000", "made_cf_skew30_gap038p1_mu050",
        "made_ro_skew30_gap000_mu000", "made1_ro_skew30_gap000_mu000",
        "made2_cf_skew30_gap000_mu000", "made2_ro_skew30_gap000_mu000",
    }  # fmt: skip
    for bridges, is_described in ((grid["bridge"], True), (["osb1"], False)):
        text = methods_of(parse_config({"grid": {"bridge": bridges}})).parts["Abutments"]
        assert ("integral end is a" in text) == ("fixed end cannot" in text) == is_described
    # such a variant stands for all gaps of the grid
    count, cells = cells_of(study.grid, ["skew_deg"])
    assert (count, cells["made_cf_skew30_gap038p1_mu050"]) == (4, [1, 3])
    point = {"skew_deg": 30.0, "gap_mm": 51.0, "friction": 0.5}
    assert study.grid.variant(own, "contact_friction", point).gap_mm == 38.1
    assert VariantOptions(bridge=own, gap_mm=51.0).variant.gap_mm == 38.1


@pytest.mark.parametrize("name", ABUTMENTS)
def test_a_variant_keeps_the_axes_of_its_model_which_has_a_builder_and_a_code_of_its_own(name):
    assert BUILDERS.keys() == ABUTMENTS.keys()
    assert len({traits.code for traits in ABUTMENTS.values()}) == len(ABUTMENTS)
    full = Variant(bridge="osb1", abutment=name, skew_deg=30, gap_mm=51, friction_pct=50)
    axes, own = ABUTMENTS[name].axes, full.normalised()
    assert (own.gap_mm, own.friction_pct) == (51 * ("gap_mm" in axes), 50 * ("friction" in axes))
