"""A motion file removed while a study runs: one message, no partial or lost results."""

from pathlib import Path

import pytest

from motions_files import make_pairs
from skewbridge.errors import InputError
from skewbridge.motions import suite
from skewbridge.motions.levels import MotionsConfig
from skewbridge.study.analyses import StudySetup
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.inputs import motions_digest, prepare_motions
from skewbridge.study.task import run_key

T1_S = 0.7
SLUG = "osb1_cf_skew30_gap051_mu050"


@pytest.fixture
def study(tmp_path: Path) -> StudyConfig:
    motions = tmp_path / "motions"
    motions.mkdir()
    make_pairs(motions, 3)
    return StudyConfig(
        results=str(tmp_path / "results"), motions=MotionsConfig(folder=str(motions), count=None)
    )


@pytest.fixture
def folder(study: StudyConfig) -> StudyFolder:
    return StudyFolder(Path(study.results))


def removed(study: StudyConfig) -> Path:
    """Remove a component of the second motion."""
    path = Path(study.motions.folder) / "q1_h2.AT2"
    path.unlink()
    return path


def prepare(study: StudyConfig, folder: StudyFolder) -> None:
    prepare_motions(study, folder)


def digest(study: StudyConfig, folder: StudyFolder) -> str:
    return motions_digest(study, folder.motions_digest)


def test_motion_removed_between_check_and_reading_is_named(
    study: StudyConfig, folder: StudyFolder
) -> None:
    prepare(study, folder)
    before = folder.suite.read_bytes()
    digest(study, folder)
    removed(study)
    with pytest.raises(InputError) as caught:
        prepare(study, folder)
    assert "motion q1: 1 component file(s) found (q1_h1.AT2), 2 needed" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert folder.suite.read_bytes() == before
    assert [path.name for path in folder.suite.parent.glob(".*")] == []


def test_removed_while_the_analyses_run(study: StudyConfig, folder: StudyFolder) -> None:
    """Analyses read the prepared motions; the next start of the study names the missing file."""
    digest(study, folder)
    prepare(study, folder)

    def keys() -> list[str]:
        return [run_key(each) for each in StudySetup.of(study).tasks(SLUG)]

    before = keys()
    removed(study)
    assert keys() == before
    with pytest.raises(InputError, match=r"q1: 1 component file\(s\) found"):
        digest(study, folder)


def test_removed_while_the_folder_is_listed(
    study: StudyConfig, folder: StudyFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = suite.files_below

    def and_removed(where: Path) -> list[Path]:
        found = listed(where)
        removed(study)
        return found

    monkeypatch.setattr(suite, "files_below", and_removed)
    with pytest.raises(InputError, match=r"q1_h2\.AT2 cannot be read: No such file"):
        digest(study, folder)
    assert not folder.motions_digest.exists()
