"""The configuration: defaults, limits, merging, and the pages made from it."""

from pathlib import Path

import pytest

from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder
from skewbridge.report.reference_pages import PAGES, ROOT
from skewbridge.study.loading import load_config, parse_config
from skewbridge.variant.grid import expand_grid


def test_the_default_grid_has_twelve_variants_and_sixteen_motions() -> None:
    config = load_config(ROOT / "config/config.yaml")
    assert len(expand_grid(config.grid)) == 12
    assert config.motions.count == 16


@pytest.mark.parametrize("name", ["smoke", "real", "full", "stripes", "ida"])
def test_every_shipped_configuration_is_valid(name: str) -> None:
    config = load_config(ROOT / f"config/{name}.yaml", base=ROOT / "config/config.yaml")
    assert expand_grid(config.grid)


def test_the_file_config_says_what_the_models_say() -> None:
    assert load_config(ROOT / "config/config.yaml") == parse_config({})


@pytest.mark.parametrize(
    ("raw", "words"),
    [
        ({"grdi": {}}, "grdi: unknown key"),
        ({"grid": {"skwe_deg": [0]}}, r"grid\.skwe_deg: unknown key"),
        ({"grid": {"skew_deg": [75]}}, r"grid\.skew_deg\.0: .* 60, got 75"),
        ({"grid": {"gap_mm": [-1]}}, r"grid\.gap_mm\.0: .* 0, got -1"),
        ({"grid": {"friction": [-0.1]}}, r"grid\.friction\.0: .* 0, got -0\.1"),
        ({"grid": {"friction": [0.123]}}, r"hundredths.*got 0\.123"),
        ({"grid": {"skew_deg": []}}, r"grid\.skew_deg: .*at least 1"),
        ({"grid": {"skew_deg": [7.5]}}, r"grid\.skew_deg\.0: .*integer, got 7\.5"),
        (
            {"model": {"cohesion_n": "2e7"}},
            r"model\.cohesion_n: .*got '2e7' \(it is text.*2\.0e\+7",
        ),
        ({"analysis": {"dt_s": 0.0}}, r"analysis\.dt_s: .*greater than 0, got 0"),
        ({"motions": {"level_range_g": [1.0, 0.1]}}, "level_range_g must rise"),
    ],
)
def test_a_bad_value_is_named_with_its_limit(raw: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_config(raw)


def test_all_findings_are_told_at_once() -> None:
    with pytest.raises(InputError, match="2 errors"):
        parse_config({"grid": {"skew_deg": [75], "gap_mm": [-1]}})


def test_a_results_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("a file of that name")
    with pytest.raises(InputError, match=r"cannot write to the folder .*results"):
        writable_folder(tmp_path / "results")


@pytest.mark.parametrize("name", sorted(PAGES))
def test_pages_written_from_the_code_are_current(name: str) -> None:
    assert (ROOT / name).read_text() == PAGES[name](), "run `make docs`"


def test_equal_bridges_are_analysed_once() -> None:
    config = parse_config(
        {"grid": {"abutment": ["roller"], "gap_mm": [25, 51], "friction": [0, 0.5]}}
    )
    assert [variant.skew_deg for variant in expand_grid(config.grid)] == [0, 30, 60]
