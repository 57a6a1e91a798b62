"""Data of the explorer of the page: runs, fits and effects of a study as plain numbers.

The vendored library is the basic bundle of plotly.js 4.1.1 (MIT, `vendor/LICENSE`), as published in
the npm package plotly.js-basic-dist-min.
"""

import base64
import gzip
import json
from importlib.resources import files
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import KEY, column_of, demands_for
from skewbridge.demands.completeness import is_complete, with_derived_columns
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.fragility.verdicts import DIFFERENCE, may_be_negligible
from skewbridge.report.answer import model_name
from skewbridge.report.axis_layout import (
    US_UNITS,
    VARIANT_COLOURS,
    named_value,
    plain_label,
    shown_axes,
    value_text,
)
from skewbridge.report.verdict_style import DEPTHS, STYLES, demand_name
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import axes_of

_LIBRARY: Final = "plotly-basic.min.js"
_FIT_VALUES: Final = ("component", "limit_state", "method", "demand", "preferred", "methods_differ")
_FIT_NUMBERS: Final = (
    *("theta", "theta_low", "theta_high", "beta", "beta_total", "threshold"),
    *("capacity_dispersion", "ln_a", "b", "sigma", "var_ln_theta", "cov_ln_theta_beta", "var_beta"),
    *("level", "methods_ratio", "n_exceed", "n_runs"),
)
_EFFECT_COLUMNS: Final = (
    *("model", "quantity", "demand", "axis", "from", "to", "values", "judged_by", "unit", "status"),
    *("value", "low", "high", "margin", "level", "dof", "possible", "headline", "n_motions"),
)


def library() -> str:
    """Return the source of the plotting library, packed."""
    return _packed((files("skewbridge.report.html") / "vendor" / _LIBRARY).read_bytes())


def explorer_data(
    demands: pd.DataFrame,
    curves: pd.DataFrame,
    effects: pd.DataFrame,
    medians: pd.DataFrame,
    units: str = "si",
) -> str:
    """Return a study as packed JSON.

    Args:
        demands: Demands table.
        curves: Fits of the single variants.
        effects: Paired effects on demands.
        medians: Effects on median capacities.
        units: Units that are shown first, ``si`` or ``us``.
    """
    demands = with_derived_columns(demands)
    im = str(curves["im"].iloc[0])
    fits = curves[curves["status"] == FITTED]
    names = dict.fromkeys([*curves["demand"], *effects["demand"]])
    columns = [str(name) for name in names if name in demands]
    models = demands[list(BRIDGE_COLUMNS)].drop_duplicates().itertuples(index=False, name=None)
    places = {model: place for place, model in enumerate(models)}
    variants = demands.drop_duplicates("variant")
    variant_places = {name: place for place, name in enumerate(variants["variant"])}
    payload: dict[str, Any] = {
        "im": plain_label(im),
        "im_name": im,
        "im_range": [float(demands[im].min()), float(demands[im].max())],
        "units": units,
        "us": {name: {"unit": us, "factor": factor} for name, (us, factor) in US_UNITS.items()},
        "colours": VARIANT_COLOURS,
        "models": [model_name(*model) for model in places],
        "axes": _axes(demands),
        "variants": _variants(variants, places),
        "demands": {name: _demand(name) for name in columns},
        "states": {str(name): demand_name(str(name)) for name in medians["demand"].unique()},
        "fits": _fits(fits, variant_places),
        "effects": {
            "columns": _EFFECT_COLUMNS,
            "rows": [*_effects(effects, places, demands), *_effects(medians, places, demands)],
        },
        "styles": {
            name: {
                "sign": style.sign,
                "fill": style.fill,
                "text": style.words(),
                "verdict": style.verdict,
            }
            for name, style in STYLES.items()
        },
        "depths": DEPTHS,
        **_runs(demands, variant_places, im, columns),
    }
    text = json.dumps(payload, separators=(",", ":"), default=_plain, ensure_ascii=False)
    return _packed(text.encode("utf-8"))


def _packed(content: bytes) -> str:
    """Return content as gzip in base64, a third of the size of the text."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


def _axes(demands: pd.DataFrame) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for axis in axes_of(demands.columns):
        values = sorted(demands[axis.name].unique())
        out.append(
            {
                "name": axis.name,
                "label": axis.label,
                "values": values,
                "texts": [value_text(axis, value) for value in values],
                "named": [named_value(axis, value) for value in values],
            }
        )
    return out


def _variants(variants: pd.DataFrame, places: dict[Any, int]) -> list[dict[str, Any]]:
    axes, shown = axes_of(variants.columns), shown_axes(variants)
    return [
        {
            "name": row["variant"],
            "model": places[row["bridge"], row["abutment"]],
            "text": ", ".join(named_value(axis, row[axis.name]) for axis in shown),
            "values": [row[axis.name] for axis in axes],
        }
        for row in variants.to_dict("records")
    ]


def _demand(name: str) -> dict[str, Any]:
    column = column_of(name)
    difference = None if column is None else column.difference
    return {
        "label": (column and column.label) or name.replace("_", " "),
        "unit": "-" if column is None else column.unit,
        "per_unit": 1.0 if difference is None else difference.per_unit,
    }


def _runs(
    demands: pd.DataFrame, places: dict[str, int], im: str, columns: list[str]
) -> dict[str, Any]:
    """Return the runs column by column; those under the same loading have the same number."""
    motions = list(dict.fromkeys(demands["motion_id"]))
    loading = demands.groupby(list(KEY[1:]), sort=False).ngroup()
    return {
        "motions": motions,
        "statuses": STATUSES,
        "runs": {
            "variant": demands["variant"].map(places).tolist(),
            "motion": pd.Categorical(demands["motion_id"], motions).codes.tolist(),
            "loading": loading.tolist(),
            "scale": demands["scale"].tolist(),
            "status": pd.Categorical(demands["status"], STATUSES).codes.tolist(),
            "complete": is_complete(demands).astype(int).tolist(),
            "key": demands["run_key"].tolist(),
            "im": _numbers(demands[im]),
            "demands": {name: _numbers(demands[name]) for name in columns},
        },
    }


def _fits(fits: pd.DataFrame, places: dict[str, int]) -> dict[str, Any]:
    rows = [
        [
            places[row["variant"]],
            *(row[name] for name in _FIT_VALUES),
            *(_number(row[name]) for name in _FIT_NUMBERS),
        ]
        for row in fits.to_dict("records")
    ]
    return {"columns": ["variant", *_FIT_VALUES, *_FIT_NUMBERS], "rows": rows}


def _effects(
    effects: pd.DataFrame, places: dict[Any, int], demands: pd.DataFrame
) -> list[list[Any]]:
    """Return rows of `_EFFECT_COLUMNS` on the scale of their verdict; pooled rows have no values.

    The page derives the family-wise verdicts, which depend on the margin that is set there.
    """
    axes = axes_of(demands.columns)
    headline = {*demands_for("headline"), *HEADLINE_STATES}
    rows: list[list[Any]] = []
    possible = may_be_negligible(effects)
    for row, may_be in zip(effects.to_dict("records"), possible, strict=True):
        apart = row["judged_by"] == DIFFERENCE
        ends = ("difference", "difference_low", "difference_high")
        names = ends if apart else ("ratio", "ci_low", "ci_high")
        values = None
        if row["scope"] != "pooled":
            values = [None if axis.name == row["axis"] else row[axis.name] for axis in axes]
        rows.append(
            [
                places[row["bridge"], row["abutment"]],
                *(row[name] for name in ("quantity", "demand", "axis", "from_value", "to_value")),
                values,
                *(row[name] for name in ("judged_by", "unit", "status")),
                *(_number(row[name]) for name in names),
                row["difference_margin" if apart else "margin"],
                *(row[name] for name in ("level", "dof")),
                bool(may_be),
                row["demand"] in headline,
                row["n_motions"],
            ]
        )
    return rows


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _numbers(values: pd.Series) -> list[float | None]:
    return [_number(value) for value in values]


def _plain(value: Any) -> Any:
    return value.item()
