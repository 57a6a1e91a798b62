"""Commands for fragility curves: fit, export, statistics of a demands table, prediction."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from skewbridge.cli.options import (
    ABUTMENT_CHOICES,
    ABUTMENT_NAMES,
    OutOption,
    StudyOption,
    folder_of,
    known_bridges,
)
from skewbridge.cli.output import Command, JsonOption, emit, messages, new_group, number
from skewbridge.errors import InputError

commands = new_group()


@commands.command(cls=Command)
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
        str | None, typer.Option(metavar="COLUMN", help="Column with the intensities of the runs.")
    ] = None,
    edp: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Column with the demands of the runs.")
    ] = None,
    capacity_dispersion: Annotated[
        float, typer.Option(help="Dispersion of the capacity (cloud).")
    ] = 0.0,
    censor_above: Annotated[
        float | None, typer.Option(help="Censor demands at or above this value (cloud).")
    ] = None,
    assumed_beta: Annotated[float, typer.Option(help="Dispersion for one-sided bounds.")] = 0.4,
    accept_bounds: Annotated[
        bool, typer.Option("--accept-bounds", help="Fit even if failed runs decide the result.")
    ] = False,
    columns: Annotated[
        Path | None,
        typer.Option(help="YAML with columns (ours: theirs), factors, constants of the table."),
    ] = None,
    paper_table: Annotated[
        bool,
        typer.Option("--paper-table", help="Print a publication table from a table of demands."),
    ] = False,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of limit states of that table.")
    ] = Path("config/limit_states.yaml"),
    as_json: JsonOption = False,
) -> None:
    """Fit a fragility curve: theta, beta, their intervals and a status.

    Example: skewbridge fit demands.csv --method cloud --im im_pga --edp drift --threshold 0.02
    """
    from skewbridge.fragility.fit_data import FitOptions, fit_file
    from skewbridge.fragility.results import paper_rows

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
    reason = f"the data do not determine it (status {result['status']})"
    emit(result, as_json=as_json, missing=reason)


@commands.command(cls=Command)
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
        Path | None,
        typer.Option(help="Hazard curve, CSV with im and rate: adds annual frequencies."),
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
    """Write fragility curves for other tools, spreadsheets and papers.

    Example: skewbridge export results/fragility/curves.parquet --format nrml --out curves.xml
    """
    from skewbridge.fragility.exports import CsvContent, export_curves

    content = CsvContent(hazard=hazard, im_range=im_range, points=points, skew_factors=skew_factors)
    report = export_curves(curves, form, out, method=method, content=content)
    for note in report["notes"]:
        messages.print(note, markup=False)
    emit(report, [{"written": name} for name in report["files"]], as_json=as_json)


@commands.command(cls=Command)
def statistics(
    demands: Annotated[
        Path, typer.Argument(help="Table of demands: .parquet or .csv (docs/columns.md).")
    ],
    out: OutOption,
    limit_states: Annotated[
        Path, typer.Option("--limit-states", help="File of limit states.")
    ] = Path("config/limit_states.yaml"),
    im: Annotated[
        str | None,
        typer.Option("--im", metavar="COLUMN", help="Intensity measure, if there are several."),
    ] = None,
    margin: Annotated[
        float | None, typer.Option("--margin", help="Relative change that is negligible: 0.05.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Fit curves and effects to any table of demands.

    Writes every table of results/fragility. Needs the columns of the axes, motion_id, status, an
    intensity measure and demands; names, scale and incidence are optional. Limit states whose
    demand is missing are left out.

    Example: skewbridge statistics demands.csv --out my_statistics
    """
    from skewbridge.fragility.results import statistics_of

    report = statistics_of(demands, out, limit_states=limit_states, im=im, margin=margin)
    for name in report["left_out"]:
        messages.print(f"left out, because its demand is missing: {name}", style="yellow")
    for note in report["notes"]:
        messages.print(note, style="yellow")
    emit(report, _counts(report), as_json=as_json, title=str(out))


def _counts(report: dict[str, Any]) -> list[dict[str, Any]]:
    rows = [{"what": f"rows of {name}", "count": n} for name, n in report["tables"].items()]
    for kind in ("status", "verdict"):
        rows += [{"what": f"{kind} {name}", "count": n} for name, n in report[kind].items()]
    return rows


@commands.command(cls=Command)
def predict(
    bridge: Annotated[
        str | None,
        typer.Option(
            "--bridge",
            metavar="NAME",
            help="Needed if the study has several bridges.",
            autocompletion=known_bridges,
        ),
    ] = None,
    abutment: Annotated[
        str | None,
        typer.Option(
            "--abutment",
            metavar=ABUTMENT_CHOICES,
            help="By default the only model of the study, or contact-friction.",
            autocompletion=lambda: list(ABUTMENT_NAMES),
        ),
    ] = None,
    skew_deg: Annotated[float | None, typer.Option("--skew-deg", help="Skew in degrees.")] = None,
    gap_mm: Annotated[float | None, typer.Option("--gap-mm", help="Joint gap in mm.")] = None,
    friction: Annotated[
        float | None, typer.Option("--friction", help="Coefficient of friction.")
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option("--axis", metavar="NAME=VALUE", help="A further axis; repeatable."),
    ] = None,
    component: Annotated[
        str | None, typer.Option("--component", metavar="NAME", help="Only this component.")
    ] = None,
    state: Annotated[
        str | None, typer.Option("--state", metavar="NAME", help="Only this limit state.")
    ] = None,
    at: Annotated[
        float | None, typer.Option("--at", help="Intensity at which to give probabilities.")
    ] = None,
    study: StudyOption = None,
    as_json: JsonOption = False,
) -> None:
    """Predict fragility between the variants of a study.

    Gives medians, dispersions and probabilities from the joint model over skew, gap and friction,
    inside the parameter range of the study. --study may be a folder written by `statistics`.

    Example: skewbridge predict --bridge osb1 --skew-deg 45 --gap-mm 51 --friction 0.5 --at 0.6
    """
    from skewbridge.fragility.predict import Point, predict_states

    values = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}
    given = {name: value for name, value in values.items() if value is not None}
    for pair in axis or []:
        name, _, text = pair.partition("=")
        try:
            given[name.strip().replace("-", "_")] = float(text)
        except ValueError:
            raise InputError(f"--axis takes NAME=VALUE, got {pair!r}") from None
    point = Point(
        bridge=bridge,
        abutment=abutment,
        values=given,
        component=component,
        state=state,
        at=at,
    )
    rows = predict_states(folder_of(study), point)
    printed = [
        {
            "state": f"{row['component']}/{row['state']}",
            "theta": number(row["theta"], form=".3g"),
            "interval": "..".join(number(end, form=".3g") for end in row["ci_theta"]),
            "beta": number(row["beta_total"], form=".2f"),
            "records": number(row["beta"], form=".2f"),
            **({} if at is None else {"P": number(row["p"], form=".3f")}),
            "left out": number(row["loo_error"], form=".1%"),
        }
        for row in rows
    ]
    messages.print("left out: error of theta when a variant is left out of the model")
    reason = "not enough variants with this state to estimate it"
    title = f"theta in {rows[0]['im']}"
    emit({"rows": rows}, printed, as_json=as_json, title=title, missing=reason)
