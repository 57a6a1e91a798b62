"""What a study will cost and how far it is, from its configuration alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path
from typing import Any, Final

from skewbridge.errors import InputError
from skewbridge.motions.index import list_motions
from skewbridge.motions.levels import most_trials
from skewbridge.statuses import FAILED
from skewbridge.study.cluster import JobSize
from skewbridge.study.config import StudyConfig, analysis_sections
from skewbridge.study.costs import CPU_S_PER_MOTION_S
from skewbridge.study.folder import StudyFolder
from skewbridge.study.journal import read_content, read_journals
from skewbridge.study.plan import planned_keys
from skewbridge.study.progress import run_command, study_state
from skewbridge.variant.grid import expand_grid

TYPICAL_MOTION_S: Final = 25.0  # of the embedded suite
CORES: Final = 2  # that a study works with
COUNTS: Final = ("variants", "analyses", "done", "failed", "suspect", "left")
DISK_KB_PER_ANALYSIS: Final = 6.0  # journal line, parquet row and solver log


@dataclass(frozen=True, slots=True, kw_only=True)
class Forecast:
    """Summary by name, analyses by variant, and what the user should know besides."""

    summary: dict[str, Any]
    analyses_by_variant: dict[str, int]
    notes: tuple[str, ...] = ()


def forecast_study(config: StudyConfig, size: JobSize | None = None) -> Forecast:
    """Return what a study needs and what of it is done.

    Done is what the journals have, by the keys of the analyses: those of the list that the
    workflow wrote, and for variants that are not on it those that the prepared motions give.
    Before the motions are prepared the number of motions is the configured one.

    Args:
        config: The study.
        size: Of the jobs of a cluster; the summary then has `jobs` and `job_cores`, and the wall
            time of one job and of all, `job_hours` and `hours`, with as many at once as the profile
            allows and no waiting in the queue.
    """
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    folder = StudyFolder(Path(config.results))
    keys = analysis_keys(config, slugs, folder)
    each = _count_motions(config) * len(config.motions.incidence_deg)
    by_variant = {slug: len(keys[slug]) if slug in keys else each for slug in slugs}
    state = replace(
        study_state(keys, read_content(folder.journals), config.suspect),
        variants=len(slugs),
        analyses=sum(by_variant.values()),
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
        "ledger": {"status": state.statuses, "rung": state.rungs},
    }
    if size is not None:
        summary |= _jobs(summary, size, config.batches.cpu_hours)
    return Forecast(
        summary=summary,
        analyses_by_variant=by_variant,
        notes=notes,
    )


def analysis_keys(
    config: StudyConfig, slugs: Sequence[str], folder: StudyFolder
) -> dict[str, list[str]]:
    """Return the keys of the analyses by variant, of those variants for which they are known."""
    planned = planned_keys(folder)
    keys = {slug: planned[slug] for slug in slugs if slug in planned}
    new = [slug for slug in slugs if slug not in planned]
    if not new or not (folder.suite.is_file() and folder.intensities.is_file()):
        return keys
    from skewbridge.study.keys import run_key
    from skewbridge.study.setup import StudySetup

    try:
        setup = StudySetup.from_sections(analysis_sections(config), folder)
        return keys | {slug: [run_key(task) for task in setup.tasks(slug)] for slug in new}
    except (InputError, KeyError):  # prepared by another version, or for other bridges
        return keys


def failed_analyses(config: StudyConfig) -> list[dict[str, Any]]:
    """Return the analyses of a study without a usable result, with the command of each alone."""
    folder = StudyFolder(Path(config.results))
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    rows = read_journals(folder)
    wanted = [key for own in analysis_keys(config, slugs, folder).values() for key in own]
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


def parts_of(config: StudyConfig, cpu_hours: float) -> int:
    """Return into how many jobs of so many processor hours the analyses that are left are cut."""
    return _parts_of(forecast_study(config).summary, cpu_hours)


def _parts_of(summary: Mapping[str, Any], cpu_hours: float) -> int:
    return max(1, min(ceil(_left_cpu_hours(summary) / cpu_hours), summary["left"]))


def _jobs(summary: Mapping[str, Any], size: JobSize, cpu_hours: float | None) -> dict[str, Any]:
    jobs = _parts_of(summary, cpu_hours or size.cpu_minutes / 60)
    job_hours = _left_cpu_hours(summary) / jobs / size.cores
    return {
        "jobs": jobs,
        "job_cores": size.cores,
        "job_hours": round(job_hours, 2),
        "hours": round(job_hours * ceil(jobs / size.jobs), 2),
    }


def _left_cpu_hours(summary: Mapping[str, Any]) -> float:
    return summary["eta_s"] * CORES / 3600


def _count_motions(config: StudyConfig) -> int:
    found = len(list_motions(Path(config.motions.folder)))
    return found if config.motions.count is None else min(config.motions.count, found)
