"""`bridge check` of a user's bridge, and warnings about the period in its file."""

import json
import logging
from pathlib import Path

import pytest
from typer.testing import CliRunner

from skewbridge.analysis.modal import (
    conditioning_period_s,
    periods_of_file,
    standing_bridge,
    warn_of_periods,
)
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.cli import build_app

RUNNER = CliRunner()
LONGER = 'extends: osb1\ntitle: longer\nspans_m: {v: [50.0, 50.0], src: "d: a test"}\n'


@pytest.fixture(name="longer")
def _longer(tmp_path: Path) -> str:
    path = tmp_path / "longer.yaml"
    path.write_text(LONGER)
    return str(path)


def test_a_bridge_of_the_catalogue_raises_no_doubts(tmp_path: Path) -> None:
    result = RUNNER.invoke(
        build_app(), ["bridge", "check", "osb1", "--out", f"{tmp_path}", "--json"]
    )
    found = json.loads(result.stdout)
    assert result.exit_code == 0
    assert found["findings"] == []
    assert found["weight_kn"] == pytest.approx(19_055, rel=1e-3)
    assert found["t1_of_the_model_s"] == pytest.approx(found["t1_of_the_file_s"], rel=0.002)
    (bent,) = found["bents"]
    # 6014 kN over 35.85 MPa on a circle of 1.676 m
    assert bent["axial_load_ratio"] == pytest.approx(6014 / 35.85e3 / 2.2061, rel=1e-3)
    assert bent["plastic_shear_kn"] < bent["shear_strength_kn"]
    assert (tmp_path / "model.png").stat().st_size > 10_000


def test_changed_spans_are_reported_with_the_model_period(longer: str, tmp_path: Path) -> None:
    out = str(tmp_path / "out")
    result = RUNNER.invoke(build_app(), ["bridge", "check", longer, "--out", out])
    model_s = conditioning_period_s(standing_bridge(longer))
    assert result.exit_code == 0
    assert model_s > 1.06 * load_bridge(longer).t1_s
    assert f"T1 of its model, {model_s:.4g} s" in result.stderr
    messages = RUNNER.invoke(build_app(), ["bridge", "modal", "--bridge", longer]).stderr
    assert f"T1 {model_s:.4g} s" in messages
    assert "t1_s = 0.7192 s is" in messages


def test_a_period_within_five_percent_is_accepted(tmp_path: Path) -> None:
    modes = standing_bridge("osb1")
    path = tmp_path / "own.yaml"
    for factor, said in ((1.049, 0), (0.951, 0), (1.051, "+5.1%"), (0.949, "-5.1%")):
        t1_s = factor * conditioning_period_s(modes)
        path = tmp_path / f"own_{factor:.3f}.yaml"
        path.write_text(f'extends: osb1\nt1_s: {{v: {t1_s:.6f}, src: "d: a test"}}\n')
        messages = periods_of_file(str(path), modes)
        assert (said in messages[0]) if said else messages == []


def test_a_study_warns_once_per_bridge(longer: str, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        warn_of_periods(["osb1", longer, longer])
    assert [record.message.split(":")[0] for record in caplog.records] == ["longer"]


def test_a_direction_shared_by_two_modes_is_reported(tmp_path: Path) -> None:
    """Long spans move vertically with the longitudinal motion of a pinned bent."""
    path = tmp_path / "long.yaml"
    path.write_text(LONGER.replace("50.0", "55.0"))
    messages = " ".join(periods_of_file(str(path), standing_bridge(str(path))))
    assert "the longitudinal motion is shared by modes of" in messages


def test_a_plan_warns_of_the_period_of_a_bridge(longer: str, tmp_path: Path) -> None:
    config = tmp_path / "own.yaml"
    config.write_text(f"results: {tmp_path}/results\ngrid:\n  bridge: [{longer}]\n")
    result = RUNNER.invoke(build_app(), ["plan", "--config", str(config)])
    assert result.exit_code == 0, result.stderr
    assert "warning: longer: t1_s = 0.7192 s" in result.stderr


def test_heavy_columns_and_weak_hoops_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "weak.yaml"
    path.write_text(
        "extends: osb1\n"
        "base: fixed\n"
        "deck:\n"
        '  line_load_kn_per_m: {v: 560.0, src: "d: a test"}\n'
        "column:\n"
        '  hoop_spacing_mm: {v: 600.0, src: "d: a test"}\n'
    )
    result = RUNNER.invoke(build_app(), ["bridge", "check", str(path), "--out", str(tmp_path)])
    messages = result.stderr.replace("\n", " ")
    assert "axial load ratio 0.2" in messages
    assert "the plastic shear of a column" in messages


def test_a_file_that_breaks_its_schema_names_all_faults(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(
        'extends: osb1\ndeck:\n  width_m: {v: -1.0, src: "d: a test"}\n'
        'column:\n  bar_count: {v: 2, src: "d: a test"}\n'
    )
    result = RUNNER.invoke(build_app(), ["bridge", "check", str(path), "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert "deck.width_m" in result.stderr
    assert "column.bar_count" in result.stderr
