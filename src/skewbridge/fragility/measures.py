"""Rank intensity measures by efficiency, practicality, proficiency and sufficiency.

Sources: Luco and Cornell (2007), Earthquake Spectra 23(2):357-392; Padgett, Nielson and DesRoches
(2008), EESD 37(5):711-725; relative sufficiency, Jalayer et al. (2012), J. Eng. Mech.
138(3):307-316.
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
from skewbridge.fragility.lines import fit_lines, tested_line
from skewbridge.fragility.settings import DEFAULTS, FitSettings

# First letters of measures with ground-motion models and hazard curves in common use.
HAZARD_KNOWN: Final = ("im_pga", "im_pgv", "im_sa_", "im_saavg", "im_arias", "im_cav")


def rank_measures(
    demands: pd.DataFrame,
    column: str,
    motions: pd.DataFrame | None = None,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return the rows of table `measures` for one positive demand, best proficiency first."""
    need_columns(demands, (column, "motion_id", "status"))
    table = demands[is_complete(demands)].reset_index(drop=True)
    demand = table[column].to_numpy(dtype=np.float64)
    require(demand > 0.0, column, "must be > 0 in completed runs", demand)
    y, codes = np.log(demand), motion_codes(table)
    count, rng = int(codes.max()) + 1, np.random.default_rng(settings.seed)
    drawn = rng.multinomial(count, np.full(count, 1.0 / count), size=settings.bootstrap)
    weights = drawn[:, codes].astype(np.float64)
    properties = _properties(table, codes, motions)
    rows: dict[str, dict[str, Any]] = {}
    replicates: dict[str, Floats] = {}
    scores: dict[str, float] = {}
    for name in map(str, table.filter(regex="^im_")):
        im = table[name].to_numpy(dtype=np.float64)
        bad = bool(np.any(~(im > 0.0)))
        if bad or np.ptp(im) == 0.0:
            status = "non_positive_im" if bad else SINGLE_LEVEL
            rows[name] = {"status": status, "proficiency": np.nan}
            continue
        x = np.log(im)
        line = tested_line(x, y)
        residual = y - line.ln_a - line.b * x
        again = fit_lines(x, y, y, weights)
        ranks = np.stack([again.sigma, again.sigma / again.b])
        replicates[name] = np.where(np.isfinite(again.b), ranks, np.inf)
        scores[name] = float(np.mean(-0.5 * (residual / line.sigma) ** 2) - np.log(line.sigma))
        row = {"status": FITTED, "efficiency": line.sigma, "practicality": line.b}
        row["proficiency"] = line.sigma / line.b if line.b > 0.0 else np.nan
        row |= {"r2": line.r2, "n_runs": line.n}
        rows[name] = row | {"hazard_computable": name.startswith(HAZARD_KNOWN)}
        by_motion = np.bincount(codes, residual) / np.bincount(codes)
        for key, values in properties.items():
            rows[name][f"p_{key}"], rows[name][f"effect_{key}"] = _dependence(values, by_motion)
    if replicates:
        best = np.argmin(np.stack(list(replicates.values())), axis=0)
        for number, name in enumerate(replicates):
            shares = np.mean(best == number, axis=1).tolist()
            rows[name]["p_best_efficiency"], rows[name]["p_best_proficiency"] = shares
            rows[name]["relative_sufficiency_nats"] = scores[name] - max(scores.values())
    out = pd.DataFrame([{"im": name, **row} for name, row in rows.items()])
    return out.sort_values("proficiency", na_position="last", ignore_index=True)


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


def _dependence(values: Floats, residual: Floats) -> tuple[float, float]:
    """Return the p-value and the effect per standard deviation of a property on the residuals."""
    # both arrays hold means by motion, shape (M,); NaN for a constant property
    good = np.isfinite(values)
    spread = np.ptp(values[good]) if np.any(good) else 0.0
    # ASSUME a relative variation of a property below 1e-6 is rounding: the property is constant
    if np.sum(good) < 4 or spread <= 1e-6 * (1.0 + float(np.max(np.abs(values[good])))):
        return np.nan, np.nan
    line = tested_line(values[good], residual[good])
    t = line.b / (line.sigma / np.sqrt(line.sxx))
    p = float(2.0 * special.stdtr(line.n - 2, -abs(t)))
    return p, line.b * float(np.std(values[good]))


def measure_table(
    demands: pd.DataFrame, motions: pd.DataFrame, settings: FitSettings = DEFAULTS
) -> pd.DataFrame:
    """Return table `measures` for all bridges, abutment models and positive headline demands."""
    names = ["motion_id", "magnitude", "distance_km"]
    suite = motions[names] if set(names) <= set(motions.columns) else None
    tables: list[pd.DataFrame] = []
    for model, part in models_of(demands[is_complete(demands)]):
        ranked = [
            rank_measures(part, column, suite, settings).assign(**model, demand=column)
            for column in demands_for("headline", demands.columns)
            if (part[column] > 0.0).all()
        ]
        if not ranked:
            continue
        table = pd.concat(ranked, ignore_index=True)
        usable = table[(table["status"] == FITTED) & table["im"].str.startswith(HAZARD_KNOWN)]
        best = None
        if len(usable):
            logs = pd.Series(np.log(usable["efficiency"].to_numpy(dtype=np.float64)))
            best = logs.groupby(usable["im"].to_numpy()).mean().idxmin()
        tables.append(table.assign(recommended=(table["im"] == best)))
    table = pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
    return table.reindex(columns=[n for n in described("measures") if n in table or not tables])
