"""Bridge files: contents of the catalogue, and messages for bad files."""

import json
from pathlib import Path

import jsonschema
import pytest
from reference_pages import ROOT

from skewbridge.bridge.catalogue import bridge_names, load_bridge, load_bridge_file
from skewbridge.bridge.catalogue.loading import FOLDER
from skewbridge.errors import InputError
from skewbridge.files.text import read_mapping


def write_variant(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text(f"extends: osb1\n{text}", encoding="utf-8")
    return path


@pytest.mark.parametrize("name", bridge_names())
def test_every_number_of_a_bridge_names_its_source_class(name: str) -> None:
    bridge = load_bridge(name)
    assert len(bridge.sources) > 60
    assert {source.split(":")[0] for source in bridge.sources.values()} <= set("abcd") | {"calc"}


@pytest.mark.parametrize("name", ["osb1", "osb1_fixed", "osb1_era1", "osb2s"])
def test_a_bridge_with_unpublished_details_says_so(name: str) -> None:
    bridge = load_bridge(name)
    assert bridge.details == "surrogate"
    assert "surrogate" in bridge.title


def test_the_fixed_bridge_differs_in_its_bases_and_period_only() -> None:
    fixed, pinned = load_bridge("osb1_fixed"), load_bridge("osb1")
    same = set(type(pinned).model_fields) - {"name", "title", "base", "t1_s", "sources"}
    assert all(getattr(fixed, name) == getattr(pinned, name) for name in same)
    assert (fixed.base, pinned.base) == ("fixed", "pinned")
    assert fixed.t1_s < pinned.t1_s


def test_a_user_adds_a_bridge_by_adding_a_file(tmp_path: Path) -> None:
    path = write_variant(tmp_path, 'deck:\n  width_m: {v: 15.0, src: "d: wider"}\n')
    bridge = load_bridge_file(path)
    assert bridge.name == "mine"
    assert bridge.deck.width_m == 15.0
    assert bridge.deck.depth_m == load_bridge("osb1").deck.depth_m
    assert bridge.sources["deck.width_m"] == "d: wider"


@pytest.mark.parametrize(
    ("text", "key", "limit"),
    [
        (
            'deck:\n  depth_m: {v: -1.8, src: "d: x"}\n',
            "deck.depth_m",
            "greater than or equal to 0.001",
        ),
        ('deck:\n  depth_m: {v: .nan, src: "d: x"}\n', "deck.depth_m", "got nan"),
        ("deck:\n  depth_m: null\n", "deck.depth_m", "valid number"),
        ("column:\n  steel: unobtainium\n", "column.steel", "a706"),
        (
            'deck:\n  soffit_height_m: {v: 5.0, src: "d: x"}\n',
            "bents.0.clear_height_m",
            "taller than the deck: soffit_height_m is 5",
        ),
        ('column:\n  bar_count: {v: 90, src: "d: x"}\n', "bar_count", "at most 76 bars"),
        ('column:\n  cover_to_hoop_m: {v: 0.9, src: "d: x"}\n', "cover_to_hoop_m", "no room"),
        ('spans_m: {v: [40.0], src: "d: x"}\n', "bents", "1 spans need 0 bents"),
        ('damping:\n  ratio: {v: 0.7, src: "d: x"}\n', "damping.ratio", "less than 0.5"),
        (
            'abutment:\n  wall_height_m: {v: 1.4, src: "d: x"}\n  backfill:\n    rule: k50\n'
            '    stiffness_mn_per_m: {v: 28.0, src: "d: x"}\n'
            '    ultimate_kn: {v: 2000, src: "d: x"}\n'
            '    ultimate_closure_ratio: {v: 0.05, src: "d: x"}\n',
            "backfill.stiffness_mn_per_m",
            "at least 28.57 with rule k50",
        ),
        ("base: hinged\n", "base", "pinned"),
        ("colour: red\n", "colour", "unknown key"),
        ("deck:\n  depth_m: 1.8\n", "deck.depth_m", "no source"),
        ('deck:\n  depth_m: {v: 1.8, src: "x: y"}\n', "deck.depth_m", "src must be"),
        ('deck:\n  depth_m: {v: 1.8e0x, src: "d: x"}\n', "deck.depth_m", "valid number"),
    ],
)
def test_a_bad_value_names_file_key_and_limit(
    tmp_path: Path, text: str, key: str, limit: str
) -> None:
    path = write_variant(tmp_path, text)
    with pytest.raises(InputError) as caught:
        load_bridge_file(path)
    message = str(caught.value)
    assert "mine.yaml" in message
    assert key in message
    assert limit in message


def test_a_missing_number_names_its_key(tmp_path: Path) -> None:
    text = (FOLDER / "osb1.yaml").read_text(encoding="utf-8")
    lines = [line for line in text.split("\n") if "hoop_spacing_mm" not in line]
    path = tmp_path / "mine.yaml"
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(InputError, match=r"mine.yaml: column.hoop_spacing_mm: is missing"):
        load_bridge_file(path)


def test_an_unknown_parent_or_bridge_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("extends: osb9\n", encoding="utf-8")
    with pytest.raises(InputError, match="osb9"):
        load_bridge_file(path)
    with pytest.raises(InputError, match="bridge must be one of"):
        load_bridge("osb9")


def test_an_own_bridge_is_found_by_its_name_before_the_catalogue(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_bridges_that_extend_each_other_are_refused(tmp_path: Path) -> None:
    (tmp_path / "one.yaml").write_text("extends: two\n", encoding="utf-8")
    (tmp_path / "two.yaml").write_text("extends: one\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"two\.yaml: extends: no other bridge 'one'"):
        load_bridge_file(tmp_path / "one.yaml")


def test_the_template_loads_and_has_every_key() -> None:
    template = load_bridge_file(ROOT / "config/bridges/template.yaml")
    assert all(value is not None for value in template.model_dump().values())
    assert set(template.sources) > set(load_bridge("osb1").sources)


def test_the_schema_of_editors_knows_the_form_of_a_bridge() -> None:
    text = (ROOT / "config/bridge.schema.json").read_text()
    schema = jsonschema.Draft202012Validator(json.loads(text))
    for path in (*FOLDER.glob("*.yaml"), *(ROOT / "config/bridges").glob("*.yaml")):
        schema.validate(read_mapping(path))
    for bad in ({"extends": "osb1", "deck": {"depth_m": 1.8}}, {"title": "one key only"}):
        with pytest.raises(jsonschema.ValidationError):
            schema.validate(bad)
