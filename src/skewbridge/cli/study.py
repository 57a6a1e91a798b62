"""Commands for whole studies: start, plan, compare, trace, maintain and publish them."""

from contextlib import chdir
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from skewbridge.cli.options import (
    DEFAULT_CONFIG,
    LIMIT_STATES,
    OUT,
    PLANNED_STUDY,
    STUDY,
    config_of,
    folder_of,
    study_of,
)
from skewbridge.cli.output import (
    NO_VALUE,
    Answer,
    Arg,
    Opt,
    Printed,
    command,
    messages,
    new_group,
    number,
    warn,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.files.text import writable_file, writable_folder, write_text
from skewbridge.statuses import FAILED

if TYPE_CHECKING:
    from skewbridge.study.config import StudyConfig

#: Tables and pictures of a finished study, which `make demo-data` writes.
DEMO_STUDY: Final = Path(__file__).parent / "demo_study"

commands = new_group()
study = new_group("study", "Maintain and publish a study: retry, journal, plot, methods, archive.")
commands.add_typer(study)


@command(commands, Arg("folder", Path, "Folder of the study; created if missing.", ...))
def init(folder: Path) -> Answer:
    """Write Snakefile, rules, configuration and motions of a study to a folder.

    Example: skewbridge init my_study
    """
    from skewbridge.study.folder import write_starter

    written = [str(path) for path in write_starter(folder)]
    note = (
        f"cd {folder}, then: snakemake -j2 --configfile config/smoke.yaml (a small study) or "
        "snakemake -j2 (the default study; skewbridge plan shows its cost)"
    )
    table = Printed([{"written": path} for path in written])
    return Answer({"written": written}, [table], notes=[note])


@command(commands, OUT._replace(default=Path("demo")))
def demo(out: Path) -> Answer:
    """Write the report of a small stored study to a folder, in seconds.

    It is the study of config/demo.yaml: eight variants of one bridge under 16 motions.

    Example: skewbridge demo --out demo
    """
    from skewbridge.report.html.page import write_report
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder, starter_files

    stored = StudyFolder(DEMO_STUDY)
    page = writable_folder(out).resolve() / "report.html"
    try:
        with chdir(starter_files()):  # the configuration names its limit states relative to it
            config = load_config(Path("config/demo.yaml"), base=DEFAULT_CONFIG)
            write_report(
                tables=stored.report_inputs,
                figures=stored.figures,
                config=config.model_dump(mode="json", exclude={"batches"}),
                output=page,
            )
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"the stored study does not fit this version of the report ({error!r}); "
            "`make demo-data` in a clone makes it again"
        ) from error
    report = {"report": str(page)}
    return Answer(report, [Printed([report])])


@command(
    commands,
    PLANNED_STUDY,
    Opt("profile", str | None, "Profile of a cluster: adds the jobs and hours there.", None,
        "slurm|FOLDER"),
)  # fmt: skip
def plan(study: Path | None, profile: str | None) -> Answer:
    """Show the variants, analyses, cost and progress of a study.

    For a finished study, also show how many motions decide each headline answer.

    Example: skewbridge plan --config config/smoke.yaml
    """
    from skewbridge.analysis.modal import periods_of_file, standing_bridge
    from skewbridge.files.tables import read_frame, records_of
    from skewbridge.study.inputs import check_inputs

    config, folder = study_of(study)
    check_inputs(config)
    for name in config.bridges_with_periods():
        for warning in periods_of_file(name, standing_bridge(name)):
            warn(warning)
    summary, variants = _forecast(config, profile)
    table = folder.fragility("needed_motions")
    needed = records_of(read_frame(table)) if table.is_file() else []
    printed = [Printed.of(["variant", "analyses"], variants.items()), _study_table(summary)]
    if needed:
        rows = [
            {
                **_pair_names(row),
                "change": f"{row['axis']} {row['from_value']:g} to {row['to_value']:g}",
                "verdict": row["verdict"],
                "motions": row["n_motions"],
                "forecast": row["forecast"],
                "needed motions": row["needed_motions"],
                "more analyses": row["more_analyses"],
                "more core hours": row["more_core_hours"],
            }
            for row in needed
        ]
        reason = "no number of motions is needed or found; see the column forecast"
        printed.append(Printed(rows, "Motions that decide the pooled effects", reason))
    return Answer(summary | {"needed_motions": needed}, printed)


@command(
    commands,
    Opt("failed", bool, "List the analyses without a usable result.", False),
    PLANNED_STUDY,
)
def status(failed: bool, study: Path | None) -> Answer:
    """Show how many analyses are done, failed and left, and the last failure.

    With --failed, list each analysis without a usable result and the command that repeats it.

    Example: skewbridge status --study results/smoke
    """
    from skewbridge.study.progress import failed_analyses

    config, folder = study_of(study)
    failures = failed_analyses(config)
    if failed:
        rows = [{name: row[name] for name in ("variant", "motion", "status")} for row in failures]
        notes = [f"{row['command']}   # {row['reason']}" for row in failures]
        answer = {"failed": len(failures), "analyses": failures}
        return Answer(answer, [Printed(rows)], notes=notes)
    summary, _ = _forecast(config)
    notes = [
        f"last failure: {last['variant']} under {last['motion']}: {last['status']} "
        f"({last['reason']}); repeat it with: {last['command']}"
        for last in failures[-1:]
    ]
    answer = {"results": config.results, "last_failure": failures[-1] if failures else None}
    return Answer(summary | answer, [_study_table(summary, f"Study in {folder.root}")], notes=notes)


@command(
    commands,
    Arg("first", Path, "Folder of a study, or its table of demands.", ...),
    Arg("second", Path, "The same for the second study.", ...),
    LIMIT_STATES,
    Opt("im", str, "Intensity measure of the medians.", "im_saavg_rotd50_g", "COLUMN"),
    Opt("margin", float, "Relative change that counts as negligible.", 0.05),
    Opt("out", Path | None, "CSV file for all rows, including each variant."),
)
def compare(
    first: Path, second: Path, limit_states: Path, im: str, margin: float, out: Path | None
) -> Answer:
    """Compare two studies run by run: ratios of demands and of medians.

    Ratios are those of the second study over the first. Runs are paired where bridge, abutment
    model, all axes, motion, scale and incidence agree.

    Example: skewbridge compare results/smoke other/results/smoke
    """
    import pandas as pd

    from skewbridge.files.tables import records_of, write_csv
    from skewbridge.study.results import compare_studies

    if out is not None and out.suffix != ".csv":
        raise InputError(f"--out must end with .csv, got {out.name}")
    pair = compare_studies(first, second, limit_states, im=im, margin=margin)
    if out is not None:
        write_csv(pd.concat([pair.demands, pair.medians], ignore_index=True), out)
    pooled, medians = (
        records_of(table[table["scope"] == "pooled"]) for table in (pair.demands, pair.medians)
    )
    reason = "fewer than two motions have a value in both studies"
    printed = [
        Printed([_comparison_row(row) for row in rows], f"{title}, {second} over {first}", reason)
        for title, rows in (("Demands", pooled), (f"Median capacities ({im})", medians))
    ]
    notes = [
        "{pairs} pairs of {variants} variants and {motions} motions; {only_first} runs of the "
        "first and {only_second} of the second study have no partner".format(**pair.counts)
    ]
    if pair.counts["equal_pairs"]:
        notes.append(f"{pair.counts['equal_pairs']} pairs have exactly the same demands")
    if pair.other_motions:
        notes.append(
            f"warning: {len(pair.other_motions)} motions have the same name in both studies but "
            f"different files, and are left out: {', '.join(pair.other_motions[:5])}"
        )
    answer = {
        "counts": pair.counts,
        "other_motions": list(pair.other_motions),
        "demands": records_of(pair.demands),
        "medians": records_of(pair.medians),
        "medians_by_state": medians,
    }
    return Answer(answer, printed, notes=notes)


@command(commands, Arg("file", Path, "Table, figure, page or JSON of a study or run.", ...), STUDY)
def provenance(file: Path, study: Path | None) -> Answer:
    """Show where a result comes from and whether it is up to date.

    Exits with 1 if the present sources and configuration give another result.

    Example: skewbridge provenance results/smoke/demands.parquet --study results/smoke
    """
    from skewbridge.study.jobs import origin_of

    config = config_of(study)
    origin = origin_of(file, config, DEFAULT_CONFIG)
    now = origin["now"]
    rows = [
        {"provenance": name, "of the file": value,
         "now": "same" if now.get(name) == value else now.get(name, "")}
        for name, value in sorted(origin["provenance"].items())
    ]  # fmt: skip
    if not origin["current"]:
        notes = ["not current: the present sources or configuration give another result"]
        if "config_digest" in origin["differences"]:
            notes.append(f"compared with {config}; for another study add --study RESULTS_FOLDER")
    elif origin["differences"]:
        unused = ", ".join(origin["differences"])
        notes = [f"current: the file does not depend on what differs ({unused})"]
    else:
        notes = ["current: the present sources and configuration give this result"]
    exit_code = 0 if origin["current"] else EXIT_FAILED
    return Answer(origin, [Printed(rows)], notes=notes, exit_code=exit_code)


@command(
    study,
    Opt("status", Literal["failed", *FAILED],
        "Status of the analyses to repeat; failed: all without a usable result.", "failed"),
    STUDY,
)  # fmt: skip
def retry(status: str, study: Path | None) -> Answer:
    """Forget failed analyses, so that the next run of the study repeats them.

    Example: skewbridge study retry --status crash --study results
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import forget

    statuses = FAILED if status == "failed" else (status,)
    rows = [
        {"variant": row["variant"], "motion": row["motion_id"], "status": row["status"]}
        for row in forget(StudyFolder(folder_of(study)), statuses)
    ]
    note = f"{len(rows)} analyses will be repeated when the study runs"
    return Answer({"forgotten": len(rows), "analyses": rows}, [Printed(rows)], notes=[note])


@command(study, Opt("compact", bool, "Remove repeated, outdated and damaged lines.", False), STUDY)
def journal(compact: bool, study: Path | None) -> Answer:
    """Count the lines of the journals of finished analyses.

    Example: skewbridge study journal --compact
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import compact_journals, read_content

    folder = StudyFolder(folder_of(study))
    content = compact_journals(folder) if compact else read_content(folder.journals)
    counts = {name: getattr(content, name) for name in ("repeated", "outdated", "damaged")}
    counts = {"analyses": len(content.rows)} | counts
    table = Printed.of(["lines", "count"], counts.items())
    return Answer(counts | {"compacted": compact}, [table])


@command(
    study,
    Arg("names", list[str] | None,
        "File names of figures; * matches any text. Without names: list the figures.", None,
        "[NAME]..."),
    OUT._replace(default=Path()),
    STUDY,
    Opt("width_mm", float | None, "Width; overrides figures.width_mm."),
    Opt("font", str | None, "Font family; overrides figures.font."),
    Opt("font_size_pt", float | None, "Size; overrides figures.font_size_pt."),
)  # fmt: skip
def plot(names: list[str] | None, out: Path, study: Path | None, **given: Any) -> Answer:
    """Draw figures of a finished study again, as SVG and PNG.

    Example: skewbridge study plot '*_curves_*' --width-mm 90 --out paper
    """
    from skewbridge.files.text import checked
    from skewbridge.report.study_figures import draw_figures, finished_figures
    from skewbridge.study.config import FigureSettings, check_font

    config, folder = study_of(study)
    changes = {name: value for name, value in given.items() if value is not None}
    settings = checked(FigureSettings, asdict(config.figures) | changes, "figures")
    check_font(settings.font)
    figures = finished_figures(folder.root)
    if not names:
        table = Printed.of(["name", "title"], ((each.name, each.title) for each, _ in figures))
        return Answer({"figures": table.rows}, [table])
    drawn = [str(path) for path in draw_figures(figures, names, settings, writable_folder(out))]
    return Answer({"written": drawn}, [], notes=[f"written: {path}" for path in drawn])


@command(study, STUDY, Opt("out", Path | None, "Markdown file instead of the terminal."))
def methods(study: Path | None, out: Path | None) -> Answer:
    """Write the methods of a study as a paper describes them, with references.

    The text follows from the configuration and, once prepared, from the sources of the motions.

    Example: skewbridge study methods --out methods.md
    """
    from skewbridge.files.tables import read_frame
    from skewbridge.report.methods import methods_of

    config, folder = study_of(study)
    suite = read_frame(folder.suite) if folder.suite.is_file() else None
    text = methods_of(config, suite).markdown()
    if out is None:
        return Answer({"methods": text}, [text])
    write_text(writable_file(out), text)
    return Answer({"methods": text}, [], notes=[f"written: {out}"])


@command(
    study,
    STUDY,
    Opt("out", Path, "ZIP file to write.", Path("study.zip"), "FILE.zip"),
    Opt("author", list[str] | None, "Author; can be repeated."),
    Opt("licence", str, "Web address of the licence of the results.",
        "https://creativecommons.org/licenses/by/4.0/", flags="--license"),
)  # fmt: skip
def archive(study: Path | None, out: Path, author: list[str] | None, licence: str) -> Answer:
    """Put a finished study into one RO-Crate (ZIP) for the supplement of a paper.

    Contains workflow, configuration, tables, report and methods, and describes them with digests,
    versions and licences. No accelerations: recorded motions may not be redistributed.

    Example: skewbridge study archive --author "A. Engineer" --out study.zip
    """
    from skewbridge.report.archive import write_archive

    if out.suffix != ".zip":
        raise InputError(f"--out must end with .zip, got {out.name}")
    written = write_archive(
        config_of(study), DEFAULT_CONFIG, out, licence=licence, authors=author or ()
    )
    size = out.stat().st_size
    for doubt in written.doubts:
        warn(doubt)
    return Answer(
        {"archive": str(out), "bytes": size, "files": written.names, "doubts": written.doubts},
        [Printed([{"in the archive": name} for name in written.names])],
        notes=[f"{out}: {size / 1e6:.1f} MB"],
    )


def _forecast(
    config: "StudyConfig", profile: str | None = None
) -> tuple[dict[str, Any], dict[str, int]]:
    """Return the forecast of a study and the number of analyses of each variant."""
    from skewbridge.study.progress import forecast_study, job_size

    forecast = forecast_study(config, job_size(profile) if profile else None)
    for note in forecast.notes:
        messages.print(note)
    return forecast.summary, forecast.variants


def _study_table(summary: dict[str, Any], title: str | None = None) -> Printed:
    """Return the forecast of a study as a table."""
    ledger = summary["ledger"]
    rows = {name: value for name, value in summary.items() if name != "ledger"}
    rows |= {f"status {name}": count for name, count in ledger["status"].items()}
    rows |= {f"recovery step {step}": count for step, count in ledger["recovery_step"].items()}
    return Printed.of(["study", "value"], rows.items(), title=title)


def _pair_names(row: dict[str, Any]) -> dict[str, str]:
    """Return the names of an effect: bridge with abutment model, demand."""
    abutment = row["abutment"].replace("_", "-")
    return {"bridge": f"{row['bridge']} {abutment}", "demand": row["demand"]}


def _comparison_row(row: dict[str, Any]) -> dict[str, str]:
    """Return a row of a comparison as it is printed."""
    names, form = ("ratio", "ci_low", "ci_high"), ".3f"
    if row["judged_by"] == "difference":
        names, form = ("difference", "difference_low", "difference_high"), "+.3g"
    values = [row[name] for name in names]
    value, low, high = ("0" if not item else number(item, form=form) for item in values)
    return {
        **_pair_names(row),
        "change": f"{value} {row['unit']}".strip() if value != NO_VALUE else value,
        f"{row['level']:.0%} interval": f"{low}..{high}",
        "verdict": row["verdict_family"],
        "motions": str(row["n_motions"]),
        "pairs": str(row["n_pairs"]),
    }
