"""The shipped suite is what its generator makes, within its promises."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from skewbridge.bridge.catalogue import load_bridge
from skewbridge.errors import InputError
from skewbridge.motions.formats import at2_text, write_at2
from skewbridge.motions.index import list_motions
from skewbridge.motions.levels import FACTOR_LIMITS, LEVEL_RANGE_G
from skewbridge.motions.read import read_motion
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.suite import prepare_suite, read_entry
from skewbridge.motions.synthesis import generate
from skewbridge.motions.synthesis.ddk18 import meets_its_times
from skewbridge.motions.synthesis.generate import (
    COUNT,
    STORED,
    default_motions,
    drawn_parameters,
    made_motion,
)
from skewbridge.units import G_MPS2

MOTIONS = Path(__file__).parents[2] / "motions"
SOME = STORED + 8  # a block of those that are made, too
MADE = [entry for entry in list_motions(MOTIONS) if not entry.components]


@pytest.fixture(scope="module")
def suite() -> pd.DataFrame:
    index = pd.read_csv(MOTIONS / "index.csv")
    return prepare_suite(MOTIONS, count=SOME, t1_s=float(index["scale_t1_s"][0]))


def test_generating_again_gives_the_shipped_files():
    """Same bytes on the processor the files were made on.

    Elsewhere the last digits of exp and sin may differ: values agree to 1e-6 of the peak.
    """
    for each, entry in zip(default_motions(3), list_motions(MOTIONS), strict=False):
        motion = each.cut
        assert motion.motion_id == entry.motion_id
        for component, (path, _) in enumerate(entry.components, start=1):
            made = at2_text(motion, component).splitlines()
            kept = path.read_text().splitlines()
            assert made[:4] == kept[:4]
            values = [np.array(" ".join(lines[4:]).split(), float) for lines in (made, kept)]
            assert np.abs(values[0] - values[1]).max() <= 1e-6 * np.abs(values[1]).max()


def test_suite_has_40_stored_and_88_generated_motions():
    entries = list_motions(MOTIONS)
    assert [bool(entry.components) for entry in entries] == [True] * STORED + [False] * 88
    assert len(entries) == COUNT
    assert len({entry.sha256 for entry in entries}) == COUNT
    numbers = [entry.made_from_number for entry in MADE]
    assert numbers == sorted(set(numbers))


def test_motions_last_at_most_25_s(suite):
    assert len(suite) == SOME
    assert ((suite["npts"] - 1) * suite["dt_s"] <= 25.0).all()


def test_motions_end_with_5_s_at_rest(suite):
    for _, row in suite.iterrows():
        for name in ("accel_1_mps2", "accel_2_mps2"):
            tail = round(5.0 / row["dt_s"])
            assert np.all(row[name][-tail:] == 0.0)
            velocity = np.cumsum(row[name]) * row["dt_s"]
            if row["motion_id"] in {entry.motion_id for entry in MADE}:
                # a sum of 2000 values rounded to 1e-7 g, four standard deviations of it
                rest = 4.0 * 1e-7 * G_MPS2 * row["dt_s"] * np.sqrt(2000 / 12)
            else:
                rest = 1e-6 * np.abs(velocity).max()
            assert abs(velocity[-1]) < rest


def test_factors_stay_moderate_and_spread_the_levels(suite):
    assert suite["scale"].between(*FACTOR_LIMITS).all()
    low_g, high_g = LEVEL_RANGE_G
    for count in (8, 16, SOME):
        level_g = np.sort((suite["scale"] * suite["im_saavg_rotd50_g"])[:count])
        share = np.log(level_g / low_g) / np.log(high_g / low_g)
        # even spread: no quarter of the range holds more than its share by one step of a block
        counts, _ = np.histogram(share, bins=4, range=(0.0, 1.0))
        assert (np.abs(counts - count / 4) <= 1).all()


def test_components_are_equally_strong_on_average(suite):
    peaks = np.array(
        [
            [np.abs(row["accel_1_mps2"]).max(), np.abs(row["accel_2_mps2"]).max()]
            for _, row in suite.iterrows()
        ]
    )
    log_ratio = np.log(peaks[:, 0] / peaks[:, 1])
    # standard error of the mean ratio is about 0.3 / sqrt(40) = 0.05
    assert abs(log_ratio.mean()) < 0.15


def test_scale_factors_use_the_period_of_osb1():
    """If not: `skewbridge motions default-suite --out motions` (only the factors change)."""
    index = pd.read_csv(MOTIONS / "index.csv")
    assert index["scale_t1_s"].nunique() == 1
    assert load_bridge("osb1").t1_s == pytest.approx(index["scale_t1_s"][0], rel=1e-3)


def test_stored_factors_are_moderate_and_match_the_levels():
    index = pd.read_csv(MOTIONS / "index.csv")
    assert index["scale"].between(*FACTOR_LIMITS).all()
    assert {*index["scale_low_g"], *index["scale_high_g"]} == set(LEVEL_RANGE_G)


def test_generated_motion_equals_its_files(tmp_path):
    made = read_entry(MADE[0])
    read = read_motion(*write_at2(made, tmp_path))
    assert made.sha256 == read.sha256 == MADE[0].sha256
    assert (made.motion_id, made.dt_s) == (read.motion_id, read.dt_s)
    for one, other in zip(made.components, read.components, strict=True):
        assert one.tobytes() == other.tobytes()


def test_generated_motion_does_not_depend_on_the_last_digits_of_the_processor(monkeypatch):
    """They differ by 1e-14 g between processors; here by ten times as much."""
    synthesize = generate.synthesize
    rng = np.random.default_rng(1)

    def elsewhere(*arguments: object, **options: object) -> GroundMotion:
        motion = synthesize(*arguments, **options)
        return motion.mapped(lambda accel: accel + rng.uniform(-1, 1, accel.size) * 1e-13 * G_MPS2)

    number = MADE[-1].made_from_number
    here = made_motion(number)
    monkeypatch.setattr(generate, "synthesize", elsewhere)
    there = made_motion(number)
    assert there.sha256 == here.sha256 == MADE[-1].sha256
    for one, other in zip(here.components, there.components, strict=True):
        assert one.tobytes() == other.tobytes()


def test_motions_with_an_inexact_envelope_are_not_generated():
    """Where a search stops that meets nothing differs between processors: 6 and 7 are stored."""

    def is_exact(number: int) -> bool:
        drawn, _ = drawn_parameters(generate.SCENARIO, index=number - 1, seed=generate.SEED)
        return meets_its_times(drawn.component_1) and meets_its_times(drawn.component_2)

    assert not is_exact(6)
    assert not is_exact(7)
    assert all(is_exact(entry.made_from_number) for entry in MADE[::10])


def test_generated_motion_with_another_digest_is_refused():
    with pytest.raises(InputError, match="other libraries"):
        read_entry(replace(MADE[0], sha256="0" * 64))


@pytest.mark.slow
def test_every_generated_motion_has_the_digest_of_the_index():
    for entry in MADE:
        read_entry(entry)
