"""`skewbridge run`: one analysis with its demands, histories and figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from skewbridge.cli.output import EXIT_FAILED, JsonOption, clear_errors, emit, messages
from skewbridge.cli.study import DEFAULT_CONFIG
from skewbridge.cli.us_units import UnitsOption
from skewbridge.cli.variant_options import (
    OutOption,
    SetOption,
    VariantChoice,
    settings_and_options,
    takes_variant,
)
from skewbridge.errors import InputError
from skewbridge.provenance.files import writable_folder

if TYPE_CHECKING:
    from skewbridge.analysis.result import AnalysisResult
    from skewbridge.analysis.settings import AnalysisSettings
    from skewbridge.study.task import Task
    from skewbridge.variant.options import ModelOptions
    from skewbridge.variant.variant import Variant

MotionOption = Annotated[
    tuple[Path, Path] | None,
    typer.Option("--motion", help="Two component files: along x and along y at incidence 0."),
]
ScaleOption = Annotated[float, typer.Option("--scale", help="Factor on both components.")]
IncidenceOption = Annotated[
    float, typer.Option("--incidence-deg", help="From bridge x to component 1.")
]
SchemeOption = Annotated[
    Literal["default", "paper"], typer.Option("--scheme", help="How to integrate.")
]
AccuracyOption = Annotated[
    Literal["reference", "default", "fast"], typer.Option("--accuracy", help="Set of numerics.")
]
DtOption = Annotated[
    float | None, typer.Option("--dt-s", help="Regular time step instead of the accuracy's.")
]
DurationOption = Annotated[
    float | None, typer.Option("--duration-s", help="Cut the motion to this window.")
]
SaveModelOption = Annotated[
    bool, typer.Option("--save-model", help="Write the model as an OpenSeesPy script, model.py.")
]
RowOption = Annotated[
    str | None,
    typer.Option(
        "--row", metavar="RUN_KEY", help="Of results/demands.parquet: repeat that analysis."
    ),
]
ConfigOption = Annotated[Path, typer.Option("--config", help="Configuration of that study.")]
FiguresOption = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")]


@clear_errors
@takes_variant()
def run(
    choice: VariantChoice,
    out: OutOption,
    motion: MotionOption = None,
    scale: ScaleOption = 1.0,
    incidence_deg: IncidenceOption = 0.0,
    scheme: SchemeOption = "default",
    accuracy: AccuracyOption = "default",
    dt_s: DtOption = None,
    duration_s: DurationOption = None,
    changes: SetOption = None,
    figures: FiguresOption = True,
    save_model: SaveModelOption = False,
    study_row: RowOption = None,
    config: ConfigOption = DEFAULT_CONFIG,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
) -> None:
    """Analyse one variant under one motion; collapse is a result, a failure exits with 1."""
    if study_row is not None:
        task = _task_of_row(study_row, config)
    elif motion is None:
        raise InputError("motion: name two component files, or a row of a finished study")
    else:
        named = {"scheme": scheme, "dt_s": dt_s, "duration_s": duration_s}
        settings, options = settings_and_options(changes, named, accuracy)
        task = _task(choice.variant().normalised(), motion, scale, incidence_deg, settings, options)
    result, row = _analysed(task, writable_folder(out))
    _write(task, result, row, out, figures=figures)
    if save_model:
        from skewbridge.analysis.model_script import model_script

        script = model_script(task.variant, task.settings.model_options(task.options))
        (out / "model.py").write_text(script, encoding="utf-8")
    emit(row, as_json=as_json, units=units)
    suspect = [f"suspect: {row['suspect']}"] if row["suspect"] else []
    for text in (*result.messages, *suspect):
        messages.print(text)
    if result.status not in ("ok", "collapse"):
        raise typer.Exit(EXIT_FAILED)


def _task(
    variant: "Variant",
    files: tuple[Path, Path],
    scale: float,
    incidence_deg: float,
    settings: "AnalysisSettings",
    options: "ModelOptions",
) -> "Task":
    """Return the analysis that the options ask for."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.motions.intensity import motion_measures, scaled_measures
    from skewbridge.motions.read import read_motion
    from skewbridge.motions.record import SuiteMotion
    from skewbridge.study.task import Task

    t1_s = load_bridge(variant.bridge).t1_s
    motion = read_motion(*files)
    measures = scaled_measures(motion_measures(motion, t1_s), scale)
    return Task(
        variant=variant,
        motion=SuiteMotion(motion=motion, scale=scale, measures=measures),
        incidence_deg=incidence_deg,
        settings=settings,
        options=options,
    )


def _task_of_row(key: str, config: Path) -> "Task":
    """Return the analysis behind a row of the demands of a study.

    Args:
        key: Its ``run_key``.
        config: Configuration of the study.

    Raises:
        InputError: No results here, no such row, or the configuration has no such analysis.
    """
    from skewbridge.provenance.tables import read_table
    from skewbridge.study.config import analysis_sections, load_config
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import read_journals
    from skewbridge.study.keys import run_key
    from skewbridge.study.setup import StudySetup

    study = load_config(config, base=DEFAULT_CONFIG)
    folder = StudyFolder(Path(study.results))
    row = read_journals(folder).get(key)  # of a study that is not finished, too
    if row is None:
        table = folder.demands
        if not table.is_file():
            raise InputError(f"row {key}: there is no {table}; run the study first")
        rows: list[dict[str, Any]] = read_table(table).to_pylist()
        row = next((row for row in rows if row["run_key"] == key), None)
        if row is None:
            raise InputError(f"row {key}: no such run_key in {table} ({len(rows)} rows)")
    setup = StudySetup.from_sections(analysis_sections(study), folder)
    task = setup.task_of(row)
    if task is None:
        raise InputError(
            f"row {key}: {config} has no {row['motion_id']} x {row['scale']:g} at "
            f"{row['incidence_deg']:g} degrees"
        )
    if run_key(task) != key:
        messages.print("settings or sources have changed since: the result may differ")
    return task


def _analysed(task: "Task", out: Path) -> tuple["AnalysisResult", dict[str, Any]]:
    """Run the task with a progress bar; return the result and its row of the demands table."""
    import time

    from rich.progress import Progress

    from skewbridge.analysis.suspect import LIMITS, SUSPECT, reasons
    from skewbridge.analysis.transient import analyse
    from skewbridge.study.keys import run_key
    from skewbridge.study.task import outcome_of
    from skewbridge.study.worker import identity_of

    identity = identity_of(task, run_key(task))
    wall_s, cpu_s = time.perf_counter(), time.process_time()
    with Progress(console=messages, transient=True) as bar:
        job = bar.add_task(task.variant.slug, total=None)
        result = analyse(
            task.variant,
            task.excitation,
            task.settings,
            task.options,
            histories=True,
            log_path=out / "opensees.log",
            progress=lambda done_s, total_s: bar.update(job, completed=done_s, total=total_s),
        )
    times = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
    row = {**identity, **outcome_of(result), **times}
    return result, {**row, SUSPECT: reasons(row, LIMITS)}


def _write(
    task: "Task", result: "AnalysisResult", row: dict[str, Any], out: Path, *, figures: bool
) -> None:
    """Write the row, the histories and the figures of an analysis."""
    import pandas as pd

    from skewbridge.demands.tables import write_demands
    from skewbridge.provenance.digests import source_digest
    from skewbridge.provenance.stamp import stamp
    from skewbridge.provenance.tables import provenance, write_frame
    from skewbridge.study.keys import ANALYSIS_MODULE

    digests = provenance(
        motion_sha256=task.motion.motion.sha256,
        run_key=row["run_key"],
        engine_digest=source_digest(ANALYSIS_MODULE),
    )
    write_demands([row], out / "demands.parquet", digests)
    histories = pd.DataFrame(result.histories)
    write_frame(histories, out / "histories.parquet", digests)
    if not figures:
        return
    from skewbridge.report.run_figures import run_figures

    title = f"{task.variant.slug}, {task.motion.motion.motion_id} x {task.motion.scale:g}"
    for name, figure in run_figures(histories, title=title).items():
        for path in (out / f"{name}.png", out / f"{name}.svg"):
            figure.savefig(path, dpi=150)
            stamp(path, digests)
    if result.contact_layout is not None:
        from skewbridge.report.contact_replay import replay_page

        page = replay_page(result.contact_layout, histories, title=title)
        (out / "contact_replay.html").write_text(page, encoding="utf-8")
        stamp(out / "contact_replay.html", digests)


COMMANDS: Final = (run,)
