"""Commands for fragility curves: fit, export, statistics of a demands table, prediction."""

from pathlib import Path
from typing import Any, Literal

from skewbridge.cli import new_group
from skewbridge.cli.options import ABUTMENT, LIMIT_STATES, OUT, STUDY, folder_of, keys_and_values
from skewbridge.cli.output import Answer, Arg, Opt, command, rounded, selected, warn
from skewbridge.errors import InputError
from skewbridge.files.text import Number, checked
from skewbridge.variant.axes import AXES

commands = new_group()


@command(
    commands,
    Arg("data", Path, "Data file: .json, .csv or .parquet.", ...),
    Opt("paper_table", bool, "Print a publication table from a table of demands.", False),
    LIMIT_STATES,
    Opt("method", Literal["stripes", "ida", "cloud"] | None, "Kind of data."),
    Opt("model", str | None, "Regression model of a cloud.", None, "[ols|tobit]"),
    Opt("link", str, "Link function of stripes.", "probit", "[probit]"),
    Opt("level", float, "Confidence level.", 0.95),
    Opt("threshold", float | None, "Median capacity."),
    Opt("im", str | None, "Column with the intensities of the runs.", None, "COLUMN"),
    Opt("edp", str | None, "Column with the demands of the runs.", None, "COLUMN"),
    Opt("capacity_dispersion", float, "Dispersion of the capacity (cloud).", 0.0),
    Opt("censor_above", float | None, "Censor demands at or above this value (cloud)."),
    Opt("assumed_beta", float, "Dispersion assumed for one-sided bounds.", 0.4),
    Opt("accept_bounds", bool, "Report medians that failed runs may move by 15 % or more.", False),
    Opt("columns", Path | None, "YAML file with the names, factors and constants of the columns."),
)
def fit(data: Path, paper_table: bool, limit_states: Path, **given: Any) -> Answer:
    """Fit a fragility curve: theta, beta, their intervals and a status.

    Example: skewbridge fit demands.csv --method cloud --im im_pga --edp drift --threshold 0.02
    """
    from skewbridge.fragility.fit_data import fit_file
    from skewbridge.study.results import paper_rows

    if paper_table:
        table = paper_rows(data, limit_states, given["im"])
        return Answer({"rows": table["rows"]}, {table["title"]: table["shown"]})
    try:
        given["method"] = given["method"] or ""
        result = fit_file(data, **given).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    for warning in (*result["warnings"], *result.get("notes", ())):
        warn(warning)
    shown = {name: value for name, value in result.items() if name != "notes"}
    return Answer(result, shown, missing=f"not determined by the data (status {result['status']})")


@command(
    commands,
    Arg("curves", Path, "Table of curves of a study (.parquet, .csv).", ...),
    Opt("form", str, "File format.", ..., "[nrml|pelicun|dlml|csv|latex]", flags="--format"),
    Opt("out", Path, "File to write.", ...),
    Opt("method", Literal["cloud", "exceedance", "ida_interval"] | None, "Method of the curves."),
    Opt("hazard", Path | None, "Hazard curve (CSV: im, rate); adds annual frequencies."),
    Opt("im_range", tuple[float, float] | None, "Range of intensities (csv).", None, "LOW HIGH"),
    Opt("skew_factors", bool, "Add ratios to skew 0 (csv) or a scaling file (pelicun).", False),
)
def export(curves: Path, form: str, out: Path, **given: Any) -> Answer:
    """Write fragility curves for other tools, spreadsheets and papers.

    Example: skewbridge export results/fragility/curves.parquet --format nrml --out curves.xml
    """
    from skewbridge.fragility.exports import export_curves

    report = export_curves(curves, form, out, **given)
    return Answer(report, {"files": report["files"]}, notes=report["notes"])


@command(
    commands,
    Arg("demands", Path, "Table with columns of demands.parquet: .parquet or .csv.", ...),
    OUT,
    LIMIT_STATES,
    Opt("im", str | None, "Intensity measure, if there are several.", None, "COLUMN"),
    Opt("margin", float | None, "Relative change that counts as negligible; default 0.05."),
    Opt("report", bool, "Also draw the figures and write report.html.", False),
)
def statistics(demands: Path, out: Path, report: bool, **given: Any) -> Answer:
    """Fit curves and effects to any table of demands.

    Writes demands.parquet and fragility/ as a study does, so `predict`, `compare`, `study plot` and
    `skewbridge.load` accept the folder. Required columns: the axes, motion_id, status, an intensity
    measure and demands; names, scale and incidence are optional. Limit states whose demand is
    missing are left out.

    Example: skewbridge statistics demands.csv --out my_statistics --report
    """
    from skewbridge.study.results import statistics_of

    answer = statistics_of(demands, out, **given)
    for text in answer["warnings"]:
        warn(text)
    if report:
        from skewbridge.report.page import write_statistics_report

        answer["report"] = str(write_statistics_report(out))
    return Answer(answer)


@command(
    commands,
    *(Opt(axis.name, float | None, axis.label_with_unit) for axis in AXES),
    Opt("axis", list[str] | None, "Value of a further axis; repeatable.", None, "NAME=VALUE"),
    STUDY,
    Opt("bridge", str | None, "Bridge; required if the study has several.", None, "NAME"),
    ABUTMENT._replace(kind=str | None, default=None, help="Abutment model, if there are several."),
    Opt("component", str | None, "Only this component.", None, "NAME"),
    Opt("state", str | None, "Only this limit state.", None, "NAME"),
    Opt("at", float | None, "Intensity at which to give probabilities."),
)
def predict(axis: list[str] | None, study: Path | None, **given: Any) -> Answer:
    """Predict fragility between the variants of a study.

    Gives medians, dispersions and probabilities from the joint model over skew, gap and friction,
    inside the parameter range of the study. --study may be a folder written by `statistics`.

    Example: skewbridge predict --bridge osb1 --skew-deg 45 --gap-mm 51 --friction 0.5 --at 0.6
    """
    from skewbridge.report.answer import untested_skew_sentence
    from skewbridge.study.results import predict_states

    axes = {axis.name: given.pop(axis.name) for axis in AXES}
    values = {name: value for name, value in axes.items() if value is not None}
    named = keys_and_values("--axis", axis)
    further = {name.replace("-", "_"): value for name, value in named.items()}
    values |= checked(dict[str, Number], further, "--axis")
    rows = predict_states(folder_of(study), values, **given)
    names = ("component", "state", "theta", "ci_theta", "beta_total", "beta", "p", "loo_error")
    statistics = [
        {name: rounded(value) for name, value in row.items()} for row in selected(rows, *names)
    ]
    flags = ("extrapolated", "theta"), ("p_extrapolated", "p")
    for row, printed in zip(rows, statistics, strict=True):
        printed["extrapolated"] = ", ".join(value for flag, value in flags if row[flag])
    shown = {f"theta in {rows[0]['im']}": statistics}
    notes = ["loo_error: error of theta when a variant is left out of the model"]
    if any(row[flag] for row in rows for flag, _ in flags):
        notes.append("extrapolated: fewer than three motions are as strong, or as weak, as this")
    if (drawn := rows[0]["random_properties"]) != "none":
        notes.append(f"each motion of the study has its own random values of: {drawn}")
    notes += filter(None, [untested_skew_sentence([values.get("skew_deg", 0.0)])])
    reason = "too few variants have an estimate for this state"
    return Answer({"rows": rows}, shown, notes=notes, missing=reason)
