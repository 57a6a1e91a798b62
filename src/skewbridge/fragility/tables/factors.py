"""What each axis of a study does, in one table: variance explained, Sobol indices, prediction."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import combinations
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.likelihood.links import FloatArray
from skewbridge.fragility.methods.axis_probit import (
    AxisProbitFit,
    fit_axis_probit,
    likelihood_ratio,
    scaled_axes,
)
from skewbridge.fragility.methods.motion_means import MotionMeans
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_beyond_model, is_complete
from skewbridge.fragility.tables.key_columns import (
    axis_names,
    models_of,
    motion_codes,
    varying_axes,
)
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import check_demands, outcomes_of
from skewbridge.fragility.tables.surrogate import (
    fit_surrogate,
    leave_one_variant_out,
    surrogate_sobol,
)
from skewbridge.variant.axes import AXES

INTERACTION_LEVEL: Final = 0.05
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
    "first_order": "Sobol index of the surrogate over the box of the study",
    "total_order": "total Sobol index",
    "scatter": "scatter of ln demand about the surrogate, within motions",
    "worst_prediction": "largest error of the surrogate for a variant it has not seen",
}


def factor_summary(
    demands: pd.DataFrame, columns: Sequence[str], settings: FitSettings = DEFAULTS
) -> pd.DataFrame:
    """Return variance explained, Sobol indices and prediction error per demand and factor.

    Each bridge with each abutment model stands by itself; axes in which its variants do not
    differ are no factors. Demands that are zero in some completed run are left out: they have no
    logarithm. ``settings`` seeds the Sobol sequence.
    """
    rows = [
        model | {"demand": column} | row
        for model, own in models_of(demands)
        for column in columns
        for row in _factors_of(own, column, settings)
    ]
    return pd.DataFrame(rows, columns=list(SUMMARY_COLUMNS))


def _factors_of(
    demands: pd.DataFrame, column: str, settings: FitSettings
) -> Iterator[dict[str, Any]]:
    """Yield a row per factor of one demand of one bridge and abutment model."""
    factors = varying_axes(demands)
    done = demands.loc[is_complete(demands), column]
    if not factors or done.empty or not bool((done > 0.0).all()):
        return
    table = demands.drop(columns=[name for name in axis_names(demands) if name not in factors])
    surrogate = fit_surrogate(table, column)
    indices = surrogate_sobol(surrogate, table, settings.seed).set_index("factor")
    worst = float(leave_one_variant_out(table, column)["error"].abs().max())
    for name in factors:
        levels = level_means(table, column, name)
        test = MotionMeans.of(levels).difference()
        yield {
            "factor": name,
            "n_motions": len(levels),
            "partial_eta2": test.f / (test.f + len(levels) - 1.0),
            **asdict(test),
            "first_order": indices.loc[name, "first_order"],
            "total_order": indices.loc[name, "total_order"],
            "scatter": surrogate.scatter,
            "worst_prediction": worst,
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


def parameterised_curve(
    demands: pd.DataFrame, state: LimitState, im_column: str, *, link: str = "probit"
) -> AxisProbitFit:
    """Fit one exceedance curve over the variants of a study, with the interactions it needs.

    Main effects first; an interaction (with another axis or with ln x) is added if its
    likelihood ratio has p < 5 % and its coefficient exceeds 1.96 cluster-robust errors: with
    motions that repeat over the variants the ratio alone finds too many.

    Raises:
        InputError: A column is missing, a value unusable, or no axis varies.
    """
    check_demands(demands, im_column, [state.demand])
    judged = outcomes_of(
        demands[state.demand].to_numpy(dtype=np.float64),
        demands["status"].to_numpy(dtype=str),
        is_beyond_model(demands),
        state,
    )
    known = ~judged.unknown
    table = demands[known]
    values = {name: table[name].to_numpy(dtype=np.float64) for name in axis_names(table)}
    varying = {name: value for name, value in scaled_axes(values).items() if np.ptp(value) > 0.0}
    if not varying:
        raise InputError("a parameterised curve needs variants that differ in an axis")
    ln_im = np.log(table[im_column].to_numpy(dtype=np.float64))
    exceed = judged.exceed[known].astype(np.float64)
    motions = motion_codes(table)

    def fit(interactions: Sequence[str]) -> AxisProbitFit:
        return fit_axis_probit(
            ln_im, varying, exceed, interactions=interactions, link=link, clusters=motions
        )

    chosen: list[str] = []
    best = fit(chosen)
    if best.status != FITTED:
        return best
    pairs = [f"{a}:{b}" for a, b in combinations(varying, 2)]
    for term in [*pairs, *(f"{name}:ln_im" for name in varying)]:
        trial = fit([*chosen, term])
        if trial.status != FITTED:
            continue
        _, _, p_value = likelihood_ratio(trial, best)
        size = abs(float(trial.coefficients[-1])) / float(trial.se_cluster[-1])
        if p_value < INTERACTION_LEVEL and size > 1.96:
            chosen, best = [*chosen, term], trial
    return best
