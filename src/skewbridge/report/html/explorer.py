"""Data of the explorer of the page: runs, fits and effects of a study as plain numbers.

The vendored library is the basic bundle of plotly.js 4.1.1 (MIT, `vendor/LICENSE`), as published in
the npm package plotly.js-basic-dist-min.
"""

import base64
import gzip
import json
from collections.abc import Sequence
from importlib.resources import files
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import KEY, column_of, demands_for
from skewbridge.demands.validity import is_complete, with_derived_columns
from skewbridge.files.tables import records_of
from skewbridge.fragility.demand_table import BRIDGE_COLUMNS
from skewbridge.fragility.fits import FITTED
from skewbridge.fragility.limit_states import HEADLINE_STATES
from skewbridge.fragility.verdicts import DIFFERENCE, DIFFERENCES, RATIOS, may_be_negligible
from skewbridge.report.answer import model_name
from skewbridge.report.axis_layout import (
    US_UNITS,
    VARIANT_COLOURS,
    named_value,
    plain_label,
    shown_axes,
    value_text,
    variant_text,
)
from skewbridge.report.verdict_style import DEPTHS, STYLES, demand_name
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import Axis, axes_of

_LIBRARY: Final = "plotly-basic.min.js"
_FIT_COLUMNS: Final = (
    *("variant", "component", "limit_state", "method", "demand", "preferred", "methods_differ"),
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
    """Return a study as packed JSON: tables as columns with rows, runs as lists by column.

    ``effects`` are those on demands, ``medians`` those on median capacities; ``units`` (si or us)
    are shown first.
    """
    demands = with_derived_columns(demands)
    im = str(curves["im"].iloc[0])
    shown = dict.fromkeys([*curves["demand"], *effects["demand"]])
    columns = [str(name) for name in shown if name in demands]
    motions = list(dict.fromkeys(demands["motion_id"]))
    models = demands[list(BRIDGE_COLUMNS)].drop_duplicates().itertuples(index=False, name=None)
    places = {model: place for place, model in enumerate(models)}
    variants = demands.drop_duplicates("variant")
    variant_places = {name: place for place, name in enumerate(variants["variant"])}
    axes = axes_of(demands.columns)
    fits = curves[curves["status"] == FITTED]
    fits = fits.assign(variant=fits["variant"].map(variant_places))[list(_FIT_COLUMNS)]
    names = [axis.name for axis in axes]
    rows = [row for table in (effects, medians) for row in _effect_rows(table, places, names)]
    payload: dict[str, Any] = {
        "im": plain_label(im),
        "im_name": im,
        "im_range": [float(demands[im].min()), float(demands[im].max())],
        "units": units,
        "us": {name: {"unit": us, "factor": factor} for name, (us, factor) in US_UNITS.items()},
        "colours": VARIANT_COLOURS,
        "models": [model_name(*model) for model in places],
        "axes": [_axis(axis, sorted(demands[axis.name].unique())) for axis in axes],
        "variants": [
            {
                "name": row["variant"],
                "model": places[row["bridge"], row["abutment"]],
                "text": variant_text(shown_axes(variants), row),
                "values": [row[axis.name] for axis in axes],
            }
            for row in records_of(variants)
        ],
        "demands": {name: _demand(name) for name in columns},
        "states": {str(name): demand_name(str(name)) for name in medians["demand"].unique()},
        "fits": {"columns": _FIT_COLUMNS, "rows": _finite(fits).to_numpy().tolist()},
        "effects": {"columns": _EFFECT_COLUMNS, "rows": rows},
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
        "motions": motions,
        "statuses": STATUSES,
        "runs": {
            "variant": demands["variant"].map(variant_places).tolist(),
            "motion": pd.Categorical(demands["motion_id"], motions).codes.tolist(),
            # runs under the same loading have the same number
            "loading": demands.groupby(list(KEY[1:]), sort=False).ngroup().tolist(),
            "scale": demands["scale"].tolist(),
            "status": pd.Categorical(demands["status"], STATUSES).codes.tolist(),
            "complete": is_complete(demands).astype(int).tolist(),
            "key": demands["run_key"].tolist(),
            "im": _finite(demands[[im]])[im].tolist(),
            "demands": _finite(demands[columns]).to_dict("list"),
        },
    }
    text = json.dumps(payload, separators=(",", ":"), default=_plain, ensure_ascii=False)
    return _packed(text.encode("utf-8"))


def _packed(content: bytes) -> str:
    """Return content as gzip in base64, a third of the size of the text."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


def _axis(axis: Axis, values: list[float]) -> dict[str, Any]:
    texts = {"texts": value_text, "named": named_value}
    shown = {name: [text(axis, value) for value in values] for name, text in texts.items()}
    return {"name": axis.name, "label": axis.label, "values": values, **shown}


def _demand(name: str) -> dict[str, Any]:
    column = column_of(name)
    difference = None if column is None else column.difference
    return {
        "label": (column and column.label) or name.replace("_", " "),
        "unit": "-" if column is None else column.unit,
        "per_unit": 1.0 if difference is None else difference.per_unit,
    }


def _effect_rows(
    effects: pd.DataFrame, places: dict[Any, int], axes: Sequence[str]
) -> list[list[Any]]:
    """Return rows of `_EFFECT_COLUMNS` on the scale of their verdict; pooled rows have no values.

    The page derives the family-wise verdicts, which depend on the margin that is set there.
    """
    apart = effects["judged_by"] == DIFFERENCE
    scaled = {
        to: effects[ratio].where(~apart, effects[difference])
        for to, ratio, difference in zip(
            ("value", "low", "high", "margin"),
            (*RATIOS, "margin"),
            (*DIFFERENCES, "difference_margin"),
            strict=True,
        )
    }
    pooled = effects["scope"] == "pooled"
    others = pd.Series(_finite(effects[list(axes)]).to_numpy().tolist(), index=effects.index)
    models = zip(effects["bridge"], effects["abutment"], strict=True)
    table = effects.assign(
        **scaled,
        model=[places[model] for model in models],
        values=others.where(~pooled, None),
        possible=may_be_negligible(effects),
        headline=effects["demand"].isin({*demands_for("headline"), *HEADLINE_STATES}),
    ).rename(columns={"from_value": "from", "to_value": "to"})
    return _finite(table[list(_EFFECT_COLUMNS)]).to_numpy().tolist()


def _finite(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of objects, with None for NaN and infinities."""
    numbers = table.replace([np.inf, -np.inf], np.nan)
    return numbers.astype(object).where(numbers.notna(), None)


def _plain(value: Any) -> Any:
    return value.item()
