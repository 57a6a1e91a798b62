"""Progress and forecast of a study: analyses done, failed and remaining, and their cost."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path
from typing import Any, Final

import yte
from yte.exceptions import YteError

from skewbridge.demands.validity import LIMITS, SuspectLimits, reasons
from skewbridge.errors import InputError
from skewbridge.motions.folder import list_motions
from skewbridge.motions.levels import most_trials
from skewbridge.motions.suite import suite_sources
from skewbridge.statuses import FAILED
from skewbridge.study.analyses import StudySetup, run_command
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import JournalContent, read_content
from skewbridge.study.task import run_key
from skewbridge.variant.grid import expand_grid

CRASH: Final = "crash"
#: Processor seconds per second of motion where no analysis has been measured yet.
#: source: docs/scaling.md, two-column bridge, default steps
CPU_S_PER_MOTION_S: Final = 0.08
TYPICAL_MOTION_S: Final = 25.0  # of the embedded suite
CORES: Final = 2  # workers of a study
DISK_KB_PER_ANALYSIS: Final = 6.0  # journal line, parquet row and solver log
PROFILES: Final = Path("workflow/profiles")
# Other work of a study, in seconds of motion whose analysis takes equally long: the measured rate
# of the analyses then also forecasts this work on a slow or busy machine.
# source: 24 variants under 12 and under 32 motions, two processors
JOB_START_MOTION_S: Final = 40.0  # start of a job
TAIL_MOTION_S: Final = 210.0  # tables, friction pair and page
TAIL_MOTION_S_PER_VARIANT: Final = 47.0  # fits and figures; up to two processors share them
CHECK_MOTION_S: Final = 55.0  # numerical check, per second of a checked row


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyProgress:
    """Progress and cost of a study.

    `summary` has the numbers of variants and analyses: done (with any status), failed (no usable
    result), suspect (to be checked by the user) and remaining, and the forecast. `ledger` counts
    the finished analyses for each status and each highest recovery step.
    """

    summary: dict[str, Any]
    failures: list[dict[str, Any]]  # failed analyses, each with the command that repeats it
    cpu_s: float | None  # mean processor time of finished analyses, None if not measured
    variants: dict[str, int]  # number of analyses by variant
    variants_left: int  # variants with analyses left
    notes: tuple[str, ...]  # on crashed analyses and on unused journal lines


def study_progress(
    run_keys: Mapping[str, Sequence[str]], content: JournalContent, limits: SuspectLimits = LIMITS
) -> StudyProgress:
    """Return the progress of a study, given the `run_keys` of each variant and the journals."""
    done, analyses = content.rows, sum(map(len, run_keys.values()))
    rows = [done[key] for keys in run_keys.values() for key in keys if key in done]
    columns = {"variant": "variant", "motion": "motion_id", "status": "status"}
    columns["reason"] = "collapse_criterion"
    failures = [
        {name: row[column] for name, column in columns.items()} | {"command": run_command(row)}
        for row in rows
        if row["status"] in FAILED
    ]
    notes = content.sentences
    if crashes := sum(row["status"] == CRASH for row in rows):
        text = f"{crashes} analyses ended their workers (status {CRASH}); `skewbridge status "
        notes += (f"{text}--failed` lists them and `skewbridge study retry` repeats them.",)
    times_s = [row["cpu_s"] for row in rows if row["cpu_s"] == row["cpu_s"]]
    ledger = {
        name: dict(sorted(Counter(row[column] for row in rows).items()))
        for name, column in (("status", "status"), ("recovery_step", "recovery_rung"))
    }
    suspect = sum(bool(reasons(row, limits)) for row in rows)
    summary: dict[str, Any] = {"variants": len(run_keys), "analyses": analyses, "done": len(rows)}
    summary |= {"failed": len(failures), "suspect": suspect, "left": analyses - len(rows)}
    return StudyProgress(
        summary=summary | {"ledger": ledger},
        failures=failures,
        cpu_s=sum(times_s) / len(times_s) if times_s else None,
        variants={slug: len(keys) for slug, keys in run_keys.items()},
        variants_left=sum(not done.keys() >= set(keys) for keys in run_keys.values()),
        notes=notes,
    )


def job_size(profile: str) -> dict[str, int] | None:
    """Return the processors per cluster job (`cores`) and the largest number of queued `jobs`.

    They are read from a Snakemake profile, a folder of `PROFILES` or a path; None if the profile is
    for one machine. `InputError` if it is missing or invalid.
    """
    own, ours = Path(profile), PROFILES / profile
    file = next(filter(Path.is_file, (own / "config.yaml", ours / "config.yaml")), None)
    if file is None:
        raise InputError(f"no profile {profile!r}: neither {own} nor {ours} is a profile")
    try:
        content: Any = yte.process_yaml(file.read_text(encoding="utf-8"), require_use_yte=True)
        if "executor" not in content:
            return None
        return {"cores": content["set-threads"]["analyse"], "jobs": content["jobs"]}
    except (YteError, KeyError, TypeError) as error:
        raise InputError(f"{file} is not a valid cluster profile: {error}") from None


def forecast_study(config: StudyConfig, size: Mapping[str, int] | None = None) -> StudyProgress:
    """Return the progress of a study with its cost in the summary.

    An analysis is done if its key is in a journal. Before motions are prepared, no analysis counts
    as done and the configured number of motions is used. With the `job_size` of a cluster, the
    summary also has `jobs`, `job_cores` and, without queueing, the wall time of one job
    (`job_hours`) and of all jobs (`hours`).
    """
    keys = analysis_keys(config)
    if not keys:
        sources = suite_sources(config.motions)
        motions = sum(len(list_motions(source.folder)[: source.count]) for source in sources)
        each = ("",) * (motions * len(config.motions.incidence_deg))
        keys = {variant.slug: each for variant in expand_grid(config.grid)}
    journals = StudyFolder(Path(config.results)).journals
    state = study_progress(keys, read_content(journals), config.suspect)
    notes, trials = state.notes, 1
    if config.motions.design == "ida":
        trials = most_trials(config.motions.level_range_g)
        notes = (*notes, f"Each count is a search of up to {trials} analyses; the cost covers all.")
    cpu_s = TYPICAL_MOTION_S * CPU_S_PER_MOTION_S if state.cpu_s is None else state.cpu_s
    every, left = (trials * state.summary[name] for name in ("analyses", "left"))
    left_s = round(left * cpu_s / CORES, 1)
    summary = state.summary | {"core_hours": round(every * cpu_s / 3600, 3), "eta_s": left_s}
    summary["disk_mb"] = round(every * DISK_KB_PER_ANALYSIS / 1024, 1)
    if size is not None:
        jobs, cores = state.variants_left, size["cores"]
        job_hours = left_s * CORES / 3600 / cores / max(jobs, 1)
        summary |= {"jobs": jobs, "job_cores": cores, "job_hours": round(job_hours, 2)}
        summary["hours"] = round(job_hours * ceil(jobs / size["jobs"]), 2)
    return replace(state, summary=summary, notes=notes)


def other_work_s(study: StudyConfig, per_s: float, cores: float) -> float:
    """Return the wall time (s) of the work of a study other than the analyses of its variants.

    It covers the numerical checks that are not yet done, fits, figures and page. `per_s` is the
    wall time of an analysis per second of its motion.
    """
    folder, variants = StudyFolder(Path(study.results)), len(expand_grid(study.grid))
    tail_s = TAIL_MOTION_S + TAIL_MOTION_S_PER_VARIANT * variants / min(cores, 2.0)
    checks_s = 0.0
    if not folder.sensitivity.is_file():
        checked_s = study.sensitivity.rows * (study.sensitivity.window_s or TYPICAL_MOTION_S)
        done = read_content([folder.journal("sensitivity")]).rows.values()
        spent_s = sum(row["wall_s"] for row in done if row["wall_s"] == row["wall_s"])
        checks_s = max(CHECK_MOTION_S * checked_s * per_s - spent_s, 0.0)
    return tail_s * per_s + checks_s / cores


def analysis_keys(config: StudyConfig) -> Mapping[str, Sequence[str]]:
    """Return the run keys of each variant; empty before the motions are prepared."""
    folder = StudyFolder(Path(config.results))
    if not (folder.suite.is_file() and folder.intensities.is_file()):
        return {}
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    try:
        setup = StudySetup.of(config)
        return {slug: [run_key(task) for task in setup.tasks(slug)] for slug in slugs}
    except (InputError, KeyError):  # prepared by another version, or for other bridges
        return {}
