"""The same bridge under the same motion, without and with friction, as histories to draw."""

from collections.abc import Sequence

import pandas as pd

from skewbridge.analysis.transient import analyse
from skewbridge.study.setup import StudySetup
from skewbridge.variant.variant import Variant, parse_slug

TYPICAL_QUANTILE = 0.75


def friction_pair(demands: pd.DataFrame) -> tuple[Variant, Variant] | None:
    """Return the most skewed bridge with the smallest gap, without and with most friction.

    Args:
        demands: Demands table.

    Returns:
        Two variants, or None where the study has one friction only.
    """
    by_place: dict[tuple[str, str, int, int], list[Variant]] = {}
    for slug in demands["variant"].unique():
        variant = parse_slug(str(slug))
        place = (variant.bridge, variant.abutment, variant.skew_deg, variant.gap_mm)
        by_place.setdefault(place, []).append(variant)
    pairs = [sorted(group) for group in by_place.values() if len(group) > 1]
    if not pairs:
        return None
    chosen = max(pairs, key=_skew_then_small_gap)
    return chosen[0], chosen[-1]


def typical_motion(demands: pd.DataFrame, variant: Variant) -> str:
    """Return the motion with the upper-quartile deck displacement among the completed runs."""
    part = demands[demands["variant"] == variant.slug]
    completed = part[part["status"] == "ok"]
    ordered = (completed if len(completed) else part).sort_values("deck_disp_m")["motion_id"]
    return str(ordered.iloc[int(TYPICAL_QUANTILE * (len(ordered) - 1))])


def pair_histories(
    setup: StudySetup, variants: Sequence[Variant], motion_id: str
) -> dict[str, pd.DataFrame]:
    """Repeat one analysis of each variant with histories.

    Args:
        setup: What the variants of the study share.
        variants: The variants.
        motion_id: The motion.

    Returns:
        Histories by friction, in the order of the variants; a run that diverged has none.
    """
    runs: dict[str, pd.DataFrame] = {}
    for variant in variants:
        task = next(t for t in setup.tasks(variant.slug) if t.motion.motion.motion_id == motion_id)
        result = analyse(
            variant,
            task.excitation,
            task.settings,
            task.options,
            histories=True,
        )
        if result.histories is not None:
            runs[f"friction {variant.friction:g}"] = pd.DataFrame(result.histories)
    return runs


def _skew_then_small_gap(group: Sequence[Variant]) -> tuple[int, int]:
    return abs(group[0].skew_deg), -group[0].gap_mm
