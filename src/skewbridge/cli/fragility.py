"""Commands that fit and export fragility curves."""

from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, messages
from skewbridge.errors import InputError

_REMOVED: Final = {
    "--where": "select the rows first, for example with pandas: "
    "table.query('skew_deg == 30').to_csv('rows.csv')",
    "--goodness": "tests of a fit without simulation are in its answer; simulate others in SciPy",
}


@clear_errors
def fit(
    data: Annotated[Path, typer.Argument(help="Data file: .json, .csv or .parquet.")],
    method: Annotated[
        Literal["stripes", "ida", "cloud"] | None, typer.Option(help="Kind of data.")
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="[ols|tobit]", help="Model of the demands in a cloud.")
    ] = None,
    link: Annotated[str, typer.Option(metavar="[probit]", help="Link of the stripes.")] = "probit",
    level: Annotated[float, typer.Option(help="Confidence level.")] = 0.95,
    threshold: Annotated[float | None, typer.Option(help="Median capacity.")] = None,
    im: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Intensities in a table of runs.")
    ] = None,
    edp: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Demands in a table of runs.")
    ] = None,
    capacity_dispersion: Annotated[
        float, typer.Option(help="Dispersion of the capacity (cloud).")
    ] = 0.0,
    censor_above: Annotated[
        float | None, typer.Option(help="Censor demands at or above this value (cloud).")
    ] = None,
    assumed_beta: Annotated[float, typer.Option(help="Dispersion for one-sided bounds.")] = 0.4,
    accept_bounds: Annotated[
        bool, typer.Option("--accept-bounds", help="Fit though failed runs decide the result.")
    ] = False,
    columns: Annotated[
        Path | None,
        typer.Option(help="YAML with columns (ours: theirs), factors, constants of the table."),
    ] = None,
    paper_table: Annotated[
        bool,
        typer.Option("--paper-table", help="Print the fragility table of a table of demands."),
    ] = False,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of limit states of that table.")
    ] = Path("config/limit_states.yaml"),
    where: Annotated[str | None, typer.Option(hidden=True)] = None,
    goodness: Annotated[bool, typer.Option("--goodness", hidden=True)] = False,
    as_json: JsonOption = False,
) -> None:
    """Fit a fragility curve: theta, beta, their intervals, a status and warnings."""
    from skewbridge.fragility.fit_data import FitOptions, fit_file
    from skewbridge.fragility.results import paper_rows

    for name, given in (("--where", where is not None), ("--goodness", goodness)):
        if given:
            raise InputError(f"{name} was removed: {_REMOVED[name]}")
    if paper_table:
        table = paper_rows(data, limit_states, im)
        emit({"rows": table["rows"]}, table["shown"], as_json=as_json, title=table["title"])
        return
    try:
        options = FitOptions(
            method=method or "",
            model=model,
            link=link,
            level=level,
            threshold=threshold,
            im=im,
            edp=edp,
            capacity_dispersion=capacity_dispersion,
            censor_above=censor_above,
            assumed_beta=assumed_beta,
            accept_bounds=accept_bounds,
            columns=columns,
        )
        result = fit_file(data, options).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    if not as_json:
        for warning in result["warnings"]:
            messages.print(f"warning: {warning}", style="yellow")
    emit(result, as_json=as_json)


@clear_errors
def export(
    curves: Annotated[Path, typer.Argument(help="Table of curves of a study (.parquet, .csv).")],
    form: Annotated[
        str, typer.Option("--format", metavar="[nrml|pelicun|csv|latex]", help="File format.")
    ],
    out: Annotated[Path, typer.Option(help="File to write.")],
    method: Annotated[
        Literal["cloud", "exceedance", "ida_interval"] | None,
        typer.Option(help="Method of the curves; without it the preferred ones."),
    ] = None,
    hazard: Annotated[
        Path | None, typer.Option(help="CSV im, rate: adds annual frequencies (csv).")
    ] = None,
    im_range: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="LOW HIGH", help="Probabilities over these intensities (csv)."),
    ] = None,
    points: Annotated[int, typer.Option(help="Number of intensities in that range.")] = 50,
    skew_factors: Annotated[
        bool,
        typer.Option("--skew-factors", help="theta(skew)/theta(0) and those of Hazus (csv)."),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Write fragility curves for other tools, spreadsheets and papers."""
    from skewbridge.fragility.exports import CsvContent, export_curves

    content = CsvContent(hazard=hazard, im_range=im_range, points=points, skew_factors=skew_factors)
    report = export_curves(curves, form, out, method=method, content=content)
    for note in report["notes"]:
        messages.print(note, markup=False)
    emit(report, [{"written": name} for name in report["files"]], as_json=as_json)


COMMANDS: Final = (fit, export)
