"""From the configuration to the analyses of a study."""

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Self

import pandas as pd
import pyarrow.parquet as pq

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.bridge.options import ModelOptions
from skewbridge.demands.batch import Task, plan_tasks, run_key, run_tasks
from skewbridge.demands.journal import open_journal, read_journal
from skewbridge.demands.parquet import provenance, write_demands, write_frame
from skewbridge.demands.progress import StudyProgress, study_state
from skewbridge.motions.intensity import IM_COLUMNS, motion_measures, scaled_measures
from skewbridge.motions.suite import SuiteMotion, prepare_suite, read_suite, write_suite
from skewbridge.study.config import AnalysisConfig, ModelConfig, MotionsConfig
from skewbridge.study.provenance import digest_of
from skewbridge.study.variant import parse_slug
from skewbridge.units import MM

logger = logging.getLogger(__name__)

#: The bridge whose conditioning period sets the factors of every study (design, section 5).
CONDITIONING_BRIDGE: Final = "osb1"
JOURNALS: Final = Path("results/journal")
SOLVER_LOGS: Final = Path("results/logs/solver")


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """What all variants of a study share.

    Attributes:
        suite: The ground motions with their factors.
        measures: Intensity measures at the factor, by bridge and motion.
        incidence_deg: Angles of incidence.
        settings: How to integrate.
        options: How to model.
    """

    suite: tuple[SuiteMotion, ...]
    measures: Mapping[tuple[str, str], dict[str, float]]
    incidence_deg: tuple[float, ...]
    settings: AnalysisSettings
    options: ModelOptions

    @classmethod
    def from_sections(cls, sections: Mapping[str, Any], motions: Mapping[str, Any]) -> Self:
        """Build the setup from sections of the configuration and the prepared motions.

        Args:
            sections: ``incidence_deg``, ``model`` and ``analysis`` of the configuration.
            motions: Paths of the files that `prepare_motions` wrote, by name.
        """
        analysis = AnalysisConfig(**sections["analysis"])
        suite = tuple(read_suite(Path(motions["suite"])))
        scales = {motion.motion.motion_id: motion.scale for motion in suite}
        intensities = pq.read_table(motions["intensities"]).to_pylist()
        return cls(
            suite=suite,
            measures={
                (row["bridge"], row["motion_id"]): scaled_measures(
                    {name: row[name] for name in IM_COLUMNS}, scales[row["motion_id"]]
                )
                for row in intensities
            },
            incidence_deg=tuple(sections["incidence_deg"]),
            settings=settings_from(analysis),
            options=options_from(ModelConfig(**sections["model"])),
        )

    def tasks(self, slug: str) -> list[Task]:
        """Return the analyses of one variant."""
        variant = parse_slug(slug)
        suite = [
            replace(motion, measures=self.measures[variant.bridge, motion.motion.motion_id])
            for motion in self.suite
        ]
        return plan_tasks(variant, suite, self.incidence_deg, self.settings, self.options)


def settings_from(analysis: AnalysisConfig) -> AnalysisSettings:
    """Return the settings of the transient analysis that the configuration asks for."""
    return AnalysisSettings(
        scheme=analysis.scheme,
        dt_s=analysis.dt_s,
        duration_s=analysis.duration_s,
        free_vibration_s=analysis.free_vibration_s,
        collapse_drift_ratio=analysis.collapse_drift_ratio,
        collapse_deck_disp_m=analysis.collapse_deck_disp_m,
    )


def options_from(model: ModelConfig) -> ModelOptions:
    """Return the modelling options that the configuration asks for."""
    return ModelOptions(
        arrays=model.arrays,
        column_integration=model.column_integration,
        transverse_gap_m=model.transverse_gap_mm * MM,
        cohesion_n=model.cohesion_n,
        backwall_points=model.backwall_points,
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
    )
    logger.info(
        "%d motions, factors %.2f to %.2f", len(suite), suite["scale"].min(), suite["scale"].max()
    )
    write_suite(suite, suite_path)
    read = read_suite(suite_path)
    intensities = [
        {
            "bridge": bridge,
            "motion_id": motion.motion.motion_id,
            **motion_measures(motion.motion, period_s),
        }
        for bridge, period_s in t1_s.items()
        for motion in read
    ]
    write_frame(pd.DataFrame(intensities), intensities_path, provenance())


def write_plan(setup: StudySetup, variants: Sequence[str], path: Path) -> None:
    """Write the keys of all analyses of the study, by variant."""
    keys = {slug: [run_key(task) for task in setup.tasks(slug)] for slug in variants}
    path.write_text(json.dumps(keys, indent=1), encoding="utf-8")
    state = study_state(keys, JOURNALS)
    logger.info(
        "%d variants, %d analyses, %d of them done", state.variants, state.analyses, state.done
    )


def analyse_variant(setup: StudySetup, slug: str, *, plan: Path, n_jobs: int, output: Path) -> None:
    """Run what is missing of one variant and write its demands.

    Args:
        setup: What the variants share.
        slug: Name of the variant.
        plan: The keys of the whole study, for the progress bar.
        n_jobs: Worker processes.
        output: Parquet file with the rows of this variant.

    Raises:
        InputError: Another process analyses this variant.
    """
    tasks = setup.tasks(slug)
    keys = json.loads(plan.read_text(encoding="utf-8"))
    journal_path = JOURNALS / f"{slug}.jsonl"
    with (
        open_journal(journal_path) as journal,
        StudyProgress(study_state(keys, JOURNALS), slug) as progress,
    ):
        rows = run_tasks(
            tasks,
            journal,
            read_journal(journal_path),
            n_jobs=n_jobs,
            log_folder=SOLVER_LOGS,
            on_finished=progress.advance,
        )
    digest = digest_of(*(row["run_key"] for row in rows))
    write_demands(rows, output, provenance(analyses_digest=digest))
