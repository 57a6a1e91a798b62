"""Data of the explorer of the page: runs, fits and effects of a study as plain numbers.

The vendored library is the basic bundle of plotly.js 4.1.1 (MIT, `vendor/LICENSE`), as published in
the npm package plotly.js-basic-dist-min.
"""

import base64
import gzip
import json
from collections.abc import Iterable, Mapping, Sequence
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
from skewbridge.report.answer import effect_name, model_name
from skewbridge.report.appearance import (
    STYLES,
    US_UNITS,
    VARIANT_COLOURS,
    named_value,
    plain_label,
    shown_axes,
    value_text,
    variant_text,
)
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import axes_of

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


def explorer_of(frames: Mapping[str, pd.DataFrame], units: str) -> dict[str, str]:
    """Return data and plotting library of the explorer, packed; empty without a curve.

    ``frames`` are demands, curves, effects and medians by name.
    """
    if not (frames["curves"]["status"] == FITTED).any():
        return {}
    library = files("skewbridge.report") / "vendor" / "plotly-basic.min.js"
    demands, curves, effects, medians = (
        frames[name] for name in ("demands", "curves", "effects", "medians")
    )
    data = explorer_data(demands, curves, effects, medians, units)
    return {"data": data, "library": _packed(library.read_bytes())}


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
    columns = [name for name in _unique([*curves["demand"], *effects["demand"]]) if name in demands]
    motions, variants = _unique(demands["motion_id"]), demands.drop_duplicates("variant")
    models = {model: place for place, model in enumerate(_unique(_models_of(demands)))}
    places = {name: place for place, name in enumerate(variants["variant"])}
    axes = axes_of(demands.columns)
    names = [axis.name for axis in axes]
    values = {axis: sorted(demands[axis.name].unique()) for axis in axes}
    fits = curves[curves["status"] == FITTED]
    fits = fits.assign(variant=fits["variant"].map(places))
    rows = [row for table in (effects, medians) for row in _effect_rows(table, models, names)]
    payload: dict[str, Any] = {
        "im": plain_label(im),
        "im_name": im,
        "im_range": [demands[im].min(), demands[im].max()],
        "units": units,
        "us": {name: {"unit": us, "factor": factor} for name, (us, factor) in US_UNITS.items()},
        "colours": VARIANT_COLOURS,
        "models": [model_name(*model) for model in models],
        "axes": [
            {
                "name": axis.name,
                "label": axis.label,
                "values": own,
                "texts": [value_text(axis, value) for value in own],
                "named": [named_value(axis, value) for value in own],
            }
            for axis, own in values.items()
        ],
        "variants": [
            {
                "name": row["variant"],
                "model": models[row["bridge"], row["abutment"]],
                "text": variant_text(shown_axes(variants), row),
                "values": [row[name] for name in names],
            }
            for row in records_of(variants)
        ],
        "demands": {name: _demand(name) for name in columns},
        "states": {str(name): effect_name(name) for name in medians["demand"].unique()},
        "fits": {"columns": _FIT_COLUMNS, "rows": _rows(fits, _FIT_COLUMNS)},
        "effects": {"columns": _EFFECT_COLUMNS, "rows": rows},
        "styles": {name: style._asdict() for name, style in STYLES.items()},
        "motions": motions,
        "statuses": STATUSES,
        "runs": {
            "variant": demands["variant"].map(places).tolist(),
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
    text = json.dumps(
        payload, separators=(",", ":"), default=lambda value: value.item(), ensure_ascii=False
    )
    return _packed(text.encode("utf-8"))


def _unique(values: Iterable[Any]) -> list[Any]:
    return list(dict.fromkeys(values))


def _models_of(table: pd.DataFrame) -> list[tuple[str, str]]:
    return list(table[list(BRIDGE_COLUMNS)].itertuples(index=False, name=None))


def _packed(content: bytes) -> str:
    """Return content as gzip in base64, a third of the size of the text."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


def _demand(name: str) -> dict[str, Any]:
    column = column_of(name)
    difference = None if column is None else column.difference
    return {
        "label": (column and column.label) or name.replace("_", " "),
        "unit": "-" if column is None else column.unit,
        "per_unit": 1.0 if difference is None else difference.per_unit,
    }


def _effect_rows(
    effects: pd.DataFrame, models: Mapping[Any, int], axes: Sequence[str]
) -> list[list[Any]]:
    """Return rows of `_EFFECT_COLUMNS` on the scale of their verdict; pooled rows have no values.

    The page derives the family-wise verdicts, which depend on the margin that is set there.
    """
    names = zip((*RATIOS, "margin"), (*DIFFERENCES, "difference_margin"), strict=True)
    scaled = [
        effects[ratio].where(effects["judged_by"] != DIFFERENCE, effects[difference])
        for ratio, difference in names
    ]
    others = pd.Series(_rows(effects, axes), index=effects.index, dtype=object)
    table = effects.assign(
        **dict(zip(("value", "low", "high", "margin"), scaled, strict=True)),
        model=[models[model] for model in _models_of(effects)],
        values=others.where(effects["scope"] != "pooled", None),
        possible=may_be_negligible(effects),
        headline=effects["demand"].isin({*demands_for("headline"), *HEADLINE_STATES}),
    )
    return _rows(table.rename(columns={"from_value": "from", "to_value": "to"}), _EFFECT_COLUMNS)


def _rows(table: pd.DataFrame, columns: Sequence[str]) -> list[list[Any]]:
    return _finite(table[list(columns)]).to_numpy().tolist()


def _finite(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of objects, with None for NaN and infinities."""
    numbers = table.replace([np.inf, -np.inf], np.nan)
    return numbers.astype(object).where(numbers.notna(), None)
