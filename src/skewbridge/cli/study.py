"""Commands for whole studies: start, plan, compare, trace, maintain and publish them."""

from contextlib import chdir
from dataclasses import asdict
from pathlib import Path
from shlex import quote
from typing import Annotated, Any, Final

from skewbridge.cli import COMMANDS, new_group
from skewbridge.cli.output import (
    DEFAULT_CONFIG,
    Answer,
    Changes,
    Hazard,
    Out,
    PlannedStudy,
    Study,
    arg,
    command,
    config_of,
    folder_of,
    keys_and_values,
    opt,
    selected,
    study_near,
    study_of,
    with_ending,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_folder
from skewbridge.statuses import FAILED
from skewbridge.units import Units

#: Tables and figures of a finished study, written by `make demo-data`.
DEMO_STUDY: Final = Path(__file__).parent / "demo_study"

#: Printed columns of a table of effects.
_CHANGE: Final = ("bridge", "abutment", "demand", "axis", "from_value", "to_value")
_COUNTED: Final = ("unit", "verdict_family", "n_motions", "n_pairs", "n_bounds")

commands = new_group()
study = new_group(name="study", help=COMMANDS["study"][1])
commands.add_typer(study)


@command(commands)
def init(folder: Annotated[Path, arg("Folder of the study; created if missing.")]) -> Answer:
    """Write Snakefile, rules, configuration and motions of a study to a folder.

    Example: skewbridge init my_study
    """
    from skewbridge.study.folder import write_starter

    note = (
        f"cd {quote(str(folder))}, then: snakemake -j2 --configfile config/smoke.yaml (a small "
        "study) or snakemake -j2 (the default study; skewbridge plan shows its cost)"
    )
    return Answer({"written": list(map(str, write_starter(folder)))}, notes=[note])


@command(commands)
def demo(units: Units, out: Out = Path("demo")) -> Answer:
    """Write the report of a small stored study to a folder, in seconds.

    It is the study of config/demo.yaml: eight variants of one bridge under 16 motions.

    Example: skewbridge demo --out demo
    """
    from skewbridge.report.page import write_report
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder, starter_files

    stored = StudyFolder(DEMO_STUDY)
    page = writable_folder(out).resolve() / "report.html"
    with chdir(starter_files()):  # the path of the limit states is relative to this folder
        study = load_config(Path("config/demo.yaml"), base=DEFAULT_CONFIG)
        tables, figures = stored.report_inputs, stored.figures
        write_report(tables=tables, figures=figures, study=study, output=page, units=units)
    notes = ["the pictures of the page are stored in SI units"] if units == "us" else []
    return Answer({"report": str(page)}, notes=notes)


@command(commands)
def plan(study: PlannedStudy = None) -> Answer:
    """Show the variants, analyses, cost and progress of a study.

    For a finished study, also show how many motions the interval of each pooled effect needs to
    decide it, without an adjustment for the number of effects as in the verdicts of the report.

    Example: skewbridge plan --config config/smoke.yaml
    """
    from skewbridge.analysis.modal import periods_of_file, standing_bridge
    from skewbridge.files.tables import read_frame, records_of
    from skewbridge.study.inputs import axis_warnings, check_inputs
    from skewbridge.study.progress import forecast_study

    config = study_of(study)
    check_inputs(config)
    warnings = list(axis_warnings(config))
    for name in config.bridges_with_periods():
        warnings += periods_of_file(name, standing_bridge(name))
    forecast = forecast_study(config)
    table = config.folder.fragility("needed_motions")
    needed_rows = records_of(read_frame(table)) if table.is_file() else []
    columns = ("needed_motions", "more_analyses", "more_core_hours")
    rows = selected(needed_rows, *_CHANGE, "verdict", "n_motions", "forecast", *columns)
    printed = {
        **forecast.summary,
        "analyses of": forecast.variants,
        "Motions with which the interval of a pooled effect alone decides it": rows,
    }
    reason = "no more motions are needed, or no number was found; see the column forecast"
    answer = forecast.summary | {"needed_motions": needed_rows}
    return Answer(answer, printed, notes=forecast.notes, missing=reason, warnings=warnings)


@command(commands)
def status(
    failed: Annotated[bool, opt("List the failed analyses.", None, "--failed")] = False,
    study: PlannedStudy = None,
) -> Answer:
    """Show how many analyses are done, failed and left, and the last failure.

    With --failed, list each analysis without a usable result and the command that repeats it.

    Example: skewbridge status --study results/smoke
    """
    from skewbridge.study.progress import forecast_study

    config = study_of(study)
    forecast = forecast_study(config)
    failures = forecast.failures
    if failed:
        printed = {"failed": selected(failures, "variant", "motion", "status", "reason")}
        notes = [row["command"] for row in failures]
        if not notes:
            notes = [f"0 of {forecast.summary['done']} finished analyses have failed"]
            notes += forecast.notes
        return Answer({"failed": len(failures), "analyses": failures}, printed, notes=notes)
    last = failures[-1] if failures else None
    answer = {"results": config.results, **forecast.summary, "last_failure": last}
    return Answer(answer, notes=forecast.notes)


@command(commands)
def compare(
    first: Annotated[Path, arg("Folder of a study, or its table of demands.")],
    second: Annotated[Path, arg("Second study: folder or table of demands.")],
    hazard: Hazard = None,
    out: Annotated[Path | None, opt("CSV file for all rows, also of single variants.")] = None,
) -> Answer:
    """Compare two studies run by run: ratios of demands and of medians.

    Ratios are the second study over the first, for limit states and intensity measure of the
    first (with a hazard curve, its measure). Runs are paired if bridge, abutment model, all axes,
    motion, scale and incidence are equal.

    Example: skewbridge compare results/smoke other/results/smoke
    """
    import pandas as pd

    from skewbridge.files.tables import records_of, write_csv
    from skewbridge.study.results import compare_studies

    path = out and with_ending(out, ".csv")
    pair = compare_studies(first, second, hazard)
    if path is not None:
        write_csv(pd.concat([pair.demands, pair.medians], ignore_index=True), path)
    tables = {name: records_of(getattr(pair, name)) for name in ("demands", "medians", "rates")}
    pooled = {name: [r for r in rows if r["scope"] == "pooled"] for name, rows in tables.items()}
    label = f"{second} over {first}"
    printed = {
        **pair.counts,
        f"Demands, {label}": list(map(_comparison_row, pooled["demands"])),
        f"Median capacities ({pair.im}), {label}": list(map(_comparison_row, pooled["medians"])),
    }
    if hazard is not None:
        columns = ("bridge", "component", "limit_state", "ratio", "ci_low", "ci_high")
        printed[f"Annual rates, {label}"] = selected(pooled["rates"], *columns)
    answer = {"counts": pair.counts, "other_motions": pair.other_motions, **tables}
    answer |= {"medians_by_state": pooled["medians"]}
    warnings = list(pair.warnings)
    if names := pair.other_motions:
        text = "motions have the same name in both studies but different files, and are left out"
        warnings.append(f"{len(names)} {text}: {', '.join(names[:5])}")
    reason = "fewer than three motions (or earthquakes) have values in both studies, or no curve"
    return Answer(answer, printed, missing=reason, warnings=warnings, digits=4)


@command(commands)
def provenance(
    file: Annotated[Path, arg("Table, figure, page or JSON of a study or run.")],
) -> Answer:
    """Show where a result comes from and whether it is up to date.

    Exits with 1 if the present sources, or the configuration of the study in whose folder the file
    is (otherwise config/config.yaml), would give a different result.

    Example: skewbridge provenance results/smoke/demands.parquet
    """
    from skewbridge.study.jobs import origin_of

    config = study_near(file)
    origin = origin_of(file, lambda: study_of(config))
    result = "current" if origin["current"] else "not current: its rule would give a new result"
    notes = [f"{result}; compared with {config}"]
    return Answer(origin, notes=notes, exit_code=0 if origin["current"] else EXIT_FAILED)


@command(study)
def retry(
    status: Annotated[
        str, opt("Status to repeat; failed: all without result.", f"[failed|{'|'.join(FAILED)}]")
    ] = "failed",
    study: Study = None,
) -> Answer:
    """Forget failed analyses, so that the next run of the study repeats them.

    Example: skewbridge study retry --status crash --study results
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import forget

    if status not in ("failed", *FAILED):
        raise InputError(f"--status must be one of failed, {', '.join(FAILED)}; got {status!r}")
    statuses = FAILED if status == "failed" else (status,)
    folder = folder_of(study)
    if folder == study and not folder.is_dir():  # a configuration may not have results yet
        raise InputError(f"there is no folder {folder}")
    rows = [
        {"variant": row["variant"], "motion": row["motion_id"], "status": row["status"]}
        for row in forget(StudyFolder(folder), statuses)
    ]
    note = f"analyses that the next run of the study repeats: {len(rows)}"
    return Answer({"forgotten": len(rows), "analyses": rows}, notes=[note])


@command(study)
def plot(
    units: Units,
    names: Annotated[list[str] | None, arg("Figures (* matches any text).", "[NAME]...")] = None,
    out: Out = Path(),
    study: Study = None,
    changes: Changes = None,  # keys of figures
) -> Answer:
    """Draw figures of a finished study again, as SVG and PNG.

    Example: skewbridge study plot '*_curves_*' --set width_mm=90 --out paper
    """
    from skewbridge.files.text import checked
    from skewbridge.report.study_figures import draw_figures, finished_figures
    from skewbridge.study.config import FigureSettings, check_font, stored_configuration
    from skewbridge.study.results import is_from_statistics

    study_folder = folder_of(study)
    defaults = FigureSettings()
    if not is_from_statistics(study_folder):
        config = stored_configuration(study) if study else None  # needs no other file of the study
        defaults = (config or study_of(study)).figures
    set_values = keys_and_values("--set", changes)
    if units != "si":  # the default, which keeps the units of the study
        set_values["units"] = units
    settings = checked(FigureSettings, asdict(defaults) | set_values, "figures")
    check_font(settings.font)
    figures = finished_figures(study_folder)
    if not names:
        rows = [{"name": caption.name, "title": caption.title} for caption, _ in figures]
        return Answer({"figures": rows})
    files = draw_figures(figures, names, settings, writable_folder(out))
    return Answer({"written": list(map(str, files))})


@command(study)
def methods(study: Study = None) -> Answer:
    """Write the methods section of a study for a paper, with references, in Markdown.

    The text uses the configuration and, if the motions are prepared, their sources.

    Example: skewbridge study methods > methods.md
    """
    from skewbridge.files.tables import read_frame
    from skewbridge.report.methods import methods_of

    config = study_of(study)
    suite = read_frame(path) if (path := config.folder.suite).is_file() else None
    text = methods_of(config, suite).markdown()
    return Answer({"methods": text}, text)


@command(study)
def archive(
    study: Study = None,
    out: Annotated[Path, opt("ZIP file to write.", "FILE.zip")] = Path("study.zip"),
    author: Annotated[list[str] | None, opt("Author; can be repeated.")] = None,
) -> Answer:
    """Put a finished study into one RO-Crate (ZIP) for the supplement of a paper.

    Contains workflow, configuration, tables, report and methods, and describes them with digests,
    versions and licences. Accelerations are left out: records may not be redistributed.

    Example: skewbridge study archive --author "A. Engineer" --out study.zip
    """
    from skewbridge.report.archive import write_archive

    with_ending(out, ".zip")
    names, doubts = write_archive(config_of(study), DEFAULT_CONFIG, out, author or ())
    size = {"archive": str(out), "bytes": out.stat().st_size}
    return Answer(size | {"files": names, "doubts": doubts})


def _comparison_row(row: dict[str, Any]) -> dict[str, Any]:
    """Return the printed columns of a comparison: the ratio, or the difference in its unit."""
    is_ratio = row["judged_by"] != "difference"
    value, prefix = ("ratio", "ci") if is_ratio else ("difference", "difference")
    n_far, cells = (row.get(name) or 0 for name in ("n_extrapolated", "n_cells"))
    return {
        **{name: row[name] for name in _CHANGE[:3]},
        "change": row[value],
        "low": row[f"{prefix}_low"],
        "high": row[f"{prefix}_high"],
        **{name: row[name] for name in _COUNTED},
        "extrapolated": f"{n_far:.0f} of {2 * cells:.0f} medians" if n_far > 0 else "",
    }
