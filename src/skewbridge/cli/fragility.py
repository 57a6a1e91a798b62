"""Commands for fragility curves: fit, export, statistics of a demands table, prediction."""

from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Final, Literal

from skewbridge.cli import new_group
from skewbridge.cli.output import (
    LIMIT_STATES,
    Answer,
    Hazard,
    LimitStates,
    Out,
    Study,
    arg,
    command,
    folder_of,
    gap_notes,
    keys_and_values,
    opt,
    selected,
)
from skewbridge.errors import InputError
from skewbridge.files.text import Number, checked
from skewbridge.units import Units

commands = new_group()

#: Printed columns of the table of `decide`, as far as it has them.
_DECISION_COLUMNS: Final = (
    *("skew_deg", "gap_mm", "seat_m", "seat_m_low", "seat_m_high", "extrapolated"),
    *("hazus_m", "aashto_m", "sdc_m", "column_rate"),
)


@dataclass(frozen=True, kw_only=True)
class FitCommand:
    """Options of `skewbridge fit`: the fields of `FitOptions`."""

    method: Annotated[Literal["stripes", "ida", "cloud"] | None, opt("Kind of data.")] = None
    model: Annotated[str | None, opt("Regression model of a cloud.", "[ols|tobit]")] = None
    link: Annotated[str, opt("Link function of stripes.", "[probit]")] = "probit"
    level: Annotated[float, opt("Confidence level.")] = 0.95
    threshold: Annotated[float | None, opt("Median capacity, in the unit of the demands.")] = None
    im: Annotated[str | None, opt("Column with the intensities of the runs.", "COLUMN")] = None
    edp: Annotated[str | None, opt("Column with the demands of the runs.", "COLUMN")] = None
    columns: Annotated[Path | None, opt("YAML file that maps the columns of your table.")] = None


@command(commands)
def fit(
    data: Annotated[Path, arg("Data file: .json, .csv or .parquet.")], options: FitCommand
) -> Answer:
    """Fit a fragility curve: theta, beta, their intervals and a status.

    Example: skewbridge fit demands.csv --method cloud --im im_pga --edp drift --threshold 0.02
    """
    from skewbridge.fragility.fit_data import fit_file

    try:
        result = fit_file(data, **vars(options)).as_json()
    except InputError as error:
        error.details.setdefault("row", None)
        raise
    notes = result.get("notes", ())
    printed = {name: value for name, value in result.items() if name != "notes"}
    reason = f"not determined by the data (status {result['status']})"
    return Answer(result, printed, notes=notes, missing=reason, warnings=result["warnings"])


@command(commands)
def export(
    curves: Annotated[Path, arg("Table of curves of a study (.parquet, .csv).")],
    form: Annotated[str, opt("File format.", "[nrml|pelicun|csv|latex]", "--format")],
    out: Annotated[Path, opt("File to write.")],
) -> Answer:
    """Write fragility curves for other tools, spreadsheets and papers.

    Example: skewbridge export results/fragility/curves.parquet --format nrml --out curves.xml
    """
    from skewbridge.fragility.exports import export_curves

    report = export_curves(curves, form, out)
    return Answer(report, {"files": report["files"]}, notes=report["notes"])


@command(commands)
def statistics(
    demands: Annotated[Path, arg("Table with columns of demands.parquet: .parquet or .csv.")],
    out: Out,
    units: Units,
    limit_states: LimitStates = LIMIT_STATES,
    im: Annotated[str | None, opt("Intensity measure, if there are several.", "COLUMN")] = None,
    hazard: Hazard = None,
    report: Annotated[bool, opt("Also write figures and report.html.", None, "--report")] = False,
) -> Answer:
    """Fit curves and effects to any table of demands.

    Writes demands.parquet and fragility/ as a study does, so `predict`, `compare`, `study plot` and
    `skewbridge.load` accept the folder. Required columns: the axes, motion_id, status, an intensity
    measure and demands; names, scale and incidence are optional. Limit states whose demand is
    missing are left out.

    Example: skewbridge statistics demands.csv --out my_statistics --report
    """
    from skewbridge.study.results import statistics_of

    answer = statistics_of(demands, out, limit_states, im, hazard)
    if report:
        from skewbridge.report.page import write_statistics_report

        answer["report"] = str(write_statistics_report(out, units))
    return Answer(answer, warnings=answer["warnings"])


def _bridge_file(study: Path, bridge: str | None) -> str:
    """Return the file of a bridge, or of the first one, in a stored study; else the name."""
    from skewbridge.study.config import stored_configuration

    files: dict[str, str] = {}
    with suppress(InputError):  # stored by another version
        if config := stored_configuration(study):
            files = {Path(name).stem: name for name in config.grid.bridge}
    return files.get(bridge or next(iter(files), ""), bridge or "")


@command(commands)
def predict(
    skew_deg: Annotated[float | None, opt("Skew (deg).")] = None,
    gap_mm: Annotated[float | None, opt("Gap (mm).")] = None,
    friction: Annotated[float | None, opt("Friction coefficient.")] = None,
    axis: Annotated[list[str] | None, opt("Value of another axis.", "NAME=VALUE")] = None,
    study: Study = None,
    bridge: Annotated[str | None, opt("Bridge; required if the study has several.", "NAME")] = None,
    abutment: Annotated[str | None, opt("Abutment model, if there are several.", "NAME")] = None,
    at: Annotated[float | None, opt("Intensity for probabilities, in unit of the curves.")] = None,
    hazard: Hazard = None,
) -> Answer:
    """Predict fragility between the variants of a study.

    Gives medians, dispersions and probabilities from the joint model over skew, gap and friction,
    inside the parameter range of the study. --study may be a folder written by `statistics`.

    Example: skewbridge predict --bridge osb1 --skew-deg 45 --gap-mm 51 --friction 0.5 --at 0.6
    """
    from skewbridge.fragility.rates import lacking_notes
    from skewbridge.report.answer import BACKFILLED, untested_skew_sentence
    from skewbridge.study.results import predict_states

    axes = {"skew_deg": skew_deg, "gap_mm": gap_mm, "friction": friction}
    values = {name: value for name, value in axes.items() if value is not None}
    pairs = keys_and_values("--axis", axis)
    axis_values = {name.replace("-", "_"): value for name, value in pairs.items()}
    if twice := values.keys() & axis_values.keys():
        raise InputError(f"{twice.pop()} is given by its option and by --axis: give it once")
    values |= checked(dict[str, Number], axis_values, "--axis")
    rows = predict_states(folder_of(study), values, bridge, abutment, at=at, hazard=hazard)
    names = ("component", "state", "theta", "ci_theta", "beta_total", "beta", "p", "loo_error")
    if hazard is not None:
        names = (*names[:4], "p", "annual_rate", "annual_rate_low", "annual_rate_high")
    statistics = selected(rows, *names)
    flags = ("extrapolated", "theta"), ("p_extrapolated", "p")
    for row, printed in zip(rows, statistics, strict=True):
        printed["extrapolated"] = ", ".join(value for flag, value in flags if row[flag])
    title = f"theta in {rows[0]['im']} with its {100 * rows[0]['level']:g} % interval"
    printed_tables = {title + (f"; p at {at:g}" if at else ""): statistics}
    text = "loo_error: error of theta when a variant is left out of the model"
    notes = [] if hazard is not None else [text]  # else it is not printed
    if any(row[flag] for row in rows for flag, _ in flags):
        notes.append("extrapolated: fewer than three motions are as strong, or weak, as this value")
    notes += lacking_notes(rows)
    if withheld := [f"{r['component']} {r['state']}" for r in rows if r["n_withheld"]]:
        notes.append(f"no curve in some variants (bounds_too_wide): {', '.join(withheld)}")
    if (drawn := rows[0]["random_properties"]) != "none":
        notes.append(f"properties drawn at random for each motion of the study: {drawn}")
    notes += gap_notes(_bridge_file(folder_of(study), bridge))
    skews_deg = [values.get("skew_deg", 0.0)] * (rows[0]["abutment"] in BACKFILLED)
    notes += filter(None, [untested_skew_sentence(skews_deg)])
    reason = "too few variants have an estimate for this state"
    return Answer({"rows": rows}, printed_tables, notes=notes, missing=reason, digits=3)


@command(commands)
def decide(
    hazard: Annotated[Path, arg("Hazard curve of the site (CSV, OpenQuake, USGS).")],
    units: Units,
    probability_50y: Annotated[float, opt("Target probability of failure in 50 years.")] = 0.02,
    axis: Annotated[list[str] | None, opt("Value of another axis.", "NAME=VALUE")] = None,
    study: Study = None,
    bridge: Annotated[str | None, opt("Bridge; required if the study has several.", "NAME")] = None,
    out: Out = Path("decision"),
) -> Answer:
    """Find the seat length and joint gap that each skew needs.

    Writes decision.csv and the chart decision.svg and .png: seat length with interval for which
    unseating stays below the target, gaps for which column failure stays below it, and the rules of
    AASHTO, SDC and Hazus. Study and hazard must use the same intensity measure.

    Example: skewbridge decide site.csv --bridge osb1 --axis friction=0.5 --out decision
    """
    from skewbridge.files.tables import read_frame, records_of, write_csv
    from skewbridge.files.text import writable_folder
    from skewbridge.fragility.hazard import hazard_curve
    from skewbridge.fragility.rates import decision, target_rate
    from skewbridge.report.bridge_figures import decision_figure, with_codes
    from skewbridge.report.study_figures import save_figure
    from skewbridge.study.config import FigureSettings
    from skewbridge.study.folder import StudyFolder
    from skewbridge.study.results import joint_rows, withheld_curves

    target = target_rate(probability_50y)
    values = checked(dict[str, Number], keys_and_values("--axis", axis), "--axis")
    rows = joint_rows(folder_of(study), bridge)
    site_curve = hazard_curve(hazard, [rows[0]["im"]], rows[0]["im"])
    assert site_curve is not None
    file = _bridge_file(folder_of(study), rows[0]["bridge"])
    needs = with_codes(decision(rows, site_curve, target, values), file)
    table = needs.table
    labels = [rows[0]["bridge"], *(f"{name} {value:g}" for name, value in needs.values.items())]
    title = f"{', '.join(labels)}: rate below {target:.3g} per year"
    if extrapolated := table["extrapolated"].sum():
        title += f" ({extrapolated} of {len(table)} seats extrapolated)"
    write_csv(table, csv := writable_folder(out) / "decision.csv")
    draw = partial(decision_figure, needs, title)
    files = save_figure(draw, FigureSettings(units=units), out, "decision")
    is_end_gap = table["gap_mm"].isin([table["gap_mm"].min(), table["gap_mm"].max()])
    is_third_skew = table["skew_deg"].isin(table["skew_deg"].unique()[::3])
    columns = [name for name in _DECISION_COLUMNS if name in table]
    printed = {title: records_of(table.loc[is_end_gap & is_third_skew, columns])}
    written = ", ".join(map(str, [csv, *files]))
    notes = [f"target: {target:.3g} per year, intensity: {site_curve.im}; written: {written}"]
    notes += gap_notes(file)
    if (last_rate := site_curve.rates[0, -1]) > 0.1 * target:
        notes.append(f"the hazard curve ends at {last_rate:.3g} per year: lengths may be too short")
    notes += needs.notes
    of_model = rows[0]["bridge"], rows[0]["abutment"], "unseating"
    withheld = withheld_curves(folder_of(study)).items()
    if lost := [f"{keys[-1]} {n}" for keys, n in withheld if keys[:-1] == of_model]:
        reason = "runs that ended early make its median, and these lengths, too uncertain"
        notes.append(f"variants without an unseating curve ({', '.join(lost)}): {reason}")
    above_target = table.filter(["gap_from_mm"]).isna().any(axis=1)
    if failing := [f"{skew_deg:g}" for skew_deg in table.loc[above_target, "skew_deg"].unique()]:
        skews = "any skew" if above_target.all() else f"skews of {', '.join(failing)} deg"
        notes.append(f"column failure is above the target at every gap for {skews}")
    if (demands := StudyFolder(folder_of(study)).demands).is_file():
        names = ["bridge", "abutment", "unseating_m"]
        model = tuple(rows[0][name] for name in names[:2])
        largest_m = read_frame(demands, names).groupby(names[:2])["unseating_m"].max()[model]
        if beyond := int((table["support_m"] > largest_m).sum()):
            text = (
                f"lengths exceed the unseating of all runs before column failure, {largest_m:.3g} m"
            )
            notes.append(f"extrapolated: {beyond} of {len(table)} {text}")
    answer = {"target": target, "values": needs.values, "rows": records_of(table)}
    return Answer(answer, printed, notes=notes, digits=3)
