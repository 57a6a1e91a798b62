"""Rows of the tables behind the main one, in words: the columns that a reader compares."""

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.tables.paper_table import with_interval
from skewbridge.report.axis_layout import named_value, shown_axes
from skewbridge.report.html.answer import model_name
from skewbridge.report.html.statements import plain_label
from skewbridge.report.verdict_style import demand_name
from skewbridge.variant.axes import axis

type Row = Mapping[Hashable, Any]


def system_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the medians of the whole bridge with their bounds."""
    if table.empty:
        return []
    axes = shown_axes(table)
    return [
        {
            "model": _model(row),
            "variant": ", ".join(named_value(each, row[each.name]) for each in axes),
            "degree of damage": row["limit_state"],
            "exceed": f"{row['n_exceed']} of {row['n_runs']}",
            "θ [interval]": _median(row),
            "β": row["beta"],
            "θ, components fully correlated": row["theta_correlated"],
            "θ, components independent": row["theta_independent"],
            "weakest component": _words(row["weakest"]),
        }
        for row in table.to_dict("records")
    ]


def measure_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the intensity measures as they rank for each demand."""
    return [
        {
            "model": _model(row),
            "demand": demand_name(row["demand"]),
            "measure": plain_label(row["im"]),
            "proficiency s/b": row["proficiency"],
            "efficiency s": row["efficiency"],
            "practicality b": row["practicality"],
            "R²": row["r2"],
            "p on magnitude": row["p_magnitude"],
            "p on ln distance": row["p_ln_distance"],
            "chance of being best": row["p_best_proficiency"],
        }
        for row in table.to_dict("records")
    ]


def factor_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the share of each axis in the differences of each demand."""
    return [
        {
            "model": _model(row),
            "demand": demand_name(row["demand"]),
            "factor": axis(row["factor"]).title,
            "motions": row["n_motions"],
            "F": row["f"],
            "p": row["p_value"],
            "partial η²": row["partial_eta2"],
            "Sobol, first order": row["first_order"],
            "Sobol, total": row["total_order"],
            "largest error for a left-out variant": row["worst_prediction"],
        }
        for row in table.to_dict("records")
    ]


def _model(row: Row) -> str:
    return model_name(row["bridge"], row["abutment"])


def _median(row: Row) -> str:
    if row["status"] != FITTED:
        return _words(row["status"])
    return with_interval([row[name] for name in ("theta", "theta_low", "theta_high")])


def _words(name: object) -> str:
    return str(name).replace("_", " ")
