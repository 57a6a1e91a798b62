"""Commands for fragility curves: fit, export, statistics of a demands table, prediction."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from skewbridge.cli.options import (
    ABUTMENT_CHOICES,
    ABUTMENT_NAMES,
    LIMIT_STATES,
    LimitStatesOption,
    Opt,
    OutOption,
    StudyOption,
    folder_of,
    known_bridges,
    takes,
)
from skewbridge.cli.output import Command, JsonOption, emit, messages, new_group, number
from skewbridge.errors import InputError

commands = new_group()


@commands.command(cls=Command)
@takes(
    Opt("method", Literal["stripes", "ida", "cloud"] | None, "Kind of data."),
    Opt("model", str | None, "Model of the demands in a cloud.", None, "[ols|tobit]"),
    Opt("link", str, "Link of the stripes.", "probit", "[probit]"),
    Opt("level", float, "Confidence level.", 0.95),
    Opt("threshold", float | None, "Median capacity."),
    Opt("im", str | None, "Column with the intensities of the runs.", None, "COLUMN"),
    Opt("edp", str | None, "Column with the demands of the runs.", None, "COLUMN"),
    Opt("capacity_dispersion", float, "Dispersion of the capacity (cloud).", 0.0),
    Opt("censor_above", float | None, "Censor demands at or above this value (cloud)."),
    Opt("assumed_beta", float, "Dispersion for one-sided bounds.", 0.4),
    Opt("accept_bounds", bool, "Fit even if failed runs decide the result.", False),
    Opt("columns", Path | None, "YAML with columns (ours: theirs), factors, constants."),
)
def fit(
    data: Annotated[Path, typer.Argument(help="Data file: .json, .csv or .parquet.")],
    *,
    paper_table: Annotated[
        bool,
        typer.Option("--paper-table", help="Print a publication table from a table of demands."),
    ] = False,
    limit_states: LimitStatesOption = LIMIT_STATES,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Fit a fragility curve: theta, beta, their intervals and a status.

    Example: skewbridge fit demands.csv --method cloud --im im_pga --edp drift --threshold 0.02
    """
    from skewbridge.fragility.fit_data import FitOptions, fit_file
    from skewbridge.fragility.study_tables import paper_rows

    if paper_table:
        table = paper_rows(data, limit_states, given["im"])
        emit({"rows": table["rows"]}, table["shown"], as_json=as_json, title=table["title"])
        return
    try:
        given["method"] = given["method"] or ""
        result = fit_file(data, FitOptions(**given)).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    if not as_json:
        for warning in result["warnings"]:
            messages.print(f"warning: {warning}", style="yellow")
    reason = f"the data do not determine it (status {result['status']})"
    emit(result, as_json=as_json, missing=reason)


@commands.command(cls=Command)
@takes(
    Opt("hazard", Path | None, "Hazard curve, CSV with im and rate: adds annual frequencies."),
    Opt(
        "im_range",
        tuple[float, float] | None,
        "Range of a table of probabilities (csv).",
        None,
        "LOW HIGH",
    ),
    Opt("points", int, "Number of intensities in that range.", 50),
    Opt(
        "skew_factors",
        bool,
        "theta(skew)/theta(0) with intervals, and those of Hazus (csv); as scaling specification "
        "(pelicun).",
        False,
    ),
)
def export(
    curves: Annotated[Path, typer.Argument(help="Table of curves of a study (.parquet, .csv).")],
    form: Annotated[
        str, typer.Option("--format", metavar="[nrml|pelicun|dlml|csv|latex]", help="File format.")
    ],
    out: Annotated[Path, typer.Option(help="File to write.")],
    *,
    method: Annotated[
        Literal["cloud", "exceedance", "ida_interval"] | None,
        typer.Option(help="Method of the curves; without it the preferred ones."),
    ] = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Write fragility curves for other tools, spreadsheets and papers.

    Example: skewbridge export results/fragility/curves.parquet --format nrml --out curves.xml
    """
    from skewbridge.fragility.exports import CsvContent, export_curves

    report = export_curves(curves, form, out, method=method, content=CsvContent(**given))
    for note in report["notes"]:
        messages.print(note, markup=False)
    emit(report, [{"written": name} for name in report["files"]], as_json=as_json)


@commands.command(cls=Command)
def statistics(
    demands: Annotated[
        Path, typer.Argument(help="Table with columns of demands.parquet: .parquet or .csv.")
    ],
    out: OutOption,
    limit_states: LimitStatesOption = LIMIT_STATES,
    im: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="Intensity measure, if there are several.")
    ] = None,
    margin: Annotated[
        float | None, typer.Option(help="Relative change that is negligible: 0.05.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Fit curves and effects to any table of demands.

    Writes every table of results/fragility. Needs the columns of the axes, motion_id, status, an
    intensity measure and demands; names, scale and incidence are optional. Limit states whose
    demand is missing are left out.

    Example: skewbridge statistics demands.csv --out my_statistics
    """
    from skewbridge.fragility.study_tables import statistics_of

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
@takes(
    Opt("bridge", str | None, "Needed if there are several.", None, "NAME", known_bridges),
    Opt(
        "abutment",
        str | None,
        "By default the only model of the study, or contact-friction.",
        None,
        ABUTMENT_CHOICES,
        lambda: list(ABUTMENT_NAMES),
    ),
    Opt("component", str | None, "Only this component.", None, "NAME"),
    Opt("state", str | None, "Only this limit state.", None, "NAME"),
    Opt("at", float | None, "Intensity at which to give probabilities."),
)
def predict(
    skew_deg: Annotated[float | None, typer.Option(help="Skew in degrees.")] = None,
    gap_mm: Annotated[float | None, typer.Option(help="Joint gap in mm.")] = None,
    friction: Annotated[float | None, typer.Option(help="Coefficient of friction.")] = None,
    axis: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="A further axis; repeatable.")
    ] = None,
    study: StudyOption = None,
    *,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Predict fragility between the variants of a study.

    Gives medians, dispersions and probabilities from the joint model over skew, gap and friction,
    inside the parameter range of the study. --study may be a folder written by `statistics`.

    Example: skewbridge predict --bridge osb1 --skew-deg 45 --gap-mm 51 --friction 0.5 --at 0.6
    """
    from skewbridge.fragility.joint import predict_states

    named = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}
    values = {name: value for name, value in named.items() if value is not None}
    for pair in axis or []:
        name, _, text = pair.partition("=")
        try:
            values[name.strip().replace("-", "_")] = float(text)
        except ValueError:
            raise InputError(f"--axis takes NAME=VALUE, got {pair!r}") from None
    rows = predict_states(folder_of(study), values, **given)
    printed = [
        {
            "state": f"{row['component']}/{row['state']}",
            "theta": number(row["theta"], form=".3g"),
            "interval": "..".join(number(end, form=".3g") for end in row["ci_theta"]),
            "beta": number(row["beta_total"], form=".2f"),
            "records": number(row["beta"], form=".2f"),
            **({} if given["at"] is None else {"P": number(row["p"], form=".3f")}),
            "left out": number(row["loo_error"], form=".1%"),
        }
        for row in rows
    ]
    messages.print("left out: error of theta when a variant is left out of the model")
    reason = "not enough variants with this state to estimate it"
    if (drawn := rows[0]["random_properties"]) != "none":
        messages.print(f"each motion of the study has its own draw of: {drawn}")
    title = f"theta in {rows[0]['im']}"
    emit({"rows": rows}, printed, as_json=as_json, title=title, missing=reason)
