"""Fragility curves for other tools and for papers: which file holds what."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.chosen import ChosenCurves, choose_curves
from skewbridge.fragility.exchange.curve_tables import (
    Sampling,
    hazard_notes,
    parameter_table,
    sampled_table,
    skew_factors,
)
from skewbridge.fragility.exchange.data_files import write_csv
from skewbridge.fragility.exchange.nrml import write_nrml
from skewbridge.fragility.exchange.pelicun import write_pelicun
from skewbridge.fragility.exchange.workbook import write_workbook
from skewbridge.fragility.old_joint.columns import JOINT_COLUMNS
from skewbridge.fragility.tables.paper_table import latex_table, paper_table
from skewbridge.provenance.files import write_text
from skewbridge.provenance.tables import read_frame

FORMATS: Final = ("nrml", "pelicun", "csv", "xlsx", "latex")
_SPREADSHEETS: Final = ("csv", "xlsx")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What of the curves is written, beside their parameters.

    Attributes:
        hazard: CSV with columns im and rate (per year) in the measure of the curves: adds the mean
            annual frequency of every limit state (csv, xlsx).
        sampling: Where curves are evaluated: the table of a csv, a sheet of an xlsx.
        skew: Whether the factors of skew are: the table of a csv, a sheet of an xlsx.
        wide: A row per variant, or per intensity, instead of one per curve (csv, xlsx).
    """

    hazard: Path | None = None
    sampling: Sampling | None = None
    skew: bool = False
    wide: bool = False


PARAMETERS: Final = Wanted()


def export_curves(
    source: Path, form: str, out: Path, *, method: str = "cloud", wanted: Wanted = PARAMETERS
) -> dict[str, Any]:
    """Write the curves of a study for another tool or a paper.

    The dispersion of a curve is beta_total, that of the capacity included, where a slope carries
    it over, and beta (record-to-record) otherwise. Curves without an estimate have their status in
    csv and xlsx; elsewhere they are left out (a number would have to be invented) and named.

    Args:
        source: results/fragility/curves.parquet, or the same as CSV.
        form: nrml, pelicun, csv, xlsx or latex.
        out: File to write; nrml may write several beside it, which are told.
        method: cloud, exceedance, ida_interval or ordered.
        wanted: What beside the parameters.

    Returns:
        ``format``, ``files`` (those written), ``curves`` (written), ``left_out`` (their number),
        ``unfitted`` (which and why), ``notes`` (sentences), and what the format adds.

    Raises:
        InputError: The format is unknown or does not hold what is wanted, the table is unreadable
            or empty, or an intensity measure has no name in the other tool.
    """
    if form not in FORMATS:
        raise InputError(f"format must be one of {', '.join(FORMATS)}, got {form!r}")
    if wanted != PARAMETERS and form not in _SPREADSHEETS:
        raise InputError(
            f"format {form} holds the parameters of curves only: --wide, --im-range, --hazard and "
            f"--skew-factors are of {' and '.join(_SPREADSHEETS)}"
        )
    curves = choose_curves(source, method)
    if curves.fitted.empty and form not in _SPREADSHEETS:
        raise InputError(f"no curve of method {method!r} has an estimate: nothing to write")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        told = _write(curves, form, out, wanted)
    except OSError as error:
        raise InputError(f"cannot write {out}: {error}") from error
    return {
        "format": form,
        "curves": len(curves.fitted),
        "left_out": len(curves.unfitted),
        **told,
        "notes": [*_notes(curves), *told.get("notes", ())],
        "unfitted": curves.unfitted,
    }


def _write(curves: ChosenCurves, form: str, out: Path, wanted: Wanted) -> dict[str, Any]:
    """Write in one format; returns ``files`` and what the format adds."""
    if form == "nrml":
        files = write_nrml(curves, out)
        return {
            "files": [each["file"] for each in files],
            "models": files,
            "notes": _nrml_notes(files, out),
        }
    if form == "pelicun":
        told = write_pelicun(curves, out)
        notes = [f"{len(told['holes'])} rows lack states without an estimate"]
        return {
            "files": [str(out), told["names"]],
            "holes": told["holes"],
            "notes": notes if told["holes"] else [],
        }
    notes: list[str] = []
    if form == "latex":
        write_text(out, latex_table(_paper_rows(curves)))
    else:
        sheets = _sheets(curves, wanted, everything=form == "xlsx")
        if wanted.hazard is not None:
            notes = hazard_notes(parameter_table(curves, hazard=wanted.hazard), wanted.hazard)
        if form == "xlsx":
            notes_sheet = pd.DataFrame({"note": [*_notes(curves), *notes]})
            write_workbook(sheets | {"notes": notes_sheet}, out)
        else:
            write_csv(next(iter(sheets.values())), out)
    return {"files": [str(out)], "notes": notes}


def _sheets(curves: ChosenCurves, wanted: Wanted, *, everything: bool) -> dict[str, pd.DataFrame]:
    """Return tables by name; the first one is that of a csv."""
    asked = [wanted.hazard is not None, wanted.sampling is not None, wanted.skew]
    if not everything and sum(asked) > 1:
        raise InputError("a csv is one table: give one of --hazard, --im-range, --skew-factors")
    sheets: dict[str, pd.DataFrame] = {}
    if everything or not (wanted.sampling or wanted.skew):
        sheets["curves"] = parameter_table(curves, hazard=wanted.hazard, wide=wanted.wide)
    if wanted.sampling is not None:
        sheets["probabilities"] = sampled_table(curves, wanted.sampling, wide=wanted.wide)
    if wanted.skew:
        sheets["skew factors"] = skew_factors(curves)
    return sheets


def _paper_rows(curves: ChosenCurves) -> pd.DataFrame:
    """Return the rows of a paper's table, with ratios and joint models where the study has them."""
    ratios, joint = (
        read_frame(path) if (path := curves.folder / f"{name}.parquet").is_file() else None
        for name in ("median_effects", "joint")
    )
    if ratios is None:
        ratios = pd.DataFrame(columns=["bridge", "abutment", "demand", "axis"])
    if joint is None:
        joint = pd.DataFrame(columns=[*JOINT_COLUMNS]).astype({"preferred": bool})
    return paper_table(curves.rows, ratios, joint)


def _notes(curves: ChosenCurves) -> list[str]:
    notes = [
        "the dispersion of a curve is beta_total, with that of the capacity; "
        "beta is record-to-record"
    ]
    if curves.without_capacity:
        notes.append(
            f"{curves.without_capacity} curves have no beta_total (no slope carries the dispersion "
            "of the capacity over): theirs is beta"
        )
    if curves.unfitted:
        notes.append(f"{len(curves.unfitted)} limit states have no estimate (listed by --json)")
    return notes


def _nrml_notes(files: list[dict[str, Any]], out: Path) -> list[str]:
    notes: list[str] = []
    if str(out) not in {each["file"] for each in files}:
        notes.append(
            f"{out.name} was not written: functions differ in their limit states, of which a file "
            f"of OpenQuake has one list; {len(files)} files stand in its place"
        )
    if crossing := sum(len(each["crossing"]) for each in files):
        notes.append(
            f"curves cross in {crossing} functions, where OpenQuake gets negative fractions of "
            "damage: curves of --method ordered never cross"
        )
    return notes
