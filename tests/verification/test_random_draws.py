"""One draw of the properties per motion gives the curves of many draws per motion."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from skewbridge.fragility.curves import fit_study
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.study.analyses import StudySetup
from skewbridge.study.batch import analysed_row
from skewbridge.study.config import parse_config
from skewbridge.study.inputs import prepare_motions
from skewbridge.study.task import run_key
from skewbridge.variant.random_properties import UncertaintyConfig

ROOT = Path(__file__).parents[2]
SLUG = "osb1_cf_skew30_gap025_mu050"
MOTIONS, DRAWS = 40, 5  # 200 draws
STATES = ("column_drift", "column_curvature", "unseating", "bearing", "deck_displacement")


def rows_of(setup, seed, logs):
    ids = [motion.motion.motion_id for motion in setup.suite]
    drawn = replace(setup, draws=UncertaintyConfig(enabled=True, seed=seed).draws(ids))
    tasks = drawn.tasks(SLUG)
    return pd.DataFrame([analysed_row(task, run_key(task), logs) for task in tasks])


def curves_of(rows):
    states = [
        state
        for state in load_limit_states(ROOT / "config/limit_states.yaml")
        if state.component in STATES and state.demand in rows
    ]
    table = fit_study(rows, states, DEFAULTS)
    return table[table["method"] == "cloud"].set_index(["component", "limit_state"])


@pytest.mark.slow
def test_one_draw_per_motion_gives_medians_and_dispersion_of_200_draws(tmp_path):
    # 8 s of each motion: the comparison does not depend on the length
    motions = {"folder": str(ROOT / "motions"), "count": MOTIONS, "shaking_s": 8.0}
    study = parse_config({"results": str(tmp_path), "motions": motions})
    prepare_motions(study)
    setup = StudySetup.of(study)
    once = curves_of(rows_of(setup, 1, tmp_path))
    draws = [rows_of(setup, seed, tmp_path) for seed in range(2, 2 + DRAWS)]
    many = curves_of(pd.concat(draws, ignore_index=True))
    reached = (once["status"] == "ok") & (once["n_exceed"].between(8, MOTIONS - 8))
    assert reached.sum() >= 4
    theta = (once["theta"] / many["theta"])[reached]
    beta = (once["beta"] / many["beta"])[reached]
    assert np.abs(theta - 1.0).max() < 0.05, theta
    assert np.abs(beta - 1.0).max() < 0.10, beta
