"""The histories without and with friction are made once, by their own rule, and only read after."""

import ast
from pathlib import Path

import pandas as pd
import pytest

import skewbridge
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse
from skewbridge.bridge.options import ModelOptions
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.suite import SuiteMotion
from skewbridge.study.friction_pair import read_friction_pair, write_friction_pair
from skewbridge.study.setup import StudySetup
from strong_motion import strong_motion

SLUGS = [
    f"osb1_cf_skew{skew:02d}_gap{gap:03d}_mu{mu:03d}"
    for skew, gap in ((0, 13), (30, 13), (30, 51))
    for mu in (0, 20, 50)
]


def demands(slugs):
    return pd.DataFrame(
        {"variant": slugs, "motion_id": "strong", "status": "ok", "deck_disp_m": 0.1}
    )


@pytest.fixture(scope="module")
def setup():
    motion = strong_motion(duration_s=1.0)
    measures = motion_measures(motion, 0.7)
    return StudySetup(
        suite=(SuiteMotion(motion=motion, scale=1.0, measures=measures),),
        measures={("osb1", "strong"): measures},
        incidence_deg=(0.0,),
        settings=AnalysisSettings(),
        options=ModelOptions(),
    )


def test_the_pair_read_is_that_of_the_analyses(setup, tmp_path):
    write_friction_pair(setup, demands(SLUGS), tmp_path / "pair.parquet")
    pair = read_friction_pair(tmp_path / "pair.parquet")
    assert pair is not None
    assert [variant.slug for variant in pair.variants] == [SLUGS[3], SLUGS[5]]
    assert pair.motion_id == "strong"
    assert list(pair.by_friction) == ["friction 0", "friction 0.5"]
    task = setup.tasks(SLUGS[5])[0]
    again = analyse(task.variant, task.excitation, task.settings, task.options, histories=True)
    pd.testing.assert_frame_equal(
        pair.histories[1], pd.DataFrame(again.histories), check_exact=True
    )


def test_a_study_of_one_friction_has_no_pair(setup, tmp_path):
    write_friction_pair(setup, demands(SLUGS[::3]), tmp_path / "pair.parquet")
    assert read_friction_pair(tmp_path / "pair.parquet") is None


@pytest.mark.parametrize(
    "path", sorted((Path(skewbridge.__file__).parent / "report").glob("*.py")), ids=lambda p: p.name
)
def test_the_report_runs_no_analysis(path):
    running = {"transient", "abutment_history", "pushover", "modal", "step_loop"}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            parts = node.module.split(".")
            assert not ("analysis" in parts and running & set(parts)), node.module
            assert node.module != "skewbridge.study.batch"
