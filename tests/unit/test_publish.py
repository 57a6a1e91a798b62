"""What is published of a study: the methods in words, and all of it in one file."""

import hashlib
import json
import subprocess
import zipfile
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rocrate.rocrate import ROCrate
from typer.testing import CliRunner

from fragility_tables import synthetic_demands
from skewbridge.cli import build_app
from skewbridge.files.digests import provenance
from skewbridge.files.tables import write_frame
from skewbridge.report.methods import REFERENCES, methods_of
from skewbridge.study.config import load_config, parse_config
from skewbridge.study.folder import write_starter

ROOT = Path(__file__).parents[2]
RUNNER = CliRunner()
SOURCE = "BSD-3-Clause; synthetic: model of Dabaghi and Der Kiureghian (2018)"


@pytest.fixture(name="study")
def _study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write a folder with the configuration and the tables of a finished study."""
    write_starter(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config/bridges/mine.yaml").write_text("extends: base\n")
    (tmp_path / "config/bridges/base.yaml").write_text("extends: osb1\n")
    (tmp_path / "own.yaml").write_text("results: results/own\ngrid:\n  bridge: [mine]\n")
    folder = tmp_path / "results/own"
    told = provenance(config_digest="c", suite_digest="s")
    for name in ("demands", "fragility/curves", "fragility/effects"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_frame(synthetic_demands(skews=(0,), gaps=(51,)), folder / f"{name}.parquet", told)
    (folder / "motions").mkdir()
    suite = pd.DataFrame(
        {
            "motion_id": ["m00", "m01"],
            "sha256": ["a", "b"],
            "source": [SOURCE, SOURCE],
            "accel_1_mps2": [np.zeros(3)] * 2,
            "accel_2_mps2": [np.zeros(3)] * 2,
        }
    )
    write_frame(suite, folder / "motions/suite.parquet", told)
    return tmp_path


def archived(out: str) -> dict:
    arguments = ["study", "archive", "--study", "own.yaml", "--out", out, "--json"]
    result = RUNNER.invoke(build_app(), [*arguments, "--author", "A. Engineer"])
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


def test_archive_is_a_crate_with_all_inputs_and_valid_digests(study: Path) -> None:
    found = archived("a.zip")
    crate = ROCrate(study / "a.zip")
    with zipfile.ZipFile(study / "a.zip") as packed:
        content = {name: packed.read(name) for name in packed.namelist()}
    described = {entity.id: entity for entity in crate.data_entities if entity.type != "Dataset"}
    assert sorted(described) == found["files"]
    assert set(content) - set(described) == {"ro-crate-metadata.json"}
    assert {
        "METHODS.md",
        "config/bridges/mine.yaml",
        "config/bridges/base.yaml",
        "config/config.yaml",
        "config/limit_states.yaml",
        "motions.csv",
        "own.yaml",
        "results/demands.parquet",
        "results/fragility/curves.parquet",
        "workflow/Snakefile",
    } <= set(content)
    for name, entity in described.items():
        assert hashlib.sha256(content[name]).hexdigest() == entity["sha256"]
    assert crate.mainEntity.id == "workflow/Snakefile"
    assert crate.root_dataset["author"]["name"] == "A. Engineer"
    assert b"openseespy==" in content["requirements.txt"]
    assert b"accel" not in content["motions.csv"]
    assert SOURCE.encode() in content["motions.csv"]


@pytest.mark.exports
def test_the_validator_of_crates_has_no_finding(study: Path) -> None:
    python = ROOT / ".exports/rocrate/bin/python"
    if not python.exists():
        pytest.skip("the validator is not installed: make test-exports")
    archived("a.zip")
    context = files("rocrate") / "data/ro-crate.jsonld"
    asked = {"files": [str(study / "a.zip")], "context": str(context)}
    done = subprocess.run(
        [python, ROOT / "tests/exports/read_rocrate.py"],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == {"issues": []}


def test_the_configuration_in_an_archive_is_that_of_the_study(study: Path) -> None:
    archived("a.zip")
    with zipfile.ZipFile(study / "a.zip") as packed:
        (study / "whole.yaml").write_bytes(packed.read("whole_config.yaml"))
    base = Path("config/config.yaml")
    assert load_config(Path("whole.yaml")) == load_config(Path("own.yaml"), base=base)


def test_tables_of_different_origin_are_reported(study: Path) -> None:
    path = study / "results/own/fragility/effects.parquet"
    write_frame(pd.read_parquet(path), path, provenance(config_digest="x", suite_digest="s"))
    assert any("different origin" in doubt for doubt in archived("a.zip")["doubts"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["results/own"], "no file in config/ with `results: results/own`"),
        (["other.yaml"], "finish the study first"),
        (["own.yaml", "--out", "a.tar"], "must end with .zip"),
    ],
)
def test_unfinished_study_is_refused(study: Path, arguments: list[str], message: str) -> None:
    (study / "other.yaml").write_text("results: results\n")
    result = RUNNER.invoke(build_app(), ["study", "archive", "--study", *arguments])
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")


def test_methods_are_those_of_the_configuration(study: Path) -> None:
    result = RUNNER.invoke(build_app(), ["study", "methods", "--study", "own.yaml"])
    assert result.exit_code == 0, result.stderr
    text = result.stdout
    assert "skew 0°, 30°, 60°; the joint gap 25 mm, 51 mm; friction 0, 0.5: 12 variants" in text
    assert "One bridge was modelled" in text
    assert "simulated, Dabaghi and Der Kiureghian 2018" in text
    assert "Dabaghi, M., Der Kiureghian, A. (2018)" in text
    assert "Houbolt" not in text


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (
            {"analysis": {"scheme": "paper"}},
            ("Houbolt 1950", "distributed plasticity", "committed"),
        ),
        ({"motions": {"design": "stripes"}}, ("scaled to 0.1, 0.2", "jackknife over motions")),
        ({"motions": {"design": "ida"}}, ("Vamvatsikos and Cornell 2002", "column_drift_ratio")),
        ({"motions": {"design": "cloud"}}, ("unscaled",)),
        ({"grid": {"abutment": ["roller"]}}, ("modelled on rollers",)),
        ({"model": {"shear_failure": "degrade"}}, ("loses its shear strength",)),
        ({"model": {"backfill": "sdc"}}, ("bilinear (Caltrans 2019)",)),
        ({"model": {"damping_ratio": 0.03}}, ("3 % of critical",)),
    ],
)
def test_methods_follow_the_choices(raw: dict, said: tuple[str, ...]) -> None:
    text = methods_of(parse_config(raw)).markdown()
    assert all(words in text for words in said), text


def test_every_work_that_is_cited_is_listed_and_no_other() -> None:
    text, _, listed = methods_of(parse_config({})).markdown().partition("## References")
    for key, work in REFERENCES.items():
        cited = (
            key in text.replace(f"{key} 2023", "") if key == "Rahman and Mackie" else key in text
        )
        assert (work in listed) == cited, key
