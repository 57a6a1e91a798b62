"""Progress and forecast of a study: analyses done, failed and left, and their cost."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any, Final, Self

import yte
from yte.exceptions import YteError

from skewbridge.demands.validity import LIMITS, SuspectLimits, reasons
from skewbridge.errors import InputError
from skewbridge.motions.folder import list_motions
from skewbridge.motions.levels import most_trials
from skewbridge.motions.suite import suite_sources
from skewbridge.statuses import FAILED
from skewbridge.study.analyses import StudySetup, failure_note, run_command
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import JournalContent, read_content, read_journals
from skewbridge.study.task import run_key
from skewbridge.variant.grid import expand_grid

CRASH: Final = "crash"
SHOWN_CRASHES: Final = 10
#: Processor seconds per second of motion where no analysis has been measured yet.
#: source: docs/scaling.md, two-column bridge, default steps
CPU_S_PER_MOTION_S: Final = 0.08
TYPICAL_MOTION_S: Final = 25.0  # of the embedded suite
CORES: Final = 2  # workers of a study
DISK_KB_PER_ANALYSIS: Final = 6.0  # journal line, parquet row and solver log
PROFILES: Final = Path("workflow/profiles")
# Other work of a study, as seconds of motion whose analysis takes as long: the measured rate of the
# analyses then forecasts all of it, on a slow or busy machine too.
# source: 24 variants under 12 and under 32 motions, two processors
JOB_START_MOTION_S: Final = 40.0  # start of a job
TAIL_MOTION_S: Final = 210.0  # tables, friction pair and page
TAIL_MOTION_S_PER_VARIANT: Final = 47.0  # fits and figures; up to two processors share them
CHECK_MOTION_S: Final = 55.0  # numerical check of a second of a row


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyState:
    """Progress of a study.

    Attributes:
        counts: Variants, analyses, those done (with a row, whatever its status), failed (without a
            usable result), suspect (to be checked by the user) and left, by name.
        cpu_s: Mean processor time of the finished analyses that have one; None before the first.
        ledger: Finished analyses by status, and by the highest recovery step they used.
        variants_left: Number of variants with analyses that are not done.
        notes: Sentences about lines of the journals that do not count, and about analyses that
            ended their workers.
    """

    counts: dict[str, int]
    cpu_s: float | None
    ledger: dict[str, dict[Any, int]]
    variants_left: int
    notes: tuple[str, ...]


def study_state(
    run_keys: Mapping[str, Sequence[str]], content: JournalContent, limits: SuspectLimits = LIMITS
) -> StudyState:
    """Count the finished analyses of a study, from its `run_keys` by variant and its journals."""
    done, analyses = content.rows, sum(map(len, run_keys.values()))
    rows = [done[key] for keys in run_keys.values() for key in keys if key in done]
    crashes = [failure_note(row) for row in rows if row["status"] == CRASH]
    if len(crashes) > SHOWN_CRASHES:
        crashes[SHOWN_CRASHES:] = [f"and {len(crashes) - SHOWN_CRASHES} more with status {CRASH}"]
    if crashes:
        crashes.append("`skewbridge study retry` lets the study try them again.")
    times_s = [row["cpu_s"] for row in rows if row["cpu_s"] == row["cpu_s"]]
    return StudyState(
        counts={
            "variants": len(run_keys),
            "analyses": analyses,
            "done": len(rows),
            "failed": sum(row["status"] in FAILED for row in rows),
            "suspect": sum(bool(reasons(row, limits)) for row in rows),
            "left": analyses - len(rows),
        },
        cpu_s=sum(times_s) / len(times_s) if times_s else None,
        ledger={
            name: dict(sorted(Counter(row[column] for row in rows).items()))
            for name, column in (("status", "status"), ("recovery_step", "recovery_rung"))
        },
        variants_left=sum(not done.keys() >= set(keys) for keys in run_keys.values()),
        notes=(*content.sentences, *crashes),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class JobSize:
    """Processors of a cluster's jobs, one for each variant, and most jobs in the queue at once."""

    cores: int
    jobs: int

    @classmethod
    def of_profile(cls, name: str) -> Self | None:
        """Return the size of a Snakemake profile's jobs; None for a profile of one machine.

        The profile is a folder of `PROFILES` or a path; `InputError` if it is missing or invalid.
        """
        folders = [Path(name), PROFILES / name]
        file = next((f / "config.yaml" for f in folders if (f / "config.yaml").is_file()), None)
        if file is None:
            raise InputError(
                f"no profile {name!r}: neither {folders[0]} nor {folders[1]} is a profile"
            )
        try:
            with file.open(encoding="utf-8") as text:
                profile: Any = yte.process_yaml(text, require_use_yte=True)
            if "executor" not in profile:
                return None
            return cls(cores=profile["set-threads"]["analyse"], jobs=profile["jobs"])
        except (YteError, KeyError, TypeError) as error:
            raise InputError(f"{file} is not a valid cluster profile: {error}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """Summary by name, analyses by variant, and notes for the user."""

    summary: dict[str, Any]
    analyses_by_variant: dict[str, int]
    notes: tuple[str, ...] = ()


def forecast_study(config: StudyConfig, size: JobSize | None = None) -> Forecast:
    """Return the cost of a study and its progress.

    An analysis is done if a journal has its key. The keys are those of the prepared motions; before
    motions are prepared nothing is done, and their number is the configured one. With the size of
    a cluster's jobs the summary has `jobs`, `job_cores` and the wall time of one job and of all,
    `job_hours` and `hours`, without waiting in the queue.
    """
    keys = analysis_keys(config)
    if not keys:
        sources = suite_sources(config.motions)
        motions = sum(len(list_motions(source.folder)[: source.count]) for source in sources)
        each = ("",) * (motions * len(config.motions.incidence_deg))
        keys = {variant.slug: each for variant in expand_grid(config.grid)}
    journals = StudyFolder(Path(config.results)).journals
    state = study_state(keys, read_content(journals), config.suspect)
    notes, trials = state.notes, 1
    if config.motions.design == "ida":
        low_g, high_g = config.motions.level_range_g
        trials = most_trials((low_g, high_g))
        notes = (*notes, f"Counted are searches of up to {trials} analyses; the cost is of all.")
    cpu_s = TYPICAL_MOTION_S * CPU_S_PER_MOTION_S if state.cpu_s is None else state.cpu_s
    every, left = trials * state.counts["analyses"], trials * state.counts["left"]
    left_s = round(left * cpu_s / CORES, 1)
    summary: dict[str, Any] = {
        **state.counts,
        "core_hours": round(every * cpu_s / 3600, 3),
        "eta_s": left_s,
        "disk_mb": round(every * DISK_KB_PER_ANALYSIS / 1024, 1),
        "ledger": state.ledger,
    }
    if size is not None:
        jobs = state.variants_left
        job_hours = left_s * CORES / 3600 / size.cores / max(jobs, 1)
        summary |= {
            "jobs": jobs,
            "job_cores": size.cores,
            "job_hours": round(job_hours, 2),
            "hours": round(job_hours * ceil(jobs / size.jobs), 2),
        }
    by_variant = {slug: len(of_variant) for slug, of_variant in keys.items()}
    return Forecast(summary=summary, analyses_by_variant=by_variant, notes=notes)


def other_work_s(study: StudyConfig, per_s: float, cores: float) -> float:
    """Return the time that a study needs besides the analyses of its variants.

    It is that of the numerical checks that are not in their journal, and of fits, figures and page.
    `per_s` is the wall time of an analysis per second of its motion.
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
    """Return the keys of the analyses by variant; empty before their motions are prepared."""
    folder = StudyFolder(Path(config.results))
    if not (folder.suite.is_file() and folder.intensities.is_file()):
        return {}
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    try:
        setup = StudySetup.of(config)
        return {slug: [run_key(task) for task in setup.tasks(slug)] for slug in slugs}
    except (InputError, KeyError):  # prepared by another version, or for other bridges
        return {}


def failed_analyses(config: StudyConfig) -> list[dict[str, Any]]:
    """Return the analyses of a study without a usable result, with the command of each alone."""
    rows = read_journals(StudyFolder(Path(config.results)))
    wanted = [key for keys in analysis_keys(config).values() for key in keys]
    return [
        {
            "variant": row["variant"],
            "motion": row["motion_id"],
            "status": row["status"],
            "reason": row["collapse_criterion"],
            "command": run_command(row),
        }
        for row in (rows[key] for key in wanted if key in rows)
        if row["status"] in FAILED
    ]
