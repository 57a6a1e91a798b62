"""Fragility table for publication: medians, dispersions and ratios of medians, also as LaTeX."""

import re
from collections.abc import Mapping, Sequence
from math import isnan
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.files.tables import records_of
from skewbridge.fragility.demand_table import axis_names, described
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.joint import JointModel
from skewbridge.fragility.settings import DEFAULTS, EFFECT_CONFIDENCE, FitSettings
from skewbridge.fragility.verdicts import RATIOS
from skewbridge.units import split_unit
from skewbridge.variant.axes import AXES, Axis, axes_of
from skewbridge.variant.variant import lacking_axes

JOINT: Final = "joint"
_ENDS: Final = ("", "_low", "_high")
_STATE: Final = ("bridge", "abutment", "component", "limit_state")
_NONE: Final = "--"
#: Column that is true, and mark of a printed median, if it is outside the range of the motions.
EXTRAPOLATED: Final = "extrapolated"
DAGGER: Final = "†"


def paper_columns(axes: Sequence[Axis]) -> dict[str, str]:
    """Return the column descriptions of the publication table for a study with these axes."""
    ends = {"": "estimate", "_low": "lower end", "_high": "upper end"}
    return described("table", axes) | {
        f"{split_unit(axis.name)[0]}_ratio{end}": f"{meaning} of the ratio to the median at the "
        f"smallest value of {axis.title}"
        for axis in reversed(axes)
        for end, meaning in ends.items()
    }


PAPER_COLUMNS: Final = paper_columns(AXES)


def chosen_curves(curves: pd.DataFrame, method: str | None = None) -> pd.DataFrame:
    """Return the curve of ``method``, or the preferred curve, per variant and limit state."""
    if method is not None:
        return curves[curves["method"] == method]
    first = curves.sort_values("preferred", ascending=False, kind="stable")
    return first.drop_duplicates(["variant", "component", "limit_state"]).sort_index()


def with_ratios(curves: pd.DataFrame, medians: pd.DataFrame) -> pd.DataFrame:
    """Add to each curve, for every axis, the ratio to the median at the smallest value of the axis.

    The ratios are paired by motion. They are NaN if not available.
    """
    axes = axis_names(curves)
    state = curves["component"].astype(str) + "/" + curves["limit_state"].astype(str)
    keys = curves[["bridge", "abutment", *axes]].assign(demand=state)
    keys = keys.astype(dict.fromkeys(axes, np.float64))
    ratios: dict[str, Any] = {}
    for axis in axes:
        pairs = medians[(medians["scope"] == "variant") & (medians["axis"] == axis)]
        pairs = pairs.assign(**{axis: pairs["to_value"]}).reindex(columns=[*keys, *RATIOS])
        pairs = pairs.astype(dict.fromkeys(axes, np.float64))
        found = keys.merge(pairs, on=list(keys), how="left", validate="many_to_one")
        ratios |= _ratio(axis, [found[name].to_numpy() for name in RATIOS])
    return curves.assign(**ratios)


def paper_table(
    curves: pd.DataFrame,
    medians: pd.DataFrame,
    joint: pd.DataFrame,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return the table for publication, without limit states of which no variant has a curve."""
    chosen = with_ratios(chosen_curves(curves), medians)
    joint = joint.merge(chosen.loc[chosen["theta"].notna(), list(_STATE)].drop_duplicates())
    rows = records_of(chosen.assign(row=chosen["variant"]))
    for row in records_of(joint[joint["status"] == FITTED]):
        model = JointModel(row)
        out = {name: row[name] for name in PAPER_COLUMNS if name in row}
        middle = model.axis_range.middle
        for axis in middle:
            low, high = (middle | {axis: end} for end in model.axis_range.limits[axis])
            out |= _ratio(axis, model.median(high, low, EFFECT_CONFIDENCE))
        rows.append(out | {"row": JOINT, "method": JOINT})
    table = pd.DataFrame(rows, columns=list(paper_columns(_axes(curves))))
    table = table[table.groupby(list(_STATE))["theta"].transform("count") > 0]
    order = {key: place for place, key in enumerate(map(tuple, curves[[*_STATE]].to_numpy()))}
    places = [order.get(key, len(order)) for key in map(tuple, table[[*_STATE]].to_numpy())]
    return table.iloc[np.argsort(places, kind="stable")].reset_index(drop=True)


def _axes(table: pd.DataFrame) -> tuple[Axis, ...]:
    """Return the axes of a table, always including the core axes."""
    return axes_of([*(axis.name for axis in AXES), *axis_names(table)])


def _ratio(axis: str, values: Sequence[Any]) -> dict[str, Any]:
    name = split_unit(axis)[0]
    return {f"{name}_ratio{end}": value for end, value in zip(_ENDS, values, strict=True)}


def ratio_names(table: pd.DataFrame) -> list[str]:
    """Return the names, without unit, of axes with at least one ratio in a publication table."""
    names = (split_unit(axis.name)[0] for axis in reversed(_axes(table)))
    return [name for name in names if table[f"{name}_ratio"].notna().any()]


def variant_in_words(row: Mapping[str, Any]) -> str:
    """Return the axis values of a variant as text: ``skew 30 deg, gap 51 mm, friction 0.5``."""
    return ", ".join(
        f"{axis.label.lower()} {row[axis.name]:g} {axis.unit}".removesuffix(" -")
        for axis in axes_of(row)
        if axis.name not in lacking_axes(str(row["abutment"])) and not isnan(row[axis.name])
    )


def printed_rows(table: pd.DataFrame) -> list[dict[str, str]]:
    """Return the rows as texts; * marks a median if the methods differ, † if it is extrapolated."""
    ratios = ratio_names(table)
    return [
        {
            "model": f"{row['bridge']} {row['abutment']}".replace("_", " "),
            "variant": "joint model" if row["row"] == JOINT else variant_in_words(row),
            "state": f"{row['component']}, {row['limit_state']}".replace("_", " "),
            "theta": _interval(row, "theta") + _marks(row),
            "total": _interval(row, "beta_total"),
            "beta": _number(row["beta"]),
            "exceed": f"{row['n_exceed']:.0f} of {row['n_runs']:.0f}",
            **{name: _interval(row, f"{name}_ratio") for name in ratios},
        }
        for row in records_of(table)
    ]


_LATEX_HEADS: Final = {
    "model": "Bridge",
    "variant": "Variant",
    "state": "Component, state",
    "theta": r"$\theta$ [interval]",
    "total": r"$\beta_\mathrm{total}$ [interval]",
    "beta": r"$\beta_\mathrm{records}$",
    "exceed": "exceed",
}


def latex_table(table: pd.DataFrame) -> str:
    """Return the table for LaTeX (packages booktabs and longtable)."""
    rows = printed_rows(table)
    names = list(rows[0]) if rows else list(_LATEX_HEADS)
    head = " & ".join(_LATEX_HEADS.get(name, f"{name.replace('_', ' ')} ratio") for name in names)
    units = ", ".join(sorted(set(table["im"].astype(str))))
    cells = ([re.sub("[_%&]", r"\\\g<0>", text) for text in row.values()] for row in rows)
    return "\n".join(
        [
            r"% needs \usepackage{booktabs,longtable}",
            f"% medians in {units}; ratios to the median at the smallest value of each axis",
            "% beta_total: dispersion of the curve, including capacity dispersion;",
            "% beta_records: record-to-record dispersion",
            "% *: cloud and exceedance medians differ by more than 2 standard errors",
            f"% {DAGGER}: extrapolated, fewer than three motions are as strong or as weak",
            "% failure in any mode: median and half of the ln range from 16 to 84 % of a union",
            rf"\begin{{longtable}}{{lll{'r' * (len(names) - 3)}}}",
            *(r"\toprule", head + r" \\", r"\midrule", r"\endhead"),
            *(" & ".join(texts) + r" \\" for texts in cells),
            *(r"\bottomrule", r"\end{longtable}", ""),
        ]
    )


def with_interval(values: Sequence[float]) -> str:
    """Return text with an estimate and its interval, from (value, lower end, upper end)."""
    middle, low, high = map(_number, values)
    return middle if _NONE in (middle, low) else f"{middle} [{low}, {high}]"


def _interval(row: Mapping[str, Any], name: str) -> str:
    return with_interval([row[f"{name}{end}"] for end in _ENDS])


def _marks(row: Mapping[str, Any]) -> str:
    names = {"methods_differ": " *", EXTRAPOLATED: f" {DAGGER}"}
    return "".join(mark for name, mark in names.items() if row.get(name) is True)


def _number(value: float) -> str:
    return _NONE if pd.isna(value) else f"{value:.3g}"
