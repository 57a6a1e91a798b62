"""The tables of two studies, read for a comparison."""

from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.limit_states import load_limit_states
from skewbridge.fragility.results import Comparison, compare_demands, demands_file, read_demands
from skewbridge.fragility.settings import DEFAULTS
from skewbridge.provenance.tables import read_frame
from skewbridge.study.folder import StudyFolder


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """How two studies are compared.

    Attributes:
        limit_states: File of the limit states whose medians are compared.
        im: Column of the intensity of the medians.
        margin: Relative change that counts as negligible.
    """

    limit_states: Path
    im: str = DEFAULTS.im
    margin: float = DEFAULTS.margin


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyPair:
    """A comparison, and the motions that have one name in both studies but are not the same."""

    comparison: Comparison
    other_motions: tuple[str, ...]


def compare_studies(first: Path, second: Path, judgement: Judgement) -> StudyPair:
    """Compare two studies, each given by its folder or by its table of demands.

    Motions are the same if their files are (by digest) where both studies have their suite, and by
    name where they have not.

    Raises:
        InputError: A table or column is missing, a value unusable, or nothing in common.
    """
    if not 0.0 < judgement.margin < 1.0:
        raise InputError(f"margin must be within 0..1, got {judgement.margin:g}")
    states = load_limit_states(judgement.limit_states)
    wanted = [state.demand for state in states]
    files = [path if path.is_file() else demands_file(path) for path in (first, second)]
    tables = [read_demands(path, judgement.im, wanted) for path in files]
    for path, table in zip((first, second), tables, strict=True):
        if judgement.im not in table.columns:
            raise InputError(f"{path}: no column {judgement.im!r}", column=judgement.im)
    other = _other_motions(first, second)
    kept = [table[~table["motion_id"].isin(other)] for table in tables]
    margins = {"margin": judgement.margin, "median_margin": judgement.margin}
    settings = replace(DEFAULTS, im=judgement.im, **margins)
    found = compare_demands(kept[0], kept[1], states, settings)
    return StudyPair(comparison=found, other_motions=other)


def _other_motions(first: Path, second: Path) -> tuple[str, ...]:
    """Return the motions of one name whose files differ."""
    suites = [StudyFolder(path).suite for path in (first, second)]
    if not all(suite.is_file() for suite in suites):
        return ()
    digests = [_digests(suite) for suite in suites]
    shared = digests[0].index.intersection(digests[1].index)
    differ = (digests[0][shared] != digests[1][shared]).to_numpy()
    return tuple(map(str, shared[differ]))


def _digests(suite: Path) -> pd.Series:
    table = read_frame(suite).drop_duplicates("motion_id")
    return table.set_index("motion_id")["sha256"]
