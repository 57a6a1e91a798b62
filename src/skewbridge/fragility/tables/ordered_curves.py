"""Curves of the states of a component with one dispersion, which never cross, beside those apart.

They stand in the table of the curves as method ``ordered``; ``common_beta_p`` compares them with
dispersions of their own.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.intervals import normal_quantile
from skewbridge.fragility.methods.ordered import OrderedFit, fit_ordered
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.curve_rows import curve_row
from skewbridge.fragility.tables.key_columns import variant_values, variants_of
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Runs, check_demands, outcomes_of, runs_of
from skewbridge.fragility.tables.spread import spread

METHOD = "ordered"


def ordered_curves(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Fit an ordered probit to the states of every variant and component that has several.

    Runs whose worst state is unknown are left out. A state that every run passes, that none reaches
    or in which none ends has no curve of its own (``empty_state``). Intervals are Wald's, none
    where motions repeat. ``jobs`` is the number of processes.

    Returns:
        Rows of the table of curves, method ``ordered``; empty if no component has two states.

    Raises:
        InputError: A column is missing or a value unusable.
    """
    check_demands(demands, im_column, list(dict.fromkeys(s.demand for s in limit_states)))
    components: dict[str, list[LimitState]] = {}
    for state in sorted(limit_states, key=lambda item: item.threshold):
        components.setdefault(state.component, []).append(state)
    several = [states for states in components.values() if len(states) > 1]
    found = spread(
        partial(_variant_rows, several=several, im_column=im_column, settings=settings),
        variants_of(demands, [im_column, *(s.demand for states in several for s in states)]),
        jobs,
    )
    return pd.DataFrame([row for rows in found for row in rows])


def _variant_rows(
    part: pd.DataFrame,
    *,
    several: Sequence[Sequence[LimitState]],
    im_column: str,
    settings: FitSettings,
) -> list[dict[str, Any]]:
    """Return the rows of the components of one variant that have several states."""
    variant, runs = variant_values(part), runs_of(part, im_column)
    return [
        variant | row
        for states in several
        if part[states[0].demand].notna().any()
        for row in _component_rows(runs, part, states, im_column, settings)
    ]


def _component_rows(
    runs: Runs,
    part: pd.DataFrame,
    states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings,
) -> Iterator[dict[str, Any]]:
    outcomes = [
        outcomes_of(part[s.demand].to_numpy(dtype=np.float64), runs.status, runs.beyond, s)
        for s in states
    ]
    known = ~np.any([item.unknown for item in outcomes], axis=0)
    worst = np.sum([item.exceed for item in outcomes], axis=0)[known]
    ends = np.bincount(worst, minlength=len(states) + 1)
    # a state counts where runs end in it, and some below it
    fitted = [i for i in range(len(states)) if ends[i + 1] > 0 and np.sum(ends[: i + 1]) > 0]
    found: OrderedFit | None = None
    if len(fitted) > 1:
        place = np.searchsorted(np.array(fitted) + 1, worst, side="right")
        found = fit_ordered(runs.im[known], np.eye(len(fitted) + 1)[place])
    z = normal_quantile(settings.confidence)
    for i, state in enumerate(states):
        fit = FragilityFit(
            method=METHOD,
            status="empty_state" if i not in fitted else "single_state",
            n_runs=int(np.sum(known)),
            level=settings.confidence,
        )
        if found is not None and i in fitted:
            fit = replace(fit, status=found.status)
            if found.status == FITTED:
                fit = _with_state(fit, found, fitted.index(i), 0.0 if runs.repeated else z)
        facts = {
            "n_runs": int(runs.im.size),
            "n_records": int(np.max(runs.records)) + 1,
            "n_exceed": int(np.sum(outcomes[i].exceed)),
            "n_unknown": int(np.sum(outcomes[i].unknown)),
            "common_beta_p": found.common_beta_p if found is not None else np.nan,
        }
        yield curve_row(fit, state, im_column, facts)


def _with_state(fit: FragilityFit, found: OrderedFit, place: int, z: float) -> FragilityFit:
    """Return the fit with median, dispersion and Wald interval of one state; z = 0 for none."""
    theta, beta, last = float(found.theta[place]), found.beta, found.theta.size
    variances = found.covariance
    fit = replace(
        fit,
        theta=theta,
        beta=beta,
        var_ln_theta=float(variances[place, place]),
        cov_ln_theta_beta=float(variances[place, last]),
        var_beta=float(variances[last, last]),
        loglik=found.loglik,
    )
    if z == 0.0:
        return fit
    reach = [float(np.exp(z * value)) for value in (fit.se_ln_theta, fit.se_beta / beta)]
    return replace(
        fit,
        ci_theta=(theta / reach[0], theta * reach[0]),
        ci_beta=(beta / reach[1], beta * reach[1]),
        ci_method="wald",
    )
