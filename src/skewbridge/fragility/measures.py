"""Rank intensity measures by efficiency, practicality, proficiency and sufficiency.

Sources: Luco and Cornell (2007), Earthquake Spectra 23(2):357-392; Padgett, Nielson and DesRoches
(2008), EESD 37(5):711-725.
"""

from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.demands.validity import is_complete
from skewbridge.files.tables import Floats, Index, require
from skewbridge.fragility.demand_table import described, models_of, motion_codes, need_columns
from skewbridge.fragility.fits import FITTED, SINGLE_LEVEL
from skewbridge.fragility.lines import tested_line

# First letters of measures with ground-motion models and hazard curves in common use.
HAZARD_KNOWN: Final = ("im_pga", "im_pgv", "im_sa_", "im_saavg", "im_arias", "im_cav")


def rank_measures(
    demands: pd.DataFrame, column: str, motions: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Return the rows of table `measures` for one positive demand, best proficiency first."""
    need_columns(demands, (column, "motion_id", "status"))
    table = demands[is_complete(demands)].reset_index(drop=True)
    demand = table[column].to_numpy(dtype=np.float64)
    require(demand > 0.0, column, "must be > 0 in completed runs", demand)
    y, codes = np.log(demand), motion_codes(table)
    properties = _properties(table, codes, motions)
    rows: list[dict[str, Any]] = []
    for name in map(str, table.filter(regex="^im_")):
        im = table[name].to_numpy(dtype=np.float64)
        has_non_positive = bool(np.any(~(im > 0.0)))
        if has_non_positive or np.ptp(im) == 0.0:
            status = "non_positive_im" if has_non_positive else SINGLE_LEVEL
            rows.append({"im": name, "status": status, "proficiency": np.nan})
            continue
        x = np.log(im)
        line = tested_line(x, y)
        residual = y - line.ln_a - line.b * x
        by_motion = np.bincount(codes, residual) / np.bincount(codes)
        row = {"im": name, "status": FITTED, "efficiency": line.sigma, "practicality": line.b}
        row["proficiency"] = line.sigma / line.b if line.b > 0.0 else np.nan
        row |= {f"p_{key}": _p_value(values, by_motion) for key, values in properties.items()}
        rows.append(row | {"n_runs": line.n})
    table = pd.DataFrame(rows)
    return table.sort_values("proficiency", na_position="last", ignore_index=True)


def _properties(
    table: pd.DataFrame, codes: Index, motions: pd.DataFrame | None
) -> dict[str, Floats]:
    """Return the motion properties on which residuals must not depend, averaged over runs, (M,)."""
    columns: dict[str, Floats] = {}
    if motions is not None:
        joined = table[["motion_id"]].merge(motions, on="motion_id", how="left")
        distance = joined["distance_km"].to_numpy(dtype=np.float64)
        columns["magnitude"] = joined["magnitude"].to_numpy(dtype=np.float64)
        columns["ln_distance"] = np.log(np.where(distance > 0.0, distance, np.nan))
    values = {"ln_scale": table.get("scale"), "ln_duration": table.get("im_d5_75_s")}
    if {"im_sa_t1_rotd50_g", "im_saavg_rotd50_g"} <= set(table):
        values["ln_shape"] = table["im_sa_t1_rotd50_g"] / table["im_saavg_rotd50_g"]
    for name, value in values.items():
        if value is not None:
            columns[name] = np.log(value.where(value > 0.0).to_numpy(dtype=np.float64))
    runs = np.bincount(codes)
    return {name: np.bincount(codes, values) / runs for name, values in columns.items()}


def _p_value(values: Floats, residual: Floats) -> float:
    """Return the p-value of the regression of residuals on a property."""
    # both arrays hold means by motion, shape (M,); NaN for a constant property
    is_finite = np.isfinite(values)
    spread = np.ptp(values[is_finite]) if np.any(is_finite) else 0.0
    # ASSUME a relative variation of a property below 1e-6 is rounding: the property is constant
    if np.sum(is_finite) < 4 or spread <= 1e-6 * (1.0 + float(np.max(np.abs(values[is_finite])))):
        return np.nan
    line = tested_line(values[is_finite], residual[is_finite])
    t = line.b / (line.sigma / np.sqrt(line.sxx))
    return float(2.0 * special.stdtr(line.n - 2, -abs(t)))


def measure_table(demands: pd.DataFrame, motions: pd.DataFrame) -> pd.DataFrame:
    """Return table `measures` for all bridges, abutment models and positive headline demands."""
    names = ["motion_id", "magnitude", "distance_km"]
    suite = motions[names] if set(names) <= set(motions.columns) else None
    tables: list[pd.DataFrame] = []
    for model, runs in models_of(demands[is_complete(demands)]):
        ranked = [
            rank_measures(runs, column, suite).assign(**model, demand=column)
            for column in demands_for("headline", demands.columns)
            if (runs[column] > 0.0).all()
        ]
        if not ranked:
            continue
        table = pd.concat(ranked, ignore_index=True)
        fitted = table[(table["status"] == FITTED) & table["im"].str.startswith(HAZARD_KNOWN)]
        most_efficient = None
        if len(fitted):
            logs = pd.Series(np.log(fitted["efficiency"].to_numpy(dtype=np.float64)))
            most_efficient = logs.groupby(fitted["im"].to_numpy()).mean().idxmin()
        tables.append(table.assign(recommended=(table["im"] == most_efficient)))
    table = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
    return table.reindex(columns=[n for n in described("measures") if n in table or not tables])
