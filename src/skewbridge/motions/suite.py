"""The motions of a study: read, measured, scaled and stored in one parquet table."""

import json
import logging
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.errors import InputError, raise_all
from skewbridge.files.digests import provenance
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.motions.conditioning import Conditioning
from skewbridge.motions.index import IndexEntry, list_motions
from skewbridge.motions.intensity import IM_COLUMNS, motion_measures, scaled_measures
from skewbridge.motions.levels import (
    BLOCK,
    FACTOR_LIMITS,
    LEVEL_MEASURE,
    LEVEL_RANGE_G,
    block_factors,
)
from skewbridge.motions.read import join_traces, read_trace, refuse_false_waho
from skewbridge.motions.record import NUMBER_FIELDS, TEXT_FIELDS, GroundMotion, SuiteMotion

logger = logging.getLogger(__name__)


def read_entry(entry: IndexEntry) -> GroundMotion:
    """Read or generate one listed motion; the index overrides the file headers.

    Raises:
        InputError: Unreadable files, a digest that differs, a false claim to be the WAHO record.
    """
    if entry.made_from_number is not None:
        # Here: a suite of files alone needs none of the model.
        from skewbridge.motions.synthesis.generate import made_motion

        motion = replace(made_motion(entry.made_from_number), motion_id=entry.motion_id)
    else:
        one, two = (read_trace(path, given) for path, given in entry.components)
        motion = join_traces(one, two, motion_id=entry.motion_id)
    if entry.sha256 and entry.sha256 != motion.sha256:
        what, why = "its values", "other libraries?"
        if motion.files:
            what, why = f"the files {' and '.join(motion.files)}", "changed files?"
        raise InputError(
            f"motion {entry.motion_id}: {what} "
            f"have sha256 {motion.sha256[:12]}..., the index has {entry.sha256[:12]}...: "
            f"{why} run `skewbridge motions check --write` to accept them",
            motion_id=entry.motion_id,
        )
    motion = replace(motion, **entry.metadata)
    refuse_false_waho(motion)
    return motion


def read_entries(entries: Sequence[IndexEntry]) -> list[GroundMotion]:
    """Read listed motions.

    Raises:
        InputError: As `read_entry`; names every motion that is wrong.
    """
    motions: list[GroundMotion] = []
    faults: list[InputError] = []
    for entry in entries:
        try:
            motions.append(read_entry(entry))
        except InputError as error:
            faults.append(error)
    raise_all(faults)
    return motions


def prepare_suite(
    folder: Path,
    *,
    count: int | None = None,
    t1_s: float,
    level_range_g: tuple[float, float] = LEVEL_RANGE_G,
    conditioning: Conditioning | None = None,
) -> pd.DataFrame:
    """Read, measure and scale the motions of a folder.

    Args:
        folder: Folder with an `index.csv`, or with component files that pair by name.
        count: How many motions, from the first; None for all.
        t1_s: Conditioning period of the bridge in s, for Sa(T1) and Sa_avg.
        level_range_g: Sa_avg the motions are spread over where the index has no factor for it.
        conditioning: Cutting and resampling, none by default.

    Returns:
        One row per motion in suite order: metadata, scale, the intensity columns at factor 1,
        accel_1_mps2 and accel_2_mps2 (lists), messages.

    Raises:
        InputError: Fewer motions than asked for, or anything wrong with one of them, by name.
    """
    entries, wanted = entries_to_read(folder, count, t1_s=t1_s, level_range_g=level_range_g)
    factors = [_stored_factor(entry, level_range_g, t1_s) for entry in entries]
    treat = (conditioning or Conditioning()).apply
    motions = [treat(motion) for motion in read_entries(entries)]
    measures = [motion_measures(motion, t1_s) for motion in motions]
    computed = block_factors([row[LEVEL_MEASURE] for row in measures], level_range_g)
    low, high = FACTOR_LIMITS
    rows: list[dict[str, object]] = []
    for stored, motion, factor, values in zip(
        factors[:wanted], motions[:wanted], computed, measures, strict=False
    ):
        scale = float(factor) if math.isnan(stored) else stored
        rows.append(
            {
                "motion_id": motion.motion_id,
                "scale": scale,
                "npts": motion.npts,
                **{name: getattr(motion, name) for name in (*TEXT_FIELDS, *NUMBER_FIELDS)},
                **values,
                "accel_1_mps2": motion.accel_1_mps2,
                "accel_2_mps2": motion.accel_2_mps2,
                "messages": json.dumps(list(motion.messages)),
            }
        )
        for message in motion.messages:
            logger.warning("motion %s: %s", motion.motion_id, message)
        if not low <= scale <= high:
            logger.warning(
                "motion %s: factor %.3g is outside %g to %g", motion.motion_id, scale, low, high
            )
    return pd.DataFrame(rows)


def entries_to_read(
    folder: Path, count: int | None, *, t1_s: float, level_range_g: tuple[float, float]
) -> tuple[list[IndexEntry], int]:
    """Return the motions to read for a suite of the first `count`, and how many are kept.

    Where factors are computed, whole blocks are read: a factor must not depend on the count.

    Raises:
        InputError: Fewer motions than asked for, no folder, a broken index.
    """
    entries = list_motions(folder)
    wanted = len(entries) if count is None else count
    if not 1 <= wanted <= len(entries):
        raise InputError(
            f"motions.count = {wanted}, but {folder} has {len(entries)} motions", folder=str(folder)
        )
    factors = [_stored_factor(entry, level_range_g, t1_s) for entry in entries[:wanted]]
    blocks = any(math.isnan(factor) for factor in factors)
    return entries[: math.ceil(wanted / BLOCK) * BLOCK if blocks else wanted], wanted


def write_suite(suite: pd.DataFrame, path: Path) -> None:
    """Write the table of `prepare_suite` as parquet."""
    write_frame(suite, path, provenance())


def read_suite(path: Path) -> list[SuiteMotion]:
    """Return the motions of a table written by `write_suite`, in suite order.

    Raises:
        InputError: No such table, or one of another version of the program.
    """
    motions: list[SuiteMotion] = []
    for row in read_frame(path).to_dict("records"):
        known: dict[str, Any] = {name: str(row[name]) for name in TEXT_FIELDS}
        known |= {name: float(row[name]) for name in NUMBER_FIELDS}
        motion = GroundMotion(
            **known,
            accel_1_mps2=row["accel_1_mps2"],
            accel_2_mps2=row["accel_2_mps2"],
            messages=tuple(json.loads(row["messages"])),
        )
        scale = float(row["scale"])
        measures = scaled_measures({name: float(row[name]) for name in IM_COLUMNS}, scale)
        motions.append(SuiteMotion(motion=motion, scale=scale, measures=measures))
    return motions


def _stored_factor(entry: IndexEntry, level_range_g: tuple[float, float], t1_s: float) -> float:
    """Return the factor of the index, nan if it has none for these levels and this period."""
    made_for = (entry.scale_low_g, entry.scale_high_g, entry.scale_t1_s)
    fits = all(
        math.isnan(kept) or math.isclose(kept, asked, rel_tol=1e-6)
        for kept, asked in zip(made_for, (*level_range_g, t1_s), strict=True)
    )
    return entry.scale if fits else float("nan")
