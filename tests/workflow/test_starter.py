"""A study outside a clone: the package as it is installed from a wheel, and `skewbridge init`."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pytest
from hatchling.builders.wheel import WheelBuilder
from typer.testing import CliRunner

from skewbridge.cli import build_app
from skewbridge.cli.study import DEMO_STUDY
from skewbridge.errors import InputError
from skewbridge.files.tables import write_frame
from skewbridge.study.folder import STARTER_PARTS, write_starter

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a wheel, as an installer unpacks them."""
    folder = tmp_path_factory.mktemp("wheel")
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site-packages")
    return folder / "site-packages"


def run(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_an_installed_package_starts_a_study_that_snakemake_plans(
    installed: Path, tmp_path: Path
) -> None:
    where = run(installed, tmp_path, "skewbridge", "init", "mine")
    assert where.returncode == 0, where.stderr
    study = tmp_path / "mine"
    assert all((study / part).exists() for part in STARTER_PARTS)
    planned = run(installed, study, "snakemake", "-n", "--configfile", "config/smoke.yaml")
    assert planned.returncode == 0, planned.stdout + planned.stderr
    assert "collect_demands" in planned.stdout
    plan = run(installed, study, "skewbridge", "plan", "--config", "config/smoke.yaml", "--json")
    assert '"analyses": 6' in plan.stdout


def test_an_installed_package_shows_the_stored_study(installed: Path, tmp_path: Path) -> None:
    done = run(installed, tmp_path, "skewbridge", "demo", "--out", "shown", "--json")
    assert done.returncode == 0, done.stderr
    page = Path(json.loads(done.stdout)["report"])
    assert page == tmp_path / "shown/report.html"
    assert "friction" in page.read_text(encoding="utf-8")
    assert sum(path.stat().st_size for path in DEMO_STUDY.rglob("*.parquet")) < 3_000_000


def test_a_stored_study_of_another_version_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "old"
    shutil.copytree(DEMO_STUDY, old)
    table = old / "fragility/curves.parquet"
    write_frame(pd.read_parquet(table).drop(columns="theta"), table, {"made_by": "a test"})
    monkeypatch.setattr("skewbridge.cli.study.DEMO_STUDY", old)
    result = CliRunner().invoke(build_app(), ["demo", "--out", str(tmp_path / "shown")])
    assert result.exit_code == 2
    assert "does not fit this version" in result.stderr
    assert not (tmp_path / "shown/report.html").exists()


def test_snakemake_has_no_finding_in_the_small_study() -> None:
    command = [sys.executable, "-m", "snakemake", "--lint", "--directory", ".test"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_existing_files_are_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("mine")
    with pytest.raises(InputError, match="has config already"):
        write_starter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["config"]
    assert (tmp_path / "config/config.yaml").read_text() == "mine"
