"""Analyses of a study from its configuration and the prepared motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.errors import InputError
from skewbridge.files.tables import read_table
from skewbridge.motions.intensity import IM_COLUMNS, scaled_measures
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.ida import Search, at_factor
from skewbridge.study.task import Task
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import parse_slug


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """Settings and motions that all variants of a study share.

    Attributes:
        folder: Folder of the study.
        suite: The ground motions with their factors.
        measures: Intensity measures at factor 1, by bridge (as the grid names it) and motion.
        incidence_deg: Angles of incidence.
        settings: Settings of the integration.
        options: Modelling options.
        search: Target of an IDA; None where the factors are given.
    """

    folder: StudyFolder
    suite: tuple[SuiteMotion, ...]
    measures: Mapping[tuple[str, str], dict[str, float]]
    incidence_deg: tuple[float, ...]
    settings: AnalysisSettings
    options: ModelOptions
    search: Search | None = None

    @classmethod
    def of(cls, study: StudyConfig, folder: StudyFolder | None = None) -> Self:
        """Return the setup of a study whose motions are prepared.

        Args:
            study: Its configuration.
            folder: Folder with the prepared motions; by default that of the study.

        Raises:
            InputError: The motions are not prepared, or by another version of the program.
        """
        folder = folder or StudyFolder(Path(study.results))
        motions = study.motions
        low_g, high_g = motions.level_range_g
        search = Search(
            demand=motions.ida_demand, threshold=motions.ida_threshold, low_g=low_g, high_g=high_g
        )
        return cls(
            folder=folder,
            suite=tuple(read_suite(folder.suite)),
            measures={
                (row["bridge"], row["motion_id"]): {name: row[name] for name in IM_COLUMNS}
                for row in read_table(folder.intensities).to_pylist()
            },
            incidence_deg=motions.incidence_deg,
            settings=study.analysis,
            options=study.model,
            search=search if motions.design == "ida" else None,
        )

    def tasks(self, slug: str) -> list[Task]:
        """Return the analyses of one variant.

        In an IDA there is one per motion, at the first factor of its search. The values of a
        variant on the axes of modelling options override the configured ones.

        Raises:
            InputError: The motions are not prepared for the bridge of the variant.
        """
        named = parse_slug(slug)
        files = {Path(bridge).stem: bridge for bridge, _ in self.measures}
        if named.bridge not in files:
            raise InputError(f"{slug}: the study has the bridges {', '.join(files)}")
        variant = replace(named, bridge=files[named.bridge])
        options = replace(self.options, **dict(variant.options))
        return [
            Task(
                variant=variant,
                motion=self._for_bridge(variant.bridge, motion),
                incidence_deg=angle,
                settings=self.settings,
                options=options,
            )
            for motion in self.suite
            for angle in self.incidence_deg
        ]

    def task_of(self, row: Mapping[str, Any]) -> Task | None:
        """Return the analysis of a row of the demands; None if the study does not have it.

        Raises:
            InputError: The bridge of the row is not in the study.
        """
        wanted = row["motion_id"], row["scale"], row["incidence_deg"]
        for task in self.tasks(row["variant"]):
            # a search chooses its factors
            own = task if self.search is None else at_factor(task, row["scale"])
            if (own.motion.motion.motion_id, own.motion.scale, own.incidence_deg) == wanted:
                return own
        return None

    def _for_bridge(self, bridge: str, motion: SuiteMotion) -> SuiteMotion:
        at_1 = self.measures[bridge, motion.motion.motion_id]
        scale = motion.scale
        if self.search is not None:
            scale = self.search.first_factor(replace(motion, scale=1.0, measures=dict(at_1)))
        return replace(motion, scale=scale, measures=scaled_measures(dict(at_1), scale))


def sampled(tasks: Sequence[Task], count: int) -> list[Task]:
    """Return a number of analyses of a variant, at equal quantiles of the scaled PGV."""
    ranked = sorted(tasks, key=_strength)
    parts = min(count, len(ranked))
    return [ranked[(2 * part + 1) * len(ranked) // (2 * parts)] for part in range(parts)]


def _strength(task: Task) -> tuple[float, str, float]:
    motion = task.motion
    return motion.measures["im_pgv_rotd50_mps"], motion.motion.motion_id, task.incidence_deg
