"""What each axis of a study does, in one table: variance explained, Sobol indices, prediction."""

from collections.abc import Sequence
from itertools import combinations
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.methods.axis_probit import (
    AxisProbitFit,
    fit_axis_probit,
    likelihood_ratio,
    scaled_axes,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.beyond_model import is_beyond_model, is_complete
from skewbridge.fragility.tables.key_columns import axis_names, motion_codes, varying_axes
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import check_demands, outcomes_of
from skewbridge.fragility.tables.surrogate import (
    anova,
    fit_surrogate,
    leave_one_variant_out,
    surrogate_sobol,
)
from skewbridge.variant.axes import AXES

INTERACTION_LEVEL: Final = 0.05
SUMMARY_COLUMNS: Final[dict[str, str]] = {
    "demand": "demand column",
    "factor": " | ".join(axis.name for axis in AXES),
    "partial_eta2": "share of ln demand within motions that the factor explains, type II",
    "p_value": "F test of the factor with the motion as block",
    "first_order": "Sobol index of the surrogate over the box of the study",
    "total_order": "total Sobol index",
    "scatter": "scatter of ln demand about the surrogate, within motions",
    "worst_prediction": "largest error of the surrogate for a variant it has not seen",
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
        explained = anova(demands, column).set_index("term")
        surrogate = fit_surrogate(demands, column)
        indices = surrogate_sobol(surrogate, demands, settings.seed).set_index("factor")
        unseen = leave_one_variant_out(demands, column)
        worst = float(unseen["error"].abs().max())
        rows += [
            {
                "demand": column,
                "factor": name,
                "partial_eta2": explained.loc[name, "partial_eta2"],
                "p_value": explained.loc[name, "p_value"],
                "first_order": indices.loc[name, "first_order"],
                "total_order": indices.loc[name, "total_order"],
                "scatter": surrogate.scatter,
                "worst_prediction": worst,
            }
            for name in factors
        ]
    return pd.DataFrame(rows, columns=list(SUMMARY_COLUMNS))


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
