"""The motions of a study: read, measured, scaled and kept in one parquet table."""

import logging
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from skewbridge.errors import InputError, raise_all
from skewbridge.motions.conditioning import Conditioning
from skewbridge.motions.index import IndexEntry, list_motions
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.paper_records import refuse_false_waho
from skewbridge.motions.prepared import suite_row
from skewbridge.motions.read import join_traces, read_trace
from skewbridge.motions.record import GroundMotion
from skewbridge.motions.scaling import BLOCK, FACTOR_LIMITS, block_factors
from skewbridge.motions.settings import LEVEL_MEASURE, LEVEL_RANGE_G

logger = logging.getLogger(__name__)


def read_entry(entry: IndexEntry) -> GroundMotion:
    """Read one listed motion, or make it; what the index knows goes before the file headers.

    Raises:
        InputError: Unreadable files, a digest that differs, a false claim to be the WAHO record.
    """
    motion = _from_files_or_rule(entry)
    if entry.sha256 and entry.sha256 != motion.sha256:
        what, why = "its values", "other libraries?"
        if motion.files:
            what, why = f"the files {' and '.join(motion.files)}", "changed files?"
        raise InputError(
            f"motion {entry.motion_id}: {what} "
            f"have sha256 {motion.sha256[:12]}..., the index says {entry.sha256[:12]}...: "
            f"{why} run `skewbridge motions check --write` to accept them",
            motion_id=entry.motion_id,
        )
    motion = replace(
        motion,
        event=entry.event or motion.event,
        station=entry.station or motion.station,
        magnitude=entry.magnitude,
        distance_km=entry.distance_km,
        vs30_mps=entry.vs30_mps,
        azimuth_1_deg=_known(entry.azimuth_1_deg, motion.azimuth_1_deg),
        azimuth_2_deg=_known(entry.azimuth_2_deg, motion.azimuth_2_deg),
        source=entry.source,
    )
    refuse_false_waho(motion)
    return motion


def _from_files_or_rule(entry: IndexEntry) -> GroundMotion:
    if entry.made_from_number is not None:
        # Here, because a suite of files alone needs none of the model.
        from skewbridge.motions.synthesis.embedded import made_motion

        return replace(made_motion(entry.made_from_number), motion_id=entry.motion_id)
    one, two = (read_trace(path, given) for path, given in entry.components)
    return join_traces(one, two, motion_id=entry.motion_id)


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
    rows = [
        suite_row(motion, _known(kept, float(factor)), values)
        for kept, motion, factor, values in zip(factors, motions, computed, measures, strict=False)
    ]
    suite = pd.DataFrame(rows[:wanted])
    _log_doubts(motions[:wanted], suite["scale"].to_list())
    return suite


def entries_to_read(
    folder: Path, count: int | None, *, t1_s: float, level_range_g: tuple[float, float]
) -> tuple[list[IndexEntry], int]:
    """Return the motions that a suite of the first `count` reads, and how many it keeps.

    Where factors are computed, whole blocks are read even if not all are kept: a factor must not
    depend on the count.

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


def _log_doubts(motions: list[GroundMotion], scales: list[float]) -> None:
    """Log what the readers noticed, and factors beyond the customary limits."""
    low, high = FACTOR_LIMITS
    for motion, scale in zip(motions, scales, strict=True):
        for message in motion.messages:
            logger.warning("motion %s: %s", motion.motion_id, message)
        if not low <= scale <= high:
            logger.warning(
                "motion %s: factor %.3g is beyond %g to %g", motion.motion_id, scale, low, high
            )


def _stored_factor(entry: IndexEntry, level_range_g: tuple[float, float], t1_s: float) -> float:
    """Return the factor of the index, nan if none or made for other levels or another period."""
    made_for = (entry.scale_low_g, entry.scale_high_g, entry.scale_t1_s)
    fits = all(
        math.isnan(kept) or math.isclose(kept, asked, rel_tol=1e-6)
        for kept, asked in zip(made_for, (*level_range_g, t1_s), strict=True)
    )
    return entry.scale if fits else float("nan")


def _known(value: float, otherwise: float) -> float:
    return otherwise if math.isnan(value) else value
