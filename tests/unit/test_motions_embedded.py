"""The shipped suite is what its generator makes, within its promises."""

from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.motions.index import list_motions
from skewbridge.motions.scaling import FACTOR_LIMITS
from skewbridge.motions.suite import prepare_suite
from skewbridge.motions.synthesis.embedded import COUNT, default_motions
from skewbridge.motions.write import at2_text

MOTIONS = Path(__file__).parents[2] / "motions"


@pytest.fixture(scope="module")
def suite() -> pd.DataFrame:
    index = pd.read_csv(MOTIONS / "index.csv")
    return prepare_suite(MOTIONS, t1_s=float(index["scale_t1_s"][0]))


def test_generating_again_gives_the_shipped_files():
    """Same bytes on the processor the files were made on.

    Elsewhere the last digits of exp and sin may differ: values agree to 1e-6 of the peak.
    """
    for (_, motion), entry in zip(
        islice(default_motions(), 3), list_motions(MOTIONS), strict=False
    ):
        assert motion.motion_id == entry.motion_id
        for component, path in ((1, entry.file_1), (2, entry.file_2)):
            made = at2_text(motion, component).splitlines()
            kept = path.read_text().splitlines()
            assert made[:4] == kept[:4]
            values = [np.array(" ".join(lines[4:]).split(), float) for lines in (made, kept)]
            assert np.abs(values[0] - values[1]).max() <= 1e-6 * np.abs(values[1]).max()


def test_generating_twice_gives_identical_bytes():
    first, second = (
        [at2_text(motion, 1) + at2_text(motion, 2) for _, motion in islice(default_motions(), 2)]
        for _ in range(2)
    )
    assert first == second


def test_suite_has_40_readable_motions_of_at_most_25_s(suite):
    assert len(suite) == COUNT
    assert ((suite["npts"] - 1) * suite["dt_s"] <= 25.0).all()


def test_motions_end_with_5_s_at_rest(suite):
    for _, row in suite.iterrows():
        for name in ("accel_1_mps2", "accel_2_mps2"):
            tail = round(5.0 / row["dt_s"])
            assert np.all(row[name][-tail:] == 0.0)
            velocity = np.cumsum(row[name]) * row["dt_s"]
            assert abs(velocity[-1]) < 1e-6 * np.abs(velocity).max()


def test_factors_stay_moderate_and_spread_the_levels(suite):
    assert suite["scale"].between(*FACTOR_LIMITS).all()
    for count in (8, 16, 40):
        level_g = np.sort((suite["scale"] * suite["im_saavg_rotd50_g"])[:count])
        share = np.log(level_g / 0.1) / np.log(15.0)
        # even spread: no quarter of the range holds more than its share by one step of a block
        counts, _ = np.histogram(share, bins=4, range=(0.0, 1.0))
        assert (np.abs(counts - count / 4) <= 1).all()


def test_neither_bridge_axis_is_favoured(suite):
    peaks = np.array(
        [
            [np.abs(row["accel_1_mps2"]).max(), np.abs(row["accel_2_mps2"]).max()]
            for _, row in suite.iterrows()
        ]
    )
    log_ratio = np.log(peaks[:, 0] / peaks[:, 1])
    # standard error of the mean ratio is about 0.3 / sqrt(40) = 0.05
    assert abs(log_ratio.mean()) < 0.15


def test_scale_factors_are_for_the_period_of_osb1():
    """If not: `skewbridge motions default-suite --out motions` (only the factors change)."""
    index = pd.read_csv(MOTIONS / "index.csv")
    assert index["scale_t1_s"].nunique() == 1
    assert load_bridge("osb1").t1_s == pytest.approx(index["scale_t1_s"][0], rel=1e-3)
