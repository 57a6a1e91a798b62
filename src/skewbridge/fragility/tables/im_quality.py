"""How good is an intensity measure: efficiency, practicality, proficiency, sufficiency, ranking.

References:
    Luco and Cornell (2007), Earthquake Spectra 23(2):357-392: efficiency and sufficiency.
    Padgett, Nielson and DesRoches (2008), EESD 37(5):711-725: practicality and proficiency.
    Jalayer, Beck and Zareian (2012), J. Eng. Mech. 138(3):307-316: relative sufficiency.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.demands.columns import demands_for
from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import record_weights, weighted_lines
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.parts import LineFit
from skewbridge.fragility.old_likelihood.validate import require_all
from skewbridge.fragility.methods.cloud import fit_line
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.key_columns import BRIDGE_COLUMNS, motion_codes, need_columns

# Measures for which ground-motion models and hazard curves are in common use.
HAZARD_KNOWN: Final = ("im_pga", "im_pgv", "im_sa_", "im_saavg", "im_arias", "im_cav")
NON_POSITIVE: Final = "non_positive_im"


def rank_measures(
    demands: pd.DataFrame,
    column: str,
    measures: Sequence[str] | None = None,
    motions: pd.DataFrame | None = None,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Rank intensity measures for one demand.

    Efficiency is the scatter s of ln D about its line on ln IM, practicality the slope b,
    proficiency zeta = s/b. ``p_best_efficiency`` and ``p_best_proficiency`` are the shares of
    record-bootstrap replicates in which the measure is the best: a rank by point value hides ties.

    Completed runs of one or more variants are used, and all ``im_`` columns unless ``measures``
    names some; ``motions`` (motion_id, magnitude, distance_km) is needed for sufficiency.

    Returns:
        One row per measure, best proficiency first; unusable measures last with a status.

    Raises:
        InputError: A column is missing or the demand is not positive.
    """
    names = [c for c in demands if str(c).startswith("im_")] if measures is None else measures
    names = [str(name) for name in names]
    need_columns(demands, (column, "motion_id", "status", *names))
    table = demands[is_complete(demands)].reset_index(drop=True)
    demand = table[column].to_numpy(dtype=np.float64)
    require_all(demand > 0.0, column, "must be > 0 in completed runs", demand)
    y = np.log(demand)
    weights = record_weights(motion_codes(table), settings.bootstrap, settings.seed)
    rows: list[dict[str, Any]] = []
    scatter: dict[str, FloatArray] = {}
    residuals: dict[str, tuple[FloatArray, float]] = {}
    for name in names:
        im = table[name].to_numpy(dtype=np.float64)
        bad = int(np.sum(~(im > 0.0)))
        if bad or np.ptp(im) == 0.0:
            reason = NON_POSITIVE if bad else existence.SINGLE_LEVEL
            rows.append({"im": name, "status": reason, "proficiency": np.nan})
            continue
        x = np.log(im)
        line = fit_line(x, y)
        residual = y - line.ln_a - line.b * x
        residuals[name] = (residual, line.sigma)
        scatter[name] = _replicate_scatter(x, y, weights)
        rows.append(_row(name, line) | _sufficiency(residual, table, motions))
    _add_probabilities(rows, scatter)
    _add_relative_sufficiency(rows, residuals)
    out = pd.DataFrame(rows)
    return out.sort_values("proficiency", na_position="last").reset_index(drop=True)


def measure_table(
    demands: pd.DataFrame, motions: pd.DataFrame, settings: FitSettings = DEFAULTS
) -> pd.DataFrame:
    """Rank the intensity measures of a study for its headline demands.

    Per bridge and abutment model, over the completed runs of all its variants; a demand that is
    missing or zero in one of them is left out. ``motions`` are those of the suite.

    Raises:
        InputError: A column is missing.
    """
    known = {"motion_id", "magnitude", "distance_km"} <= set(motions.columns)
    done = demands[is_complete(demands)]
    tables: list[pd.DataFrame] = []
    for (bridge, abutment), part in done.groupby(list(BRIDGE_COLUMNS), sort=True):
        for column in demands_for("headline", demands.columns):
            if not (part[column] > 0.0).all():
                continue
            ranked = rank_measures(
                part, column, motions=motions if known else None, settings=settings
            )
            ranked.insert(0, "demand", column)
            ranked.insert(0, "abutment", str(abutment))
            ranked.insert(0, "bridge", str(bridge))
            tables.append(ranked)
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()


def _row(name: str, line: LineFit) -> dict[str, Any]:
    return {
        "im": name,
        "status": FITTED if line.b > 0.0 else existence.NON_INCREASING,
        "ln_a": line.ln_a,
        "practicality": line.b,
        "efficiency": line.sigma,
        "proficiency": line.sigma / line.b if line.b > 0.0 else np.nan,
        "r2": line.r2,
        "hazard_computable": name.startswith(HAZARD_KNOWN),
    }


def _sufficiency(
    residual: FloatArray, table: pd.DataFrame, motions: pd.DataFrame | None
) -> dict[str, float]:
    """Regress the residual on magnitude and on ln distance: p-value and effect per deviation.

    The effect (change of ln D per standard deviation of the variable) is reported beside p,
    because p shrinks with the number of runs however small the effect.
    """
    if motions is None:
        return {}
    joined = table[["motion_id"]].merge(
        motions[["motion_id", "magnitude", "distance_km"]], on="motion_id", how="left"
    )
    out: dict[str, float] = {}
    distance = joined["distance_km"].to_numpy(dtype=np.float64)
    codes = motion_codes(table)
    runs = np.bincount(codes)
    per_motion = np.bincount(codes, residual) / runs  # runs of one motion are not independent
    for name, each in (
        ("magnitude", joined["magnitude"].to_numpy(dtype=np.float64)),
        ("ln_distance", np.log(np.where(distance > 0.0, distance, np.nan))),
    ):
        values = np.bincount(codes, each) / runs
        good = np.isfinite(values)
        if np.sum(good) < 4 or np.ptp(values[good]) == 0.0:
            out |= {f"p_{name}": np.nan, f"effect_{name}": np.nan}
            continue
        line = fit_line(values[good], per_motion[good])
        t = line.b / (line.sigma / np.sqrt(line.sxx))
        out[f"p_{name}"] = float(2.0 * special.stdtr(line.n - 2, -abs(t)))
        out[f"effect_{name}"] = line.b * float(np.std(values[good]))
    return out


def _replicate_scatter(x: FloatArray, y: FloatArray, weights: FloatArray) -> FloatArray:
    """Return s and zeta of each replicate, shape (2, R)."""
    line = weighted_lines(x, y, weights)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([line.scatter, np.where(line.b > 0.0, line.scatter / line.b, np.inf)])


def _add_probabilities(rows: list[dict[str, Any]], scatter: dict[str, FloatArray]) -> None:
    if not scatter:
        return
    best = np.argmin(np.stack(list(scatter.values())), axis=0)
    index = {name: number for number, name in enumerate(scatter)}
    for row in rows:
        if row["im"] in scatter:
            shares = np.mean(best == index[row["im"]], axis=1)
            row["p_best_efficiency"], row["p_best_proficiency"] = shares.tolist()


def _add_relative_sufficiency(
    rows: list[dict[str, Any]], residuals: dict[str, tuple[FloatArray, float]]
) -> None:
    """Mean log-density of the demand given the measure, relative to the best one (nats)."""
    score = {
        name: float(np.mean(-0.5 * (e / s) ** 2) - np.log(s)) for name, (e, s) in residuals.items()
    }
    for row in rows:
        if row["im"] in score:
            row["relative_sufficiency_nats"] = score[row["im"]] - max(score.values())
