"""The key of an analysis: whatever can change its result changes the key, and nothing else does."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motions_files import index_of, make_pairs
from skewbridge.analysis.keys import bridge_digest
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue.loading import FOLDER
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import content_digest, prepare_suite, read_suite, write_suite
from skewbridge.study import task as task_module
from skewbridge.study.task import run_key
from skewbridge.variant.options import ModelOptions
from study_parts import task_of


def first_motion(folder: Path, **index: list[object]) -> SuiteMotion:
    """The first motion of a folder, read with an index and kept as a study keeps it."""
    pairs = make_pairs(folder, 1)
    index_of(folder, pairs, scale=[1.0], **index)
    write_suite(prepare_suite(folder, t1_s=0.7), folder / "suite.parquet")
    return read_suite(folder / "suite.parquet")[0]


def test_a_corrected_time_step_or_unit_is_another_analysis(tmp_path: Path) -> None:
    motions = [
        first_motion(tmp_path, dt_s=[dt_s], unit=[unit])
        for dt_s, unit in ((0.01, "g"), (0.02, "g"), (0.01, "m/s2"))
    ]
    assert len({motion.motion.sha256 for motion in motions}) == 1
    assert len({run_key(task_of(motion)) for motion in motions}) == 3


def test_a_reader_that_turns_a_sign_makes_another_analysis(tmp_path: Path) -> None:
    suite_motion = first_motion(tmp_path)
    motion = suite_motion.motion
    turned = motion.with_components(motion.accel_1_mps2, -motion.accel_2_mps2)
    assert turned.sha256 == motion.sha256
    other = replace(suite_motion, motion=turned)
    assert run_key(task_of(suite_motion)) != run_key(task_of(other))


def test_names_and_measures_of_a_motion_are_not_in_the_key(tmp_path: Path) -> None:
    one = first_motion(tmp_path)
    other = replace(one, motion=replace(one.motion, motion_id="b", event="E"), measures={})
    assert run_key(task_of(one)) == run_key(task_of(other))
    as_numpy = replace(one, scale=np.float64(one.scale))
    assert run_key(task_of(one)) == run_key(task_of(as_numpy))


def test_every_setting_that_matters_is_in_the_key() -> None:
    task = task_of()
    others = [
        replace(task, incidence_deg=90.0),
        replace(task, motion=replace(task.motion, scale=1.1)),
        replace(task, settings=AnalysisSettings(dt_s=0.004)),
        replace(task, options=ModelOptions(cohesion_n=1.0)),
        replace(task, variant=replace(task.variant, gap_mm=26)),
        replace(task, variant=replace(task.variant, bridge="osb1_fixed")),
    ]
    assert len({run_key(each) for each in (task, *others)}) == 7


def test_another_solver_is_another_analysis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = task_of(first_motion(tmp_path))
    before = run_key(task)
    monkeypatch.setattr(task_module, "opensees_version", lambda: "9.9")
    assert run_key(task) != before


def test_only_numbers_of_a_bridge_change_its_digest(tmp_path: Path) -> None:
    texts = {
        "as it is": "extends: osb1\nbase: {v: fixed, src: 'd: test'}\n",
        "comment": "# why\nextends: osb1\nbase: {v: fixed, src: 'd: test'}\n",
        "source": "extends: osb1\nbase: {v: fixed, src: 'd: another reason'}\n",
        "title": "extends: osb1\ntitle: Mine\nbase: {v: fixed, src: 'd: test'}\n",
        "base": "extends: osb1\nbase: {v: pinned, src: 'd: test'}\n",
    }
    found: dict[str, str] = {}
    for name, text in texts.items():
        folder = tmp_path / name
        folder.mkdir()
        (folder / "mine.yaml").write_text(text)
        found[name] = bridge_digest(str(folder / "mine.yaml"))
    assert found["as it is"] == found["comment"] == found["source"] == found["title"]
    assert found["base"] != found["as it is"]


def test_the_parent_of_a_bridge_counts(tmp_path: Path) -> None:
    digests: list[str] = []
    for number in (1, 2):
        folder = tmp_path / str(number)
        folder.mkdir()
        parent = (FOLDER / "osb1.yaml").read_text()
        (folder / "parent.yaml").write_text(parent.replace("0.7192", f"0.74{number}", 1))
        (folder / "child.yaml").write_text("extends: parent\n")
        digests.append(bridge_digest(str(folder / "child.yaml")))
    assert digests[0] != digests[1]


class TestContentOfAFolderOfMotions:
    """The digest of what is read: times, notes and places of files do not count."""

    @staticmethod
    def digest(folder: Path, cache: Path, count: int | None = 2) -> str:
        return content_digest(folder, count, t1_s=0.7, level_range_g=(0.1, 1.5), cache=cache)

    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        folder = tmp_path / "motions"
        folder.mkdir()
        index_of(folder, make_pairs(folder, 3), scale=[1.0, 1.0, 1.0])
        return folder

    def test_notes_and_times_do_not_count(self, folder: Path, tmp_path: Path) -> None:
        cache = tmp_path / "digest.json"
        before = self.digest(folder, cache)
        (folder / "README.md").write_text("a note")
        for path in folder.iterdir():
            path.touch()
        assert self.digest(folder, cache) == before
        moved = folder.rename(tmp_path / "elsewhere")
        assert self.digest(moved, tmp_path / "other.json") == before

    def test_values_and_index_count(self, folder: Path, tmp_path: Path) -> None:
        cache = tmp_path / "digest.json"
        before = self.digest(folder, cache)
        path = next(folder.glob("q0*.AT2"))
        text = path.read_text()
        path.write_text(text + " 1.0E-3\n")
        assert self.digest(folder, cache) != before
        path.write_text(text)
        assert self.digest(folder, cache) == before
        index = folder / "index.csv"
        index.write_text(index.read_text().replace("q1,", "r1,", 1))
        assert self.digest(folder, cache) != before

    def test_a_motion_that_the_study_does_not_use_does_not_count(
        self, folder: Path, tmp_path: Path
    ) -> None:
        cache = tmp_path / "digest.json"
        before = self.digest(folder, cache)
        third = next(folder.glob("q2*.AT2"))
        third.write_text(third.read_text() + " 1.0E-3\n")
        assert self.digest(folder, cache) == before
        assert self.digest(folder, cache, count=None) != before
