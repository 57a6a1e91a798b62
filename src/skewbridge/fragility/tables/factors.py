"""What each axis of a study does, in one table: variance explained, Sobol indices, prediction."""

from collections.abc import Sequence
from typing import Any, Final

import pandas as pd

from skewbridge.fragility.joint.shares import axis_shares
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.key_columns import varying_axes
from skewbridge.fragility.tables.surrogate import anova
from skewbridge.variant.axes import AXES

SUMMARY_COLUMNS: Final[dict[str, str]] = {
    "demand": "demand column",
    "factor": " | ".join(axis.name for axis in AXES),
    "partial_eta2": "share of ln demand within motions that the factor explains, type II",
    "p_value": "F test of the factor with the motion as block",
    "first_order": "Sobol index of the joint model of ln demand over the box of the study",
    "total_order": "total Sobol index",
    "scatter": "scatter of ln demand about that model, within motions",
    "worst_prediction": "its largest error for a variant that was left out",
}


def factor_summary(
    demands: pd.DataFrame, columns: Sequence[str], settings: FitSettings = DEFAULTS
) -> pd.DataFrame:
    """Return variance explained, Sobol indices and prediction error per demand and factor.

    Demands that are zero in some completed run are left out: they have no logarithm.

    The table holds two variants or more; ``settings`` seeds the Sobol sequence.
    """
    rows: list[dict[str, Any]] = []
    factors = varying_axes(demands)
    for column in columns:
        done = demands.loc[is_complete(demands), column]
        if not factors or done.empty or not bool((done > 0.0).all()):
            continue
        shares = axis_shares(demands, column, settings.im, settings.seed)
        if shares is None:
            continue
        explained = anova(demands, column).set_index("term")
        rows += [
            {
                "demand": column,
                "factor": name,
                "partial_eta2": explained.loc[name, "partial_eta2"],
                "p_value": explained.loc[name, "p_value"],
                "first_order": shares.first_order[number],
                "total_order": shares.total_order[number],
                "scatter": shares.scatter,
                "worst_prediction": shares.worst_prediction,
            }
            for number, name in enumerate(shares.axes)
        ]
    return pd.DataFrame(rows, columns=list(SUMMARY_COLUMNS))
