"""Commands of the fragility package."""

from pathlib import Path
from typing import Annotated, Final

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, messages
from skewbridge.errors import InputError


@clear_errors
def fit(
    data: Annotated[Path, typer.Argument(help="Data: .json, .csv or .parquet.")],
    method: Annotated[str | None, typer.Option(help="stripes, ida or cloud.")] = None,
    model: Annotated[
        str | None, typer.Option(help="Cloud: ols, tobit, modified or heteroscedastic.")
    ] = None,
    link: Annotated[str, typer.Option(help="Stripes: probit, logit or cloglog.")] = "probit",
    level: Annotated[float, typer.Option(help="Confidence level.")] = 0.95,
    threshold: Annotated[float | None, typer.Option(help="Median capacity.")] = None,
    im: Annotated[str | None, typer.Option(help="Column of intensities, table of runs.")] = None,
    edp: Annotated[str | None, typer.Option(help="Column of demands, table of runs.")] = None,
    where: Annotated[str | None, typer.Option(help="Rows to use: skew_deg == 30.")] = None,
    capacity_dispersion: Annotated[float, typer.Option(help="Of the capacity (cloud).")] = 0.0,
    censor_above: Annotated[float | None, typer.Option(help="Tobit: censor from here.")] = None,
    discard_below: Annotated[float | None, typer.Option(help="Tobit: drop below.")] = None,
    assumed_beta: Annotated[float, typer.Option(help="For one-sided bounds of theta.")] = 0.4,
    accept_bounds: Annotated[
        bool, typer.Option("--accept-bounds", help="Fit though failed runs decide the result.")
    ] = False,
    paper_table: Annotated[
        bool,
        typer.Option(
            "--paper-table", help="Table of demands: the table a paper prints, all limit states."
        ),
    ] = False,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of limit states of the paper's table.")
    ] = Path("config/limit_states.yaml"),
    as_json: JsonOption = False,
) -> None:
    """Fit a fragility curve: theta, beta, intervals and a status that says what they are worth."""
    from skewbridge.fragility.exchange.fit_file import FitOptions, fit_file

    if paper_table:
        from skewbridge.fragility.tables.any_demands import paper_rows

        table = paper_rows(data, limit_states, im)
        emit({"rows": table.rows}, table.shown, as_json=as_json, title=table.title)
        return
    try:
        result = fit_file(
            data,
            FitOptions(
                method=method or "",
                model=model,
                link=link,
                level=level,
                threshold=threshold,
                im=im,
                edp=edp,
                where=where,
                capacity_dispersion=capacity_dispersion,
                censor_above=censor_above,
                discard_below=discard_below,
                assumed_beta=assumed_beta,
                accept_bounds=accept_bounds,
            ),
        ).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    if not as_json:
        for warning in result["warnings"]:
            messages.print(f"warning: {warning}", style="yellow")
    emit(result, as_json=as_json)


@clear_errors
def export(
    curves: Annotated[Path, typer.Argument(help="Curves: the parquet table of the study.")],
    form: Annotated[str, typer.Option("--format", help="nrml, pelicun or csv.")],
    out: Annotated[Path, typer.Option(help="File to write.")],
    method: Annotated[str, typer.Option(help="cloud, exceedance or ida_interval.")] = "cloud",
    hazard: Annotated[
        Path | None, typer.Option(help="CSV im, rate: adds annual frequencies to the csv.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Write fragility curves for other tools."""
    from skewbridge.fragility.exchange.export import export_curves

    report = export_curves(curves, form, out, method=method, hazard=hazard)
    emit(report, [report], as_json=as_json)


COMMANDS: Final = (fit, export)
