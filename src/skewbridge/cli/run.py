"""`skewbridge run`: one analysis with its demands, histories and figures."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from skewbridge.cli.options import OUT, STUDY, VARIANT, settings_and_model, study_of, variant_of
from skewbridge.cli.output import UNITS, Answer, Opt, command, in_units, messages, new_group
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder
from skewbridge.units import Units

if TYPE_CHECKING:
    from skewbridge.analysis.transient import AnalysisResult
    from skewbridge.study.task import Task

commands = new_group()


@command(
    commands,
    *VARIANT,
    OUT,
    Opt("motion", tuple[Path, Path] | None,
        "Two component files: along x and along y at incidence 0."),
    Opt("figures", bool, "Draw the figures.", True, flags="--figures/--no-figures"),
    Opt("save_model", bool, "Write the model as an OpenSeesPy script.", False),
    Opt("row_key", str | None, "Repeat this row of the demands of --study.", None, "RUN_KEY",
        flags="--row"),
    STUDY,
    Opt("scale", float, "Factor on both components.", 1.0),
    Opt("incidence_deg", float, "Angle from bridge x to component 1.", 0.0),
    Opt("scheme", Literal["default", "paper"], "Integration scheme.", "default"),
    Opt("accuracy", Literal["reference", "default", "fast"], "Set of numerics.", "default"),
    Opt("dt_s", float | None, "Time step in s; overrides the step of --accuracy."),
    Opt("duration_s", float | None, "Cut the motion to this length."),
    UNITS,
)  # fmt: skip
def run(out: Path, **given: Any) -> Answer:
    """Analyse one variant under one motion and draw its histories.

    Collapse is a result; an analysis that failed numerically exits with 1.

    Example: skewbridge run --skew-deg 30 --motion A.AT2 B.AT2 --out run30
    """
    if given["row_key"] is not None:
        task = _task_of_row(given["row_key"], given["study"])
    else:
        task = _task(given)
    result, row = _analysed(task, writable_folder(out))
    title = f"{task.variant.slug}, {task.motion.motion.motion_id} x {task.motion.scale:g}"
    written = _write(task, result, row, out, figures_title=title if given["figures"] else "")
    if given["save_model"]:
        from skewbridge.analysis.model_script import model_script

        script = model_script(task.variant, task.settings.model_options(task.options))
        (out / "model.py").write_text(script, encoding="utf-8")
        written.append("model.py")
    text = (
        f"{task.variant.slug} under {task.motion.motion.motion_id} x {task.motion.scale:g}: "
        f"{_result(row, given['units'])}.\n{_limits(row, result.messages)}\n"
        f"Files in {out}: {', '.join(written)}."
    )
    has_result = result.status in ("ok", "collapse")
    return Answer(row, [text], exit_code=0 if has_result else EXIT_FAILED)


def _task(given: Mapping[str, Any]) -> "Task":
    """Return the analysis that the options ask for."""
    from skewbridge.bridge.catalogue import load_bridge
    from skewbridge.motions.intensity import motion_measures, scaled_measures
    from skewbridge.motions.read import read_motion
    from skewbridge.motions.record import SuiteMotion
    from skewbridge.study.task import Task

    if given["motion"] is None:
        raise InputError("motion: name two component files, or a row of a study with --row")
    variant, scale = variant_of(given).normalised(), given["scale"]
    settings, options = settings_and_model(given, ("scheme", "dt_s", "duration_s"))
    motion = read_motion(*given["motion"])
    measures = scaled_measures(motion_measures(motion, load_bridge(variant.bridge).t1_s), scale)
    return Task(
        variant=variant,
        motion=SuiteMotion(motion=motion, scale=scale, measures=measures),
        incidence_deg=given["incidence_deg"],
        settings=settings,
        options=options,
    )


def _task_of_row(key: str, study: Path | None) -> "Task":
    """Return the analysis of a row of the demands of a study, finished or not.

    Raises:
        InputError: The study has no such row, or its configuration no longer has the analysis.
    """
    from skewbridge.files.tables import read_table
    from skewbridge.study.analyses import StudySetup
    from skewbridge.study.journal import read_content
    from skewbridge.study.task import run_key

    config, folder = study_of(study)
    row = read_content(folder.journals).rows.get(key)
    if row is None and folder.demands.is_file():
        rows: list[dict[str, Any]] = read_table(folder.demands).to_pylist()
        row = next((row for row in rows if row["run_key"] == key), None)
    if row is None:
        raise InputError(
            f"row {key}: no such run_key in the journals and {folder.demands}; run the study first "
            "or name another with --study"
        )
    task = StudySetup.of(config).task_of(row)
    if task is None:
        raise InputError(
            f"row {key}: the study in {folder.root} no longer has {row['motion_id']} x "
            f"{row['scale']:g} at {row['incidence_deg']:g} degrees"
        )
    if run_key(task) != key:
        messages.print("settings or sources have changed since: the result may differ")
    return task


def _analysed(task: "Task", out: Path) -> tuple["AnalysisResult", dict[str, Any]]:
    """Run the task with a progress bar; return the result and its row of the demands table."""
    from rich.progress import Progress

    from skewbridge.analysis.transient import analyse
    from skewbridge.demands.validity import LIMITS, SUSPECT, reasons
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
    task: "Task", result: "AnalysisResult", row: dict[str, Any], out: Path, *, figures_title: str
) -> list[str]:
    """Write the row, the histories and, given a title, the figures; return the file names."""
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
    if not figures_title:
        return written
    from skewbridge.report.run_figures import run_figures

    for name, figure in run_figures(histories, title=figures_title).items():
        for path in (out / f"{name}.png", out / f"{name}.svg"):
            figure.savefig(path, dpi=150, metadata=figure_metadata(digests))
        written.append(f"{name}.png and .svg")
    if result.contact_layout is not None:
        from skewbridge.report.contact_replay import replay_page

        page = out / "contact_replay.html"
        text = replay_page(result.contact_layout, histories, title=figures_title)
        page.write_text(text, encoding="utf-8")
        stamp(page, digests)
        written.append(page.name)
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
