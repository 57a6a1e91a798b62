"""The table that a paper prints: medians, dispersions and what the axes do to the medians."""

from collections.abc import Iterator, Mapping, Sequence
from math import nan
from typing import Any, Final

import pandas as pd

from skewbridge.fragility.old_joint.model import JointModel
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.key_columns import BRIDGE_COLUMNS, axis_names
from skewbridge.reading.tables import records_of
from skewbridge.variant.axes import AXES

JOINT: Final = "joint"
#: Methods of a variant's curve, the first with an estimate counts.
METHODS: Final = ("cloud", "exceedance", "ida_interval")
#: Axes whose ratios of medians are printed, with their names in the columns.
RATIOS: Final = {axis.name: axis.name.split("_")[0] for axis in reversed(AXES)}
_ENDS: Final = ("", "_low", "_high")
_NONE: Final = "--"
PAPER_COLUMNS: Final[dict[str, str]] = {
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    "row": "name of the variant, or joint (the joint model in the middle of the box)",
    **{axis.name: f"{axis.label.lower()} of the variant; none of a joint model" for axis in AXES},
    "component": "component of the limit state",
    "limit_state": "degree of damage",
    "im": "intensity measure",
    "method": "fit behind the row",
    "theta": "median",
    "theta_low": "lower end of its interval",
    "theta_high": "upper end",
    "beta": "record-to-record dispersion",
    "beta_total": "dispersion with that of the capacity",
    "n_exceed": "runs known to exceed",
    "n_runs": "runs",
    **{
        f"{name}_ratio{end}": f"{meaning} of the ratio of medians, this {name} over the smallest "
        "(joint: largest over smallest)"
        for name in RATIOS.values()
        for end, meaning in zip(_ENDS, ("estimate", "lower end", "upper end"), strict=True)
    },
}


def paper_table(
    curves: pd.DataFrame,
    medians: pd.DataFrame,
    joint: pd.DataFrame,
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Return one row per variant and limit state, and one per joint model.

    Limit states without an estimate anywhere are left out; ratios have the confidence level of
    effects, medians that of fits.

    Args:
        curves: Fits of the single variants.
        medians: Paired ratios of their medians.
        joint: Joint models.
        settings: Confidence levels.
    """
    found = [*_variant_rows(curves, medians), *_joint_rows(joint, settings.effect_confidence)]
    table = pd.DataFrame(found, columns=list(PAPER_COLUMNS))
    state = ["bridge", "abutment", "component", "limit_state"]
    some = table.groupby(state)["theta"].transform("count") > 0
    order = {key: place for place, key in enumerate(map(tuple, curves[state].to_numpy()))}
    table = table[some].reset_index(drop=True)
    place = [order.get(key, len(order)) for key in map(tuple, table[state].to_numpy())]
    return table.iloc[sorted(range(len(table)), key=lambda row: (place[row], row))]


def _variant_rows(curves: pd.DataFrame, medians: pd.DataFrame) -> Iterator[dict[str, Any]]:
    axes = axis_names(curves)
    ratios = {
        (row["bridge"], row["abutment"], row["demand"], row["axis"], *_others(row, axes)): row
        for row in records_of(medians)
    }
    rank = {method: number for number, method in enumerate(METHODS)}
    best = curves.assign(
        _lacks=curves["status"] != FITTED, _rank=curves["method"].map(rank).fillna(len(rank))
    ).sort_values(["_lacks", "_rank"], kind="stable")
    keys = ["variant", "component", "limit_state"]
    best = best.drop_duplicates(keys).sort_index()
    for row in records_of(best):
        out = {name: row[name] for name in PAPER_COLUMNS if name in row}
        out["row"] = row["variant"]
        for axis, name in RATIOS.items():
            if axis not in axes:
                continue
            place = {**row, "axis": axis, "to_value": row[axis]}
            state = f"{row['component']}/{row['limit_state']}"
            key = (row["bridge"], row["abutment"], state, axis, *_others(place, axes))
            pair = ratios.get(key)
            values = (
                (nan,) * 3 if pair is None else [pair[c] for c in ("ratio", "ci_low", "ci_high")]
            )
            out |= {f"{name}_ratio{end}": v for end, v in zip(_ENDS, values, strict=True)}
        yield out


def _others(row: Mapping[str, Any], axes: list[str]) -> tuple[float, ...]:
    """Return the upper value of the axis that a pair differs in, and the other axes."""
    others = [float(row[name]) for name in axes if name != row["axis"]]
    return (float(row["to_value"]), *others)


def _joint_rows(joint: pd.DataFrame, level: float) -> Iterator[dict[str, Any]]:
    usable = joint[joint["preferred"].to_numpy(dtype=bool) & (joint["status"] == FITTED)]
    for row in records_of(usable):
        model = JointModel.of_row(row)
        middle = {name: 0.5 * (low + high) for name, (low, high) in model.box.limits.items()}
        out = {name: row[name] for name in PAPER_COLUMNS if name in row}
        out |= {"row": JOINT, "method": row["source"]}
        for axis, name in RATIOS.items():
            if axis in model.box.limits:
                low, high = model.box.limits[axis]
                values = model.ratio(middle | {axis: low}, middle | {axis: high}, level)
                out |= {f"{name}_ratio{end}": v for end, v in zip(_ENDS, values, strict=True)}
        yield out


def printed_rows(table: pd.DataFrame) -> list[dict[str, str]]:
    """Return the rows as texts by the heads of the columns, without ratios that no row has."""
    names = [name for name in RATIOS.values() if table[f"{name}_ratio"].notna().any()]
    return [
        {
            "variant": " ".join(str(row[name]) for name in (*BRIDGE_COLUMNS, "row"))
            if row["row"] == JOINT
            else str(row["row"]),
            "state": f"{row['component']}, {row['limit_state']}".replace("_", " "),
            "theta": with_interval([row[f"theta{end}"] for end in _ENDS]),
            "total": _number(row["beta_total"]),
            "beta": _number(row["beta"]),
            "exceed": f"{row['n_exceed']:.0f} of {row['n_runs']:.0f}",
            **{name: with_interval([row[f"{name}_ratio{end}"] for end in _ENDS]) for name in names},
        }
        for row in records_of(table)
    ]


_LATEX_HEADS: Final = {
    "variant": "Variant",
    "state": "Component, state",
    "theta": r"$\theta$ [interval]",
    "total": r"$\beta_\mathrm{total}$",
    "beta": r"$\beta_\mathrm{records}$",
    "exceed": "exceed",
}


def latex_table(table: pd.DataFrame) -> str:
    """Return the table for LaTeX (packages booktabs and longtable)."""
    rows = printed_rows(table)
    names = list(rows[0]) if rows else list(_LATEX_HEADS)
    head = " & ".join(_LATEX_HEADS.get(name, f"{name} ratio") for name in names)
    units = ", ".join(sorted(set(table["im"].astype(str))))
    return "\n".join(
        [
            r"% needs \usepackage{booktabs,longtable}",
            f"% medians in {units}; ratios of medians to the smallest value of each axis",
            "% beta_total: dispersion of the curve, with that of the capacity;",
            "% beta_records: record-to-record",
            rf"\begin{{longtable}}{{ll{'r' * (len(names) - 2)}}}",
            r"\toprule",
            head + r" \\",
            r"\midrule",
            r"\endhead",
            *(" & ".join(map(_escaped, row.values())) + r" \\" for row in rows),
            r"\bottomrule",
            r"\end{longtable}",
            "",
        ]
    )


def _number(value: float) -> str:
    return _NONE if pd.isna(value) else f"{value:.3g}"


def with_interval(values: Sequence[float]) -> str:
    """Return an estimate with its interval as a table prints it, from value, low and high end."""
    middle, low, high = map(_number, values)
    return middle if _NONE in (middle, low) else f"{middle} [{low}, {high}]"


def _escaped(text: str) -> str:
    return text.replace("_", r"\_").replace("%", r"\%").replace("&", r"\&")
