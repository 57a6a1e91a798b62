"""The same bridge under the same motion, without and with friction: histories for the figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq

from skewbridge.analysis.transient import analyse
from skewbridge.demands.tables import provenance, write_frame
from skewbridge.study.setup import StudySetup
from skewbridge.variant.variant import Variant, parse_slug

TYPICAL_QUANTILE = 0.75


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionPair:
    """Two histories that differ by friction only.

    Attributes:
        variants: Without, and with most friction.
        motion_id: Their motion.
        histories: History table of each, in the same order.
    """

    variants: tuple[Variant, ...]
    motion_id: str
    histories: tuple[pd.DataFrame, ...]

    @property
    def by_friction(self) -> Mapping[str, pd.DataFrame]:
        """The histories by a label for legends, such as ``friction 0.5``."""
        labels = (f"friction {variant.friction:g}" for variant in self.variants)
        return dict(zip(labels, self.histories, strict=True))


def chosen_variants(demands: pd.DataFrame) -> tuple[Variant, Variant] | None:
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


def write_friction_pair(setup: StudySetup, demands: pd.DataFrame, output: Path) -> None:
    """Repeat one analysis of each variant of the pair and write their histories.

    Args:
        setup: What the variants of the study share.
        demands: Demands table.
        output: Parquet file: the histories one below the other with a column ``variant``, the
            motion in the file metadata; without rows where the study has one friction only.
    """
    variants = chosen_variants(demands)
    if variants is None:
        write_frame(pd.DataFrame({"variant": []}, dtype=str), output, provenance())
        return
    motion_id = typical_motion(demands, variants[-1])
    tables: list[pd.DataFrame] = []
    for variant in variants:
        task = next(t for t in setup.tasks(variant.slug) if t.motion.motion.motion_id == motion_id)
        run = analyse(variant, task.excitation, task.settings, task.options, histories=True)
        tables.append(pd.DataFrame({"variant": variant.slug, **(run.histories or {})}))
    write_frame(pd.concat(tables), output, provenance(motion_id=motion_id))


def read_friction_pair(path: Path) -> FrictionPair | None:
    """Return what `write_friction_pair` wrote, or None where there was no pair."""
    table = pd.read_parquet(path)
    if table.empty:
        return None
    groups = dict(iter(table.groupby("variant", sort=False)))
    return FrictionPair(
        variants=tuple(parse_slug(str(slug)) for slug in groups),
        motion_id=(pq.read_schema(path).metadata or {})[b"motion_id"].decode(),
        histories=tuple(
            own.drop(columns="variant").reset_index(drop=True) for own in groups.values()
        ),
    )


def _skew_then_small_gap(group: Sequence[Variant]) -> tuple[int, int]:
    return abs(group[0].skew_deg), -group[0].gap_mm
