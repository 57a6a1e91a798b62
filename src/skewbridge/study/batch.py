"""The analyses of one variant, in parallel, each finished one written to the journal at once."""

import logging
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from joblib import Parallel, delayed

from skewbridge.analysis.exit_message import hush_exit_message
from skewbridge.analysis.result import RAN, AnalysisResult
from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.analysis.transient import analyse, opensees_version
from skewbridge.bridge.catalogue import load_bridge
from skewbridge.demands.columns import INTENSITY_COLUMNS
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.demands.schema import key_values
from skewbridge.errors import InputError
from skewbridge.motions.suite import SuiteMotion
from skewbridge.provenance.digests import ENGINE_ROOMS, canonical, digest_of, source_digest
from skewbridge.study.journal import JournalWriter
from skewbridge.study.orphans import end_with
from skewbridge.variant.options import ModelOptions
from skewbridge.variant.variant import Variant

logger = logging.getLogger(__name__)

type Row = dict[str, Any]
#: Makes the rows of a task: (task, its key, folder of the solver's messages, owner's pid).
type Work = Callable[[Task, str, Path, int], list[Row]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One analysis: everything a worker needs.

    Attributes:
        variant: The bridge.
        motion: The ground motion with its factor and its intensity measures at that factor.
        incidence_deg: Angle from bridge x to component 1.
        settings: How to integrate.
        options: How to model.
    """

    variant: Variant
    motion: SuiteMotion
    incidence_deg: float
    settings: AnalysisSettings
    options: ModelOptions


def run_key(task: Task) -> str:
    """Return the digest of everything that the result of an analysis depends on."""
    return digest_of(
        canonical(asdict(task.variant)),
        task.motion.motion.sha256,
        task.motion.scale,
        task.incidence_deg,
        canonical(asdict(task.settings)),
        canonical(asdict(task.options)),
        load_bridge(task.variant.bridge).model_dump_json(exclude={"title", "sources"}),
        source_digest(*ENGINE_ROOMS),
        opensees_version(),
    )


def plan_tasks(
    variant: Variant,
    suite: Sequence[SuiteMotion],
    incidence_deg: Sequence[float],
    settings: AnalysisSettings,
    options: ModelOptions,
) -> list[Task]:
    """Return the analyses of one variant, the longest motions first (better use of the cores)."""
    tasks = [
        Task(
            variant=variant, motion=motion, incidence_deg=angle, settings=settings, options=options
        )
        for motion in suite
        for angle in incidence_deg
    ]
    return sorted(tasks, key=lambda task: -task.motion.motion.duration_s)


def run_tasks(
    tasks: Sequence[Task],
    journal: JournalWriter,
    done: Mapping[str, Row],
    *,
    n_jobs: int,
    log_folder: Path,
    on_finished: Callable[[Row], None],
    work: Work | None = None,
) -> list[Row]:
    """Run what the journal does not have, and return the rows of all tasks in their order.

    A worker that dies (a fault inside the solver) costs its own analysis only: it is tried once
    more alone and then recorded with status ``crash``.

    Args:
        tasks: What the variant needs.
        journal: Open journal of the variant.
        done: Rows that the journal has already, by `run_key`.
        n_jobs: Worker processes.
        log_folder: Where each analysis leaves the solver's messages.
        on_finished: Called with each new row.
        work: What to do with each task, whatever the journal has (it may give several rows, a
            search for example); by default the one analysis that it describes, if it is new.
    """
    keys = [run_key(task) for task in tasks]
    rows = {key: [done[key]] for key in keys if key in done and work is None}

    def finish(key: str, found: list[Row]) -> None:
        rows[key] = found
        for row in found:
            if row["run_key"] not in done:
                journal.append(row)
                on_finished(row)

    while pending := [pair for pair in zip(tasks, keys, strict=True) if pair[1] not in rows]:
        try:
            for key, found in _stream(pending, n_jobs, log_folder, work or _one_analysis):
                finish(key, found)
        except BrokenProcessPool:
            left = [pair for pair in pending if pair[1] not in rows][: n_jobs + 1]
            logger.warning("a worker died; the %d analyses under way run alone", len(left))
            for task, key in left:
                finish(key, _alone(task, key, log_folder, work or _one_analysis))
    return [row for key in keys for row in rows[key]]


def analyse_row(task: Task, key: str, log_folder: Path, owner_pid: int) -> Row:
    """Run one analysis in this process and return its row of the demands table.

    Args:
        task: The analysis.
        key: Its `run_key`; it is the caller's, whose sources may be older than this process.
        log_folder: Where the solver's messages go, in a file named after motion and key.
        owner_pid: The process that the result is for; when it ends, so does this one.
    """
    hush_exit_message()
    end_with(owner_pid)
    log_folder.mkdir(parents=True, exist_ok=True)
    log_path = log_folder / f"{task.motion.motion.motion_id}_{key}.log"
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    try:
        result = analyse(
            task.variant,
            task.motion.motion,
            task.motion.scale,
            task.incidence_deg,
            task.settings,
            task.options,
            histories=False,
            log_path=log_path,
        )
    except InputError as error:
        outcome = _no_result("invalid_input", str(error))
    except Exception as error:  # the boundary: whatever fails in one analysis is data
        logger.exception("%s under %s", task.variant.slug, task.motion.motion.motion_id)
        outcome = _no_result("crash", f"{type(error).__name__}: {error}")
    else:
        outcome = outcome_of(result)
    return {
        **identity_of(task, key),
        **outcome,
        "wall_s": time.perf_counter() - wall_s,
        "cpu_s": time.process_time() - cpu_s,
    }


def identity_of(task: Task, key: str) -> Row:
    """Return the columns of a row that say which analysis it is, with its `run_key`."""
    motion = task.motion
    return {
        **key_values(task.variant, motion.motion.motion_id, motion.scale, task.incidence_deg),
        **{column.name: motion.measures[column.name] for column in INTENSITY_COLUMNS},
        "run_key": key,
    }


def outcome_of(result: AnalysisResult) -> Row:
    """Return the columns of a row that an analysis gives: demands and what became of it."""
    reason = "" if result.status in RAN else "; ".join(result.messages)
    return {
        **result.demands,
        "status": result.status,
        "collapse_criterion": result.collapse_criterion or reason,
        "time_reached_s": result.time_reached_s,
        "duration_s": result.duration_s,
        "recovery_rung": result.recovery_rung,
        "substeps": result.substeps,
    }


def _one_analysis(task: Task, key: str, log_folder: Path, owner_pid: int) -> list[Row]:
    return [analyse_row(task, key, log_folder, owner_pid)]


def _keyed(
    work: Work, task: Task, key: str, log_folder: Path, owner_pid: int
) -> tuple[str, list[Row]]:
    return key, work(task, key, log_folder, owner_pid)


def _stream(
    pairs: Sequence[tuple[Task, str]], n_jobs: int, log_folder: Path, work: Work
) -> Iterator[tuple[str, list[Row]]]:
    parallel = Parallel(n_jobs=n_jobs, backend="loky", return_as="generator_unordered")
    yield from parallel(
        delayed(_keyed)(work, task, key, log_folder / task.variant.slug, os.getpid())
        for task, key in pairs
    )


def _alone(task: Task, key: str, log_folder: Path, work: Work) -> list[Row]:
    try:
        # Two workers for one task: with one, joblib would run it in this process.
        return next(_stream([(task, key)], 2, log_folder, work))[1]
    except BrokenProcessPool:
        crash = _no_result("crash", "the worker process died")
        return [{**identity_of(task, key), **crash, "wall_s": math.nan, "cpu_s": math.nan}]


def _no_result(status: str, reason: str) -> Row:
    empty: Final = {column.name: math.nan for column in DEMAND_COLUMNS}
    return {
        **empty,
        "status": status,
        "collapse_criterion": reason,
        "time_reached_s": 0.0,
        "duration_s": math.nan,
        "recovery_rung": 0,
        "substeps": 0,
    }
