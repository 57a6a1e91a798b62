"""The commands of the bridge room, from outside."""

import json
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app

RUNNER = CliRunner()


def answer(*arguments: str) -> dict[str, object]:
    result = RUNNER.invoke(build_app(), [*arguments, "--json"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_modal_answers_weight_axial_forces_and_mass_ratios(tmp_path: Path) -> None:
    found = answer("modal", "--bridge", "osb1", "--skew-deg", "30", "--out", str(tmp_path))
    assert found["weight_kn"] == pytest.approx(19_055, rel=1e-3)
    assert len(found["column_axial_kn"]) == 2
    modes = found["modes"]
    assert {"period_s", "mass_x", "mass_y", "mass_rz"} <= set(modes[0])
    assert sum(mode["mass_x"] for mode in modes) == pytest.approx(1.0, abs=0.05)
    assert all(0.0 <= mode[k] <= 1.0 for mode in modes for k in ("mass_x", "mass_y", "mass_rz"))
    assert len(pd.read_parquet(tmp_path / "modal.parquet")) == len(modes)


@pytest.mark.parametrize("command", ["pushover", "static"])
def test_a_push_writes_its_curve(tmp_path: Path, command: str) -> None:
    found = answer(command, "--direction", "y", "--max-disp-m", "0.1", "--out", str(tmp_path))
    curve = pd.read_parquet(tmp_path / "curve.parquet")
    assert list(curve.columns) == ["disp_m", "force_kn"]
    assert curve["disp_m"].iloc[-1] == pytest.approx(0.1, rel=0.01)
    assert found["peak_kn"] == curve["force_kn"].max()
    assert found["disp_at_peak_m"] == curve["disp_m"][curve["force_kn"].idxmax()]
    first = curve["force_kn"][1] / curve["disp_m"][1]
    assert found["initial_stiffness_kn_per_m"] == pytest.approx(first)


def test_a_model_is_drawn_and_written(tmp_path: Path) -> None:
    found = answer("model", "--skew-deg", "-30", "--bridge", "osb2s", "--out", str(tmp_path))
    assert found["variant"] == "osb2s_cf_skewm30_gap051_mu050"
    assert (tmp_path / "model.png").stat().st_size > 10_000
    page = (tmp_path / "model.html").read_text(encoding="utf-8")
    assert "right backwall 5" in page
    assert "ops.element" in (tmp_path / "model.py").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("modal", "--bridge", "osb9"), "bridge must be one of"),
        (("modal", "--skew-deg", "75"), "skew_deg must be within -60..60, got 75"),
        (("modal", "--gap-mm", "-1"), "gap_mm must be within"),
        (("modal", "--friction", "-0.1"), "friction"),
        (("modal", "--friction", "0.505"), "whole hundredths"),
        (("modal", "--abutment", "seat"), "abutment must be one of"),
        (("modal", "--column-integration", "simpson"), "column_integration must be one of"),
        (("pushover", "--direction", "z", "--out", "."), "direction must be x or y"),
        (("static", "--max-disp-m", "-1", "--out", "."), "max_disp_m must be within"),
        (("static", "--backfill", "clay", "--out", "."), "backfill must be one of"),
    ],
)
def test_bad_input_is_named_and_exits_with_2(arguments: tuple[str, ...], message: str) -> None:
    result = RUNNER.invoke(build_app(), list(arguments))
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")
