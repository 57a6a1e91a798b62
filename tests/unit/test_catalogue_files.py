"""Bridge files of the catalogue, messages for bad files, and abutment models as rows of traits."""

import ast
import json
from pathlib import Path

import jsonschema
import pytest
from reference_pages import ROOT

import skewbridge
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


def write_variant(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text(f"extends: osb1\n{text}", encoding="utf-8")
    return path


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
    same = set(type(other).model_fields) - {
        "name",
        "title",
        "base",
        "foundation",
        "t1_s",
        "sources",
    }
    assert all(getattr(one, name) == getattr(other, name) for name in same)
    assert (one.base, other.base) == ("fixed", "pinned")
    assert one.t1_s < other.t1_s
    assert one.foundation is not None
    assert other.foundation is None


def test_a_fixed_base_without_foundation_stands_on_the_springs_of_bridge_a(tmp_path) -> None:
    typical = load_bridge("bridge_a")
    sprung = load_bridge(write_variant(tmp_path, "base: fixed\n"))
    assert sprung.foundation == typical.foundation is not None
    # PyPBEE Bridge_A: 722 MN/m, 4,592 and 4,815 MN m/rad
    found = sprung.foundation.model_dump()
    assert [found[key] for key in ("kx_mn_per_m", "ky_mn_per_m")] == [722.0, 722.0]
    assert [found[f"kr{axis}_mnm_per_rad"] for axis in "xy"] == [4592.0, 4815.0]
    key = "foundation.krx_mnm_per_rad"
    assert sprung.sources[key] == typical.sources[key] == "b: PyPBEE Bridge_A"
    single = "base: fixed\nbents:\n  - columns: {v: 1, src: 'd: x'}\n"
    single += "".join(
        f"    {key}: {{v: {value}, src: 'd: x'}}\n"
        for key, value in load_bridge("osb1").bents[0].model_dump().items()
        if key != "columns" and value is not None
    )
    rigid, own = tmp_path / "rigid.yaml", tmp_path / "own.yaml"
    rigid.write_text("extends: osb1\nbase: fixed\nfoundation: null\n", encoding="utf-8")
    own.write_text(f"extends: osb1\n{single}", encoding="utf-8")
    assert load_bridge(rigid).foundation is None
    assert load_bridge(own).foundation == typical.foundation


def test_a_user_adds_a_bridge_by_a_file_in_which_nothing_is_missing(tmp_path) -> None:
    path = write_variant(tmp_path, 'deck:\n  width_m: {v: 15.0, src: "d: wider"}\n')
    bridge = load_bridge(path)
    assert bridge.name == "mine"
    assert bridge.deck.width_m == 15.0
    assert bridge.deck.depth_m == load_bridge("osb1").deck.depth_m
    assert bridge.sources["deck.width_m"] == "d: wider"
    lines = (FOLDER / "osb1.yaml").read_text(encoding="utf-8").split("\n")
    path = tmp_path / "other.yaml"
    path.write_text("\n".join(line for line in lines if "hoop_spacing_mm" not in line))
    with pytest.raises(InputError, match=r"other.yaml: column.hoop_spacing_mm: is missing"):
        load_bridge(path)


def given(section: str, key: str, value: object) -> str:
    """Return the text of a value with its source."""
    return f'{section}:\n  {key}: {{v: {value}, src: "d: x"}}\n'


K50 = """abutment:
  wall_height_m: {v: 1.4, src: "d: x"}
  backfill:
    rule: k50
    stiffness_mn_per_m: {v: 28.0, src: "d: x"}
    ultimate_kn: {v: 2000, src: "d: x"}
    ultimate_closure_ratio: {v: 0.05, src: "d: x"}
"""


BENT = """bents:
  - columns: {{v: {columns}, src: "d: x"}}
    {key}: {{v: 5.0, src: "d: x"}}
    cap_width_m: {{v: 2.0, src: "d: x"}}
    cap_depth_m: {{v: 1.8, src: "d: x"}}
    cap_weight_kn: {{v: 500, src: "d: x"}}
"""


WALL = """column:
  shape: rectangular
  width_m: {v: 5.0, src: "d: x"}
  depth_m: {v: 1.0, src: "d: x"}
  bar_count: {v: 44, src: "d: x"}
  tie_legs: {v: [4, 8], src: "d: x"}
"""


def test_a_bent_replaces_single_keys_of_the_column_and_the_base(tmp_path: Path) -> None:
    own = """    base: fixed
    column:
      shape: oblong
      width_m: {v: 3.0, src: "b: S-7"}
      depth_m: {v: 1.2, src: "b: S-7"}
"""
    path = write_variant(tmp_path, BENT.format(columns=1, key="clear_height_m") + own)
    bridge = load_bridge(path)
    column, (bent,) = bridge.column_of(bridge.bents[0]), bridge.bents
    assert (bridge.base_of(bent), bridge.bases, bridge.base) == ("fixed", "fixed", "pinned")
    assert bridge.foundation == load_bridge("bridge_a").foundation
    inherited = column.model_dump(exclude={"shape", "width_m", "depth_m", "cross_ties"})
    assert inherited == bridge.column.model_dump(exclude={"shape", "diameter_m"})
    assert (column.shape, column.width_m, bridge.column.shape) == ("oblong", 3.0, "circular")
    assert bridge.sources["bents.0.column.width_m"] == "b: S-7"
    # another shape in a file that extends a bridge, too
    wall = tmp_path / "wall.yaml"
    wall.write_text(f"extends: mine\n{WALL}", encoding="utf-8")
    assert load_bridge(wall).column.tie_legs == (4, 8)
    assert load_bridge(wall).column.bar_area_mm2 == load_bridge("osb1").column.bar_area_mm2


def test_a_single_column_needs_no_spacing(tmp_path: Path) -> None:
    path = write_variant(tmp_path, BENT.format(columns=1, key="clear_height_m"))
    (bent,) = load_bridge(path).bents
    assert (bent.columns, bent.column_spacing_m) == (1, 0.0)
    with domain():
        assert len(build(variant(bridge=str(path)), ModelOptions()).columns) == 1


PLAIN = ("drawing S-12", "Drawing S-12: section B", "p. 14", "as-built, 1998", "design code")
MISTAKES = ("e: drawing", "B: drawing", "b:drawing", "b: ", "b", "calc", "calc:3", "", "  ")


def test_a_source_without_a_letter_is_a_document_at_hand(tmp_path: Path) -> None:
    schema = json.loads((ROOT / "config/bridge.schema.json").read_text())
    for number, text in enumerate((*PLAIN, *MISTAKES)):
        path = tmp_path / f"own{number}.yaml"
        path.write_text(f'extends: osb1\nt1_s: {{v: 0.7, src: "{text}"}}\n', encoding="utf-8")
        is_valid = jsonschema.Draft202012Validator(schema).is_valid(read_mapping(path))
        assert is_valid is (text in PLAIN), text
        if text in PLAIN:
            assert load_bridge(path).sources["t1_s"] == f"b: {text}"
        else:
            with pytest.raises(InputError, match=r"t1_s: src must be 'LETTER: text'"):
                load_bridge(path)
    for value in ("12", "[S-12]", "null"):
        path = tmp_path / f"own_{len(value)}.yaml"
        path.write_text(f"extends: osb1\nt1_s: {{v: 0.7, src: {value}}}\n", encoding="utf-8")
        with pytest.raises(InputError, match=r"t1_s: src must be"):
            load_bridge(path)


@pytest.mark.parametrize(
    ("text", "key", "limit"),
    [
        (given("deck", "depth_m", -1.8), "deck.depth_m", "greater than or equal to 0.001"),
        (given("deck", "depth_m", ".nan"), "deck.depth_m", "got nan"),
        ("deck:\n  depth_m: null\n", "deck.depth_m", "valid number"),
        ("column:\n  steel: unobtainium\n", "column.steel", "a706"),
        (given("deck", "soffit_height_m", 5.0), "bents.0.clear_height_m",
         "taller than the deck: soffit_height_m is 5"),
        (given("column", "bar_count", 90), "bar_count", "at most 76 bars"),
        (given("column", "cover_to_hoop_m", 0.9), "cover_to_hoop_m", "no room"),
        ('spans_m: {v: [40.0], src: "d: x"}\n', "bents", "1 spans need 0 bents"),
        (given("damping", "ratio", 0.7), "damping.ratio", "less than 0.5"),
        (K50, "backfill.stiffness_mn_per_m", "at least 28.57 with rule k50"),
        ("base: hinged\n", "base", "pinned"),
        ("colour: red\n", "colour", "unknown key"),
        ("deck:\n  depth_m: 1.8\n", "deck.depth_m", "no source"),
        ('deck:\n  depth_m: {v: 1.8, src: "x: y"}\n', "deck.depth_m", "src must be"),
        (given("deck", "depth_m", "1.8e0x"), "deck.depth_m", "valid number"),
        (given("column", "width_m", 1.2), "column: width_m is not a key of shape circular",
         "only of oblong and rectangular"),
        ("column:\n  shape: square\n", "column: shape must be one of circular,", "got 'square'"),
        (WALL + "  diameter_m: {v: 1.2, src: 'd: x'}\n", "column: diameter_m is not a key of shape",
         "rectangular, only of circular"),
        (WALL.replace("[4, 8]", "[4]"), "column.tie_legs.1", "is missing"),
        (WALL.replace("v: 44", "v: 45"), "column", "bar_count must be even, got 45"),
        (WALL.replace("v: 5.0", "v: 20.0"), "bents.0: the columns span 27.32 m", "deck.width_m"),
        (BENT.format(columns=1, key="clear_height_m") + "    column: {shape: square}\n",
         "bents.0.column", "shape must be one of circular, oblong, rectangular"),
        (BENT.format(columns=1, key="clear_height_m") + "    base: hinged\n", "bents.0.base",
         "pinned"),
        (given("column", "diametre_m", 1), "diametre_m", "(did you mean column.diameter_m?)"),
        (given("deck", "wall_width_m", 9), "deck.wall_width_m", "(did you mean deck.width_m?)"),
        (given("foundation", "hoop_spacing_mm", 9), "foundation.hoop_spacing_mm",
         "(did you mean column.hoop_spacing_mm?)"),
        (BENT.format(columns=1, key="clear_hight_m"), "bents.0.clear_hight_m",
         "(did you mean bents.clear_height_m?)"),
        (BENT.format(columns=2, key="clear_height_m"), "bents.0",
         "column_spacing_m is missing or 0: 2 columns need it"),
        ('deck:\n  depth_m: {v: 1.8, source: "S-12"}\n', "deck.depth_m.source", "has v and src"),
    ],
)  # fmt: skip
def test_a_bad_value_names_file_key_and_limit(tmp_path, text, key, limit):
    with pytest.raises(InputError) as caught:
        load_bridge(write_variant(tmp_path, text))
    assert all(part in str(caught.value) for part in ("mine.yaml", key, limit))


def test_unknown_or_circular_parents_are_refused(tmp_path: Path) -> None:
    path = write_variant(tmp_path, "")
    path.write_text("extends: osb9\n", encoding="utf-8")
    with pytest.raises(InputError, match="osb9"):
        load_bridge(path)
    (tmp_path / "one.yaml").write_text("extends: two\n", encoding="utf-8")
    (tmp_path / "two.yaml").write_text("extends: one\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"two\.yaml: extends: no other bridge is named 'one'"):
        load_bridge(tmp_path / "one.yaml")


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
    text = (ROOT / "config/bridge.schema.json").read_text()
    schema = jsonschema.Draft202012Validator(json.loads(text))
    for path in (*FOLDER.glob("*.yaml"), *(ROOT / "config/bridges").glob("*.yaml")):
        schema.validate(read_mapping(path))
    for bad in ({"extends": "osb1", "deck": {"depth_m": "six"}}, {"title": "one key only"}):
        with pytest.raises(jsonschema.ValidationError):
            schema.validate(bad)


# --- an abutment model is a row of traits and a builder; no other code uses its name


PACKAGE = Path(skewbridge.__file__).parent
# The paper's studies may name the paper's models; drawings name groups of elements.
MAY_NAME_MODELS = ("verification/", "report/bridge_figures.py")
MODULES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if not path.relative_to(PACKAGE).as_posix().startswith(MAY_NAME_MODELS)
)


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


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_module_compares_with_the_name_of_a_model(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Compare):
            texts = {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)}
            assert not texts & set(ABUTMENTS), ast.unparse(node)


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
