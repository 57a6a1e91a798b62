"""Commands for fragility curves: fit, export, statistics of a demands table, prediction."""

from pathlib import Path
from typing import Any, Literal

from skewbridge.cli.options import ABUTMENT, LIMIT_STATES, OUT, STUDY, folder_of, known_bridges
from skewbridge.cli.output import (
    Answer,
    Arg,
    Opt,
    Printed,
    command,
    messages,
    new_group,
    number,
    quantities,
    warn,
)
from skewbridge.errors import InputError

commands = new_group()


@command(
    commands,
    Arg("data", Path, "Data file: .json, .csv or .parquet.", ...),
    Opt("paper_table", bool, "Print a publication table from a table of demands.", False),
    LIMIT_STATES,
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
    Opt("columns", Path | None, "YAML file that maps our column names to those of the data, with "
        "unit factors and constants."),
)  # fmt: skip
def fit(data: Path, paper_table: bool, limit_states: Path, **given: Any) -> Answer:
    """Fit a fragility curve: theta, beta, their intervals and a status.

    Example: skewbridge fit demands.csv --method cloud --im im_pga --edp drift --threshold 0.02
    """
    from skewbridge.fragility.fit_data import fit_file
    from skewbridge.study.results import paper_rows

    if paper_table:
        table = paper_rows(data, limit_states, given["im"])
        return Answer({"rows": table["rows"]}, [Printed(table["shown"], table["title"])])
    try:
        given["method"] = given["method"] or ""
        result = fit_file(data, **given).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    for warning in result["warnings"]:
        warn(warning)
    reason = f"the data do not determine it (status {result['status']})"
    return Answer(result, [Printed(quantities(result), missing=reason)])


@command(
    commands,
    Arg("curves", Path, "Table of curves of a study (.parquet, .csv).", ...),
    Opt("form", str, "File format.", ..., "[nrml|pelicun|dlml|csv|latex]", flags="--format"),
    Opt("out", Path, "File to write.", ...),
    Opt("method", Literal["cloud", "exceedance", "ida_interval"] | None,
        "Method of the curves; by default the preferred one."),
    Opt("hazard", Path | None, "Hazard curve, CSV with im and rate: adds annual frequencies."),
    Opt("im_range", tuple[float, float] | None, "Range of a table of probabilities (csv).",
        None, "LOW HIGH"),
    Opt("skew_factors", bool,
        "theta(skew)/theta(0) with intervals, and those of Hazus (csv); as scaling specification "
        "(pelicun).", False),
)  # fmt: skip
def export(curves: Path, form: str, out: Path, **given: Any) -> Answer:
    """Write fragility curves for other tools, spreadsheets and papers.

    Example: skewbridge export results/fragility/curves.parquet --format nrml --out curves.xml
    """
    from skewbridge.fragility.exports import export_curves

    report = export_curves(curves, form, out, **given)
    written = Printed([{"written": path} for path in report["files"]])
    return Answer(report, [written], notes=report["notes"])


@command(
    commands,
    Arg("demands", Path, "Table with columns of demands.parquet: .parquet or .csv.", ...),
    OUT,
    LIMIT_STATES,
    Opt("im", str | None, "Intensity measure, if there are several.", None, "COLUMN"),
    Opt("margin", float | None, "Relative change that is negligible: 0.05."),
)
def statistics(demands: Path, out: Path, **given: Any) -> Answer:
    """Fit curves and effects to any table of demands.

    Writes every table of results/fragility. Needs the columns of the axes, motion_id, status, an
    intensity measure and demands; names, scale and incidence are optional. Limit states whose
    demand is missing are left out.

    Example: skewbridge statistics demands.csv --out my_statistics
    """
    from skewbridge.study.results import statistics_of

    report = statistics_of(demands, out, **given)
    for name in report["left_out"]:
        messages.print(f"left out, because its demand is missing: {name}", style="yellow")
    for note in report["notes"]:
        messages.print(note, style="yellow")
    counts = {f"rows of {name}": count for name, count in report["tables"].items()}
    for kind in ("status", "verdict"):
        counts |= {f"{kind} {name}": count for name, count in report[kind].items()}
    return Answer(report, [Printed.of(["what", "count"], counts.items(), title=str(out))])


@command(
    commands,
    Opt("skew_deg", float | None, "Skew in degrees."),
    Opt("gap_mm", float | None, "Joint gap in mm."),
    Opt("friction", float | None, "Coefficient of friction."),
    Opt("axis", list[str] | None, "A further axis; repeatable.", None, "NAME=VALUE"),
    STUDY,
    Opt("bridge", str | None, "Bridge of the curves; needed if there are several.", None, "NAME",
        known_bridges),
    ABUTMENT._replace(kind=str | None, default=None,
                      help="By default the only model of the study, or contact-friction."),
    Opt("component", str | None, "Only this component.", None, "NAME"),
    Opt("state", str | None, "Only this limit state.", None, "NAME"),
    Opt("at", float | None, "Intensity at which to give probabilities."),
)  # fmt: skip
def predict(axis: list[str] | None, study: Path | None, **given: Any) -> Answer:
    """Predict fragility between the variants of a study.

    Gives medians, dispersions and probabilities from the joint model over skew, gap and friction,
    inside the parameter range of the study. --study may be a folder written by `statistics`.

    Example: skewbridge predict --bridge osb1 --skew-deg 45 --gap-mm 51 --friction 0.5 --at 0.6
    """
    from skewbridge.study.results import predict_states

    named = {name: given.pop(name) for name in ("skew_deg", "gap_mm", "friction")}
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
    if (drawn := rows[0]["random_properties"]) != "none":
        messages.print(f"each motion of the study has its own draw of: {drawn}")
    reason = "not enough variants with this state to estimate it"
    return Answer({"rows": rows}, [Printed(printed, f"theta in {rows[0]['im']}", reason)])
