"""Rows of the report on the paired effects."""

from typing import Any

import pandas as pd

from skewbridge.demands.columns import demands_for, label_of
from skewbridge.fragility.tables.needed_motions import MORE
from skewbridge.fragility.tables.verdicts import DIFFERENCE, VERDICTS
from skewbridge.report.fragility_effect_figures import change_text
from skewbridge.variant.axes import axes_of


def headline_rows(pooled: pd.DataFrame, needed: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the pooled effects on the headline demands, each with what would decide it.

    Args:
        pooled: Pooled rows of the effects.
        needed: Table of `needed_motions`.
    """
    keys = ["bridge", "abutment", "demand", "axis", "from_value", "to_value"]
    rows = pooled[pooled["demand"].isin(demands_for("headline"))]
    rows = rows.merge(needed[[*keys, "forecast", "needed_motions"]], on=keys, how="left")
    return [
        {
            "model": f"{row['bridge']}, {str(row['abutment']).replace('_', '-')}",
            "demand": label_of(str(row["demand"])),
            "change": _change(row),
            "effect": change_text(row),
            "interval": _interval(row),
            "verdict": row["verdict"],
            "family": row["verdict_family"],
            "p_cells": row["p_cells"],
            "forecast": f"{row['needed_motions']:g} motions"
            if row["forecast"] == MORE
            else row["forecast"],
        }
        for row in rows.to_dict("records")
    ]


def verdict_shares(cells: pd.DataFrame) -> list[dict[str, Any]]:
    """Return how often each verdict is given to the pairs of variants, alone and in the family."""
    return [
        {
            "verdict": name,
            "meaning": meaning,
            "alone": int((cells["verdict"] == name).sum()),
            "family": int((cells["verdict_family"] == name).sum()),
        }
        for name, meaning in VERDICTS.items()
    ]


def _change(row: dict[Any, Any]) -> str:
    axis = axes_of([row["axis"]])[0]
    return f"{axis.label_with_unit} {row['from_value']:g} to {row['to_value']:g}"


def _interval(row: dict[Any, Any]) -> str:
    """Return the interval of the effect as it is judged: per cent, or its unit."""
    if row["judged_by"] == DIFFERENCE:
        return f"{row['difference_low']:+.2g} to {row['difference_high']:+.2g} {row['unit']}"
    low, high = (100.0 * (row[name] - 1.0) for name in ("ci_low", "ci_high"))
    return f"{low:+.1f} to {high:+.1f} %"
