"""Commands of the fragility package."""

from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from skewbridge.cli.output import JsonOption, clear_errors, emit, messages
from skewbridge.errors import InputError


@clear_errors
def fit(
    data: Annotated[Path, typer.Argument(help="Data: .json, .csv or .parquet.")],
    method: Annotated[
        Literal["stripes", "ida", "cloud"] | None, typer.Option(help="What the data are.")
    ] = None,
    model: Annotated[
        Literal["ols", "tobit", "modified", "heteroscedastic"] | None,
        typer.Option(help="Of the demands in a cloud."),
    ] = None,
    link: Annotated[
        Literal["probit", "logit", "cloglog"], typer.Option(help="Of the stripes.")
    ] = "probit",
    level: Annotated[float, typer.Option(help="Confidence level.")] = 0.95,
    threshold: Annotated[float | None, typer.Option(help="Median capacity.")] = None,
    im: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Of intensities, table of runs.")
    ] = None,
    edp: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Of demands, table of runs.")
    ] = None,
    where: Annotated[
        str | None, typer.Option(metavar="CONDITION", help="Rows to use: skew_deg == 30.")
    ] = None,
    capacity_dispersion: Annotated[
        float, typer.Option(help="Of the capacity: cloud, and stripes of a table of runs.")
    ] = 0.0,
    censor_above: Annotated[float | None, typer.Option(help="Tobit: censor from here.")] = None,
    discard_below: Annotated[float | None, typer.Option(help="Tobit: drop below.")] = None,
    assumed_beta: Annotated[float, typer.Option(help="For one-sided bounds of theta.")] = 0.4,
    accept_bounds: Annotated[
        bool, typer.Option("--accept-bounds", help="Fit though failed runs decide the result.")
    ] = False,
    goodness: Annotated[
        bool, typer.Option("--goodness", help="Add tests of the fit with simulated p-values.")
    ] = False,
    columns: Annotated[
        Path | None,
        typer.Option(help="YAML with columns (ours: theirs), factors, constants of the table."),
    ] = None,
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
    from skewbridge.fragility.exchange.fit_file import fit_file
    from skewbridge.fragility.exchange.fit_options import FitOptions

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
                goodness=goodness,
                columns=columns,
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
    form: Annotated[
        Literal["nrml", "pelicun", "csv", "xlsx", "latex"],
        typer.Option("--format", help="Of the file."),
    ],
    out: Annotated[Path, typer.Option(help="File to write.")],
    method: Annotated[
        Literal["cloud", "exceedance", "ida_interval", "ordered"],
        typer.Option(help="Which curves."),
    ] = "cloud",
    hazard: Annotated[
        Path | None, typer.Option(help="CSV im, rate: adds annual frequencies (csv, xlsx).")
    ] = None,
    wide: Annotated[
        bool, typer.Option("--wide", help="A row per variant or intensity (csv, xlsx).")
    ] = False,
    im_range: Annotated[
        tuple[float, float] | None,
        typer.Option(metavar="LOW HIGH", help="Probabilities over these intensities (csv, xlsx)."),
    ] = None,
    points: Annotated[int, typer.Option(help="Intensities in that range.")] = 50,
    skew_factors: Annotated[
        bool,
        typer.Option("--skew-factors", help="theta(skew)/theta(0) beside Hazus (csv, xlsx)."),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Write fragility curves for other tools, spreadsheets and papers."""
    from skewbridge.fragility.exchange.curve_tables import Sampling
    from skewbridge.fragility.exchange.export import Wanted, export_curves

    sampling = None if im_range is None else Sampling(*im_range, points)
    wanted = Wanted(hazard=hazard, sampling=sampling, skew=skew_factors, wide=wide)
    report = export_curves(curves, form, out, method=method, wanted=wanted)
    for note in report["notes"]:
        messages.print(note, markup=False)
    emit(report, [{"written": name} for name in report["files"]], as_json=as_json)


COMMANDS: Final = (fit, export)
