"""Fits of a whole study: every variant and limit state of a demands table, by every method."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.existence import NOT_APPLICABLE
from skewbridge.fragility.old_likelihood.fit import FITTED, FragilityFit
from skewbridge.fragility.methods import cloud
from skewbridge.fragility.methods.ordered import crossing
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.fragility.tables.curve_rows import curve_row
from skewbridge.fragility.tables.key_columns import variant_values, variants_of
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import Runs, check_demands, outcomes_of, runs_of
from skewbridge.fragility.tables.reach import VariantReach, force_columns
from skewbridge.fragility.tables.spread import spread
from skewbridge.fragility.tables.variant_cloud import fit_variant_cloud
from skewbridge.fragility.tables.variant_exceedance import fit_exceedance, fit_record_brackets
from skewbridge.statuses import COLLAPSE


def fit_study(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    settings: FitSettings = DEFAULTS,
    *,
    jobs: int = 1,
) -> pd.DataFrame:
    """Fit every variant and limit state of a demands table.

    Methods: ``cloud`` (log-log regression; Tobit where runs collapsed, failed or
    went beyond the model) and
    ``exceedance`` (probit on exceeded or not); where motions repeat at several levels also
    ``ida_interval``. Intervals are Fieller's (cloud) and profile (others), but by record
    bootstrap where motions repeat, since runs are not independent then. ``jobs`` is the number of
    processes.

    Returns:
        One row per (variant, component, limit state, method); columns in
        `skewbridge.fragility.tables.curve_rows.CURVE_COLUMNS`. Unless ``status`` is ``ok``, theta
        and beta are NaN: nothing is extrapolated from data in which nothing exceeds.

    Raises:
        InputError: A column is missing or a value is unusable; names row and column.
    """
    if not limit_states:
        raise InputError("no limit states to fit")
    columns = list(dict.fromkeys(state.demand for state in limit_states))
    check_demands(demands, im_column, columns)
    found = spread(
        partial(_all_states, states=limit_states, im_column=im_column, settings=settings),
        variants_of(demands, [im_column, *columns, *force_columns(demands, columns)]),
        jobs,
    )
    rows = [row for rows in found for row in rows]
    return _flag_crossings(pd.DataFrame(rows), demands[im_column])


def _all_states(
    part: pd.DataFrame, *, states: Sequence[LimitState], im_column: str, settings: FitSettings
) -> list[dict[str, Any]]:
    """Return the rows of one variant."""
    runs = runs_of(part, im_column)
    variant, reach = variant_values(part), VariantReach(part, im_column)
    return [
        variant | curve_row(fit, state, im_column, **facts)
        for state in states
        for fit, facts in _state_fits(runs, part, state, reach, settings)
    ]


def _flag_crossings(curves: pd.DataFrame, im: pd.Series) -> pd.DataFrame:
    """Add ``curves_cross`` where curves of a component, fitted apart, cross inside the range."""
    low, high = float(im.min()), float(im.max())
    drawn = curves[curves["status"] == FITTED].sort_values("threshold")
    for _, part in drawn.groupby(["variant", "component", "method"], sort=False):
        theta, beta = part["theta"].to_numpy(), part["beta"].to_numpy()
        for first, second, _ in crossing(theta, beta, low, high):
            for index in (part.index[first], part.index[second]):
                known = str(curves.loc[index, "warnings"]).split(";")
                flags = dict.fromkeys([*(name for name in known if name), "curves_cross"])
                curves.loc[index, "warnings"] = ";".join(flags)
    return curves


def _state_fits(
    runs: Runs, part: pd.DataFrame, state: LimitState, reach: VariantReach, settings: FitSettings
) -> Iterator[tuple[FragilityFit, dict[str, Any]]]:
    """Yield the fits of one variant and limit state with what `curve_row` takes beside them."""
    demand = part[state.demand].to_numpy(dtype=np.float64)
    outcomes = outcomes_of(demand, runs.status, runs.beyond, state)
    missing = np.isnan(demand) & outcomes.complete
    facts: dict[str, Any] = {
        "n_runs": int(runs.im.size),
        "n_records": int(np.max(runs.records)) + 1,
        "n_exceed": int(np.sum(outcomes.exceed)),
        "n_unknown": int(np.sum(outcomes.unknown)),
        "n_collapse": int(np.sum(runs.status == COLLAPSE)),
        "n_beyond_model": int(np.sum(runs.beyond)),
    }
    if np.any(missing):
        if not np.all(np.isnan(demand[outcomes.complete])):
            motion = part["motion_id"].iloc[int(np.flatnonzero(missing)[0])]
            row = int(part.index.to_numpy()[np.flatnonzero(missing)[0]])
            raise InputError(
                f"{state.demand} is missing for {part['variant'].iloc[0]} under {motion}",
                row=row,
                column=state.demand,
            )
        for name in ("cloud", "exceedance"):
            absent = FragilityFit(method=name, status=NOT_APPLICABLE, level=settings.confidence)
            yield absent, {"facts": facts}
        return
    facts |= reach.columns(state, reached=bool(np.any(outcomes.exceed)))
    line = fit_variant_cloud(runs, outcomes, state, settings)
    if not np.isnan(facts["plateau"]):
        others = (name for name in line.warnings if name not in (cloud.SATURATING, cloud.CURVED))
        line = replace(line, warnings=(*others, cloud.SATURATING))
    fits = [line, fit_exceedance(runs, outcomes, settings)]
    if runs.several_levels:
        fits.append(fit_record_brackets(runs, outcomes, settings))
    for fit in fits:
        yield fit, {"facts": facts, "slope": line.line.b if line.line else None}
