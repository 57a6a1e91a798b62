"""Histories of one bridge under one motion, without and with friction."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import pandas as pd

from skewbridge.demands.validity import is_complete
from skewbridge.files.digests import provenance
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.variant.variant import Variant, parse_slug

if TYPE_CHECKING:
    from skewbridge.study.analyses import StudySetup

TYPICAL_QUANTILE: Final = 0.75


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionPair:
    """Histories of one motion by a legend like ``friction 0.5``; variants without and with it."""

    variants: tuple[Variant, ...]
    motion_id: str
    by_friction: Mapping[str, pd.DataFrame]


def friction_pair(demands: pd.DataFrame) -> tuple[Variant, Variant] | None:
    """Return the most skewed bridge with the smallest gap, without and with the largest friction.

    None where the study has one friction only.
    """
    by_bridge_and_gap: dict[Variant, list[Variant]] = {}
    for slug in demands["variant"].unique():
        variant = parse_slug(str(slug))
        by_bridge_and_gap.setdefault(replace(variant, friction_pct=0), []).append(variant)
    pairs = {key: sorted(group) for key, group in by_bridge_and_gap.items() if len(group) > 1}
    if not pairs:
        return None
    chosen = pairs[max(pairs, key=lambda key: (abs(key.skew_deg), -key.gap_mm))]
    return chosen[0], chosen[-1]


def typical_motion(demands: pd.DataFrame, variant: Variant) -> str:
    """Return the motion with the upper-quartile deck displacement among the completed runs."""
    part = demands[demands["variant"] == variant.slug]
    completed = part[is_complete(part)]
    ordered = (completed if len(completed) else part).sort_values("deck_disp_m")["motion_id"]
    return str(ordered.iloc[int(TYPICAL_QUANTILE * (len(ordered) - 1))])


def write_friction_pair(setup: "StudySetup", demands: Path, output: Path) -> None:
    """Repeat one analysis without and one with friction, and write their histories.

    The table has variant, motion_id and the histories. It has no rows where the study has one
    friction only, and none of a run that diverged.
    """
    # Here, because the processes that draw the figures do without OpenSees.
    from skewbridge.analysis.transient import analyse

    rows = read_frame(demands)
    pair = friction_pair(rows)
    if pair is None:
        write_frame(pd.DataFrame(), output, provenance())
        return
    motion_id = typical_motion(rows, pair[-1])
    runs: list[pd.DataFrame] = []
    for variant in pair:
        task = next(t for t in setup.tasks(variant.slug) if t.motion.motion.motion_id == motion_id)
        result = analyse(task.variant, task.excitation, task.settings, task.options, histories=True)
        histories = pd.DataFrame(result.histories or {})
        runs.append(histories.assign(variant=variant.slug, motion_id=motion_id))
    write_frame(pd.concat(runs, ignore_index=True), output, provenance())


def read_friction_pair(path: Path) -> FrictionPair | None:
    """Return the pair that `write_friction_pair` wrote, or None if there was none."""
    table = read_frame(path)
    if table.empty:
        return None
    runs = {parse_slug(str(slug)): rows for slug, rows in table.groupby("variant")}
    return FrictionPair(
        variants=tuple(runs),
        motion_id=str(table["motion_id"].iloc[0]),
        by_friction={
            f"friction {variant.friction:g}": rows.drop(columns=["variant", "motion_id"])
            .dropna(axis="columns", how="all")
            .reset_index(drop=True)
            for variant, rows in runs.items()
        },
    )
