"""Sentences of the page that have a number or a condition, each from the tables of the study."""

import re
from collections.abc import Sequence
from typing import Any

import pandas as pd

from skewbridge.analysis.suspect import SUSPECT
from skewbridge.bridge.catalogue.data import BridgeData
from skewbridge.demands.columns import label_of
from skewbridge.demands.completeness import KINDS, failure_kinds
from skewbridge.report.axis_layout import value_text
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import axes_of


def plain_label(column: str) -> str:
    """Return the label of a column without the marks of its formula."""
    return re.sub(r"\$|\\mathrm|[{}_]", "", label_of(column).replace(r"\,", " "))


def subtitle(demands: pd.DataFrame, im: str) -> str:
    """Return what was analysed: models, axes with their values, motions and their range."""
    bridges = ", ".join(dict.fromkeys(demands["bridge"]))
    models = ", ".join(str(name).replace("_", "-") for name in dict.fromkeys(demands["abutment"]))
    axes = [
        f"{axis.label.lower()} {', '.join(value_text(axis, value) for value in values)}"
        for axis in axes_of(demands.columns)
        if (values := sorted(demands[axis.name].unique()))
    ]
    motions = demands["motion_id"].nunique()
    low, high = demands["scale"].min(), demands["scale"].max()
    scaled = "unscaled" if low == high == 1.0 else f"scaled by {low:.2g} to {high:.2g}"
    reach = f"{demands[im].min():.2g} to {demands[im].max():.2g}"
    return (
        f"{bridges} with {models} abutments · {' × '.join(axes)} · "
        f"{motions} motion{'s' if motions > 1 else ''} {scaled}, {plain_label(im)} {reach}"
    )


def chips(demands: pd.DataFrame, checks: dict[str, Any], sensitivity: pd.DataFrame) -> list[str]:
    """Return what a reader asks first of the quality of a study, each in a few words."""
    counts = demands["status"].value_counts()
    became = ", ".join(f"{counts.get(name, 0)} {name}" for name in STATUSES if name in counts)
    residual = 100.0 * demands["energy_residual_ratio"].abs()
    passed = sum(check["passed"] for check in checks["checks"])
    said = [
        f"{len(demands)} analyses: {became}".replace("_", " "),
        f"energy residual: median {residual.median():.2g} %, worst {residual.max():.2g} %",
        f"{passed} of {len(checks['checks'])} checks passed",
        f"suspect rows: {checks['suspect_rows']}",
    ]
    if len(sensitivity):
        worst = 100.0 * sensitivity["reference_largest_change"].max()
        middle = 100.0 * sensitivity["reference_largest_change"].median()
        said.append(f"against the reference accuracy: median {middle:.2g} %, worst {worst:.2g} %")
    return said


def bridge_lines(bridges: Sequence[BridgeData]) -> list[dict[str, Any]]:
    """Return title, name and facts of every bridge."""
    return [
        {
            "title": bridge.title,
            "name": bridge.name,
            "facts": f"{bridge.base} column bases, conditioning period T1 = {bridge.t1_s:.3g} s",
            "surrogate": bridge.details == "surrogate",
        }
        for bridge in bridges
    ]


def beyond_model(demands: pd.DataFrame) -> str:
    """Return what is said of analyses in which a column failed beyond the model."""
    kinds = failure_kinds(demands)
    counts = {name: int((kinds == name).sum()) for name in KINDS}
    if not any(counts.values()):
        return "In no analysis did a column fail beyond what the model can follow."
    told = ", ".join(f"{name} {count}" for name, count in counts.items() if count)
    return (
        f"Analyses in which a column failed beyond what the model can follow: {told}. Their "
        "demands are peaks up to that time: in the fits the column exceeds every state, the rest "
        "at least what it had reached; in the paired effects they count as bounds."
    )


def friction_excess(demands: pd.DataFrame) -> str:
    """Return how much of the friction work was done above the limit of its step."""
    name = "cone_work_over_10pct_ratio"
    rubbed = demands[demands["slip_work_kj"] > 0.0]
    if rubbed.empty or name not in rubbed:
        return ""
    share = 100.0 * rubbed[name]
    return (
        "The friction limit of a step is set before the step, so that it lags at an impact of one "
        f"or two steps. In the {len(rubbed)} analyses with friction work, the share of that work "
        f"with friction 10 % and more above the local limit has the median {share.median():.2g} % "
        f"and the 95th percentile {share.quantile(0.95):.2g} %; the worst is {share.max():.2g} %."
    )


def suspect_line(demands: pd.DataFrame, *, excluded: bool) -> str:
    """Return how many rows are suspect, and what the fits make of them."""
    count = int((demands[SUSPECT] != "").sum())
    if not count:
        return f"None of the {len(demands)} rows is suspect."
    use = "as unknown outcomes" if excluded else "like all others"
    return f"{count} of {len(demands)} rows are suspect; the fits use them {use}."


def sensitivity_line(table: pd.DataFrame) -> str:
    """Return what the table of the accuracy compares; empty without one."""
    if table.empty:
        return ""
    return (
        f"Peak demands of {table['rows'].max()} rows of the study over the same at the reference "
        "accuracy (mean ratio), and the largest change of a single row: against the reference, and "
        "when a contact penalty (normal kn, tangential kt) is halved and doubled. Both sides of "
        "every comparison are analysed for the strongest part of the motion alone, "
        f"{table['analysed_s'].max():.3g} s."
    )
