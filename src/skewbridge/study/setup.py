"""From the configuration and the prepared motions to the analyses of a study."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Self

import pandas as pd
import pyarrow.parquet as pq

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.demands.tables import provenance, write_frame
from skewbridge.motions.conditioning import Conditioning
from skewbridge.motions.intensity import IM_COLUMNS, motion_measures, scaled_measures
from skewbridge.motions.levels import striped, unscaled_cloud
from skewbridge.motions.settings import MotionsConfig
from skewbridge.motions.suite import SuiteMotion, prepare_suite, read_suite, write_suite
from skewbridge.study.batch import Task, plan_tasks
from skewbridge.study.capacity_search import Search
from skewbridge.study.config import StudyConfig
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import parse_slug

logger = logging.getLogger(__name__)

#: The bridge whose conditioning period sets the factors of every study (design, section 5).
CONDITIONING_BRIDGE: Final = "osb1"


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """What all variants of a study share.

    Attributes:
        suite: The ground motions with their factors.
        measures: Intensity measures at factor 1, by bridge (as the grid names it) and motion.
        incidence_deg: Angles of incidence.
        settings: How to integrate.
        options: How to model.
        search: What an IDA searches for; None where the factors are given.
    """

    suite: tuple[SuiteMotion, ...]
    measures: Mapping[tuple[str, str], dict[str, float]]
    incidence_deg: tuple[float, ...]
    settings: AnalysisSettings
    options: ModelOptions
    search: Search | None = None

    @classmethod
    def from_config(cls, study: StudyConfig, motions: Mapping[str, Any]) -> Self:
        """Build the setup from the configuration and the prepared motions.

        Args:
            study: Of the sections, ``motions``, ``model`` and ``analysis`` count.
            motions: Paths of the files that `prepare_motions` wrote, by name.
        """
        intensities = pq.read_table(motions["intensities"]).to_pylist()
        return cls(
            suite=tuple(read_suite(Path(motions["suite"]))),
            measures={
                (row["bridge"], row["motion_id"]): {name: row[name] for name in IM_COLUMNS}
                for row in intensities
            },
            incidence_deg=study.motions.incidence_deg,
            settings=study.analysis,
            options=study.model,
            search=search_from(study.motions),
        )

    def tasks(self, slug: str) -> list[Task]:
        """Return the analyses of one variant; in an IDA one per motion, at the first factor.

        The values of a variant on the axes of modelling options stand above the configured ones.
        """
        named = parse_slug(slug)
        files = {Path(bridge).stem: bridge for bridge, _ in self.measures}
        variant = replace(named, bridge=files[named.bridge])
        suite = [self._for_bridge(variant.bridge, motion) for motion in self.suite]
        options = replace(self.options, **dict(variant.options))
        return plan_tasks(variant, suite, self.incidence_deg, self.settings, options)

    def _for_bridge(self, bridge: str, motion: SuiteMotion) -> SuiteMotion:
        at_1 = self.measures[bridge, motion.motion.motion_id]
        scale = motion.scale
        if self.search is not None:
            scale = self.search.first_factor(replace(motion, scale=1.0, measures=dict(at_1)))
        return replace(motion, scale=scale, measures=scaled_measures(dict(at_1), scale))


def search_from(motions: MotionsConfig) -> Search | None:
    """Return what an IDA searches for, or None for the other designs."""
    if motions.design != "ida":
        return None
    low_g, high_g = motions.level_range_g
    return Search(
        demand=motions.ida_demand, threshold=motions.ida_threshold, low_g=low_g, high_g=high_g
    )


def prepare_motions(
    motions: MotionsConfig, *, bridges: Sequence[str], suite_path: Path, intensities_path: Path
) -> None:
    """Read the motions, fix their factors, measure them for every bridge, write both tables.

    Raises:
        InputError: A folder or motion is missing or malformed, or a bridge is unknown.
    """
    low_g, high_g = motions.level_range_g
    t1_s = {bridge: load_bridge(bridge).t1_s for bridge in bridges}
    suite = prepare_suite(
        Path(motions.folder),
        count=motions.count,
        t1_s=load_bridge(CONDITIONING_BRIDGE).t1_s,
        level_range_g=(low_g, high_g),
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
    write_suite(designed, suite_path)
    distinct = {motion.motion.motion_id: motion.motion for motion in read_suite(suite_path)}
    intensities = [
        {"bridge": bridge, "motion_id": name, **motion_measures(motion, period_s)}
        for bridge, period_s in t1_s.items()
        for name, motion in distinct.items()
    ]
    write_frame(pd.DataFrame(intensities), intensities_path, provenance())


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
