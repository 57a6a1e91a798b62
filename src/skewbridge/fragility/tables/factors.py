"""What each axis of a study does, in one table: variance explained, Sobol indices, prediction."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.old_joint.shares import axis_shares
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.motion_means import MotionMeans
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_complete
from skewbridge.fragility.tables.key_columns import (
    axis_names,
    demand_columns,
    models_of,
    varying_axes,
)
from skewbridge.fragility.tables.spread import spread
from skewbridge.variant.axes import AXES

SUMMARY_COLUMNS: Final[dict[str, str]] = {
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    "demand": "demand column",
    "factor": " | ".join(axis.name for axis in AXES),
    "n_motions": "motions with a run at every value of the factor",
    "partial_eta2": "share of ln demand that the factor explains, beside factor x motion",
    "f": "F statistic: mean square of the factor over that of factor x motion",
    "dof": "degrees of freedom of the factor, corrected for unequal scatter (Huynh-Feldt)",
    "dof_error": "of factor x motion, corrected",
    "p_value": "F test of the factor, the motion as random block",
    "first_order": "Sobol index of the joint model of ln demand over the box of the study",
    "total_order": "total Sobol index",
    "scatter": "scatter of ln demand about that model, within motions",
    "worst_prediction": "its largest error for a variant that was left out",
}


def factor_summary(
    demands: pd.DataFrame,
    columns: Sequence[str],
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return variance explained, Sobol indices and prediction error per demand and factor.

    Each bridge with each abutment model stands by itself; axes in which its variants do not
    differ are no factors. Demands that are zero in some completed run are left out: they have no
    logarithm. ``settings`` seeds the Sobol sequence; ``jobs`` is the number of processes.
    """
    items = (
        (model | {"demand": column}, demand_columns(own, [column, settings.im]))
        for model, own in models_of(demands)
        for column in columns
    )
    found = spread(partial(_rows, settings=settings), items, jobs)
    return pd.DataFrame([row for rows in found for row in rows], columns=list(SUMMARY_COLUMNS))


def _rows(item: tuple[dict[str, Any], pd.DataFrame], settings: FitSettings) -> list[dict[str, Any]]:
    """Return the rows of one demand of one bridge and abutment model."""
    told, own = item
    return [told | row for row in _factors_of(own, told["demand"], settings)]


def _factors_of(
    demands: pd.DataFrame, column: str, settings: FitSettings
) -> Iterator[dict[str, Any]]:
    """Yield a row per factor of one demand of one bridge and abutment model."""
    factors = varying_axes(demands)
    done = demands.loc[is_complete(demands), column]
    if not factors or done.empty or not bool((done > 0.0).all()):
        return
    table = demands.drop(columns=[name for name in axis_names(demands) if name not in factors])
    shares = axis_shares(table, column, settings.im, settings.seed)
    if shares is None:
        return
    for number, name in enumerate(shares.axes):
        levels = level_means(table, column, name)
        test = MotionMeans.of(levels).difference()
        yield {
            "factor": name,
            "n_motions": len(levels),
            "partial_eta2": test.f / (test.f + len(levels) - 1.0),
            **asdict(test),
            "first_order": shares.first_order[number],
            "total_order": shares.total_order[number],
            "scatter": shares.scatter,
            "worst_prediction": shares.worst_prediction,
        }


def level_means(demands: pd.DataFrame, column: str, factor: str) -> FloatArray:
    """Return mean ln demand of each motion at each value of a factor, shape (motions, values).

    The mean is over all combinations of the other axes in which the motion has a completed run
    at every value of the factor, so that nothing but the factor differs between the columns;
    a motion without such a combination is left out.
    """
    done = demands[is_complete(demands)]
    others = [name for name in axis_names(done) if name != factor]
    cell = ["motion_id", "scale", "incidence_deg", *others]
    table = done[[*cell, factor]].assign(ln_demand=np.log(done[column]))
    wide = table.pivot_table(index=cell, columns=factor, values="ln_demand").dropna()
    return wide.groupby("motion_id").mean().to_numpy(dtype=np.float64)
