"""Rows of the table that a paper prints, in words and units, and the states beyond reach."""

from collections import Counter
from collections.abc import Hashable, Mapping
from typing import Any, Final

import pandas as pd

from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.tables.paper_table import JOINT, paper_table, printed_rows
from skewbridge.report.axis_layout import named_value, shown_axes, threshold_text
from skewbridge.report.html.answer import model_name
from skewbridge.report.html.statements import plain_label
from skewbridge.variant.axes import axes_of

type Row = Mapping[Hashable, Any]


def paper_rows(curves: pd.DataFrame, medians: pd.DataFrame, joint: pd.DataFrame) -> dict[str, Any]:
    """Return the table of a paper as it is shown: heads, groups of rows by model and state.

    Args:
        curves: Fits of the single variants.
        medians: Paired ratios of their medians.
        joint: Joint models.
    """
    table = paper_table(curves, medians, joint)
    texts = printed_rows(table)
    names = [name for name in (texts[0] if texts else {}) if name.endswith(_RATIO_NAMES)]
    variants = {str(row["variant"]): row for row in curves.to_dict("records")}
    shown = shown_axes(curves)
    states = curves.drop_duplicates(["component", "limit_state"])
    capacity = {
        (row["component"], row["limit_state"]): threshold_text(row["demand"], row["threshold"])
        for row in states.to_dict("records")
    }
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row, text in zip(table.to_dict("records"), texts, strict=True):
        where = variants.get(str(row["row"]))
        state = f"{row['component']}, {row['limit_state']}".replace("_", " ")
        limit = capacity[row["component"], row["limit_state"]]
        key = model_name(row["bridge"], row["abutment"]), f"{state} ({limit})"
        groups.setdefault(key, []).append(
            {
                "variant": "all variants, middle of the box"
                if where is None
                else ", ".join(named_value(axis, where[axis.name]) for axis in shown),
                "joint": row["row"] == JOINT,
                "theta": _median(row, text["theta"]),
                "beta": text["beta"],
                "total": text["total"],
                "exceed": text["exceed"],
                "ratios": [text[name] for name in names],
            }
        )
    return {
        "im": plain_label(str(curves["im"].iloc[0])),
        "level": float(curves["level"].iloc[0]),
        "ratios": [f"θ ratio, {name}" for name in names],
        "groups": [
            {"model": model, "state": state, "rows": rows}
            for (model, state), rows in groups.items()
        ],
    }


_RATIO_NAMES: Final = ("skew", "gap", "friction")


def _median(row: Row, text: str) -> str:
    if pd.notna(row["theta"]):
        return text
    if row["n_exceed"] == 0:
        return "none exceeds"
    return "all exceed" if row["n_exceed"] == row["n_runs"] else "outcomes give no median"


def states_out_of_reach(curves: pd.DataFrame) -> list[dict[str, str]]:
    """Return the states that no run of some variants reached, with what limits their demand."""
    told = curves[(curves["reach"] != "") & (curves["method"] == "cloud")]
    keys = ["bridge", "abutment", "component", "limit_state", "mechanism"]
    out: list[dict[str, str]] = []
    for (bridge, abutment, component, state, _), own in told.groupby(keys, sort=False):
        first = own.iloc[0]
        same = (curves["bridge"] == bridge) & (curves["abutment"] == abutment)
        where = ", ".join(named_value(axis, first[axis.name]) for axis in axes_of(own.columns))
        out.append(
            {
                "model": model_name(bridge, abutment),
                "state": f"{component}, {state}".replace("_", " "),
                "variants": f"{len(own)} of {curves.loc[same, 'variant'].nunique()}",
                "where": where,
                "reason": str(first["reach"]),
            }
        )
    return out


def fit_counts(curves: pd.DataFrame) -> list[tuple[str, int]]:
    """Return how many fits have each status, estimates first."""
    counts = Counter(curves["status"].astype(str)).most_common()
    counts.sort(key=_is_no_estimate)
    return [(name.replace("_", " "), count) for name, count in counts]


def _is_no_estimate(counted: tuple[str, int]) -> bool:
    return counted[0] != FITTED
