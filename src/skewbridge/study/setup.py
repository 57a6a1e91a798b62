"""From the configuration and the prepared motions to the analyses of a study."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.options import ModelOptions
from skewbridge.motions.intensity import IM_COLUMNS, scaled_measures
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.provenance.tables import read_table
from skewbridge.study.capacity_search import Search
from skewbridge.study.config import AnalysisConfig, ModelConfig, MotionsConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.task import Task
from skewbridge.units import MM
from skewbridge.variant.variant import parse_slug


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """What all variants of a study share.

    Attributes:
        folder: Where the study lies.
        suite: The ground motions with their factors.
        measures: Intensity measures at factor 1, by bridge and motion.
        incidence_deg: Angles of incidence.
        settings: How to integrate.
        options: How to model.
        search: What an IDA searches for; None where the factors are given.
    """

    folder: StudyFolder
    suite: tuple[SuiteMotion, ...]
    measures: Mapping[tuple[str, str], dict[str, float]]
    incidence_deg: tuple[float, ...]
    settings: AnalysisSettings
    options: ModelOptions
    search: Search | None = None

    @classmethod
    def from_sections(cls, sections: Mapping[str, Any], folder: StudyFolder) -> Self:
        """Build the setup from sections of the configuration and the prepared motions.

        Args:
            sections: ``motions``, ``model`` and ``analysis`` of the configuration.
            folder: Where the study lies, with its motions prepared.

        Raises:
            InputError: The motions are not prepared, or by another version of the program.
        """
        shaking = MotionsConfig(**sections["motions"])
        intensities = read_table(folder.intensities).to_pylist()
        return cls(
            folder=folder,
            suite=tuple(read_suite(folder.suite)),
            measures={
                (row["bridge"], row["motion_id"]): {name: row[name] for name in IM_COLUMNS}
                for row in intensities
            },
            incidence_deg=tuple(shaking.incidence_deg),
            settings=settings_from(AnalysisConfig(**sections["analysis"])),
            options=options_from(ModelConfig(**sections["model"])),
            search=search_from(shaking),
        )

    def tasks(self, slug: str) -> list[Task]:
        """Return the analyses of one variant, the longest motions first (better use of the cores).

        In an IDA there is one per motion, at the first factor of its search.
        """
        variant = parse_slug(slug)
        tasks = [
            Task(
                variant=variant,
                motion=self._for_bridge(variant.bridge, motion),
                incidence_deg=angle,
                settings=self.settings,
                options=self.options,
            )
            for motion in self.suite
            for angle in self.incidence_deg
        ]
        return sorted(tasks, key=lambda task: -task.motion.motion.duration_s)

    def _for_bridge(self, bridge: str, motion: SuiteMotion) -> SuiteMotion:
        at_1 = self.measures[bridge, motion.motion.motion_id]
        scale = motion.scale
        if self.search is not None:
            scale = self.search.first_factor(replace(motion, scale=1.0, measures=dict(at_1)))
        return replace(motion, scale=scale, measures=scaled_measures(dict(at_1), scale))


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


def search_from(motions: MotionsConfig) -> Search | None:
    """Return what an IDA searches for, or None for the other designs."""
    if motions.design != "ida":
        return None
    low_g, high_g = motions.level_range_g
    return Search(
        demand=motions.ida_demand, threshold=motions.ida_threshold, low_g=low_g, high_g=high_g
    )
