"""Progress and forecast of a study: analyses done, failed and remaining, and their cost."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Final

from skewbridge.analysis.settings import AnalysisSettings
from skewbridge.bridge.library import load_structure
from skewbridge.demands.validity import reasons
from skewbridge.errors import InputError
from skewbridge.files.tables import read_stamp, read_table
from skewbridge.motions.blocks import Placed, planned_runs, unread
from skewbridge.motions.folder import IndexEntry, list_motions
from skewbridge.motions.levels import FACTOR_LIMITS, most_trials
from skewbridge.motions.suite import read_entry, suite_sources
from skewbridge.statuses import FAILED
from skewbridge.study.analyses import StudySetup, analyses_s, check_plan, forecast_s, run_command
from skewbridge.study.config import StudyConfig
from skewbridge.study.folder import DEFAULT_ROOT, OUT_OF_TIME, last_plan, round_line
from skewbridge.study.jobs import made_from, rule_digest
from skewbridge.study.journal import JournalContent, Row, read_content
from skewbridge.study.task import run_key
from skewbridge.variant.grid import expand_grid

CRASH: Final = "crash"
CORES: Final = 2  # workers of a study
# source: folders of the default study (38 MB) and of the demo (12 MB)
DISK_KB_PER_ANALYSIS: Final = 24.0  # journal line, parquet row and, mostly, messages of the solver
DISK_KB_PER_VARIANT: Final = 800.0  # figures, page and tables
# Processor time of the other work of a study, on the processor of `forecast_s`.
# source: 2 to 24 variants under 3 to 32 motions, two processors
START_S: Final = 10.0  # Snakemake, motions and contact checks
JOB_START_S: Final = 2.7  # start of a job
TAIL_S: Final = 11.5  # tables, figures and page
TAIL_S_PER_VARIANT: Final = 2.9  # fits and figures; up to two processors share them


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyProgress:
    """Progress and cost of a study.

    `summary` has the numbers of variants and analyses: done (with any status), failed (no usable
    result), suspect (to be checked by the user) and remaining, and the forecast. `ledger` counts
    the finished analyses for each status and each highest recovery step.
    """

    summary: dict[str, Any]
    failures: list[dict[str, Any]]  # failed analyses, each with the command that repeats it
    rows: list[Row]  # finished analyses
    variants: dict[str, int]  # number of analyses by variant
    notes: tuple[str, ...]  # on crashed analyses and on unused journal lines


def study_progress(
    run_keys: Mapping[str, Sequence[str]], content: JournalContent, results: str = DEFAULT_ROOT
) -> StudyProgress:
    """Return the progress of a study, given the `run_keys` of each variant and the journals."""
    done, analyses = content.rows, sum(map(len, run_keys.values()))
    rows = [done[key] for keys in run_keys.values() for key in keys if key in done]
    failures = [
        {"variant": row["variant"], "motion": row["motion_id"], "status": row["status"]}
        | {"reason": row["collapse_criterion"], "command": run_command(row, results)}
        for row in rows
        if row["status"] in FAILED
    ]
    notes = content.sentences
    if crashes := sum(row["status"] == CRASH for row in rows):
        text = f"Analyses that ended their workers (status {CRASH}): {crashes}; `skewbridge status "
        notes += (f"{text}--failed` lists them and `skewbridge study retry` repeats them.",)
    if done and not rows:
        text = (
            f"None of the {len(done)} stored analyses has the present sources, settings and motions"
            ": the study will repeat its analyses."
            if any(map(any, run_keys.values()))
            else "The motions are new or changed: the study prepares them first, and then repeats "
            f"only those of the {len(done)} stored analyses that the change affects."
        )
        notes += (text,)
    ledger = {
        name: dict(sorted(Counter(row[column] for row in rows).items()))
        for name, column in (("status", "status"), ("recovery_step", "recovery_rung"))
    }
    suspect = sum(bool(reasons(row)) for row in rows)
    summary: dict[str, Any] = {"variants": len(run_keys), "analyses": analyses, "done": len(rows)}
    summary |= {"failed": len(failures), "suspect": suspect, "left": analyses - len(rows)}
    return StudyProgress(
        summary=summary | {"ledger": ledger},
        failures=failures,
        rows=rows,
        variants={slug: len(keys) for slug, keys in run_keys.items()},
        notes=notes,
    )


def forecast_study(config: StudyConfig) -> StudyProgress:
    """Return the progress of a study with its cost in the summary.

    An analysis is done if its key is in a journal or a current table of demands. The cost follows
    from the lengths of the motions and the measured cost of finished analyses.
    """
    keys, durations_s = analysis_keys(config)
    folder = config.folder
    content = read_content(folder.journals)
    lacking = [slug for slug in keys if not content.rows.keys() >= {*filter(None, keys[slug])}]
    content = replace(content, rows=_tabulated(config, lacking) | content.rows)
    state = study_progress(keys, content, config.results)
    notes, factor = state.notes, 1
    if plan := last_plan(folder) if config.design.until and state.rows else None:
        notes = (*notes, f"{round_line(plan)}.")
        resumes = plan["ended"] == OUT_OF_TIME and config.design.hours > plan["hours"]
        if plan["ended"] is not None and not resumes:
            state = replace(state, summary=state.summary | {"left": 0})
    if config.motions.design == "ida":
        factor = most_trials(config.motions.level_range_g)
        notes = (*notes, f"Each count is a search of up to {factor} analyses; the cost covers all.")
    if config.motions.design == "stripes" and not any(map(any, keys.values())):
        limits = "{:g} to {:g}".format(*FACTOR_LIMITS)
        notes = (*notes, f"Fewer if motions need factors outside {limits} at some stripes.")
    described = {name: load_structure(name).description for name in config.grid.bridge}
    costly = [name for name, it in described.items() if it.joints_m or it.details == "script"]
    if costly and not state.rows:
        text = "can take up to 9 times as long: scripts and joints inside a bridge are not forecast"
        notes = (*notes, f"Analyses of {', '.join(costly)} {text}.")
    speed = measured_speed(state.rows, config.analysis)
    expected_s = {
        "analyses": factor * analyses_s(config, durations_s),
        "checks": check_plan(config, durations_s)[1],
        "other": START_S + TAIL_S + (JOB_START_S + TAIL_S_PER_VARIANT) * len(keys),
    }
    cpu_s = {name: round(speed * time_s, 1) for name, time_s in expected_s.items()}
    analyses, remaining = (factor * state.summary[name] for name in ("analyses", "left"))
    left_s = cpu_s["analyses"] * remaining / max(analyses, 1)
    is_made = not remaining and folder.report.is_file()
    other_s = 0.0 if is_made else cpu_s["checks"] + cpu_s["other"]
    summary = state.summary | {"core_hours": round(sum(cpu_s.values()) / 3600, 4), "cpu_s": cpu_s}
    summary["eta_s"] = round((left_s + other_s) / CORES, 1)
    disk_kb = analyses * DISK_KB_PER_ANALYSIS + len(keys) * DISK_KB_PER_VARIANT
    summary["disk_mb"] = round(disk_kb / 1024, 1)
    return replace(state, summary=summary, notes=notes)


def _tabulated(config: StudyConfig, slugs: Iterable[str]) -> dict[str, Row]:
    """Return the rows, by run key, of those demands files of variants that would not be redone."""
    rows = dict[str, Row]()
    if paths := [path for slug in slugs for path in config.folder.demands_files(slug)]:
        digests = made_from(config)
        current = {rule_digest(digests[rule]) for rule in ("analyse", "analyse_round")}
        for path in paths:
            with suppress(InputError):  # damaged
                if read_stamp(path).get("rule_digest") in current:
                    rows |= {row["run_key"]: row for row in read_table(path).to_pylist()}
    return rows


def measured_speed(rows: Iterable[Row], settings: AnalysisSettings, time: str = "cpu_s") -> float:
    """Return the measured (column ``time``) / expected time of all rows; 1 without timed rows."""
    columns = (time, "duration_s")
    timed = [row for row in rows if all((row[name] or 0.0) > 0.0 for name in columns)]
    expected_s = sum(forecast_s(row["duration_s"], row["abutment"], settings) for row in timed)
    return sum(row[time] for row in timed) / expected_s if timed else 1.0


def other_work_s(
    study: StudyConfig, durations_s: Sequence[float], speed: float, cores: float
) -> float:
    """Return the wall time (s) of checks not yet done, fits, figures and page of a study."""
    variants = len(expand_grid(study.grid))
    _, rows_s = check_plan(study, durations_s)
    tail_s = TAIL_S + TAIL_S_PER_VARIANT * variants / min(cores, 2.0)
    checks_s = 0.0
    if not study.folder.sensitivity.is_file():
        done = read_content([study.folder.journal("sensitivity")]).rows.values()
        spent_s = sum(row["wall_s"] for row in done if row["wall_s"] == row["wall_s"])
        checks_s = max(rows_s * speed - spent_s, 0.0)
    return tail_s * speed + checks_s / cores


def analysis_keys(config: StudyConfig) -> tuple[Mapping[str, Sequence[str]], Sequence[float]]:
    """Return the run keys of each variant and the lengths (s) of the motions.

    Before the motions are prepared from the present files and configuration, the keys are empty,
    and every motion is counted at every stripe.
    """
    slugs = [variant.slug for variant in expand_grid(config.grid)]
    with suppress(InputError, KeyError):  # prepared by another version, or for other bridges
        if _is_prepared(config):
            setup = StudySetup.of(config)
            keys = {slug: [run_key(task) for task in setup.planned_tasks(slug)] for slug in slugs}
            return keys, setup.durations_s
    durations_s: list[float] = []
    rows: list[Placed] = []
    levels = len(config.motions.stripes_g) if config.motions.design == "stripes" else 1
    for source in suite_sources(config.motions):
        entries = list_motions(source.folder)[: source.count] * levels
        durations_s += [min(_length_s(entry), config.motions.shaking_s or inf) for entry in entries]
        rows += unread(len(entries), source.name)
    runs = planned_runs(config.grid, config.motions, rows)
    return {slug: ("",) * len(runs[slug]) for slug in slugs}, durations_s


def _is_prepared(config: StudyConfig) -> bool:
    """Return whether the workflow would leave the tables of the motions as they are."""
    folder = config.folder
    if not (folder.suite.is_file() and folder.intensities.is_file()):
        return False
    made_by = read_stamp(folder.suite).get("rule_digest")
    return made_by in (None, rule_digest(made_from(config)["prepare_motions"]))


def _length_s(entry: IndexEntry) -> float:
    """Return the length (s) of a listed motion, without generating a motion that has no files."""
    if entry.components or not (entry.dt_s and entry.npts.isdigit()):
        return read_entry(entry).duration_s
    return entry.dt_s * int(entry.npts)
