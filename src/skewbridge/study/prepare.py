"""The motions of a study: read once, with their factors and their intensity for every bridge."""

import logging
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from skewbridge.motions.conditioning import Conditioning
from skewbridge.motions.intensity import motion_measures
from skewbridge.motions.levels import MotionsConfig, striped, unscaled_cloud
from skewbridge.motions.suite import prepare_suite, read_suite, write_suite
from skewbridge.provenance.tables import provenance, write_frame
from skewbridge.study.folder import StudyFolder

logger = logging.getLogger(__name__)


def prepare_motions(
    motions: MotionsConfig,
    *,
    conditioning_t1_s: float,
    t1_s: Mapping[str, float],
    folder: StudyFolder,
) -> None:
    """Read the motions, fix their factors, measure them for every bridge, write both tables.

    Args:
        motions: The section of the configuration.
        conditioning_t1_s: Period that the factors are made with.
        t1_s: Conditioning period of each bridge of the study.
        folder: Where the study lies.

    Raises:
        InputError: A folder or motion is missing or malformed.
    """
    suite = prepare_suite(
        Path(motions.folder),
        count=motions.count,
        t1_s=conditioning_t1_s,
        level_range_g=motions.level_range_g,
        conditioning=Conditioning(shaking_s=motions.shaking_s),
    )
    designed = _designed(suite, motions)
    logger.info(
        "%d motions, %d rows, factors %.2f to %.2f",
        len(suite),
        len(designed),
        designed["scale"].min(),
        designed["scale"].max(),
    )
    write_suite(designed, folder.suite)
    distinct = {motion.motion.motion_id: motion.motion for motion in read_suite(folder.suite)}
    intensities = [
        {"bridge": bridge, "motion_id": name, **motion_measures(motion, period_s)}
        for bridge, period_s in t1_s.items()
        for name, motion in distinct.items()
    ]
    write_frame(pd.DataFrame(intensities), folder.intensities, provenance())


def _designed(suite: pd.DataFrame, motions: MotionsConfig) -> pd.DataFrame:
    if motions.design == "cloud":
        return unscaled_cloud(suite)
    if motions.design != "stripes":
        return suite
    low, high = motions.factor_limits
    table = striped(suite, motions.stripes_g, factor_limits=(low, high))
    if table.attrs["left_out"]:
        logger.warning(
            "%d of %d scaled motions are left out: their factor is beyond %g to %g",
            table.attrs["left_out"],
            len(suite) * len(motions.stripes_g),
            low,
            high,
        )
    return table
