"""Commands for whole studies: start, plan, compare, trace, maintain and publish them."""

from contextlib import chdir
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from skewbridge.cli.options import (
    DEFAULT_CONFIG,
    LIMIT_STATES,
    LimitStatesOption,
    Opt,
    OutOption,
    PlannedStudyOption,
    StudyOption,
    config_of,
    folder_of,
    takes,
)
from skewbridge.cli.output import (
    NO_VALUE,
    Command,
    JsonOption,
    emit,
    emit_json,
    emit_table,
    messages,
    new_group,
    number,
)
from skewbridge.errors import EXIT_FAILED, InputError
from skewbridge.statuses import FAILED

#: Tables and pictures of a finished study, which `make demo-data` writes.
DEMO_STUDY: Final = Path(__file__).parent / "demo_study"

commands = new_group()
study = new_group("study", "Maintain and publish a study: retry, journal, plot, methods, archive.")
commands.add_typer(study)


@commands.command(cls=Command)
def init(
    folder: Annotated[Path, typer.Argument(help="Folder of the study; created if missing.")],
    *,
    as_json: JsonOption = False,
) -> None:
    """Write Snakefile, rules, configuration and motions of a study to a folder.

    Example: skewbridge init my_study
    """
    from skewbridge.study.folder import write_starter

    written = [str(path) for path in write_starter(folder)]
    emit({"written": written}, [{"written": path} for path in written], as_json=as_json)
    messages.print(
        f"cd {folder}, then: snakemake -j2 --configfile config/smoke.yaml (a small study) or "
        "snakemake -j2 (the default study; skewbridge plan shows its cost)"
    )


@commands.command(cls=Command)
def demo(*, out: OutOption = Path("demo"), as_json: JsonOption = False) -> None:
    """Write the report of a small stored study to a folder, in seconds.

    It is the study of config/demo.yaml: eight variants of one bridge under 16 motions.

    Example: skewbridge demo --out demo
    """
    from skewbridge.files.text import writable_folder
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
    emit({"report": str(page)}, [{"report": str(page)}], as_json=as_json)


@commands.command(cls=Command)
def plan(
    *,
    study: PlannedStudyOption = None,
    pilot: Annotated[
        int | None,
        typer.Option(
            metavar="MOTIONS",
            help="Run this many motions on corner variants and propose a range of levels.",
        ),
    ] = None,
    profile: Annotated[
        str | None,
        typer.Option(
            metavar="slurm|FOLDER", help="Profile of a cluster: adds the jobs and hours there."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show the variants and analyses of a study, their cost and what is done.

    For a finished study, also show how many motions decide each headline answer.

    Example: skewbridge plan --config config/smoke.yaml
    """
    from skewbridge.analysis.modal import periods_of_file, standing_bridge
    from skewbridge.files.tables import read_frame, records_of
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.inputs import check_inputs

    config = load_config(config_of(study), base=DEFAULT_CONFIG)
    check_inputs(config)
    for name in config.bridges_with_periods():
        for warning in periods_of_file(name, standing_bridge(name)):
            messages.print(f"warning: {warning}", style="yellow")
    if pilot is not None:
        _propose_levels(config, pilot, as_json=as_json)
        return
    summary, variants = _forecast(config, profile)
    table = StudyFolder(Path(config.results)).fragility("needed_motions")
    needed = records_of(read_frame(table)) if table.is_file() else []
    if not as_json:
        emit_table([{"variant": slug, "analyses": count} for slug, count in variants.items()])
    emit(summary | {"needed_motions": needed}, _study_rows(summary), as_json=as_json)
    if needed and not as_json:
        rows = [
            {
                "bridge": f"{row['bridge']} {row['abutment']}".replace("_", "-"),
                "demand": row["demand"],
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
        emit_table(rows, "Motions that decide the pooled effects", missing=reason)


@commands.command(cls=Command)
def status(
    *,
    failed: Annotated[
        bool, typer.Option("--failed", help="List the analyses without a usable result.")
    ] = False,
    study: PlannedStudyOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show how many analyses are done, failed and left, and the last failure.

    With --failed, list each analysis without a usable result and the command that repeats it.

    Example: skewbridge status --study results/smoke
    """
    from skewbridge.study.config import load_config
    from skewbridge.study.progress import failed_analyses

    config = load_config(config_of(study), base=DEFAULT_CONFIG)
    failures = failed_analyses(config)
    if failed:
        rows = [{name: row[name] for name in ("variant", "motion", "status")} for row in failures]
        emit({"failed": len(failures), "analyses": failures}, rows, as_json=as_json)
        for row in failures:
            messages.print(f"{row['command']}   # {row['reason']}")
        return
    summary, _ = _forecast(config)
    last = failures[-1] if failures else None
    title = f"Study in {config.results}"
    answer = summary | {"results": config.results, "last_failure": last}
    emit(answer, _study_rows(summary), as_json=as_json, title=title)
    if last is not None:
        messages.print(
            f"last failure: {last['variant']} under {last['motion']}: {last['status']} "
            f"({last['reason']}); repeat it with: {last['command']}"
        )


@commands.command(cls=Command)
def compare(
    first: Annotated[Path, typer.Argument(help="Folder of a study, or its table of demands.")],
    second: Annotated[Path, typer.Argument(help="The same for the second study.")],
    limit_states: LimitStatesOption = LIMIT_STATES,
    im: Annotated[
        str, typer.Option(metavar="COLUMN", help="Intensity measure of the medians.")
    ] = "im_saavg_rotd50_g",
    margin: Annotated[
        float, typer.Option(help="Relative change that counts as negligible.")
    ] = 0.05,
    out: Annotated[
        Path | None, typer.Option(help="CSV file for all rows, including each variant.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Compare two studies run by run: ratios of demands and of medians.

    Ratios are those of the second study over the first. Runs are paired where bridge, abutment
    model, all axes, motion, scale and incidence agree.

    Example: skewbridge compare results/smoke other/results/smoke
    """
    import pandas as pd

    from skewbridge.fragility.exports import write_csv
    from skewbridge.study.two_studies import compare_studies

    if out is not None and out.suffix != ".csv":
        raise InputError(f"--out must end with .csv, got {out.name}")
    pair = compare_studies(first, second, limit_states, im=im, margin=margin)
    if out is not None:
        write_csv(pd.concat([pair.demands, pair.medians], ignore_index=True), out)
    pooled, medians = (
        table[table["scope"] == "pooled"].to_dict("records")
        for table in (pair.demands, pair.medians)
    )
    if as_json:
        emit_json(
            {
                "counts": pair.counts,
                "other_motions": list(pair.other_motions),
                "demands": pair.demands.to_dict("records"),
                "medians": pair.medians.to_dict("records"),
                "medians_by_state": medians,
            }
        )
        return
    for title, rows in (("Demands", pooled), (f"Median capacities ({im})", medians)):
        reason = "fewer than two motions have a value in both studies"
        table = [_comparison_row(row) for row in rows]
        emit_table(table, f"{title}, {second} over {first}", missing=reason)
    messages.print(
        "{pairs} pairs of {variants} variants and {motions} motions; {only_first} runs of the "
        "first and {only_second} of the second study have no partner".format(**pair.counts)
    )
    if pair.counts["equal_pairs"]:
        messages.print(f"{pair.counts['equal_pairs']} pairs have exactly the same demands")
    if pair.other_motions:
        messages.print(
            f"warning: {len(pair.other_motions)} motions have the same name in both studies but "
            f"different files, and are left out: {', '.join(pair.other_motions[:5])}"
        )


@commands.command(cls=Command)
def provenance(
    file: Annotated[Path, typer.Argument(help="Table, figure, page or JSON of a study or run.")],
    *,
    study: StudyOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show where a result comes from and whether it is up to date.

    Exits with 1 if the present sources and configuration give another result.

    Example: skewbridge provenance results/smoke/demands.parquet --study results/smoke
    """
    from skewbridge.study.products import origin_of

    config = config_of(study)
    origin = origin_of(file, config, DEFAULT_CONFIG)

    def now(name: str, value: str) -> str:
        present = origin.now.get(name, "")
        return "same" if present == value else present

    rows = [
        {"provenance": name, "of the file": value, "now": now(name, value)}
        for name, value in sorted(origin.recorded.items())
    ]
    answer = {"current": origin.is_current, "provenance": origin.recorded, "now": origin.now}
    emit(answer | {"differences": origin.differences}, rows, as_json=as_json)
    if not origin.is_current:
        messages.print("not current: the present sources or configuration give another result")
        if "config_digest" in origin.differences:
            messages.print(f"compared with {config}; name another study with --study")
        raise typer.Exit(EXIT_FAILED)
    if origin.differences:
        unused = ", ".join(origin.differences)
        messages.print(f"current: the file does not depend on what differs ({unused})")
    else:
        messages.print("current: the present sources and configuration give this result")


@study.command(cls=Command)
def retry(
    *,
    status: Annotated[
        str,
        typer.Option(
            metavar=f"[failed|{'|'.join(FAILED)}]",
            help="Status of the analyses to repeat; failed: all without a usable result.",
            autocompletion=lambda: ["failed", *FAILED],
        ),
    ] = "failed",
    study: StudyOption = None,
    as_json: JsonOption = False,
) -> None:
    """Forget failed analyses, so that the next run of the study repeats them.

    Example: skewbridge study retry --status crash --study results
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import forget

    if status != "failed" and status not in FAILED:
        raise InputError(f"status: must be failed or one of {', '.join(FAILED)}, got {status}")
    statuses = FAILED if status == "failed" else (status,)
    rows = [
        {"variant": row["variant"], "motion": row["motion_id"], "status": row["status"]}
        for row in forget(StudyFolder(folder_of(study)), statuses)
    ]
    emit({"forgotten": len(rows), "analyses": rows}, rows, as_json=as_json)
    messages.print(f"{len(rows)} analyses will be repeated when the study runs")


@study.command(cls=Command)
def journal(
    *,
    compact: Annotated[
        bool, typer.Option("--compact", help="Remove repeated, outdated and damaged lines.")
    ] = False,
    study: StudyOption = None,
    as_json: JsonOption = False,
) -> None:
    """Count the lines of the journals of finished analyses.

    Example: skewbridge study journal --compact
    """
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.journal import compact_journals, read_content

    folder = StudyFolder(folder_of(study))
    content = compact_journals(folder) if compact else read_content(folder.journals)
    counts = {
        "analyses": len(content.rows),
        "repeated": content.repeated,
        "outdated": content.outdated,
        "damaged": content.damaged,
    }
    rows = [{"lines": name, "count": count} for name, count in counts.items()]
    emit(counts | {"compacted": compact}, rows, as_json=as_json)


@study.command(cls=Command)
@takes(
    Opt("width_mm", float | None, "Width; overrides figures.width_mm."),
    Opt("font", str | None, "Font family; overrides figures.font."),
    Opt("font_size_pt", float | None, "Size; overrides figures.font_size_pt."),
)
def plot(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="File names of figures; * matches any text. Without names: list the figures.",
        ),
    ] = None,
    out: OutOption = Path(),
    study: StudyOption = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Draw figures of a finished study again, as SVG and PNG.

    Example: skewbridge study plot '*_curves_*' --width-mm 90 --out paper
    """
    from skewbridge.files.checking import checked
    from skewbridge.files.text import writable_folder
    from skewbridge.report.study_figures import draw_figures, finished_figures
    from skewbridge.study.config import FigureSettings, check_font, load_config

    config = load_config(config_of(study), base=DEFAULT_CONFIG)
    changes = {name: value for name, value in given.items() if value is not None}
    settings = checked(FigureSettings, asdict(config.figures) | changes, "figures")
    check_font(settings.font)
    figures = finished_figures(Path(config.results))
    if not names:
        rows = [{"name": figure.name, "title": figure.title} for figure, _ in figures]
        emit({"figures": rows}, rows, as_json=as_json)
        return
    drawn = draw_figures(figures, names, settings, writable_folder(out))
    if as_json:
        emit_json({"written": [str(path) for path in drawn]})
    for path in drawn:
        messages.print(f"written: {path}")


@study.command(cls=Command)
def methods(
    *,
    study: StudyOption = None,
    out: Annotated[Path | None, typer.Option(help="Markdown file instead of the terminal.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Write the methods of a study as a paper describes them, with references.

    The text follows from the configuration and, once prepared, from the sources of the motions.

    Example: skewbridge study methods --out methods.md
    """
    from skewbridge.files.tables import read_frame
    from skewbridge.files.text import writable_file, write_text
    from skewbridge.report.methods import methods_of
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder

    config = load_config(config_of(study), base=DEFAULT_CONFIG)
    suite = StudyFolder(Path(config.results)).suite
    text = methods_of(config, read_frame(suite) if suite.is_file() else None).markdown()
    if out is not None:
        write_text(writable_file(out), text)
        messages.print(f"written: {out}")
    if as_json:
        emit_json({"methods": text})
    elif out is None:
        typer.echo(text)


@study.command(cls=Command)
def archive(
    *,
    study: StudyOption = None,
    out: Annotated[Path, typer.Option(help="ZIP file to write.", metavar="FILE.zip")] = Path(
        "study.zip"
    ),
    author: Annotated[list[str] | None, typer.Option(help="Author; can be repeated.")] = None,
    licence: Annotated[
        str, typer.Option("--license", help="Web address of the licence of the results.")
    ] = "https://creativecommons.org/licenses/by/4.0/",
    as_json: JsonOption = False,
) -> None:
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
    answer = {
        "archive": str(out),
        "bytes": size,
        "files": list(written.names),
        "doubts": list(written.doubts),
    }
    emit(answer, [{"in the archive": name} for name in written.names], as_json=as_json)
    for doubt in written.doubts:
        messages.print(f"warning: {doubt}", style="yellow")
    messages.print(f"{out}: {size / 1e6:.1f} MB")


def _forecast(config: Any, profile: str | None = None) -> tuple[dict[str, Any], dict[str, int]]:
    """Return the forecast of a study and the number of analyses of each variant."""
    from skewbridge.study.progress import JobSize, forecast_study

    size = None if profile is None else JobSize.of_profile(profile)
    forecast = forecast_study(config, size)
    for note in forecast.notes:
        messages.print(note)
    return forecast.summary, forecast.analyses_by_variant


def _study_rows(summary: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of the table that a forecast is printed as."""
    ledger = summary["ledger"]
    rows = {name: value for name, value in summary.items() if name != "ledger"}
    rows |= {f"status {name}": count for name, count in ledger["status"].items()}
    rows |= {f"recovery step {step}": count for step, count in ledger["recovery_step"].items()}
    return [{"study": name, "value": value} for name, value in rows.items()]


def _propose_levels(config: Any, motions: int, *, as_json: bool) -> None:
    """Run a few motions of a study and print the range of levels that they suggest."""
    from skewbridge.study.trial_runs import run_trials

    proposal, rows = run_trials(config, motions)
    variants = len({row["variant"] for row in rows})
    title = f"{len(rows)} analyses of {variants} variants; share = with outcomes on both sides"
    answer = asdict(proposal) | {"analyses": len(rows), "variants": variants}
    emit(answer, proposal.states, as_json=as_json, title=title)
    if as_json:
        return
    for (low_g, high_g), share in (
        (proposal.configured_g, proposal.configured_share),
        (proposal.level_range_g, proposal.share),
    ):
        messages.print(
            f"levels {low_g:g} to {high_g:g} g: at least two motions on both sides of {share:.1%} "
            f"of the {proposal.in_reach} states in reach (of {proposal.n_states})"
        )
    same = proposal.level_range_g == proposal.configured_g
    words = "the configuration can stay:" if same else "to paste into the configuration:"
    messages.print(f"{words}\n{proposal.config_lines}")


def _comparison_row(row: dict[Any, Any]) -> dict[str, str]:
    """Return a row of a comparison as it is printed."""
    names, form = ("ratio", "ci_low", "ci_high"), ".3f"
    if row["judged_by"] == "difference":
        names, form = ("difference", "difference_low", "difference_high"), "+.3g"
    values = [row[name] for name in names]
    value, low, high = ("0" if not item else number(item, form=form) for item in values)
    return {
        "bridge": f"{row['bridge']} {row['abutment']}".replace("_", "-"),
        "demand": row["demand"],
        "change": f"{value} {row['unit']}".strip() if value != NO_VALUE else value,
        f"{row['level']:.0%} interval": f"{low}..{high}",
        "verdict": row["verdict_family"],
        "motions": str(row["n_motions"]),
        "pairs": str(row["n_pairs"]),
    }
