"""The runs that a cloud of points shows where a study has more of them than can be told apart."""

from typing import Final

import pandas as pd

from skewbridge.fragility.settings import DEFAULTS

#: Runs of a figure.
MAX_SHOWN_RUNS: Final = 5000


def sampled_runs(demands: pd.DataFrame) -> pd.DataFrame:
    """Return the runs to be shown: all, or `MAX_SHOWN_RUNS` drawn at random, in their order."""
    if len(demands) <= MAX_SHOWN_RUNS:
        return demands
    return demands.sample(MAX_SHOWN_RUNS, random_state=DEFAULTS.seed).sort_index()


def sample_note(shown: int, runs: int) -> str:
    """Return what is said beside a cloud; empty where it shows every run."""
    return "" if shown == runs else f"{shown} of {runs} runs, drawn at random; fits are of all."
