"""Progress and forecast of a study: analyses done, failed and left, and their cost."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from typing import Any, Final, Self

import yte
from yte.exceptions import YteError

from skewbridge.demands.suspect import LIMITS, SuspectLimits, reasons
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
COUNTS: Final = ("variants", "analyses", "done", "failed", "suspect", "left")
DISK_KB_PER_ANALYSIS: Final = 6.0  # journal line, parquet row and solver log
PROFILES: Final = Path("workflow/profiles")


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyState:
    """Progress of a study.

    Attributes:
        done: Analyses with a row, whatever its status.
        failed: Those without a usable result.
        cpu_s: Processor time of the finished analyses.
        recovery_steps: Analyses by the highest recovery step they used.
        suspect: Analyses that a user should check.
        variants_left: Variants with analyses that are not done.
        notes: Sentences about lines of the journals that do not count, and about analyses that
            ended their workers.
    """

    variants: int
    analyses: int
    done: int
    failed: int
    cpu_s: float
    recovery_steps: dict[int, int] = field(default_factory=dict[int, int])
    statuses: dict[str, int] = field(default_factory=dict[str, int])
    suspect: int = 0
    variants_left: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def left(self) -> int:
        """Analyses still to run."""
        return self.analyses - self.done


def study_state(
    run_keys: Mapping[str, Sequence[str]], content: JournalContent, limits: SuspectLimits = LIMITS
) -> StudyState:
    """Count the finished analyses of a study, from its `run_keys` by variant and its journals."""
    done = content.rows
    rows = [done[key] for keys in run_keys.values() for key in keys if key in done]
    return StudyState(
        variants=len(run_keys),
        analyses=sum(len(keys) for keys in run_keys.values()),
        done=len(rows),
        failed=sum(row["status"] in FAILED for row in rows),
        cpu_s=sum(row["cpu_s"] for row in rows if row["cpu_s"] == row["cpu_s"]),
        recovery_steps=_counts(row["recovery_rung"] for row in rows),
        statuses=_counts(row["status"] for row in rows),
        suspect=sum(bool(reasons(row, limits)) for row in rows),
        variants_left=tuple(
            slug for slug, keys in run_keys.items() if not all(key in done for key in keys)
        ),
        notes=(*content.sentences, *_crash_notes(rows)),
    )


def _crash_notes(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return notes on analyses that ended or stopped their workers."""
    notes = [failure_note(row) for row in rows if row["status"] == CRASH]
    if len(notes) > SHOWN_CRASHES:
        notes[SHOWN_CRASHES:] = [f"and {len(notes) - SHOWN_CRASHES} more with status {CRASH}"]
    return [*notes, "`skewbridge study retry` lets the study try them again."] if notes else []


def _counts(values: Iterable[Any]) -> dict[Any, int]:
    return dict(sorted(Counter(values).items()))


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
            return cls(
                cores=profile["set-threads"]["analyse"],
                jobs=profile["jobs"],
            )
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
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    folder = StudyFolder(Path(config.results))
    keys = analysis_keys(config, slugs)
    each = _count_motions(config) * len(config.motions.incidence_deg)
    by_variant = {slug: len(keys[slug]) if slug in keys else each for slug in slugs}
    state = study_state(
        keys or dict.fromkeys(slugs, ("",) * each), read_content(folder.journals), config.suspect
    )
    notes, trials = state.notes, 1
    if config.motions.design == "ida":
        low_g, high_g = config.motions.level_range_g
        trials = most_trials((low_g, high_g))
        notes = (*notes, f"Counted are searches of up to {trials} analyses; the cost is of all.")
    cpu_s = state.cpu_s / state.done if state.done else TYPICAL_MOTION_S * CPU_S_PER_MOTION_S
    summary = {
        **{name: getattr(state, name) for name in COUNTS},
        "core_hours": round(trials * state.analyses * cpu_s / 3600, 3),
        "eta_s": round(trials * state.left * cpu_s / CORES, 1),
        "disk_mb": round(trials * state.analyses * DISK_KB_PER_ANALYSIS / 1024, 1),
        "ledger": {"status": state.statuses, "recovery_step": state.recovery_steps},
    }
    if size is not None:
        summary |= _jobs(summary, size, state)
    return Forecast(summary=summary, analyses_by_variant=by_variant, notes=notes)


def analysis_keys(config: StudyConfig, slugs: Sequence[str]) -> dict[str, list[str]]:
    """Return the keys of the analyses by variant; empty before their motions are prepared."""
    folder = StudyFolder(Path(config.results))
    if not (folder.suite.is_file() and folder.intensities.is_file()):
        return {}
    try:
        setup = StudySetup.of(config)
        return {slug: [run_key(task) for task in setup.tasks(slug)] for slug in slugs}
    except (InputError, KeyError):  # prepared by another version, or for other bridges
        return {}


def failed_analyses(config: StudyConfig) -> list[dict[str, Any]]:
    """Return the analyses of a study without a usable result, with the command of each alone."""
    folder = StudyFolder(Path(config.results))
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    rows = read_journals(folder)
    wanted = [key for keys in analysis_keys(config, slugs).values() for key in keys]
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


def _jobs(summary: Mapping[str, Any], size: JobSize, state: StudyState) -> dict[str, Any]:
    """Return the jobs of a cluster, one for each variant with analyses left."""
    jobs = len(state.variants_left)
    left_h = summary["eta_s"] * CORES / 3600 / size.cores
    return {
        "jobs": jobs,
        "job_cores": size.cores,
        "job_hours": round(left_h / max(jobs, 1), 2),
        "hours": round(left_h / max(jobs, 1) * ceil(jobs / size.jobs), 2),
    }


def _count_motions(config: StudyConfig) -> int:
    total = 0
    for source in suite_sources(config.motions):
        available = len(list_motions(source.folder))
        total += available if source.count is None else min(source.count, available)
    return total
