"""The table of joint models: one per bridge, abutment model, limit state and kind of data."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.fragility.old_joint.columns import JOINT_COLUMNS
from skewbridge.fragility.old_joint.fits import (
    NO_AXIS,
    JointFit,
    fit_demand,
    fit_outcomes,
)
from skewbridge.fragility.old_joint.judged import SOURCES, Fitted, judged, preferred
from skewbridge.fragility.old_joint.runs import JointRuns, joint_runs
from skewbridge.fragility.old_likelihood.bootstrap import record_weights
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.key_columns import BRIDGE_COLUMNS
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Outcomes, check_demands
from skewbridge.fragility.tables.spread import spread

# ASSUME the limit states of one demand take about a second
_WORTH_PROCESSES: Final = 8


class _Draws:
    """Weights of the bootstrap, made once per number of motions."""

    def __init__(self, settings: FitSettings) -> None:
        self._settings = settings
        self._weights: dict[int, FloatArray] = {}

    def fitted(self, fit: JointFit) -> Fitted:
        """Return a fit with its replicates."""
        if fit.sums is None:
            return Fitted(fit=fit)
        count = fit.sums.score.shape[0]
        if count not in self._weights:
            draw = (self._settings.bootstrap, self._settings.seed)
            self._weights[count] = record_weights(np.arange(count), *draw)
        return Fitted(
            fit=fit,
            best=fit.sums.best(),
            left_out=fit.sums.one_left_out(),
            again=fit.sums.reweighted(self._weights[count]),
        )


def joint_table(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    curves: pd.DataFrame,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Fit one model over the axes per bridge, abutment model and limit state.

    Args:
        demands: The demands table.
        limit_states: The limit states.
        im_column: The intensity measure.
        curves: The fits of the single variants, which leaving variants out is measured against.
        settings: Confidence level, replicates and seed.
        jobs: Number of processes.

    Returns:
        Rows with the columns `JOINT_COLUMNS`, two per limit state.

    Raises:
        InputError: A column is missing or a value unusable; names row and column.
    """
    check_demands(demands, im_column, list(dict.fromkeys(s.demand for s in limit_states)))
    found = spread(
        partial(_rows, settings=settings),
        _items(demands, limit_states, im_column, curves),
        jobs,
        least=_WORTH_PROCESSES,
    )
    # as the models and the limit states stand, whichever demands they share
    rows = sorted((each for item in found for each in item), key=lambda each: each[0])
    return pd.DataFrame([row for _, row in rows], columns=list(JOINT_COLUMNS))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Item:
    """The limit states of one demand of a bridge and abutment model, by their place in the table.

    ``named`` are the columns of the model, ``own`` the fits of its variants.
    """

    named: dict[str, Any]
    runs: JointRuns
    states: dict[tuple[int, int], LimitState]
    own: pd.DataFrame


def _items(
    demands: pd.DataFrame, states: Sequence[LimitState], im_column: str, curves: pd.DataFrame
) -> Iterator[_Item]:
    fitted = curves[curves["status"] == FITTED]
    own_columns = ["variant", "component", "limit_state", "method", "theta", "var_ln_theta"]
    for number, (key, part) in enumerate(demands.groupby(list(BRIDGE_COLUMNS), sort=True)):
        own = fitted[(fitted["bridge"] == key[0]) & (fitted["abutment"] == key[1])][own_columns]
        runs = joint_runs(part.reset_index(drop=True), im_column)
        named = dict(zip(BRIDGE_COLUMNS, key, strict=True)) | {"im": im_column}
        for demand in dict.fromkeys(state.demand for state in states):
            places = {(number, i): s for i, s in enumerate(states) if s.demand == demand}
            components = {state.component for state in places.values()}
            yield _Item(
                named=named,
                runs=runs.of_demand(demand),
                states=places,
                own=own[own["component"].isin(components)],
            )


def _rows(item: _Item, *, settings: FitSettings) -> list[tuple[tuple[int, int], dict[str, Any]]]:
    """Return the rows of the limit states of one demand, each with its place."""
    kept: dict[bytes, Fitted] = {}
    draws, runs = _Draws(settings), item.runs
    names = ["component", "limit_state", "method"]
    theirs = {key: part.set_index("variant") for key, part in item.own.groupby(names)}
    rows: list[tuple[tuple[int, int], dict[str, Any]]] = []
    for place, state in item.states.items():
        outcomes = runs.outcomes(state)
        found = {
            source: judged(
                runs,
                outcomes,
                (state, source, each),
                theirs.get((state.component, state.name, SOURCES[source])),
                settings,
            )
            for source, each in _fits(runs, outcomes, state, (kept, draws)).items()
        }
        chosen = preferred(found, runs.motion[~outcomes.unknown])
        for source, each in found.items():
            rows.append((place, item.named | each.row | {"preferred": source == chosen}))
    return rows


def _fits(
    runs: JointRuns,
    outcomes: Outcomes,
    state: LimitState,
    cache: tuple[dict[bytes, Fitted], _Draws],
) -> dict[str, Fitted]:
    if not runs.box.limits:
        return dict.fromkeys(SOURCES, Fitted(fit=JointFit(status=NO_AXIS)))
    kept, draws = cache
    peak = np.nan_to_num(outcomes.demand, nan=0.0)
    lower = np.where(outcomes.defined, np.maximum(peak, state.threshold), peak)
    used = np.where(outcomes.complete, np.isfinite(outcomes.demand), lower > 0.0)
    key = lower.tobytes()  # states of one demand share the fit
    if key not in kept:
        kept[key] = draws.fitted(fit_demand(runs, lower, outcomes.complete, used))
    known = ~outcomes.unknown & (np.isfinite(outcomes.demand) | outcomes.exceed)
    outcome = fit_outcomes(runs, outcomes.exceed, known, kept[key].fit)
    return {"demand": kept[key], "exceedance": draws.fitted(outcome)}
