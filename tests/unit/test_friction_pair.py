"""The histories without and with friction are made once, by their own rule, and only read after."""

import pandas as pd
import pytest

from skewbridge.analysis.transient import analyse
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.record import SuiteMotion
from skewbridge.study.friction_pair import write_friction_pair
from strong_motion import strong_motion
from study_parts import study_of

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
def setup(tmp_path_factory):
    motion = strong_motion(duration_s=1.0)
    suite = SuiteMotion(motion=motion, scale=1.0, measures=motion_measures(motion, 0.7))
    return study_of(tmp_path_factory.mktemp("study"), suite)


def written(setup, slugs, folder):
    demands(slugs).to_parquet(folder / "demands.parquet")
    write_friction_pair(setup, folder / "demands.parquet", folder / "pair.parquet")
    return pd.read_parquet(folder / "pair.parquet")


def test_the_pair_written_is_that_of_the_analyses(setup, tmp_path):
    pair = written(setup, SLUGS, tmp_path)
    assert list(pair["variant"].unique()) == [SLUGS[3], SLUGS[5]]
    assert set(pair["motion_id"]) == {"strong"}
    task = setup.tasks(SLUGS[5])[0]
    again = analyse(task.variant, task.excitation, task.settings, task.options, histories=True)
    own = pair[pair["variant"] == SLUGS[5]].drop(columns=["variant", "motion_id"])
    expected = pd.DataFrame(again.histories)
    pd.testing.assert_frame_equal(own.reset_index(drop=True), expected, check_exact=True)


def test_a_study_of_one_friction_has_no_pair(setup, tmp_path):
    assert written(setup, SLUGS[::3], tmp_path).empty
