"""Analyses of a study: their tasks from the configuration and the motions, and jobs that run them.

The journal of a job is its cache: an analysis that a journal of the study has is not repeated.
"""

import logging
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Final, Self

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.demands.tables import write_variant
from skewbridge.demands.validity import SuspectLimits
from skewbridge.errors import InputError
from skewbridge.files.tables import read_table
from skewbridge.motions.intensity import IM_COLUMNS, scaled_measures
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.statuses import FAILED
from skewbridge.study.batch import Search, Workers, at_factor, run_tasks, search_capacity
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import Row, open_journal, read_content, read_journals
from skewbridge.study.processes import PROGRESS_LOG
from skewbridge.study.task import Task, run_key
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.random_properties import DIRECTION, with_draw
from skewbridge.variant.variant import parse_slug

logger = logging.getLogger(__name__)

progress_logger = logging.getLogger(PROGRESS_LOG)

LOG_INTERVAL_S: Final = 60.0
PGV: Final = "im_pgv_rotd50_mps"
#: Time that a job waits for the lock of its journal. If the node of the previous job was lost,
#: NFSv4 releases the lock when the lease of that node ends (90 s by default); if the node comes
#: back, the lock stays and this job ends.
PREDECESSOR_S: Final = 180.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """Settings and motions that all variants of a study share.

    Attributes:
        suite: The ground motions with their factors.
        measures: Intensity measures at factor 1, by bridge (as the grid names it) and motion.
        draws: Random properties by motion; empty where they are not drawn.
        search: Target of an IDA; None where the factors are given.
    """

    folder: StudyFolder
    suite: tuple[SuiteMotion, ...]
    measures: Mapping[tuple[str, str], dict[str, float]]
    incidence_deg: tuple[float, ...]
    settings: AnalysisSettings
    options: ModelOptions
    draws: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    search: Search | None = None

    @classmethod
    def of(cls, study: StudyConfig, folder: StudyFolder | None = None) -> Self:
        """Return the setup of a study; `InputError` unless this version prepared its motions."""
        folder = folder or StudyFolder(Path(study.results))
        motions = study.motions
        low_g, high_g = motions.level_range_g
        search = Search(
            demand=motions.ida_demand, threshold=motions.ida_threshold, low_g=low_g, high_g=high_g
        )
        measures = {
            (row["bridge"], row["motion_id"]): {name: row[name] for name in IM_COLUMNS}
            for row in read_table(folder.intensities).to_pylist()
        }
        suite = tuple(read_suite(folder.suite))
        draws: dict[str, dict[str, float]] = {}
        for place, name in enumerate(dict.fromkeys(motion.suite for motion in suite)):
            ids = {each.number: each.motion.motion_id for each in suite if each.suite == name}
            # by their numbers, whatever the design of the study leaves out
            listed = [ids.get(number, "") for number in range(max(ids) + 1)]
            draws |= study.uncertainty.draws(listed, name if place else "")
        return cls(
            folder=folder,
            suite=suite,
            measures=measures,
            incidence_deg=motions.incidence_deg,
            settings=study.analysis,
            options=study.model,
            draws=draws,
            search=search if motions.design == "ida" else None,
        )

    @property
    def motion_ids(self) -> list[str]:
        """Motions of the suite in its order; a motion with several levels is named once."""
        return list(dict.fromkeys(each.motion.motion_id for each in self.suite))

    def tasks(self, slug: str) -> list[Task]:
        """Return the analyses of one variant; `InputError` without motions for its bridge.

        In an IDA there is one per motion, at the first factor of its search. The values of a
        variant on the axes of modelling options override the configured ones.
        """
        variant = parse_slug(slug)
        files = {Path(bridge).stem: bridge for bridge, _ in self.measures}
        if variant.bridge not in files:
            raise InputError(f"{slug}: the study has the bridges {', '.join(files)}")
        variant = replace(variant, bridge=files[variant.bridge])
        options = replace(self.options, **dict(variant.options))
        tasks: list[Task] = []
        for motion in self.suite:
            draw = self.draws.get(motion.motion.motion_id, {})
            tasks += [
                Task(
                    variant=variant,
                    motion=self._for_bridge(variant.bridge, motion),
                    incidence_deg=(angle + draw.get(DIRECTION, 0.0)) % 360.0,
                    settings=self.settings,
                    options=with_draw(options, draw),
                    draw=draw,
                )
                for angle in self.incidence_deg
            ]
        return tasks

    def task_of(self, row: Mapping[str, Any]) -> Task | None:
        """Return the analysis of a row of the demands; None if the study does not have it."""
        wanted = row["motion_id"], row["scale"], row["incidence_deg"]
        for task in self.tasks(row["variant"]):
            # a search chooses its factors
            trial = task if self.search is None else at_factor(task, row["scale"])
            motion = trial.motion
            if (motion.motion.motion_id, motion.scale, trial.incidence_deg) == wanted:
                return trial
        return None

    def _for_bridge(self, bridge: str, motion: SuiteMotion) -> SuiteMotion:
        at_1 = self.measures[bridge, motion.motion.motion_id]
        scale = motion.scale
        if self.search is not None:
            scale = self.search.first_factor(replace(motion, scale=1.0, measures=dict(at_1)))
        return replace(motion, scale=scale, measures=scaled_measures(dict(at_1), scale))


def sampled(tasks: Sequence[Task], count: int) -> list[Task]:
    """Return a number of analyses of a variant, at equal quantiles of the scaled PGV."""

    def strength(task: Task) -> tuple[float, str, float]:
        motion = task.motion
        return motion.measures[PGV], motion.motion.motion_id, task.incidence_deg

    ranked = sorted(tasks, key=strength)
    parts = min(count, len(ranked))
    return [ranked[(2 * part + 1) * len(ranked) // (2 * parts)] for part in range(parts)]


def analyse_variant(
    setup: StudySetup, slug: str, *, workers: Workers, limits: SuspectLimits, output: Path
) -> None:
    """Run the analyses of a variant that its journal does not have, and write its demands.

    Raises:
        InputError: Another process analyses this variant, or its files cannot be written.
    """
    folder, search = setup.folder, setup.search
    tasks = sorted(setup.tasks(slug), key=lambda task: -task.analysed_s)
    keys = [run_key(task) for task in tasks]
    searches = folder.journal(f"{slug}_searches")
    with open_journal(folder.journal(slug), PREDECESSOR_S) as journal:
        content = read_content([journal.path, searches])
        for sentence in content.sentences:
            logger.warning("%s: %s", slug, sentence)
        done = content.rows
        with JobProgress(slug, keys, sum(key in done for key in keys)) as progress:
            rows = run_tasks(
                tasks,
                journal,
                done,
                workers=workers,
                log_folder=folder.solver_logs,
                on_finished=progress.advance,
                search=None if search is None else partial(search_capacity, search, done, searches),
            )
    write_variant(rows, output, limits)


def run_in_journal(
    setup: StudySetup, name: str, tasks: Sequence[Task], workers: Workers
) -> list[Row]:
    """Run the tasks that no journal of the study has; return the rows of all in order.

    The name is that of the journal for new rows and of the folder for messages of the solver.
    Equal tasks are analysed once.

    Raises:
        InputError: The journal is being written by another process, or cannot be written.
    """
    once = {run_key(task): task for task in tasks}
    done = read_journals(setup.folder)
    logger.info("%d analyses, %d of them done", len(once), len(once.keys() & done.keys()))
    with open_journal(setup.folder.journal(name)) as journal:
        rows = run_tasks(
            list(once.values()),
            journal,
            done,
            workers=workers,
            log_folder=setup.folder.solver_logs / name,
            on_finished=log_failure,
        )
    by_key = dict(zip(once, rows, strict=True))
    return [by_key[run_key(task)] for task in tasks]


class JobProgress:
    """Logs a line a minute on one job, and one at its end, without analyses that a search adds."""

    def __init__(self, name: str, keys: Sequence[str], done: int) -> None:
        self._name, self._keys = name, frozenset(keys)
        self._before = self._done = done
        self._began_s = self._logged_s = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._log()

    def advance(self, row: Mapping[str, Any]) -> None:
        """Count one finished analysis."""
        log_failure(row)
        self._done += row["run_key"] in self._keys
        if time.monotonic() - self._logged_s > LOG_INTERVAL_S:
            self._log()

    def _log(self) -> None:
        self._logged_s = time.monotonic()
        new, left = self._done - self._before, len(self._keys) - self._done
        per_min = new / max(self._logged_s - self._began_s, 1e-9) * 60
        progress_logger.info(
            "%s: %d of %d analyses done%s%s%s",
            self._name,
            self._done,
            len(self._keys),
            f" ({self._before} of them before)" if self._before else "",
            f", {per_min:.1f} per minute" if new else "",
            f", {left / per_min:.0f} min left" if new and left else "",
        )


def log_failure(row: Mapping[str, Any]) -> None:
    """Warn of an analysis without a usable result, with the command that repeats it."""
    if row["status"] in FAILED:
        logger.warning(failure_note(row))


def failure_note(row: Mapping[str, Any]) -> str:
    """Return the outcome of an analysis, and the command that repeats it alone."""
    return (
        f"{row['variant']} under {row['motion_id']}: {row['status']} "
        f"({row['collapse_criterion']}); alone: {run_command(row)}"
    )


def run_command(row: Mapping[str, Any]) -> str:
    """Return the command that repeats one analysis alone."""
    return f"skewbridge run --row {row['run_key']} --out row_{row['run_key']}"
