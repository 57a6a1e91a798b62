"""The commands of the bridge package, from outside."""

import json
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from skewbridge.cli import build_app

RUNNER = CliRunner()


def answer(*arguments: str) -> dict[str, object]:
    result = RUNNER.invoke(build_app(), ["bridge", *arguments, "--json"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_all_bridges_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).parents[2])
    names = [row["bridge"] for row in answer("list")["bridges"]]
    assert {"osb1", "osb1_fixed", "osb2s", "bridge_a", "template"} <= set(names)
    assert len(names) == 8
    result = RUNNER.invoke(build_app(), ["bridge", "modal", "--bridge", "osb1_fixd"])
    assert "did you mean osb1_fixed?" in result.stderr.replace("\n", " ")


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
    assert "right backwall 3" in page
    assert "ops.element" in (tmp_path / "model.py").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("modal", "--bridge", "osb9"), "bridge must be one of"),
        (("modal", "--skew-deg", "75"), "skew_deg must be within -60..60, got 75"),
        (("modal", "--gap-mm", "-1"), "gap_mm must be within"),
        (("modal", "--friction", "-0.1"), "friction"),
        (("modal", "--gap-mm", "25.4321"), "gap_mm must have at most 3 decimals, got 25.4321"),
        (("modal", "--abutment", "seat"), "abutment must be one of"),
        (("modal", "--set", "column_integration=simpson"), "column_integration: must be 'hinge"),
        (("pushover", "--direction", "z", "--out", "."), "'z' is not one of 'x', 'y'"),
        (("static", "--max-disp-m", "-1", "--out", "."), "max_disp_m must be within"),
        (("static", "--set", "backfill=clay", "--out", "."), "backfill: must be 'hyperbolic'"),
    ],
)
def test_bad_input_is_named_and_exits_with_2(arguments: tuple[str, ...], message: str) -> None:
    result = RUNNER.invoke(build_app(), ["bridge", *arguments])
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")


def test_a_column_is_summed_up_and_drawn(tmp_path: Path) -> None:
    found = answer("column", "--bridge", "osb2s", "--bent", "2", "--out", str(tmp_path))
    assert found["axial_kn"] == pytest.approx(7_412, rel=0.01)
    curve = pd.read_parquet(tmp_path / "moment_curvature.parquet")
    assert curve["moment_knm"].max() > found["plastic_moment_knm"]
    assert (tmp_path / "column.png").stat().st_size > 10_000
    result = RUNNER.invoke(build_app(), ["bridge", "column", "--bent", "2", "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert "bent must be within 1..1" in result.stderr


def test_the_whole_ladder_is_pushed_and_drawn(tmp_path: Path) -> None:
    found = answer("static", "--abutment", "all", "--max-disp-m", "0.08", "--out", str(tmp_path))
    curves = pd.read_parquet(tmp_path / "curve.parquet")
    assert curves["abutment"].nunique() == 5
    peaks = {(row["abutment"], row["angle_deg"]): row["peak_kn"] for row in found["pushes"]}
    assert peaks["roller", 0.0] == 0.0
    assert peaks["contact", 0.0] == pytest.approx(peaks["spring", 0.0], rel=0.03)
    assert (tmp_path / "ladder.png").stat().st_size > 10_000


def test_checks_of_a_run_name_every_corner(tmp_path: Path) -> None:
    row = {"variant": "osb1_cf_skew30_gap051_mu050", "deck_disp_m": 0.1}
    pd.DataFrame([row]).to_parquet(tmp_path / "demands.parquet")
    corners = {
        f"abutment_{side}_{kind}_{axis}_m": [0.0, 0.1]
        for side in ("left", "right")
        for kind in ("acute", "obtuse")
        for axis in "xy"
    }
    pd.DataFrame(corners).to_parquet(tmp_path / "histories.parquet")
    found = answer("sdc", str(tmp_path))
    names = [check["check"] for check in found["checks"]]
    assert sum("seat, SDC" in name for name in names) == 4
    assert all(check["ok"] for check in found["checks"])
    own = tmp_path / "own.yaml"
    own.write_text("extends: osb1\nbase: fixed\n")
    row = pd.DataFrame([{"variant": "own_cf_skew30_gap051_mu050", "deck_disp_m": 0.1}])
    row.to_parquet(tmp_path / "demands.parquet")
    checks = answer("sdc", str(tmp_path), "--bridge", str(own))["checks"]
    assert checks[0]["check"] == "bent 1 displacement, hinge 0.739 m by rule (m)"
    missing = RUNNER.invoke(build_app(), ["bridge", "sdc", str(tmp_path / "none")])
    assert missing.exit_code == 2


def test_a_bridge_gets_the_capacities_of_its_bents(tmp_path: Path) -> None:
    bents = answer("sdc", "osb2s")["bents"]
    assert [bent["p_delta_ratio"] for bent in bents] == pytest.approx([0.39, 0.43], abs=0.01)
    assert not any(bent["ok"] for bent in bents)
    path = tmp_path / "own.yaml"
    path.write_text(
        'extends: osb1\ncolumn:\n  hinge_length_m: {v: 0.7, src: "d: a test"}\n', encoding="utf-8"
    )
    (bent,) = answer("sdc", str(path))["bents"]
    assert (bent["hinge_length_m"], bent["hinge_length_by"], bent["ok"]) == (0.7, "file", True)


def test_a_study_gets_one_row_of_checks_per_variant(tmp_path: Path) -> None:
    rows = [
        {
            "variant": f"osb1_cf_skew{skew:02d}_gap051_mu050",
            "deck_disp_m": disp,
            "acute_corner_unseating_m": 0.2,
            "unseating_m": 0.9,
        }
        for skew in (0, 30)
        for disp in (0.1, 0.2, 0.3)
    ]
    path = tmp_path / "demands.parquet"
    pd.DataFrame(rows).to_parquet(path)
    found = answer("sdc", str(path))["checks"]
    assert [row["variant"] for row in found] == sorted({row["variant"] for row in rows})
    assert found[0]["disp_ratio"] == pytest.approx(0.2 / 0.2154, rel=0.01)
    assert found[0]["seat_acute_ratio"] < 1.0 < found[0]["seat_worst_ratio"]
    assert found[0]["seat_aashto_ratio"] < found[1]["seat_aashto_ratio"]
