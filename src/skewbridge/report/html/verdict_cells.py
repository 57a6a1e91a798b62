"""The verdict map of the page: every demand against every change of an axis, model by model."""

from typing import Any

import pandas as pd

from skewbridge.report.axis_layout import value_text
from skewbridge.report.html.answer import model_name
from skewbridge.report.verdict_style import (
    change_text,
    demand_name,
    interval_text,
    margin_text,
    verdict_style,
)
from skewbridge.variant.axes import axis


def verdict_maps(pooled: pd.DataFrame) -> list[dict[str, Any]]:
    """Return a map per bridge and abutment model: its heads, and rows of cells.

    Args:
        pooled: Pooled rows of the effects.
    """
    changes = ["axis", "from_value", "to_value"]
    out: list[dict[str, Any]] = []
    for model, part in pooled.groupby(["bridge", "abutment"], sort=False):
        heads = list(part[changes].drop_duplicates().itertuples(index=False, name=None))
        rows = [
            {
                "label": demand_name(str(demand)),
                "margin": margin_text(own.iloc[0]),
                "cells": _cells(own.set_index(changes), heads),
            }
            for demand, own in part.groupby("demand", sort=False)
        ]
        names = [change_name(*head) for head in heads]
        out.append({"model": model_name(*model), "heads": names, "rows": rows})
    return out


def _cells(found: pd.DataFrame, heads: list[Any]) -> list[dict[str, str] | None]:
    return [_cell(found.loc[head]) if head in found.index else None for head in heads]


def change_name(name: str, low: float, high: float) -> str:
    """Return a change of an axis in words, such as ``Skew 0° to 60°``."""
    told = axis(name)
    return f"{told.label} {value_text(told, low)} to {value_text(told, high)}"


def _cell(row: pd.Series) -> dict[str, str]:
    style = verdict_style(row)
    return {
        "style": style.name,
        "sign": style.sign,
        "text": change_text(row),
        "interval": interval_text(row),
    }
