"""The configuration: defaults, limits, merging, and the pages made from it."""

import json
import re
from pathlib import Path

import jsonschema
import pytest
import yaml
from reference_pages import PAGES, ROOT

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.files.text import read_mapping, read_yaml
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.motions.folder import list_motions
from skewbridge.study.config import StudyConfig, load_config, parse_config
from skewbridge.study.folder import DEFAULT_ROOT
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.options import ModelOptions

NAN = float("nan")
SCHEMA = jsonschema.Draft202012Validator(json.loads((ROOT / "config/schema.json").read_text()))
SHIPPED = ("config", "smoke", "real", "full", "stripes", "ida", "suites")


def shipped(name: str) -> StudyConfig:
    return load_config(ROOT / f"config/{name}.yaml", base=ROOT / "config/config.yaml")


@pytest.mark.parametrize(
    ("name", "variants"),
    [
        ("config", 24),
        ("smoke", 2),
        ("real", 24),
        ("full", 160),
        ("stripes", 4),
        ("ida", 4),
        ("suites", 16),
    ],
)
def test_the_grid_of_a_shipped_configuration_has_its_variants(name: str, variants: int) -> None:
    assert len(expand_grid(shipped(name).grid)) == variants


def test_no_study_overwrites_the_results_of_another() -> None:
    folders = [shipped(name).results for name in SHIPPED]
    assert folders[0] == DEFAULT_ROOT
    assert len(set(folders)) == len(SHIPPED)


def test_the_full_study_takes_96_motions_of_the_suite() -> None:
    full = shipped("full").motions
    assert full.count == 96 <= len(list_motions(ROOT / full.folder))
    assert full.level_range_g == shipped("config").motions.level_range_g


def test_the_shipped_configuration_has_the_defaults() -> None:
    drawn = parse_config({"uncertainty": {"enabled": True}})
    assert load_config(ROOT / "config/config.yaml") == drawn


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"grdi": {}}, "grdi: unknown key"),
        ({"grid": {"skwe_deg": [0]}}, r"grid\.skwe_deg: unknown key"),
        ({"grid": {"skew_deg": [75]}}, r"grid\.skew_deg\.0: must be within -60\.\.60, got 75$"),
        ({"grid": {"gap_mm": [-1]}}, r"grid\.gap_mm\.0: .* 0\.\.999, got -1$"),
        ({"grid": {"friction": [-0.1]}}, r"grid\.friction\.0: .* 0\.\.1\.5, got -0\.1"),
        ({"grid": {"friction": [0.1234567]}}, r"friction\.0: .*most 5 decimals, got 0\.1234567"),
        ({"grid": {"skew_deg": []}}, r"grid\.skew_deg: .*at least 1"),
        ({"grid": {"skew_deg": [7.5001]}}, r"skew_deg\.0: .*most 3 decimals, got 7\.5001"),
        (
            {"model": {"cohesion_n": "2e7"}},
            r"model\.cohesion_n: .*got '2e7' \(it is text.*2\.0e\+7",
        ),
        (
            {"analysis": {"dt_s": 0.0}},
            r"analysis\.dt_s: .*equal to 0\.00001, got 0$",
        ),
        ({"motions": {"level_range_g": [1.0, 0.1]}}, "level_range_g must rise"),
        (
            {"model": {"backfill": "clay"}},
            r"model\.backfill: must be .* or 'sdc', got 'clay'",
        ),
        ({"model": {"transverse_gap_mm": -0.1}}, r"model\.transverse_gap_mm: "),
        ({"model": {"backwall_points": 1}}, r"model\.backwall_points: "),
        ({"model": {"wall_dashpot_ratio": 2.0}}, r"model\.wall_dashpot_ratio: "),
        ({"model": {"normal_stiffness_n_per_m": 0.0}}, r"model\.normal_stiffness_n_per_m: "),
        ({"model": {"normal_stiffness_n_per_m": NAN}}, r"model\.normal_stiffness_n_per_m: "),
        ({"model": {"column_fibers": [8, 2, 2]}}, r"column_fibers\.1: "),
        ({"model": {"column_fibers": [8, 0, 2]}}, r"column_fibers\.1: .*to 3, got 0$"),
        ({"figures": {"width_mm": 5}}, r"figures\.width_mm: .*equal to 40, got 5$"),
        ({"accuracy": "exact"}, r"accuracy: must be 'reference', 'default' or 'fast', got 'exact'"),
        ({"accuracy": ["fast"]}, r"accuracy: must be 'reference', 'default' or 'fast'"),
        ({"model": 3}, "model: keys and values are needed, got 3$"),
        ({"analysis": {"integrator": ["Euler"]}}, "integrator must be Houbolt, Newmark or HHT"),
        (
            {"analysis": {"scheme": "paper", "dt_s": 0.01}},
            r"fixed at 0\.005 .* got 0\.01",
        ),
        ({"grid": {"transverse_gap_mm": [-1]}}, r"grid\.transverse_gap_mm\.0: .*100000, got -1$"),
        ({"grid": {"backwall_points": [5.5]}}, r"backwall_points\.0: must be whole, got 5\.5"),
        ({"grid": {"arrays": ["rigid"]}}, r"grid\.arrays: unknown key"),
        (
            {"grid": {"cohesion_n": ["2e7"]}},
            r"grid\.cohesion_n\.0: .* number, got '2e7'",
        ),
        ({"grid": {"bridge": ["My-Bridge"]}}, "small letters, digits and _.*got 'My-Bridge'"),
        ({"grid": {"bridge": ["osb1", "x/osb1.yaml"]}}, "two bridges have the same name"),
    ],
)
def test_a_bad_value_is_named_with_its_limit(raw: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_config(raw)


def test_a_section_is_the_class_that_the_analyses_take() -> None:
    config = parse_config({})
    assert config.model == ModelOptions()
    assert config.analysis == AnalysisSettings()


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
    assert parse_config({"model": {"backwall_points": 41}}).model.backwall_points == 41


def test_plain_values_are_read_back_as_they_were() -> None:
    raw = {
        "grid": {"transverse_gap_mm": [6.4, 25.4], "backwall_points": [5]},
        "model": {"column_fibers": [6, 12, 1], "keys": "monolithic"},
        "analysis": {"integrator": ["Newmark", 0.5, 0.25]},
    }
    config = parse_config(raw)
    plain = json.loads(json.dumps(config.model_dump(mode="json")))
    assert parse_config(plain) == config
    assert config.analysis.integrator_command == ("Newmark", 0.5, 0.25)


def config_files() -> list[Path]:
    return sorted(path for path in (ROOT / "config").glob("*.yaml") if "limit" not in path.name)


@pytest.mark.parametrize("path", config_files(), ids=lambda path: path.name)
def test_the_schema_of_editors_accepts_every_shipped_configuration(path: Path) -> None:
    assert path.read_text().startswith("# yaml-language-server: $schema=schema.json\n")
    SCHEMA.validate(read_mapping(path))


@pytest.mark.parametrize(
    "raw",
    [
        {"grid": {"skew_degg": [0]}},
        {"grid": {"skew_deg": [75]}},
        {"grid": {"transverse_gap_mm": [-1]}},
        {"model": {"backfill": "clay"}},
        {"analysis": {"dt_s": "fast"}},
    ],
)
def test_the_schema_of_editors_refuses_bad_values(raw: dict[str, object]) -> None:
    with pytest.raises(InputError):
        parse_config(raw)
    with pytest.raises(jsonschema.ValidationError):
        SCHEMA.validate(raw)


@pytest.mark.parametrize("name", sorted(PAGES))
def test_pages_written_from_the_code_are_current(name: str) -> None:
    assert (ROOT / name).read_text() == PAGES[name](), "run `make docs`"


def test_equal_bridges_are_analysed_once() -> None:
    config = parse_config(
        {
            "grid": {
                "bridge": ["osb1"],
                "abutment": ["roller"],
                "gap_mm": [25, 51],
                "friction": [0, 0.5],
            }
        }
    )
    assert [variant.skew_deg for variant in expand_grid(config.grid)] == [0, 30, 60]


@pytest.mark.parametrize("name", ["limit_states.yaml", "limit_states_template.yaml"])
def test_limit_states_fit_their_schema_and_load(name: str) -> None:
    path = ROOT / "config" / name
    assert path.read_text().startswith("# yaml-language-server: $schema=limit_states.schema.json\n")
    schema = json.loads((ROOT / "config/limit_states.schema.json").read_text())
    entries = read_yaml(path)
    jsonschema.validate(entries, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate([entries[0] | {"unit": "furlong"}], schema)
    assert load_limit_states(path)
