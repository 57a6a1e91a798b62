"""Fits of a table with one row per run: its statuses, repeated motions and options are obeyed."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.fit_columns import fit_cloud_columns
from skewbridge.fragility.exchange.fit_options import FitOptions
from skewbridge.fragility.exchange.fit_tests import with_normal_test, with_stripe_tests
from skewbridge.fragility.old_likelihood.bootstrap import record_weights
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.old_likelihood.parts import RunCounts
from skewbridge.fragility.old_likelihood.validate import as_column, same_length
from skewbridge.fragility.methods import cloud, tobit
from skewbridge.fragility.tables.beyond_model import is_beyond_model
from skewbridge.fragility.tables.key_columns import motion_codes, need_columns
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Outcomes, Runs, bootstrapped, outcomes_of
from skewbridge.fragility.tables.variant_cloud import fit_variant_cloud
from skewbridge.fragility.tables.variant_exceedance import (
    fit_exceedance,
    fit_record_brackets,
    fit_uncertain_capacity,
)
from skewbridge.statuses import COLLAPSE, OK


@dataclass(frozen=True, slots=True)
class _Table:
    """The runs of a table against one threshold."""

    runs: Runs
    outcomes: Outcomes
    state: LimitState
    demand: FloatArray

    @property
    def complete(self) -> bool:
        """Whether every run ended, without collapse and inside the model."""
        return bool(np.all(self.outcomes.complete))


def fit_run_table(data: pd.DataFrame | Mapping[str, Any], options: FitOptions) -> FragilityFit:
    """Fit a table of runs; ``status``, ``beyond_model``, ``collapse`` and ``motion_id`` count.

    Raises:
        InputError: A column or option is missing or wrong, or an option cannot be honoured for
            these runs; says which and what to do.
    """
    if options.im is None or options.edp is None or options.threshold is None:
        raise InputError("a table of runs needs --im, --edp and --threshold")
    if not isinstance(data, pd.DataFrame):
        lists = {str(name): value for name, value in data.items() if isinstance(value, list)}
        same_length(**{name: np.empty(len(value)) for name, value in lists.items()})
        data = pd.DataFrame(lists)
    need_columns(data, (options.im, options.edp), "the table")
    table = _read(data, options.im, options.edp, options)
    if options.method == "cloud":
        fit = _fit_cloud(table, options)
    elif options.method == "ida":
        fit = fit_record_brackets(table.runs, table.outcomes, options.settings)
    else:
        fit = _fit_stripes(table, options)
    counts = replace(
        fit.counts or RunCounts(),
        n_records=int(np.unique(table.runs.records).size),
        n_unknown=int(np.sum(table.outcomes.unknown)),
    )
    return replace(fit, counts=counts)


def _read(data: pd.DataFrame, im_column: str, edp: str, options: FitOptions) -> _Table:
    im = as_column(data[im_column].to_numpy(), im_column)
    threshold = float(options.threshold or 0.0)
    cloud.cloud_columns(im, np.ones(im.size), threshold)
    status = np.full(im.size, OK) if "status" not in data else data["status"].to_numpy(str)
    if "collapse" in data:
        fallen = as_column(data["collapse"].to_numpy(), "collapse") > 0.0
        status = np.where(fallen & (status == OK), COLLAPSE, status)
    state = LimitState(
        component=edp,
        name="threshold",
        demand=edp,
        threshold=threshold,
        dispersion=options.capacity_dispersion,
    )
    beyond = is_beyond_model(data)
    demand = as_column(data[edp].to_numpy(), edp)
    outcomes = outcomes_of(demand, status, beyond, state)
    if options.method == "cloud" or not np.all(outcomes.complete):
        cloud.cloud_columns(im, demand, threshold, (~outcomes.complete).astype(np.float64))
    codes = motion_codes(data) if "motion_id" in data else np.arange(im.size)
    return _Table(Runs(im=im, status=status, beyond=beyond, records=codes), outcomes, state, demand)


def _fit_stripes(table: _Table, options: FitOptions) -> FragilityFit:
    known = ~table.outcomes.unknown
    if table.state.dispersion > 0.0:
        return fit_uncertain_capacity(
            table.runs, table.outcomes, table.state, options.settings, link=options.link
        )
    fit = fit_exceedance(table.runs, table.outcomes, options.settings, link=options.link)
    if not options.goodness:
        return fit
    exceed = table.outcomes.exceed[known].astype(np.float64)
    return with_stripe_tests(fit, table.runs.im[known], np.ones(exceed.size), exceed)


def _fit_cloud(table: _Table, options: FitOptions) -> FragilityFit:
    runs, outcomes, model = table.runs, table.outcomes, options.model
    fallen = (runs.status == COLLAPSE) & ~runs.beyond
    unfinished = ~outcomes.complete
    trimmed = options.censor_above is not None or options.discard_below is not None
    if runs.repeated and model in ("modified", "heteroscedastic"):
        raise InputError(
            f"--model {model} takes runs as independent, but motions repeat (motion_id): take ols "
            "or tobit, whose intervals are of the bootstrap by motion"
        )
    if np.any(unfinished) and model in ("ols", "heteroscedastic"):
        raise InputError(
            f"--model {model} would leave out {int(np.sum(unfinished))} runs that did not complete:"
            " take tobit, or no --model"
        )
    if model == "modified":
        if np.any(unfinished & ~fallen):
            raise InputError(
                "--model modified needs runs that completed or collapsed; "
                f"{int(np.sum(unfinished & ~fallen))} failed or went beyond the model: take tobit"
            )
        flags = fallen.astype(np.float64)
        return fit_cloud_columns(runs.im, table.demand, table.state.threshold, flags, options)
    if trimmed:
        return _fit_trimmed(table, options)
    if table.complete and not runs.repeated:
        return fit_cloud_columns(runs.im, table.demand, table.state.threshold, None, options)
    fit = fit_variant_cloud(
        runs,
        outcomes,
        table.state,
        options.settings,
        capacity_dispersion=options.capacity_dispersion,
    )
    if not options.goodness:
        return fit
    done = outcomes.complete
    return with_normal_test(fit, np.log(runs.im[done]), np.log(table.demand[done]))


def _fit_trimmed(table: _Table, options: FitOptions) -> FragilityFit:
    """Fit the line with demands censored above a value, or dropped below one."""
    runs, outcomes = table.runs, table.outcomes
    if np.any(outcomes.unknown):
        raise InputError("--censor-above and --discard-below need runs with a known outcome")
    data = outcomes.censored(table.state.threshold)
    low = options.discard_below or 0.0
    used: NDArray[np.bool_] = data.used & (data.lower >= low)
    lower, upper = data.lower[used], data.upper[used]
    if options.censor_above is not None:
        high = lower >= options.censor_above
        lower, upper = np.where(high, options.censor_above, lower), np.where(high, np.inf, upper)
    im, motions = runs.im[used], runs.records[used]
    fit = tobit.fit_tobit(
        im,
        lower,
        table.state.threshold,
        upper,
        capacity_dispersion=options.capacity_dispersion,
        settings=options.settings,
        interval=not runs.repeated,
    )
    if fit.status != FITTED or not runs.repeated:
        return fit
    settings = options.settings
    weights = record_weights(motions, settings.bootstrap, settings.seed)
    again = tobit.refit_tobit(im, lower, table.state.threshold, upper, weights)
    return bootstrapped(fit, again.widened(options.capacity_dispersion))
