"""A study outside a clone: the package as it is installed from a wheel, and `skewbridge init`."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

from skewbridge.errors import InputError
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


def test_existing_files_are_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("mine")
    with pytest.raises(InputError, match="has config already"):
        write_starter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["config"]
    assert (tmp_path / "config/config.yaml").read_text() == "mine"
