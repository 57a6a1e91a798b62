"""`skewbridge run`: one analysis with its demands, histories and figures."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from skewbridge.cli.options import (
    DEFAULT_CONFIG,
    Opt,
    OutOption,
    SetOption,
    StudyOption,
    VariantChoice,
    config_of,
    settings_and_options,
    takes,
    takes_variant,
)
from skewbridge.cli.output import (
    Command,
    JsonOption,
    Units,
    UnitsOption,
    emit_json,
    in_units,
    messages,
    new_group,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder

if TYPE_CHECKING:
    from skewbridge.analysis.transient import AnalysisResult
    from skewbridge.study.task import Task
    from skewbridge.variant.variant import Variant

commands = new_group()


@commands.command(cls=Command)
@takes_variant()
@takes(
    Opt("scale", float, "Factor on both components.", 1.0),
    Opt("incidence_deg", float, "Angle from bridge x to component 1.", 0.0),
    Opt("scheme", Literal["default", "paper"], "Integration scheme.", "default"),
    Opt("accuracy", Literal["reference", "default", "fast"], "Set of numerics.", "default"),
    Opt("dt_s", float | None, "Time step; overrides that of --accuracy."),
    Opt("duration_s", float | None, "Cut the motion to this length."),
)
def run(
    choice: VariantChoice,
    out: OutOption,
    motion: Annotated[
        tuple[Path, Path] | None,
        typer.Option(help="Two component files: along x and along y at incidence 0."),
    ] = None,
    changes: SetOption = None,
    figures: Annotated[
        bool, typer.Option("--figures/--no-figures", help="Draw the figures.")
    ] = True,
    save_model: Annotated[
        bool, typer.Option("--save-model", help="Write the model as an OpenSeesPy script.")
    ] = False,
    row_key: Annotated[
        str | None,
        typer.Option("--row", metavar="RUN_KEY", help="Repeat this row of the demands of --study."),
    ] = None,
    study: StudyOption = None,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Analyse one variant under one motion and draw its histories.

    Collapse is a result; an analysis that failed numerically exits with 1.

    Example: skewbridge run --skew-deg 30 --motion A.AT2 B.AT2 --out run30
    """
    if row_key is not None:
        task = _task_of_row(row_key, config_of(study))
    elif motion is None:
        raise InputError("motion: name two component files, or a row of a study with --row")
    else:
        task = _task(choice.variant().normalised(), motion, changes, given)
    result, row = _analysed(task, writable_folder(out))
    written = _write(task, result, row, out, figures=figures)
    if save_model:
        from skewbridge.analysis.model_script import model_script

        script = model_script(task.variant, task.settings.model_options(task.options))
        (out / "model.py").write_text(script, encoding="utf-8")
        written.append("model.py")
    if as_json:
        emit_json(row)
    title = f"{task.variant.slug} under {task.motion.motion.motion_id} x {task.motion.scale:g}"
    (messages.print if as_json else typer.echo)(
        f"{title}: {_result(row, units)}.\n{_limits(row, result.messages)}\n"
        f"Files in {out}: {', '.join(written)}."
    )
    if result.status not in ("ok", "collapse"):
        raise typer.Exit(EXIT_FAILED)


def _task(
    variant: "Variant",
    files: tuple[Path, Path],
    changes: list[str] | None,
    given: Mapping[str, Any],
) -> "Task":
    """Return the analysis that the options ask for."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.motions.intensity import motion_measures, scaled_measures
    from skewbridge.motions.read import read_motion
    from skewbridge.motions.record import SuiteMotion
    from skewbridge.study.task import Task

    named = {name: given[name] for name in ("scheme", "dt_s", "duration_s")}
    settings, options = settings_and_options(changes, named, given["accuracy"])
    motion = read_motion(*files)
    measures = motion_measures(motion, load_bridge(variant.bridge).t1_s)
    scaled = SuiteMotion(
        motion=motion, scale=given["scale"], measures=scaled_measures(measures, given["scale"])
    )
    return Task(
        variant=variant,
        motion=scaled,
        incidence_deg=given["incidence_deg"],
        settings=settings,
        options=options,
    )


def _task_of_row(key: str, config: Path) -> "Task":
    """Return the analysis of a row of the demands of a study, finished or not.

    Raises:
        InputError: The study has no results, no such row, or no such analysis any more.
    """
    from skewbridge.files.tables import read_table
    from skewbridge.study.analyses import StudySetup
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import read_journals
    from skewbridge.study.task import run_key

    study = load_config(config, base=DEFAULT_CONFIG)
    folder = StudyFolder(Path(study.results))
    row = read_journals(folder).get(key)
    if row is None:
        table = folder.demands
        if not table.is_file():
            raise InputError(
                f"row {key}: there is no {table}; run the study first or name another with --study"
            )
        rows: list[dict[str, Any]] = read_table(table).to_pylist()
        row = next((row for row in rows if row["run_key"] == key), None)
        if row is None:
            raise InputError(
                f"row {key}: no such run_key in {table} ({len(rows)} rows); name another study "
                "with --study"
            )
    task = StudySetup.of(study).task_of(row)
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
    from rich.progress import Progress

    from skewbridge.analysis.transient import analyse
    from skewbridge.demands.suspect import LIMITS, SUSPECT, reasons
    from skewbridge.study.batch import row_of_task
    from skewbridge.study.task import outcome_of, run_key

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
    row = row_of_task({**outcome_of(result), **times}, task, run_key(task))
    return result, {**row, SUSPECT: reasons(row, LIMITS)}


def _write(
    task: "Task", result: "AnalysisResult", row: dict[str, Any], out: Path, *, figures: bool
) -> list[str]:
    """Write the row, the histories and the figures of an analysis; return the names of files."""
    import pandas as pd

    from skewbridge.demands.tables import to_table
    from skewbridge.files.digests import engine_digest, provenance
    from skewbridge.files.tables import figure_metadata, stamp, write_frame, write_table

    digests = provenance(
        motion_sha256=task.motion.motion.sha256,
        run_key=row["run_key"],
        engine_digest=engine_digest(),
    )
    write_table(to_table([row], digests), out / "demands.parquet")
    histories = pd.DataFrame(result.histories)
    write_frame(histories, out / "histories.parquet", digests)
    written = ["demands.parquet", "histories.parquet"]
    if not figures:
        return written
    from skewbridge.report.run_figures import run_figures

    title = f"{task.variant.slug}, {task.motion.motion.motion_id} x {task.motion.scale:g}"
    for name, figure in run_figures(histories, title=title).items():
        for path in (out / f"{name}.png", out / f"{name}.svg"):
            figure.savefig(path, dpi=150, metadata=figure_metadata(digests))
        written.append(f"{name}.png and .svg")
    if result.contact_layout is not None:
        from skewbridge.report.contact_replay import replay_page

        page = replay_page(result.contact_layout, histories, title=title)
        (out / "contact_replay.html").write_text(page, encoding="utf-8")
        stamp(out / "contact_replay.html", digests)
        written.append("contact_replay.html")
    return written


def _result(row: Mapping[str, Any], units: Units) -> str:
    """Return status and main demands of an analysis in words."""
    length = "in" if units == "us" else "m"
    (converted,) = in_units([row], units)
    texts = {
        "column_shear_dcr": "column shear {:.3g} of its capacity",
        "column_drift_ratio": "column drift {:.2%}",
        f"deck_disp_{length}": f"deck displacement {{:.3g}} {length}",
        f"unseating_{length}": f"unseating {{:.3g}} {length}",
    }
    values = {name: converted[name] for name in texts}
    known = [texts[name].format(value) for name, value in values.items() if value == value]
    return f"{row['status']}; {', '.join(known) or 'no demand was recorded'}"


def _limits(row: Mapping[str, Any], notes: tuple[str, ...]) -> str:
    """Return failures and exceeded limits of validity in one sentence."""
    found = [f"{row['status']} ({row['collapse_criterion']})"] if row["status"] != "ok" else []
    if row["beyond_model"]:
        found.append(f"a column failed in {row['beyond_model']} at {row['beyond_model_s']:.2f} s")
    found += [f"suspect: {row['suspect']}"] if row["suspect"] else []
    found += [note for note in notes if note not in found]
    return f"{'; '.join(found)}." if found else "No failure; all limits of validity are met."
