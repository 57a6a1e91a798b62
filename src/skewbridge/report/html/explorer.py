"""What the explorer of the page draws: the runs and fits of a study as plain numbers.

The vendored library is the basic bundle of plotly.js 4.1.1 (MIT, `vendor/LICENSE`), as published in
the npm package plotly.js-basic-dist-min.
"""

import json
from importlib.resources import files
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.demands.columns import label_of
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.report.axis_layout import named_value, shown_axes
from skewbridge.report.fragility_figures import total_dispersion
from skewbridge.report.html.answer import model_name
from skewbridge.report.html.statements import plain_label
from skewbridge.report.sampled_runs import sample_note, sampled_runs
from skewbridge.variant.axes import axes_of

_LIBRARY: Final = "plotly-basic.min.js"
_DIGITS: Final = 10  # of a number, so that curves agree with Python's to 1e-9


def library() -> str:
    """Return the source of the plotting library."""
    vendor = files("skewbridge.report.html") / "vendor" / _LIBRARY
    return vendor.read_text(encoding="utf-8")


def explorer_data(demands: pd.DataFrame, curves: pd.DataFrame) -> str:
    """Return runs, fits and variants as JSON that may stand in a script element.

    Of a large study the runs are a sample, of which ``sample_note`` tells.

    Args:
        demands: Demands table.
        curves: Fits of the single variants.
    """
    im = str(curves["im"].iloc[0])
    fits = curves[curves["status"] == FITTED]
    columns = [name for name in dict.fromkeys(curves["demand"]) if name in demands]
    shown = shown_axes(demands)
    axes = axes_of(demands.columns)
    variants, runs = demands.drop_duplicates("variant"), sampled_runs(demands)
    payload: dict[str, Any] = {
        "im": plain_label(im),
        "axes": [{"name": axis.name, "label": axis.label_with_unit} for axis in axes],
        "variants": {
            row["variant"]: {
                "model": model_name(row["bridge"], row["abutment"]),
                "text": ", ".join(named_value(axis, row[axis.name]) for axis in shown),
                **{axis.name: row[axis.name] for axis in axes},
            }
            for row in variants.to_dict("records")
        },
        "demands": {name: label_of(name) for name in columns},
        "fits": [_fit(row) for row in fits.to_dict("records")],
        "sample_note": sample_note(len(runs), len(demands)),
        "runs": {
            "variant": runs["variant"].tolist(),
            "motion": runs["motion_id"].tolist(),
            "status": runs["status"].tolist(),
            "key": runs["run_key"].tolist(),
            "im": _numbers(runs[im]),
            **{name: _numbers(runs[name]) for name in columns},
        },
    }
    return json.dumps(payload, separators=(",", ":"), default=_plain).replace("</", "<\\/")


def _fit(row: dict[Any, Any]) -> dict[str, Any]:
    names = ("variant", "component", "limit_state", "method", "demand")
    numbers = ("theta", "theta_low", "theta_high", "beta", "threshold", "ln_a", "b", "sigma")
    more = ("var_ln_theta", "cov_ln_theta_beta", "var_beta", "level", "n_exceed", "n_runs")
    out = {name: str(row[name]) for name in names}
    out |= {name: _number(row[name]) for name in (*numbers, *more)}
    return out | {"beta_total": _number(total_dispersion(row))}


def _number(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None


def _numbers(values: pd.Series) -> list[float | None]:
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]


def _plain(value: Any) -> Any:
    return value.item()
