"""A study outside a clone: the package as it is installed from a wheel, and `skewbridge init`."""

import json
import sys
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

from skewbridge.cli.study import DEMO_STUDY
from skewbridge.errors import InputError
from skewbridge.study.folder import STARTER_PARTS, write_starter
from small_study import ROOT, done


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The files of a wheel, as an installer unpacks them."""
    folder = tmp_path_factory.mktemp("wheel")
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site-packages")
    return folder / "site-packages"


def run(installed, folder, *arguments):
    environment = {"PYTHONPATH": str(installed)}
    return done([sys.executable, "-m", *arguments], folder, environment=environment)


def test_an_installed_package_starts_a_study_and_shows_the_stored_one(installed, tmp_path):
    started = run(installed, tmp_path, "skewbridge", "init", "my study")
    study = tmp_path / "my study"
    assert "cd 'my study', then: snakemake" in started.stderr
    assert all((study / part).exists() for part in STARTER_PARTS)
    planned = run(installed, study, "snakemake", "-n", "--configfile", "config/smoke.yaml")
    assert "collect_demands" in planned.stdout
    plan = run(installed, study, "skewbridge", "plan", "--config", "config/smoke.yaml", "--json")
    assert '"analyses": 6' in plan.stdout
    shown = run(installed, tmp_path, "skewbridge", "demo", "--out", "shown", "--json")
    page = Path(json.loads(shown.stdout)["report"])
    assert page == tmp_path / "shown/report.html"
    assert "friction" in page.read_text(encoding="utf-8")
    assert sum(path.stat().st_size for path in DEMO_STUDY.rglob("*.parquet")) < 3_000_000


def test_existing_files_are_not_overwritten(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("mine")
    with pytest.raises(InputError, match="already has config"):
        write_starter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["config"]
    assert (tmp_path / "config/config.yaml").read_text() == "mine"
