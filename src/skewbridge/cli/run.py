"""Commands that analyse or check one case: run, contact, deck, doctor, verify."""

import time
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from skewbridge.cli import new_group
from skewbridge.cli.output import (
    Answer,
    Out,
    Study,
    VariantOptions,
    arg,
    command,
    failure_notes,
    gap_notes,
    messages,
    opt,
    selected,
    study_of,
    with_ending,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder
from skewbridge.statuses import RAN
from skewbridge.units import Units

if TYPE_CHECKING:
    from skewbridge.study.task import Task

commands = new_group()

Case = Annotated[Path, arg("The case file.", "CASE.yaml")]
Accuracy = Literal["reference", "default", "fast"]
_PAIR: Final = opt("Components along x and y, or p695 and record number.")
_SUPPORTS: Final = opt("YAML list of support, direction, record: instead of --motion.", "FILE")
#: Printed columns of the demands; --json gives all.
_SHOWN: Final = (
    *("variant", "motion_id", "scale", "status", "collapse_criterion", "beyond_model", "suspect"),
    *("column_shear_dcr", "column_drift_ratio", "deck_disp_m", "unseating_m"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadingOptions:
    """Motion and numerical settings of an analysis."""

    motion: Annotated[tuple[Path, Path] | None, _PAIR] = None
    support_motions: Annotated[Path | None, _SUPPORTS] = None
    scale: Annotated[float, opt("Scale factor of both components.")] = 1.0
    incidence_deg: Annotated[float, opt("Angle from bridge x to component 1, in deg.")] = 0.0
    scheme: Annotated[Literal["default", "paper"], opt("Integration scheme.")] = "default"
    accuracy: Annotated[Accuracy, opt("Set of numerics (fast: for trials).")] = "default"
    dt_s: Annotated[float | None, opt("Time step in s; overrides the step of --accuracy.")] = None
    duration_s: Annotated[float | None, opt("Truncate the motion to this length in s.")] = None


@command(commands)
def run(
    case: VariantOptions,
    loading: LoadingOptions,
    out: Out,
    units: Units,
    row: Annotated[str | None, opt("Repeat the row of a study with this key.", "RUN_KEY")] = None,
    study: Study = None,
) -> Answer:
    """Analyse one variant under one motion and draw its histories.

    Exits with 1 if the analysis failed numerically; a collapse is a valid result.

    Example: skewbridge run --skew-deg 30 --motion A.AT2 B.AT2 --out run30
    """
    task = _task(case, loading) if row is None else _task_of_row(row, study, case, loading)
    import pandas as pd
    from rich.progress import Progress

    from skewbridge.analysis.bridge_check import doubts
    from skewbridge.bridge.catalogue import read_bridge
    from skewbridge.bridge.library import is_script
    from skewbridge.demands.tables import to_table
    from skewbridge.demands.validity import with_suspect
    from skewbridge.files.digests import engine_digest, provenance
    from skewbridge.files.tables import figure_metadata, write_frame, write_table
    from skewbridge.motions.intensity import cut_warning
    from skewbridge.report.appearance import shown_in
    from skewbridge.report.run_figures import run_figures
    from skewbridge.study.batch import row_of_task
    from skewbridge.study.task import outcome_of, run_key

    key, log = run_key(task), writable_folder(out) / "opensees.log"
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    with Progress(console=messages, transient=True) as bar:
        job = bar.add_task(task.variant.slug, total=None)

        def show(done_s: float, total_s: float) -> None:
            bar.update(job, completed=done_s, total=total_s)

        result = task.analyse(histories=True, log_path=log, progress=show)
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    demands = with_suspect(row_of_task({**outcome_of(result), **times}, task, key))
    motion, histories = task.motion.motion, pd.DataFrame(result.histories)
    digests = provenance(motion_sha256=motion.sha256, run_key=key, engine_digest=engine_digest())
    write_table(to_table([demands], digests), out / "demands.parquet")
    write_frame(histories, out / "histories.parquet", digests)
    write_frame(pd.DataFrame(result.bents), out / "capacities.parquet", digests)
    title = f"{task.variant.slug}, {motion.motion_id} x {task.motion.scale:g}"
    with shown_in(units):
        drawn = run_figures(histories, title=title)
    for name, figure in drawn.items():
        for path in (out / f"{name}.png", out / f"{name}.svg"):
            figure.savefig(path, dpi=150, metadata=figure_metadata(digests))
    warnings = [*filter(None, [cut_warning(motion, task.settings.duration_s)])]
    if not is_script(task.variant.bridge):
        warnings += doubts(read_bridge(task.variant.bridge))
    read = [text for record in (task.supports or {"": motion}).values() for text in record.messages]
    notes = [*failure_notes(demands), *gap_notes(task.variant.bridge), *read, *result.messages]
    notes.append(f"written to {out}")
    code = 0 if result.status in RAN else EXIT_FAILED
    return Answer(demands, selected([demands], *_SHOWN)[0], notes, code, warnings=warnings)


def _task(case: VariantOptions, loading: LoadingOptions) -> "Task":
    from skewbridge.bridge.library import load_structure
    from skewbridge.motions.intensity import motion_measures, scaled_measures
    from skewbridge.motions.read import read_support_motions
    from skewbridge.motions.record import GroundMotion, SuiteMotion
    from skewbridge.motions.suite import read_pair
    from skewbridge.study.task import Task

    supports: dict[str, GroundMotion] = {}
    if loading.motion is not None and loading.support_motions is None:
        motion = read_pair(*loading.motion)
    elif loading.motion is None and loading.support_motions is not None:
        supports = read_support_motions(loading.support_motions)
        motion = supports.get("bent 1", next(iter(supports.values())))
    else:
        choices = "two files with --motion, a file with --support-motions, or a row of a study"
        raise InputError(f"the motion is missing or given twice: give {choices} with --row")
    variant, scale = case.variant.normalised(), loading.scale
    analysis_keys = {name: getattr(loading, name) for name in ("scheme", "dt_s", "duration_s")}
    settings, options = case.settings_and_model(loading.accuracy, **analysis_keys)
    measures = scaled_measures(motion_measures(motion, load_structure(variant.bridge).t1_s), scale)
    return Task(
        variant=variant,
        motion=SuiteMotion(motion=motion, scale=scale, measures=measures),
        incidence_deg=loading.incidence_deg,
        settings=settings,
        options=options,
        supports=supports,
    )


def _task_of_row(key: str, study: Path | None, *options: Any) -> "Task":
    """Return the analysis of a study with this run key; raise `InputError` if there is none.

    No field of ``options`` may differ from its default.
    """
    from skewbridge.files.tables import read_table
    from skewbridge.study.analyses import StudySetup
    from skewbridge.study.journal import read_content
    from skewbridge.study.task import run_key

    changed = [
        "--set" if field.name == "changes" else f"--{field.name.replace('_', '-')}"
        for group in options
        for field in fields(group)
        if getattr(group, field.name) != field.default
    ]
    if changed:
        raise InputError(f"--row repeats an analysis without changes: omit {', '.join(changed)}")
    config = study_of(study)
    folder = config.folder
    row = read_content(folder.journals).rows.get(key)
    if row is None and folder.demands.is_file():
        rows: list[dict[str, Any]] = read_table(folder.demands).to_pylist()
        row = next((row for row in rows if row["run_key"] == key), None)
    if row is None:
        raise InputError(
            f"row {key}: no such run_key in the journals or {folder.demands}; run the study first "
            "or give another study with --study"
        )
    task = StudySetup.of(config).task_of(row)
    if task is None:
        raise InputError(
            f"row {key}: the study in {folder.root} no longer has motion {row['motion_id']} with "
            f"factor {row['scale']:g} at {row['incidence_deg']:g} degrees"
        )
    if run_key(task) != key:
        messages.print("settings or sources have changed since, so the result may differ")
    return task


@command(commands)
def contact(
    case: Case, out: Annotated[Path, opt("File for the forces along the path.", "F.csv")]
) -> Answer:
    """Drive one contact unit along a displacement path.

    The case file names a CSV file with the columns t_s, ux_m, uy_m and uz_m (positive opens).

    Example: skewbridge contact slide.yaml --out forces.csv
    """
    from skewbridge.verification.references.driven_unit import run_contact_case

    return Answer(run_contact_case(case, with_ending(out, ".csv")))


@command(commands)
def deck(case: Case, out: Annotated[Path, opt("File for the histories.", "F.parquet")]) -> Answer:
    """Run the rigid skew deck under a pulse or a record.

    The case file chooses the solver: OpenSees, a penalty ODE or an LCP. Its skew is positive
    clockwise from above, opposite to that of bridges.

    Example: skewbridge deck deck30.yaml --out deck30.parquet
    """
    from skewbridge.verification.references.deck_solvers import run_deck_case

    return Answer(run_deck_case(case, with_ending(out, ".parquet")))


@command(commands)
def doctor() -> Answer:
    """Check the environment: versions, OpenSees, a one-second self-test.

    Example: skewbridge doctor
    """
    import platform
    from importlib.metadata import version

    packages = ("openseespy", "numpy", "scipy", "pandas", "pyarrow", "joblib", "snakemake")
    report: dict[str, Any] = {"python": platform.python_version()}
    report |= {name: version(name) for name in packages}
    try:
        from skewbridge.verification.registry import run_study

        checks = run_study("gate").table()
        failed = [str(name) for name in checks.loc[~checks["pass"], "quantity"]]
        report["self_test"] = f"failed: {', '.join(failed)}" if failed else "passed"
    except ImportError as error:
        failed = ["import"]
        report["self_test"] = f"OpenSees cannot be imported ({error}): run make setup again"
    return Answer(report | {"ok": not failed}, exit_code=EXIT_FAILED if failed else 0)


@command(commands)
def verify(
    names: Annotated[list[str] | None, arg("Studies; default: short ones.", "[NAME...]")] = None,
    out: Annotated[Path | None, opt("Folder for tables and figures.")] = None,
    records: Annotated[
        Path | None, opt("Folder of one or more recorded events (`painter`).", "DIR")
    ] = None,
) -> Answer:
    """Repeat the studies of the paper and compare with their references.

    Exits with 1 if a comparison fails. A statement of the paper that does not hold is no failure.

    Example: skewbridge verify fig1 fig3
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.verification.registry import run_studies

    folder = out or StudyFolder().verification
    rows = run_studies(names or [], folder, report_progress=messages.print, records=records)
    checks = [row for row in rows if "outcome" not in row]
    statements = [row for row in rows if "outcome" in row]
    columns = ("study", "quantity", "value", "reference", "tolerance", "pass")
    details = ("quantity", "source", "study", "case", "reason", "outcome")
    title = "Statements of the paper (a disagreement is not a failure)"
    shown = [row | ({} if row["tolerance"] is not None else {"pass": "no limit"}) for row in checks]
    printed = {"Verification": selected(shown, *columns), title: selected(statements, *details)}
    notes = [f"{row['quantity']}: {row['missed']}" for row in checks if row.get("missed")]
    exit_code = 0 if all(row["pass"] for row in rows) else EXIT_FAILED
    return Answer(rows, printed, notes, exit_code)
