"""Commands for whoever publishes a study: its figures, its methods in words, all in one file."""

from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, emit_json, messages
from skewbridge.cli.study import DEFAULT_CONFIG, ConfigOption
from skewbridge.errors import InputError


@clear_errors
def methods(
    *,
    config: ConfigOption = DEFAULT_CONFIG,
    out: Annotated[
        Path | None, typer.Option("--out", help="Markdown file instead of the terminal.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Write the methods of a study as a paper describes them, with references.

    They are made from the configuration, and from the sources of the motions once these are
    prepared.
    """
    from skewbridge.provenance.files import writable_file, write_text
    from skewbridge.provenance.tables import read_frame
    from skewbridge.report.methods import methods_of
    from skewbridge.study.config import load_config
    from skewbridge.study.folder import StudyFolder

    study = load_config(config, base=DEFAULT_CONFIG)
    suite = StudyFolder(Path(study.results)).suite
    text = methods_of(study, read_frame(suite) if suite.is_file() else None).markdown()
    if out is not None:
        write_text(writable_file(out), text)
        messages.print(f"written: {out}")
    if as_json:
        emit_json({"methods": text})
    elif out is None:
        typer.echo(text)


@clear_errors
def archive(
    results: Annotated[Path, typer.Argument(help="Folder of a finished study.")] = Path("results"),
    out: Annotated[
        Path, typer.Option("--out", help="ZIP file to write.", metavar="FILE.zip")
    ] = Path("study.zip"),
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Put a study into one file for the supplement of a paper; equal studies give equal bytes.

    Configuration, tables, report, methods, digests, licences and how to repeat it; no
    accelerations, because recorded motions may not be passed on.
    """
    from skewbridge.report.archive import write_archive

    if out.suffix != ".zip":
        raise InputError(f"--out must end with .zip, got {out.name}")
    written = write_archive(results, config, DEFAULT_CONFIG, out)
    size = written.path.stat().st_size
    answer = {
        "archive": str(written.path),
        "bytes": size,
        "sha256": written.sha256,
        "files": list(written.names),
        "doubts": list(written.doubts),
    }
    emit(answer, [{"in the archive": name} for name in written.names], as_json=as_json)
    for told in written.doubts:
        messages.print(f"warning: {told}", style="yellow")
    messages.print(f"{out}: {size / 1e6:.1f} MB, sha256 {written.sha256}")


@clear_errors
def plot(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Figures by the names of their files; * stands for any text. None: list them.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder of the files.")] = Path(),
    width_mm: Annotated[
        float | None, typer.Option("--width-mm", help="Instead of figures.width_mm.")
    ] = None,
    font: Annotated[
        str | None, typer.Option("--font", help="Family, instead of figures.font.")
    ] = None,
    font_size_pt: Annotated[
        float | None, typer.Option("--font-size-pt", help="Instead of figures.font_size_pt.")
    ] = None,
    config: ConfigOption = DEFAULT_CONFIG,
    as_json: JsonOption = False,
) -> None:
    """Draw single figures of a finished study again, as SVG and PNG.

    Width and font are those of the configuration, or as given here for these files alone.
    """
    from dataclasses import asdict

    from skewbridge.provenance.files import writable_folder
    from skewbridge.reading import checked
    from skewbridge.report.study_figures import draw_figures, finished_figures
    from skewbridge.study.config import load_config
    from skewbridge.study.figure_settings import FigureSettings, check_font

    study = load_config(config, base=DEFAULT_CONFIG)
    given = {"width_mm": width_mm, "font": font, "font_size_pt": font_size_pt}
    chosen = {name: value for name, value in given.items() if value is not None}
    settings = checked(FigureSettings, asdict(study.figures) | chosen, "figures")
    check_font(settings.font)
    figures = finished_figures(Path(study.results))
    if not names:
        rows = [{"name": figure.name, "title": figure.title} for figure, _ in figures]
        emit({"figures": rows}, rows, as_json=as_json)
        return
    drawn = draw_figures(figures, names, settings, writable_folder(out))
    if as_json:
        emit_json({"written": [str(path) for path in drawn]})
    for path in drawn:
        messages.print(f"written: {path}", markup=False)


COMMANDS: Final = (methods, archive, plot)
