"""Bridge files of the catalogue, messages for bad files, and abutment models as rows of traits."""

import json
from pathlib import Path

import jsonschema
import pytest
import yaml
from reference_pages import ROOT

from bridge_variants import variant
from skewbridge.bridge.abutments import BUILDERS
from skewbridge.bridge.catalogue import FOLDER, bridge_names, load_bridge
from skewbridge.bridge.model import build, domain
from skewbridge.errors import InputError
from skewbridge.files.text import read_mapping
from skewbridge.report.methods import methods_of
from skewbridge.study.config import parse_config
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import ABUTMENTS, AbutmentTraits, Variant

BRIDGE_SCHEMA = jsonschema.Draft202012Validator(
    json.loads((ROOT / "config/bridge.schema.json").read_text())
)
# a bridge like osb1 with numbers of one source
OWN = "extends: osb1\nsource: 'd: x'\n"


@pytest.mark.parametrize("name", bridge_names())
def test_every_number_of_a_bridge_names_its_source_class(name: str) -> None:
    bridge = load_bridge(name)
    assert len(bridge.sources) > 60
    assert {source.split(":")[0] for source in bridge.sources.values()} <= set("abcd") | {"calc"}
    if name.startswith("osb"):
        assert bridge.details == "surrogate"
        assert "surrogate" in bridge.title


@pytest.mark.parametrize(
    ("fixed", "pinned"), [("osb1_fixed", "osb1"), ("osb1_fixed_era1", "osb1_era1")]
)
def test_a_fixed_bridge_differs_in_base_foundation_and_period(fixed: str, pinned: str) -> None:
    one, other = load_bridge(fixed), load_bridge(pinned)
    different = {"name", "title", "base", "foundation", "t1_s", "sources"}
    assert one.model_dump(exclude=different) == other.model_dump(exclude=different)
    assert (one.base, other.base) == ("fixed", "pinned")
    assert one.t1_s < other.t1_s
    assert one.foundation is not None
    assert other.foundation is None


def test_a_fixed_base_without_foundation_stands_on_the_springs_of_bridge_a(written) -> None:
    typical, osb1 = load_bridge("bridge_a"), load_bridge("osb1")
    sprung = load_bridge(written("extends: osb1\nbase: fixed\n"))
    assert sprung.foundation == typical.foundation is not None
    # PyPBEE Bridge_A: 722 MN/m, 4,592 and 4,815 MN m/rad
    found = sprung.foundation.model_dump()
    assert [found[key] for key in ("kx_mn_per_m", "ky_mn_per_m")] == [722.0, 722.0]
    assert [found[f"kr{axis}_mnm_per_rad"] for axis in "xy"] == [4592.0, 4815.0]
    key = "foundation.krx_mnm_per_rad"
    assert sprung.sources[key] == typical.sources[key] == "b: PyPBEE Bridge_A"
    bent = osb1.bents[0].model_dump(exclude_none=True) | {"columns": 1}
    single = load_bridge(written(f"{OWN}base: fixed\n{yaml.safe_dump({'bents': [bent]})}"))
    assert single.foundation == typical.foundation
    rigid = load_bridge(written("extends: osb1\nbase: fixed\nfoundation: null\n"))
    assert rigid.foundation is None


def test_a_user_adds_a_bridge_by_a_file_in_which_nothing_is_missing(written) -> None:
    bridge = load_bridge(written("extends: osb1\ndeck: {width_m: {v: 15.0, src: 'd: wider'}}\n"))
    assert bridge.name == "made"
    assert (bridge.deck.width_m, bridge.sources["deck.width_m"]) == (15.0, "d: wider")
    assert bridge.deck.depth_m == load_bridge("osb1").deck.depth_m
    lines = (FOLDER / "osb1.yaml").read_text(encoding="utf-8").split("\n")
    other = written("\n".join(line for line in lines if "hoop_spacing_mm" not in line))
    with pytest.raises(InputError, match=r"made1.yaml: column.hoop_spacing_mm: is missing"):
        load_bridge(other)


def bents(columns: int = 1, **keys: object) -> str:
    """Return the text of a bent with further keys."""
    bent = {"columns": columns, "clear_height_m": 5.0, "cap_width_m": 2.0, "cap_depth_m": 1.8}
    return yaml.safe_dump({"bents": [bent | {"cap_weight_kn": 500} | keys]})


WALL = "column: {shape: rectangular, width_m: 5.0, depth_m: 1.0, bar_count: 44, tie_legs: [4, 8]}\n"


def test_a_bent_replaces_single_keys_of_the_column_and_the_base(written) -> None:
    oblong = {"shape": "oblong", "width_m": 3.0, "depth_m": 1.2}
    path = written(OWN + bents(base="fixed", column=oblong))
    bridge = load_bridge(path)
    column, (bent,) = bridge.column_of(bridge.bents[0]), bridge.bents
    assert (bridge.base_of(bent), bridge.bases, bridge.base) == ("fixed", "fixed", "pinned")
    assert bridge.foundation == load_bridge("bridge_a").foundation
    inherited = column.model_dump(exclude={"shape", "width_m", "depth_m", "cross_ties"})
    assert inherited == bridge.column.model_dump(exclude={"shape", "diameter_m"})
    assert (column.shape, column.width_m, bridge.column.shape) == ("oblong", 3.0, "circular")
    assert bridge.sources["bents.0.column.width_m"] == "d: x"
    # a single column needs no spacing
    assert (bent.columns, bent.column_spacing_m) == (1, 0.0)
    with domain():
        assert len(build(variant(bridge=path), ModelOptions()).columns) == 1
    # another shape in a file that extends a bridge, too
    wall = load_bridge(written(f"extends: made\nsource: 'd: x'\n{WALL}"))
    assert wall.column.tie_legs == (4, 8)
    assert wall.column.bar_area_mm2 == load_bridge("osb1").column.bar_area_mm2


PLAIN = ("drawing S-12", "Drawing S-12: section B", "p. 14", "as-built, 1998", "design code")
MISTAKES = ("e: drawing", "B: drawing", "b:drawing", "b: ", "b", "calc", "calc:3", "", "  ")


def test_a_source_without_a_letter_is_a_document_at_hand(written) -> None:
    for text in PLAIN:
        path = written(f'extends: osb1\nt1_s: {{v: 0.7, src: "{text}"}}\n')
        assert BRIDGE_SCHEMA.is_valid(read_mapping(Path(path)))
        assert load_bridge(path).sources["t1_s"] == f"b: {text}"
    for value in (*(f'"{text}"' for text in MISTAKES), "12", "[S-12]", "null"):
        path = written(f"extends: osb1\nt1_s: {{v: 0.7, src: {value}}}\n")
        assert not BRIDGE_SCHEMA.is_valid(read_mapping(Path(path)))
        with pytest.raises(InputError, match=r"t1_s: src must be"):
            load_bridge(path)


K50 = """abutment:
  wall_height_m: 1.4
  backfill: {rule: k50, stiffness_mn_per_m: 28.0, ultimate_kn: 2000, ultimate_closure_ratio: 0.05}
"""


@pytest.mark.parametrize(
    ("text", "key", "limit"),
    [
        ("deck: {depth_m: -1.8}", "deck.depth_m", "greater than or equal to 0.001"),
        ("deck: {depth_m: .nan}", "deck.depth_m", "got nan"),
        ("deck: {depth_m: null}", "deck.depth_m", "valid number"),
        ("column: {steel: unobtainium}", "column.steel", "a706"),
        ("deck: {soffit_height_m: 5.0}", "bents.0.clear_height_m",
         "taller than the deck: soffit_height_m is 5"),
        ("column: {bar_count: 90}", "bar_count", "at most 76 bars"),
        ("column: {cover_to_hoop_m: 0.9}", "cover_to_hoop_m", "no room"),
        ("spans_m: [40.0]", "bents", "1 spans need 0 bents"),
        ("damping: {ratio: 0.7}", "damping.ratio", "less than 0.5"),
        (K50, "backfill.stiffness_mn_per_m", "at least 28.57 with rule k50"),
        ("base: hinged", "base", "pinned"),
        ("colour: red", "colour", "unknown key"),
        ('deck: {depth_m: {v: 1.8, src: "x: y"}}', "deck.depth_m", "src must be"),
        ("deck: {depth_m: {v: 1.8e0x, src: 'd: x'}}", "deck.depth_m", "valid number"),
        ("column: {width_m: 1.2}", "column: width_m is not a key of shape circular",
         "only of oblong and rectangular"),
        ("column: {shape: square}", "column: shape must be one of circular,", "got 'square'"),
        (WALL.replace("width_m", "diameter_m: 1.2, width_m"),
         "column: diameter_m is not a key of shape", "rectangular, only of circular"),
        (WALL.replace("[4, 8]", "[4]"), "column.tie_legs.1", "is missing"),
        (WALL.replace("44", "45"), "column", "bar_count must be even, got 45"),
        (WALL.replace("5.0", "20.0"), "bents.0: the columns span 27.32 m", "deck.width_m"),
        (bents(column={"shape": "square"}), "bents.0.column",
         "shape must be one of circular, oblong, rectangular"),
        (bents(base="hinged"), "bents.0.base", "pinned"),
        ("column: {diametre_m: 1}", "diametre_m", "(did you mean column.diameter_m?)"),
        ("deck: {wall_width_m: 9}", "deck.wall_width_m", "(did you mean deck.width_m?)"),
        ("foundation: {hoop_spacing_mm: 9}", "foundation.hoop_spacing_mm",
         "(did you mean column.hoop_spacing_mm?)"),
        (bents(clear_hight_m=5.0), "bents.0.clear_hight_m", "(did you mean bents.clear_height_m?)"),
        (bents(columns=2), "bents.0", "column_spacing_m is missing or 0: 2 columns need it"),
        ('deck: {depth_m: {v: 1.8, source: "S-12"}}', "deck.depth_m.source", "has v and src"),
    ],
)  # fmt: skip
def test_a_bad_value_names_file_key_and_limit(written, text, key, limit):
    with pytest.raises(InputError) as caught:
        load_bridge(written(OWN + text))
    assert all(part in str(caught.value) for part in ("made.yaml", key, limit))


def test_unknown_or_circular_parents_and_numbers_without_source_are_refused(written) -> None:
    for path, words in (
        (written("extends: osb9\n"), "osb9"),
        (
            written("extends: osb1\ndeck: {depth_m: 1.8}\n"),
            "depth_m: the number 1.8 has no source",
        ),
        (written("extends: made3\n"), r"made3\.yaml: extends: no other bridge is named 'made2'"),
        (written("extends: made2\n"), r"made2\.yaml: extends: no other bridge is named 'made3'"),
    ):
        with pytest.raises(InputError, match=words):
            load_bridge(path)


def test_an_own_bridge_is_found_by_its_name_before_the_catalogue(tmp_path, monkeypatch):
    own = tmp_path / "config/bridges"
    own.mkdir(parents=True)
    (own / "mine.yaml").write_text("extends: osb1\nbase: fixed\n", encoding="utf-8")
    (own / "osb1.yaml").write_text("extends: osb1\ntitle: mine\n", encoding="utf-8")
    before = load_bridge("osb1").title
    monkeypatch.chdir(tmp_path)
    assert load_bridge("osb1").title == "mine" != before
    assert (load_bridge("mine").base, load_bridge("mine").title) == ("fixed", "mine")
    assert load_bridge("config/bridges/mine.yaml") == load_bridge("mine")
    with pytest.raises(InputError, match=r"bridge must be one of .* mine.* got 'osb9'"):
        load_bridge("osb9")


def test_the_schema_of_editors_knows_the_form_of_a_bridge() -> None:
    for path in (*FOLDER.glob("*.yaml"), *(ROOT / "config/bridges").glob("*.yaml")):
        BRIDGE_SCHEMA.validate(read_mapping(path))
    for bad in ({"extends": "osb1", "deck": {"depth_m": "six"}}, {"title": "one key only"}):
        with pytest.raises(jsonschema.ValidationError):
            BRIDGE_SCHEMA.validate(bad)


# --- an abutment model is a row of traits and a builder


@pytest.mark.parametrize("name", ABUTMENTS)
def test_a_variant_keeps_the_axes_of_its_model_which_has_a_builder_and_a_code_of_its_own(name):
    assert BUILDERS.keys() == ABUTMENTS.keys()
    assert len({traits.code for traits in ABUTMENTS.values()}) == len(ABUTMENTS)
    full = Variant(bridge="osb1", abutment=name, skew_deg=30, gap_mm=51, friction_pct=50)
    axes = ABUTMENTS[name].axes
    own = full.normalised()
    assert own.gap_mm == (51 if "gap_mm" in axes else 0)
    assert own.friction_pct == (50 if "friction" in axes else 0)
    assert Variant.of_row({"bridge": own.bridge, "abutment": own.abutment, **own.values()}) == own


CONTACT = {"backfill": "none", "has_contacts": True}


@pytest.mark.parametrize(
    ("traits", "stated", "not_stated"),
    [
        ({"backfill": "none"}, [], ["backfill is", "Contact is"]),
        ({"backfill": "option"}, ["The backfill is hyperbolic"], ["Contact is"]),
        (CONTACT, ["Contact is", "points are placed"], ["backfill is"]),
    ],
)
def test_the_report_describes_a_further_model(monkeypatch, traits, stated, not_stated):
    further = AbutmentTraits(code="fu", description="as springs of a further model", **traits)
    monkeypatch.setitem(ABUTMENTS, "further", further)
    text = methods_of(parse_config({"grid": {"abutment": ["further"]}})).parts["Abutments"]
    assert all(part in text for part in ["modelled as springs of a further model", *stated])
    assert not any(part in text for part in not_stated)
