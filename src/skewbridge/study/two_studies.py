"""Comparison of two studies whose runs are paired."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.demands.columns import demands_for
from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame
from skewbridge.fragility.demand_table import (
    BRIDGE_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    models_of,
    prepared,
    read_demands,
)
from skewbridge.fragility.effects import (
    Pairs,
    demand_effects,
    effect_table,
    median_effects,
    run_pairs,
)
from skewbridge.fragility.limit_states import LimitState, load_limit_states, with_column_failure
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.study.folder import StudyFolder
from skewbridge.study.results import demands_file

#: In place of an axis in the tables of a comparison: 0 is the first study, 1 the second.
STUDY: Final = "study"


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyComparison:
    """Changes from a first study to a second one; effects have the columns `effect_columns`.

    Attributes:
        counts: Pairs, runs of one study alone, variants and motions in both, equal pairs.
        other_motions: Motions that have one name in both studies but are not the same; their runs
            are left out.
    """

    demands: pd.DataFrame
    medians: pd.DataFrame
    counts: dict[str, int]
    other_motions: tuple[str, ...] = ()


def compare_studies(
    first: Path,
    second: Path,
    limit_states: Path,
    *,
    im: str = DEFAULTS.im,
    margin: float = DEFAULTS.margin,
) -> StudyComparison:
    """Compare two studies, each given by its folder or its demands; the first is divided by.

    Motions are matched by the digests of their files if both studies have a suite, otherwise by
    name. The medians are those of the limit states, with intensity `im`.

    Raises:
        InputError: A table or column is missing, a value unusable, or nothing in common.
    """
    if not 0.0 < margin < 1.0:
        raise InputError(f"margin must be within 0..1, got {margin:g}")
    states = load_limit_states(limit_states)
    other = _other_motions(first, second)
    tables: list[pd.DataFrame] = []
    for study in (first, second):
        path = study if study.is_file() else demands_file(study)
        table = read_demands(path, im, [state.demand for state in states])
        if im not in table.columns:
            raise InputError(f"{path}: no column {im!r}", column=im)
        tables.append(table[~table["motion_id"].isin(other)])
    settings = replace(DEFAULTS, im=im, margin=margin, median_margin=margin)
    return replace(compare_demands(tables[0], tables[1], states, settings), other_motions=other)


def _other_motions(first: Path, second: Path) -> tuple[str, ...]:
    """Return the motions of one name whose files differ."""
    suites = [StudyFolder(path).suite for path in (first, second)]
    if not all(suite.is_file() for suite in suites):
        return ()
    tables = [read_frame(suite).drop_duplicates("motion_id") for suite in suites]
    both = tables[0].merge(tables[1], on="motion_id", suffixes=("", "_other"))
    return tuple(map(str, both["motion_id"][both["sha256"] != both["sha256_other"]]))


def compare_demands(
    first: pd.DataFrame,
    second: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings,
) -> StudyComparison:
    """Pair the runs of two tables of demands and return the changes from the first to the second.

    Runs are paired where bridge, abutment model, all axes, motion, scale and incidence agree. Pairs
    in which one run ended early count as bounds, as in `demand_effects`.
    """
    shared = set(first.columns) & set(second.columns)
    states = [s for s in with_column_failure(limit_states, shared) if s.demand in shared]
    names = list(demands_for("effect", sorted(shared)))
    columns = list(dict.fromkeys([*names, *(state.demand for state in states), settings.im]))
    both = pd.concat([first.assign(**{STUDY: 0}), second.assign(**{STUDY: 1})], ignore_index=True)
    table = run_pairs(both, STUDY, columns)
    if table.empty:
        raise InputError(_nothing_shared(first, second, axis_names(both)))
    change = {"axis": STUDY, "from_value": 0.0, "to_value": 1.0}
    effects: list[dict[str, Any]] = []
    for model, part in models_of(table):
        pairs = Pairs.of(model | change, part)
        effects += demand_effects(pairs, names=names, settings=settings, reference_im={})[0]
    demands = effect_table(both, effects)
    key = [*BRIDGE_COLUMNS, *axis_names(both), *LOADING_COLUMNS]
    paired = both.merge(table[key].drop_duplicates(), on=key)
    runs = prepared(paired, [state.demand for state in states], settings).table
    top, bottom = (table[[f"{name}_{end}" for name in names]] for end in ("to", "from"))
    equal = (top == bottom.to_numpy()) | (top.isna() & bottom.isna().to_numpy())
    return StudyComparison(
        demands=demands,
        medians=median_effects(runs, states, settings, axes=[STUDY]),
        counts={
            "pairs": len(table),
            "only_first": len(first) - len(table),
            "only_second": len(second) - len(table),
            "variants": len(table[[*BRIDGE_COLUMNS, *axis_names(both)]].drop_duplicates()),
            "motions": int(table["motion_id"].nunique()),
            "equal_pairs": int(equal.all(axis=1).sum()),
        },
    )


def _nothing_shared(first: pd.DataFrame, second: pd.DataFrame, axes: Sequence[str]) -> str:
    """Return why no runs can be paired: the variants, motions and loadings that tables share."""
    kinds = {
        "variants": [*BRIDGE_COLUMNS, *axes],
        "motions": ["motion_id"],
        "motions with the same scale and incidence": [*LOADING_COLUMNS],
    }
    shared: list[str] = []
    for name, columns in kinds.items():
        one, other = (t.reindex(columns=columns).drop_duplicates() for t in (first, second))
        shared.append(f"{len(one.merge(other))} {name}")
    return (
        f"the studies have no run in common; they share {', '.join(shared)} (the scale of a motion "
        "follows from the number of motions and the range of levels)"
    )
