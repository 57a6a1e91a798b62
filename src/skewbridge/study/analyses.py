"""Analyses of a study: tasks made from the configuration and the motions, and jobs that run them.

The journals are a cache: an analysis that is in a journal of the study is not repeated.
"""

import logging
import time
from collections import Counter
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from math import inf, sqrt
from pathlib import Path
from shlex import quote
from typing import Any, Final, Self

from skewbridge.analysis.settings import NUMERICS, AnalysisSettings
from skewbridge.bridge.library import without_effect
from skewbridge.demands.tables import write_variant
from skewbridge.errors import InputError
from skewbridge.files.tables import read_table
from skewbridge.motions.blocks import Run, placed, planned_runs, unread
from skewbridge.motions.intensity import IM_COLUMNS, scaled_measures
from skewbridge.motions.levels import MotionsConfig
from skewbridge.motions.record import SuiteMotion
from skewbridge.motions.suite import read_suite
from skewbridge.statuses import FAILED
from skewbridge.study import batch
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import DEFAULT_ROOT, StudyFolder
from skewbridge.study.journal import Row, open_journal, read_content
from skewbridge.study.processes import PROGRESS_LOG
from skewbridge.study.task import Task, run_key
from skewbridge.variant.grid import expand_grid
from skewbridge.variant.random_properties import DIRECTION, PROPERTIES, Draw, with_draw
from skewbridge.variant.variant import ABUTMENTS, Variant

logger = logging.getLogger(__name__)

progress_logger = logging.getLogger(PROGRESS_LOG)

# Processor time (s) of an analysis of a two-column bridge with contacts.
# source: 64 analyses of osb1 and osb1_fixed under motions of 10 to 90 s, on two processors
STRONG_S: Final = 12.0  # duration of the strong part of a motion
CPU_S_PER_STRONG_S: Final = 0.10  # per second of this part
CPU_S_PER_LATER_S: Final = 0.03
CPU_S_PER_STEP: Final = 1.5e-3  # constant steps: scheme paper and reference accuracy
WITHOUT_CONTACTS: Final = 0.6  # ratio
#: Share of the sensitivity check in the expected cost of the analyses; at worst it takes a quarter.
CHECK_SHARE: Final = 0.18
#: Strongest seconds of a motion for the check; ASSUME errors of steps and penalties show in them.
CHECK_WINDOW_S: Final = 4.0
REPEATS_AT_DEFAULT: Final = 5  # analyses of a checked row that are not at the reference accuracy

LOG_INTERVAL_S: Final = 60.0
PGV: Final = "im_pgv_rotd50_mps"
#: Time that a job waits for the lock of its journal. If the node of the previous job was lost,
#: NFSv4 releases the lock when the lease of that node ends (90 s by default); if the node comes
#: back, the lock stays and this job ends.
PREDECESSOR_S: Final = 180.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySetup:
    """Configuration of a study with its prepared motions."""

    study: StudyConfig
    suite: tuple[SuiteMotion, ...]  # motions with their factors
    #: Intensity measures at factor 1, keyed by bridge (as the grid names it) and motion.
    measures: Mapping[tuple[str, str], dict[str, float]]
    #: Time (s) at which an analysis ends (`motions.tail_ratio`), with the same keys.
    shaken_s: Mapping[tuple[str, str], float]
    #: Random properties and alternatives of each motion; empty if none are drawn.
    draws: Mapping[str, Draw] = field(default_factory=dict)
    #: Analyses of each variant; empty: all.
    planned: Mapping[str, Set[Run]] = field(default_factory=dict)
    workers: int = 1

    @classmethod
    def of(cls, study: StudyConfig, workers: int = 1) -> Self:
        """Return the setup of a study; `InputError` unless this version prepared its motions."""
        suite = tuple(read_suite(study.folder.suite))
        draws: dict[str, Draw] = {}
        for suite_number, name in enumerate(dict.fromkeys(motion.suite for motion in suite)):
            ids = {m.number: m.motion.motion_id for m in suite if m.suite == name}
            # by number, so that motions left out by the design do not change the draws
            motion_ids = [ids.get(number, "") for number in range(max(ids) + 1)]
            draws |= study.uncertainty.draws(motion_ids, name if suite_number else "")
        stored = read_table(study.folder.intensities).to_pylist()
        rows = {(row["bridge"], row["motion_id"]): row for row in stored}
        runs = planned_runs(study.grid, study.motions, placed(suite))
        return cls(
            study=study,
            suite=suite,
            measures={key: {name: row[name] for name in IM_COLUMNS} for key, row in rows.items()},
            # motions prepared by an earlier version have no end before their last value
            shaken_s={key: row.get("shaken_s", inf) for key, row in rows.items()},
            draws=draws,
            planned=runs if study.motions.blocks else {},
            workers=workers,
        )

    @property
    def folder(self) -> StudyFolder:
        """Files of the study."""
        return self.study.folder

    @property
    def ida(self) -> MotionsConfig | None:
        """Section ``motions`` of an IDA; None for any other design."""
        return self.study.motions if self.study.motions.design == "ida" else None

    @property
    def durations_s(self) -> list[float]:
        """Largest analysed lengths (s) of the motions of the suite."""
        bridges = dict.fromkeys(bridge for bridge, _ in self.shaken_s)
        motions = [motion.motion for motion in self.suite]
        ends_s = [max(self.shaken_s[name, m.motion_id] for name in bridges) for m in motions]
        return [min(m.duration_s, end_s) for m, end_s in zip(motions, ends_s, strict=True)]

    @property
    def motion_ids(self) -> list[str]:
        """Motions of the suite in order, each named once even if it has several levels."""
        return list(dict.fromkeys(motion.motion.motion_id for motion in self.suite))

    @property
    def without_alternatives(self) -> Self:
        """The setup in which every motion has the configured modelling options."""
        draws = {
            motion: {name: draw[name] for name in draw if name in PROPERTIES}
            for motion, draw in self.draws.items()
        }
        return replace(self, draws=draws)

    def of_motions(self, first: int, end: int) -> Self:
        """Return the setup with the motions ``first`` to ``end`` - 1, counted from 0."""
        motion_ids = self.motion_ids[first:end]
        return replace(self, suite=tuple(m for m in self.suite if m.motion.motion_id in motion_ids))

    def named(self, slug: str) -> Variant:
        """Return the variant of the grid with a name; `InputError` if there is none."""
        variants = {variant.slug: variant for variant in expand_grid(self.study.grid)}
        if slug not in variants:
            raise InputError(f"{slug}: not a variant of the grid (`skewbridge plan` lists them)")
        return variants[slug]

    def tasks(self, of: Variant | str) -> list[Task]:
        """Return the tasks of a variant, or of the variant of the grid with a name.

        In an IDA, each motion has the first factor of its search. Options that are axes have the
        value of the variant. `InputError` if no motions are prepared for its bridge.
        """
        variant = self.named(of) if isinstance(of, str) else of
        files = {Path(bridge).stem: bridge for bridge, _ in self.measures}
        if variant.bridge_name not in files:
            raise InputError(f"{variant.slug}: the study has only the bridges {', '.join(files)}")
        variant = replace(variant, bridge=files[variant.bridge_name])
        options = replace(self.study.model, **dict(variant.options))
        ineffective = without_effect(variant.bridge).difference(PROPERTIES)
        tasks: list[Task] = []
        for motion, angle in product(self.suite, self.study.motions.incidence_deg):
            drawn = self.draws.get(motion.motion.motion_id, {})
            draw = {name: value for name, value in drawn.items() if name not in ineffective}
            task = Task(
                variant=variant,
                motion=self._for_bridge(variant.bridge, motion),
                incidence_deg=(angle + draw.get(DIRECTION, 0.0)) % 360.0,
                settings=self._until_quiet(variant.bridge, motion),
                options=with_draw(options, draw),
                draw=draw,
            )
            tasks.append(task)
        return tasks

    def planned_tasks(self, slug: str) -> list[Task]:
        """Return `tasks` of a variant that the study runs: all, or those of `motions.blocks`."""
        runs = [
            (motion.motion.motion_id, motion.scale, angle)
            for motion, angle in product(self.suite, self.study.motions.incidence_deg)
        ]
        tasks = zip(self.tasks(slug), runs, strict=True)
        return [task for task, run in tasks if not self.planned or run in self.planned[slug]]

    def task_of(self, row: Mapping[str, Any]) -> Task | None:
        """Return the task of a row of the demands table; None if the study does not have it."""
        motion_key = row["motion_id"], row["scale"], row["incidence_deg"]
        for task in self.tasks(Variant.of_row(row)):
            # the search of an IDA chooses its factors
            trial = batch.at_factor(task, row["scale"]) if self.ida else task
            motion = trial.motion
            if (motion.motion.motion_id, motion.scale, trial.incidence_deg) == motion_key:
                return trial
        return None

    def _until_quiet(self, bridge: str, motion: SuiteMotion) -> AnalysisSettings:
        settings, shaken_s = self.study.analysis, self.shaken_s[bridge, motion.motion.motion_id]
        if shaken_s >= min(settings.duration_s or inf, motion.motion.duration_s):
            return settings
        return replace(settings, duration_s=max(shaken_s, settings.dt_s))

    def _for_bridge(self, bridge: str, motion: SuiteMotion) -> SuiteMotion:
        measures, scale = self.measures[bridge, motion.motion.motion_id], motion.scale
        if self.ida:
            low, high = batch.search_limits(self.ida, replace(motion, scale=1.0, measures=measures))
            scale = sqrt(low * high)
        return replace(motion, scale=scale, measures=scaled_measures(measures, scale))


# ---- Forecast of processor time


def forecast_s(duration_s: float, abutment: str, settings: AnalysisSettings) -> float:
    """Return the expected processor time (s) of an analysis of a two-column bridge."""
    if settings.contact_dt_s is None:
        return CPU_S_PER_STEP * duration_s / settings.dt_s
    strong_s = min(duration_s, STRONG_S)
    cpu_s = CPU_S_PER_STRONG_S * strong_s + CPU_S_PER_LATER_S * (duration_s - strong_s)
    return cpu_s if ABUTMENTS[abutment].has_contacts else WITHOUT_CONTACTS * cpu_s


def analyses_s(study: StudyConfig, durations_s: Sequence[float]) -> float:
    """Return the expected processor time (s) of all analyses for these lengths of the motions."""
    per_motion = float(len(study.motions.incidence_deg))
    if study.motions.blocks:
        runs = planned_runs(study.grid, study.motions, unread(len(durations_s)))
        per_motion = sum(map(len, runs.values())) / len(runs) / len(durations_s)
    longest_s, later_s = study.analysis.duration_s or inf, study.analysis.free_vibration_s
    n_variants = Counter(variant.abutment for variant in expand_grid(study.grid))
    return per_motion * sum(
        n * forecast_s(min(length_s, longest_s) + later_s, abutment, study.analysis)
        for abutment, n in n_variants.items()
        for length_s in durations_s
    )


def check_plan(study: StudyConfig, durations_s: Sequence[float]) -> tuple[int, float]:
    """Return the number of rows of the sensitivity check and its expected processor time (s).

    The number is limited so that the check costs at most `CHECK_SHARE` of the analyses.
    """
    settings = study.analysis
    if settings.scheme != "default":
        return 0, 0.0  # the reference accuracy has settings that scheme paper refuses
    variants = expand_grid(study.grid)
    abutment = max((variant.abutment for variant in variants), key=list(ABUTMENTS).index)
    counted_s = durations_s[: study.design.first] if study.design.until else durations_s
    budget_s = CHECK_SHARE * analyses_s(study, counted_s)
    window_s = min(CHECK_WINDOW_S, max(durations_s), settings.duration_s or inf)
    row_s = CPU_S_PER_STEP * window_s / NUMERICS["reference"]["analysis"]["dt_s"]
    row_s += REPEATS_AT_DEFAULT * forecast_s(window_s, abutment, settings)
    rows = min(study.sensitivity.rows, int(budget_s / row_s))
    return rows, rows * row_s


def sampled(tasks: Sequence[Task], count: int) -> list[Task]:
    """Return ``count`` tasks of a variant, at evenly spaced quantiles of the scaled PGV."""

    def rank(task: Task) -> tuple[float, str, float]:
        return task.motion.measures[PGV], task.motion.motion.motion_id, task.incidence_deg

    ranked, n_samples = sorted(tasks, key=rank), min(count, len(tasks))
    return [ranked[(2 * i + 1) * len(ranked) // (2 * n_samples)] for i in range(n_samples)]


def analyse_variant(setup: StudySetup, slug: str, output: Path) -> None:
    """Run the analyses of a variant that are not in its journals, and write its demands table."""
    write_variant(run_in_journal(setup, slug, setup.planned_tasks(slug), of_variant=True), output)


def run_in_journal(
    setup: StudySetup, name: str, tasks: Sequence[Task], *, of_variant: bool = False
) -> list[Row]:
    """Run the analyses that are not in a journal, longest first; return all rows in task order.

    ``name`` is the journal of new rows. With ``of_variant``, it is the name of a variant, only its
    journals are read (else all of the study), and in an IDA each task starts a search.
    `InputError` if the journal is locked or unwritable.
    """
    folder, ida = setup.folder, setup.ida if of_variant else None
    main_path, searches_path = folder.journal(name), folder.journal(f"{name}_searches")
    by_key = {run_key(task): task for task in sorted(tasks, key=lambda task: -task.analysed_s)}
    with open_journal(main_path, PREDECESSOR_S) as journal:
        content = read_content([main_path, searches_path] if of_variant else folder.journals)
        for sentence in content.sentences:
            logger.warning("%s: %s", name, sentence)
        journal_rows = content.rows
        finished = n_before = len(by_key.keys() & journal_rows.keys())
        began_s = logged_s = time.monotonic()
        kind = "searches" if ida else "analyses"
        progress = partial(_progress, kind, len(by_key), n_before, began_s)

        def on_finished(row: Row) -> None:
            nonlocal finished, logged_s
            if row["status"] in FAILED:
                columns = ("variant", "motion_id", "status", "collapse_criterion")
                outcome = (row[column] for column in columns)
                command = run_command(row, setup.study.results)
                logger.warning("%s under %s: %s (%s); repeat: %s", *outcome, command)
            finished += row["run_key"] in by_key  # rows that a search adds do not count
            if time.monotonic() - logged_s > LOG_INTERVAL_S:
                logged_s = time.monotonic()
                progress_logger.info("%s: %s", name, progress(finished))

        try:
            rows = batch.run_tasks(
                by_key,
                journal,
                journal_rows,
                workers=batch.Workers(setup.workers, setup.study.batches.no_progress_s),
                log_folder=folder.solver_logs / name,
                on_finished=on_finished,
                search=ida and partial(batch.search_capacity, ida, journal_rows, searches_path),
            )
        finally:
            progress_logger.info("%s: %s", name, progress(finished))
    # rows from journals and of equal tasks take the names and measures of their own task
    return [
        batch.row_of_task(row, batch.at_factor(task, row["scale"]) if ida else task, row["run_key"])
        for task in tasks
        for row in rows[run_key(task)]
    ]


def _progress(kind: str, n_tasks: int, n_before: int, began_s: float, finished: int) -> str:
    """Return a text on the progress of a job; ``n_before`` tasks were finished when it began."""
    n_new, n_left = finished - n_before, n_tasks - finished
    per_min = n_new / max(time.monotonic() - began_s, 1e-9) * 60
    text = f"{finished} of {n_tasks} {kind} done"
    text += f" ({n_before} in earlier runs)" if n_before else ""
    text += f", {per_min:.1f} per minute" if n_new else ""
    return text + (f", {n_left / per_min:.0f} min left" if n_new and n_left else "")


def run_command(row: Mapping[str, Any], results: str) -> str:
    """Return the command that repeats one analysis of the study in a results folder alone."""
    command = f"skewbridge run --row {row['run_key']} --out row_{row['run_key']}"
    return command if results == DEFAULT_ROOT else f"{command} --study {quote(results)}"
