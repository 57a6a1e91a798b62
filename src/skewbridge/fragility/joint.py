"""Table `joint`: coefficients of the demand models, from which `predict` computes medians.

A row has the parameters of the demand model (`demand_model`) of a limit state, or of both modes of
a union, from all runs and without each event. Curves at the variants of the study, effects and
predictions between the variants are therefore the same function of the same numbers.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.files.tables import Floats, Row, records_of
from skewbridge.fragility import demand_model, demand_table
from skewbridge.fragility.demand_model import BridgeModels, DemandFit, DemandModel, StateCurve
from skewbridge.fragility.fits import BOUNDS_TOO_WIDE, FITTED
from skewbridge.fragility.limit_states import LimitState, States
from skewbridge.fragility.motion_means import Jackknifed, covered_range
from skewbridge.fragility.outcomes import outcomes_by_state
from skewbridge.fragility.settings import DEFAULTS, FitSettings

JOINT_COLUMNS: Final = demand_table.described("joint")
#: Largest relative error of the median of a left-out variant with which a model may predict.
MAX_ERROR: Final = 0.25
_LEAST_MOTIONS: Final = 5


class JointModel:
    """The curves of one limit state, from its row of results/fragility/joint.parquet."""

    def __init__(self, row: Mapping[str, Any]) -> None:
        self.axis_range = demand_model.AxisRange(levels=json.loads(row["axis_ranges"]))
        self.level = float(row["level"])
        replicates = np.asarray(row["replicates"], dtype=np.float64)
        modes = json.loads(row["modes"])
        ends = np.cumsum([np.prod(mode["shape"]) for mode in modes])
        *parameters, rho = np.split(replicates, ends)
        self._modes, self._models = list[LimitState](), list[DemandModel]()
        for mode, values in zip(modes, parameters, strict=True):
            capacity = {name: mode[name] for name in ("demand", "threshold", "dispersion")}
            self._modes.append(LimitState(component="", name="", **capacity))
            constants = {name: mode[name] for name in ("centre", "motions")}
            constants["span"] = tuple(mode["span"])
            constants["knot"] = np.inf if mode["knot"] is None else mode["knot"]
            constants["parameters"] = values.reshape(mode["shape"])
            self._models.append(DemandModel(axes=self.axis_range, **constants))
        self._rho = rho if len(modes) > 1 else None

    def curve(self, values: Mapping[str, Any]) -> StateCurve:
        """Return the curves at values of the axes, from all runs and without each event."""
        curve = demand_model.state_curve(self._models, self._modes, values, self._rho)
        if isinstance(curve, str):
            nans = np.full(len(self._models[0].parameters), np.nan)
            return StateCurve(nans, nans, nans)
        return curve

    def median(
        self,
        values: Mapping[str, float],
        over: Mapping[str, float] | None = None,
        level: float | None = None,
    ) -> tuple[float, float, float]:
        """Return theta at ``values`` with interval ends, divided by theta at ``over`` if given."""
        curve = self.curve(values)
        median = curve.ln_median() if over is None else curve.ln_ratio(self.curve(over))
        return median.exp_interval(level or self.level)


def joint_table(
    models: Iterable[BridgeModels],
    limit_states: States,
    settings: FitSettings = DEFAULTS,
    *,
    curves: pd.DataFrame | None = None,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return table `joint`, with one row per bridge, abutment model and limit state.

    A state without any curve in ``curves``, because of unknown outcomes, has no estimate here.
    """
    common = {"im": settings.im, "level": settings.confidence}
    items = ((bridge, limit_states, common) for bridge in models)
    rows = demand_table.spread(_rows, items, jobs, alone_s=0.0)
    table = pd.DataFrame(chain.from_iterable(rows), columns=list(JOINT_COLUMNS))
    if curves is not None:
        keys = [*demand_table.BRIDGE_COLUMNS, "component", "limit_state"]
        is_lost = curves["status"].where(curves["method"] == "cloud") == BOUNDS_TOO_WIDE
        by_state = curves.assign(is_lost=is_lost).groupby(keys)[["is_lost", "preferred"]].any()
        too_wide = by_state.index[by_state["is_lost"] & ~by_state["preferred"]]
        withheld = pd.MultiIndex.from_frame(table[keys]).isin(too_wide)
        table.loc[withheld & (table["status"] == FITTED), "status"] = BOUNDS_TOO_WIDE
    return table


def _rows(arguments: tuple[BridgeModels, States, Row]) -> list[Row]:
    models, states, common = arguments
    im = models.runs[common["im"]].to_numpy(dtype=np.float64)
    low, high = covered_range(im, demand_table.motion_codes(models.runs))
    rows: list[Row] = []
    for state, outcome in outcomes_by_state(models.runs, states).items():
        row = models.labels | common | state.columns | outcome.counts(state)
        row |= {"im_low": low, "im_high": high}
        row["axis_ranges"] = json.dumps({n: list(v) for n, v in models.axes.levels.items()})
        row["status"] = outcome.status(state)
        if row["status"] == FITTED:
            row |= _estimate(models, state, row)
        row["extrapolated"] = row["status"] == FITTED and not low <= row["theta"] <= high
        rows.append(row)
    return rows


def _estimate(models: BridgeModels, state: LimitState, row: Row) -> Row:
    """Return the columns of table `joint` for one state, which may be the union of two modes."""
    modes = models.modes(state)
    fits = [fit for fit in map(models.fit, modes) if not isinstance(fit, str)]
    if not models.axes.varying or len(fits) < len(modes):
        reasons = [fit for fit in map(models.fit, modes) if isinstance(fit, str)]
        return {"status": reasons[0] if reasons else "no_axis_varies"}
    if fits[0].model.motions < _LEAST_MOTIONS:
        return {"status": "too_few_motions"}
    names = ("level", "slope", "bend", *models.axes.names, "growth", "ln_tau", "ln_sigma")
    estimate: Row = {"terms": "|".join([";".join(names)] * len(fits))}
    replicates = [fit.model.parameters.ravel() for fit in fits]
    if len(fits) > 1:
        replicates.append(models.correlation(*modes))
    estimate["replicates"] = np.concatenate(replicates).tolist()
    constants: list[Row] = []  # of the demand models, without their parameters
    for fit, mode in zip(fits, modes, strict=True):
        model = fit.model
        capacity = {name: getattr(mode, name) for name in ("demand", "threshold", "dispersion")}
        scale = {"centre": model.centre, "knot": model.knot if np.isfinite(model.knot) else None}
        shape = {"span": model.span, "motions": model.motions, "shape": model.parameters.shape}
        constants.append(capacity | scale | shape)
    estimate["modes"] = json.dumps(constants)
    if len(fits) == 1:
        estimate["slope"] = float(fits[0].model.parameters[0, 1])
        estimate["capacity_dispersion"] = modes[0].dispersion
    curve = models.curve(state, models.axes.middle)
    if isinstance(curve, str):
        return estimate | {"status": curve}
    ln_total = Jackknifed.of_replicates(np.log(curve.total), curve.priors)
    logs = [*curve.ln_median_and_beta(), ln_total]
    for name, ln in zip(("theta", "beta", "beta_total"), logs, strict=True):
        ends = ln.exp_interval(row["level"])
        estimate |= dict(zip((name, f"{name}_low", f"{name}_high"), ends, strict=True))
    errors = _left_out_errors(models, state, fits)
    if np.any(np.isfinite(errors)):
        estimate["loo_error"] = float(np.nanmedian(errors))
        if np.nanmax(errors) > MAX_ERROR:
            estimate["status"] = "prediction_error_above_25_percent"
    # priors divide the effect of such axes: medians of other combinations of them are arbitrary
    if np.linalg.matrix_rank(effects := fits[0].effects) < effects.shape[1]:
        estimate["status"] = "axes_change_together"
    return estimate


def _left_out_errors(models: BridgeModels, state: LimitState, fits: Sequence[DemandFit]) -> Floats:
    """Return |theta fitted without a variant / theta - 1| of each variant; NaN without a theta."""
    modes, rho = models.modes(state), None
    if len(modes) > 1:
        rho = models.correlation(*modes)[:1]
    errors = np.full(len(models.variants), np.nan)
    subsets = zip(*(fit.without_variants for fit in fits), strict=True)
    for i, (refits, values) in enumerate(zip(subsets, records_of(models.variants), strict=True)):
        if any(isinstance(model, str) for model in refits):
            continue
        curve = demand_model.state_curve(refits, modes, values, rho)
        all_runs = models.curve(state, values)
        if not isinstance(curve, str) and not isinstance(all_runs, str):
            errors[i] = abs(np.exp(curve.ln_theta[0] - all_runs.ln_theta[0]) - 1.0)
    return errors
