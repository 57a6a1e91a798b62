"""System fragility of the variants of a study: any component at a degree of damage, or beyond it.

A component whose states lack a degree takes part with its next more severe state, so that a bridge
with failed shear keys is never damaged completely but not extensively.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import nan
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood import existence
from skewbridge.fragility.old_likelihood.bootstrap import Replicates, shared_weights, student_reach
from skewbridge.fragility.old_likelihood.fit import FITTED, exp_end
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.methods.system import (
    JointDemand,
    contributions,
    joint_demand,
    lognormals,
    replicate_medians,
    residual_correlation,
)
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.key_columns import variant_values, variants_of
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import (
    CensoredDemands,
    Outcomes,
    Runs,
    check_demands,
    outcomes_of,
    runs_of,
)
from skewbridge.fragility.tables.spread import spread
from skewbridge.fragility.tables.variant_cloud import refit_censored
from skewbridge.statuses import COLLAPSE

#: Runs of a variant, and complete ones of a component, without which there is no system curve.
MIN_RUNS: Final = 8
MIN_COMPLETE: Final = 4
#: Replicates behind the interval: its half-width is known to 5 %.
REPLICATES: Final = 199


def system_curves(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return the system curve of every variant and degree of damage.

    Every component takes part that has a state of the degree, or a more severe one, and a rising
    line through positive demands; ``left_out`` names the others with the reason. Runs that
    collapsed, failed or went beyond the model are demands known only to exceed a value (Tobit).
    No number is given where no run, or every run, reaches the state of a component. ``jobs`` is the
    number of processes.

    Returns:
        One row per (variant, limit_state): components (with the state of another name that
        stands for the degree), left_out, status, theta, beta (lognormal through x16, x50, x84)
        with intervals from the bootstrap by motion, max_dp (largest distance of the lognormal to
        the curve), the same for fully correlated and for independent components, theta_weakest
        and weakest (component with the largest contribution at theta), its share_without, the
        one-sided theta_bound without an estimate, and counts of runs.

    Raises:
        InputError: A column is missing or a value unusable; or the degrees of damage of the
            components have no common order.
    """
    states = [state for state in limit_states if state.system_degree]
    check_demands(demands, im_column, list(dict.fromkeys(state.demand for state in states)))
    members = system_members(states)
    found = spread(
        partial(_variant_rows, members=members, im_column=im_column, settings=settings),
        variants_of(demands, [im_column, *(state.demand for state in states)]),
        jobs,
    )
    return pd.DataFrame([row for rows in found for row in rows])


def _variant_rows(
    part: pd.DataFrame,
    *,
    members: Mapping[str, Sequence[LimitState]],
    im_column: str,
    settings: FitSettings,
) -> list[dict[str, Any]]:
    """Return the rows of one variant, one per degree of damage."""
    runs, variant = runs_of(part, im_column), variant_values(part)
    return [
        variant | {"limit_state": degree} | _System(runs, part, (degree, own), settings).row()
        for degree, own in members.items()
    ]


def system_members(states: Sequence[LimitState]) -> dict[str, list[LimitState]]:
    """Return per degree of damage the state with which each component takes part.

    The degrees are ordered as the components order them, mild to severe. A component takes part
    with its mildest state of that degree or of one that is more severe.

    Raises:
        InputError: Two components order the degrees differently.
    """
    by_component: dict[str, list[LimitState]] = {state.component: [] for state in states}
    for state in sorted(states, key=lambda item: item.threshold):
        by_component[state.component].append(state)
    degrees = list(dict.fromkeys(state.system_degree for state in states))
    beyond: dict[str, set[str]] = {name: set() for name in degrees}
    for _ in degrees:  # what is more severe than what is more severe
        for own in by_component.values():
            names = [state.system_degree for state in own]
            for first, mild in enumerate(names):
                for severe in names[first + 1 :]:
                    beyond[mild] |= {severe} | beyond[severe]
    for name in degrees:
        if name in beyond[name]:
            raise InputError(f"components put the degree of damage {name!r} in different orders")
    found: dict[str, list[LimitState]] = {}
    for degree in sorted(degrees, key=lambda name: -len(beyond[name])):
        reach = {degree} | beyond[degree]
        chosen = [
            next((state for state in own if state.system_degree in reach), None)
            for own in by_component.values()
        ]
        found[degree] = [state for state in chosen if state is not None]
    return found


@dataclass(frozen=True, slots=True)
class _Member:
    """A component that takes part: its state, outcomes, demands as a line sees them, the line."""

    state: LimitState
    outcomes: Outcomes
    data: CensoredDemands
    line: Replicates


class _System:
    """The components of one variant at one degree of damage."""

    def __init__(
        self,
        runs: Runs,
        part: pd.DataFrame,
        system: tuple[str, Sequence[LimitState]],
        settings: FitSettings,
    ) -> None:
        self._degree, members = system
        self._runs, self._settings = runs, settings
        self._weights = shared_weights(runs.records, REPLICATES, settings.seed)
        self._motions = int(np.unique(runs.records).size)
        self._members: list[_Member] = []
        self._left_out: list[str] = []
        for state in members:
            demand = part[state.demand].to_numpy(dtype=np.float64)
            found = self._member(state, demand)
            if isinstance(found, str):
                self._left_out.append(f"{state.component}: {found}")
            else:
                self._members.append(found)

    def _member(self, state: LimitState, demand: FloatArray) -> _Member | str:
        """Return a component with its lines, that of the data first, or why it takes no part."""
        runs = self._runs
        outcomes = outcomes_of(demand, runs.status, runs.beyond, state)
        complete = outcomes.complete
        if np.sum(complete) < MIN_COMPLETE:
            return "too few complete runs"
        if not np.all(np.isfinite(demand[complete])):
            return "demand missing"
        if np.any(demand[complete] <= 0.0):
            return "zero demand"
        if np.ptp(runs.im[complete]) == 0.0:
            return "single level"
        data = outcomes.censored(state.threshold)
        used = data.used
        kept = CensoredDemands(data.lower[used], data.upper[used], used[used])
        line = refit_censored(runs.im[used], kept, state.threshold, self._weights[:, used])
        if not np.isfinite(line.theta[0]):
            return "demand does not grow"
        return _Member(state, outcomes, data, line)

    def row(self) -> dict[str, Any]:
        """Return the columns of the system."""
        runs, members, settings = self._runs, self._members, self._settings
        exceed = np.zeros(runs.im.size, dtype=np.bool_)
        unknown = exceed.copy()
        for member in members:
            exceed |= member.outcomes.exceed
            unknown |= member.outcomes.unknown
        unknown &= ~exceed
        row: dict[str, Any] = {
            "n_runs": int(runs.im.size),
            "n_exceed": int(np.sum(exceed)),
            "n_unknown": int(np.sum(unknown)),
            "n_collapse": int(np.sum(runs.status == COLLAPSE)),
            "n_beyond_model": int(np.sum(runs.beyond)),
            "components": ";".join(self._name(member.state) for member in members),
            "left_out": ";".join(self._left_out),
            "level": settings.confidence,
        }
        if not members or runs.im.size < MIN_RUNS:
            return row | _BLANK | {"status": "too_few_runs" if members else "no_component"}
        if not np.any(exceed) or np.all(exceed | unknown):
            every = bool(np.any(exceed))
            status = existence.ALL_EXCEED if every else existence.NO_EXCEEDANCE
            found = row | _BLANK | {"status": status}
            if np.any(~unknown):
                found["theta_bound"] = existence.median_bound(
                    np.log(runs.im[~unknown]),
                    np.ones(int(np.sum(~unknown))),
                    beta=settings.assumed_beta,
                    level=settings.confidence,
                    exceed=every,
                )
            return found
        return row | _BLANK | {"status": FITTED} | self._estimate()

    def _name(self, state: LimitState) -> str:
        same = state.system_degree == self._degree and state.name == self._degree
        return state.component if same else f"{state.component} ({state.name})"

    def _estimate(self) -> dict[str, Any]:
        members = self._members
        observed = [
            np.where(member.outcomes.complete, np.log(np.maximum(member.data.lower, 1e-300)), nan)
            for member in members
        ]
        correlation = residual_correlation(
            np.log(self._runs.im), np.stack(observed, axis=1), self._weights
        )
        every = joint_demand(
            [member.line for member in members],
            [member.state.dispersion for member in members],
            correlation,
        )
        joint = every.first
        (theta, beta, distance), together, apart = lognormals(joint)
        share = contributions(np.array([theta]), joint)[0]
        weakest = int(np.argmax(share)) if share.size > 1 else 0
        return {
            "theta": theta,
            "beta": beta,
            "max_dp": distance,
            "theta_correlated": together[0],
            "beta_correlated": together[1],
            "theta_independent": apart[0],
            "beta_independent": apart[1],
            "weakest": members[weakest].state.component,
            "theta_weakest": float(joint.theta[weakest]),
            "share_without": float(share[weakest]),
            **self._interval(every, theta, beta),
        }

    def _interval(self, every: JointDemand, theta: float, beta: float) -> dict[str, float]:
        """Return the ends of theta and beta, symmetric in their logarithms."""
        ln_theta, betas = replicate_medians(every, theta, beta)
        level, m = self._settings.confidence, self._motions
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = [student_reach(v[1:], m, level) for v in (ln_theta, np.log(betas))]
        ends = [exp_end(value) for value in reach]
        return {
            "theta_low": theta / ends[0],
            "theta_high": theta * ends[0],
            "beta_low": beta / ends[1],
            "beta_high": beta * ends[1],
        }


_BLANK: Final[dict[str, Any]] = {
    **dict.fromkeys(
        (
            "theta", "beta", "theta_low", "theta_high", "beta_low", "beta_high", "max_dp",
            "theta_correlated", "beta_correlated", "theta_independent", "beta_independent",
            "theta_weakest", "share_without", "theta_bound",
        ),
        nan,
    ),
    "weakest": "",
}  # fmt: skip
