"""More motions are more of the same: nothing that was analysed changes, nothing else is made."""

from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.cli import build_app
from skewbridge.motions.content import content_digest
from skewbridge.motions.levels import LEVEL_RANGE_G, MotionsConfig
from skewbridge.motions.suite import prepare_suite
from skewbridge.motions.synthesis import generate
from skewbridge.study.config import CONDITIONING_BRIDGE, parse_config
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.setup import StudySetup
from skewbridge.study.task import run_key
from skewbridge.variant.grid import expand_grid

MOTIONS = Path(__file__).parents[2] / "motions"
T1_S = load_bridge(CONDITIONING_BRIDGE).t1_s


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The end of the stored motions and the beginning of those that are made."""
    folder = tmp_path / "motions"
    folder.mkdir()
    index = pd.read_csv(MOTIONS / "index.csv", dtype=str, keep_default_na=False)
    for name in (*index["file_1"][39:40], *index["file_2"][39:40]):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes((MOTIONS / name).read_bytes())
    index[39:42].to_csv(folder / "index.csv", index=False)
    return folder


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of the motions that were made."""
    numbers: list[int] = []
    make = generate.made_motion

    def counted(number: int) -> object:
        numbers.append(number)
        return make(number)

    monkeypatch.setattr(generate, "made_motion", counted)
    return numbers


def keys_of(folder: Path, count: int, results: Path) -> list[list[str]]:
    """Run keys by variant, as the rules prepare, plan and know them."""
    study = parse_config(
        {
            "results": str(results),
            "grid": {"bridge": ["osb1"], "skew_deg": [30]},
            "motions": {"folder": str(folder), "count": count},
        }
    )
    place = StudyFolder(results)
    prepare_motions(
        study.motions,
        conditioning_t1_s=T1_S,
        t1_s={"osb1": T1_S},
        folder=place,
    )
    setup = StudySetup.of(study, place)
    return [
        [run_key(task) for task in setup.tasks(variant.slug)] for variant in expand_grid(study.grid)
    ]


def test_more_motions_preserve_keys_and_generate_only_new_ones(
    folder: Path, tmp_path: Path, made: list[int]
) -> None:
    few = keys_of(folder, 1, tmp_path / "few")
    assert made == []
    many = keys_of(folder, 3, tmp_path / "many")
    assert made == [48, 49]
    assert [keys[:1] for keys in many] == few
    assert all(len(set(keys)) == 3 for keys in many)


def test_other_levels_preserve_the_factors_of_full_blocks(made: list[int]) -> None:
    """Without a factor in the index for these levels, whole blocks are measured, and no more."""
    few, many = (
        prepare_suite(MOTIONS, count=count, t1_s=T1_S, level_range_g=(0.2, 1.0)) for count in (1, 9)
    )
    assert few["scale"][0] == many["scale"][0]
    assert made == []


def test_digest_of_the_suite_needs_no_generated_motion(
    folder: Path, tmp_path: Path, made: list[int]
) -> None:
    def digest() -> str:
        return content_digest(
            folder, 3, t1_s=T1_S, level_range_g=LEVEL_RANGE_G, cache=tmp_path / "digest.json"
        )

    before = digest()
    index = folder / "index.csv"
    index.write_text(index.read_text().replace(",48\n", ",51\n"))
    assert digest() != before
    assert made == []


def test_check_generates_the_motion_and_preserves_its_index_row(folder: Path) -> None:
    index = folder / "index.csv"
    before = index.read_text()
    runner = CliRunner()
    done = runner.invoke(build_app(), ["motions", "check", str(folder), "--write", "--json"])
    assert done.exit_code == 0, done.output
    assert '"format": "made"' in done.stdout
    assert index.read_text().splitlines()[2:] == before.splitlines()[2:]
    index.write_text(before.replace(",48\n", ",51\n"))
    done = runner.invoke(build_app(), ["motions", "check", str(folder), "--json"])
    assert done.exit_code == 2
    assert "other libraries" in done.stdout


@pytest.mark.parametrize(("old", "new"), [(",48\n", ",0\n"), ("syn048,,", "syn048,a.AT2,")])
def test_number_and_files_together_are_refused(folder: Path, old: str, new: str) -> None:
    index = folder / "index.csv"
    index.write_text(index.read_text().replace(old, new))
    done = CliRunner().invoke(build_app(), ["motions", "check", str(folder), "--json"])
    assert done.exit_code == 2
    assert "made_from_number must be at least 1, without files in the row" in done.stdout


def test_default_suite_has_enough_motions() -> None:
    assert MotionsConfig().count <= 96 <= generate.COUNT
