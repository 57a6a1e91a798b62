"""From the configuration to the analyses of a variant."""

from pathlib import Path

from skewbridge.study.analyses import StudySetup
from skewbridge.study.config import StudyConfig, parse_config
from skewbridge.variant.grid import expand_grid
from study_parts import study_of


def setup_of(study: StudyConfig) -> StudySetup:
    return study_of(
        "results", bridges=study.grid.bridge, settings=study.analysis, options=study.model
    )


def test_the_value_on_an_axis_overrides_the_configured_one() -> None:
    raw = {
        "grid": {"transverse_gap_mm": [12.5, 25.4], "backwall_points": [7]},
        "model": {"keys": "monolithic", "transverse_gap_mm": 3.0},
    }
    study = parse_config(raw)
    setup = setup_of(study)
    slugs = [variant.slug for variant in expand_grid(study.grid) if variant.skew_deg == 30]
    options = [setup.tasks(slug)[0].options for slug in slugs]
    assert {each.transverse_gap_m for each in options} == {0.0125, 0.0254}
    assert {(each.keys, each.backwall_points) for each in options} == {("monolithic", 7)}


def test_a_bridge_from_any_path_reaches_its_analyses(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text("extends: osb1\nbase: fixed\n", encoding="utf-8")
    study = parse_config({"grid": {"bridge": [str(path), "osb1"], "abutment": ["roller"]}})
    setup = setup_of(study)
    task = setup.tasks("mine_ro_skew30_gap000_mu000")[0]
    assert task.variant.bridge == str(path)
    assert task.variant.bridge_name == "mine"
    assert task.variant in expand_grid(study.grid)
