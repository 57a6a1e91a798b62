"""System fragility of the variants of a study: any component at its slight, moderate ... state."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.likelihood.fit import FITTED
from skewbridge.fragility.methods.system import (
    contributions,
    joint_demand,
    lognormal_of_system,
    series_system,
)
from skewbridge.fragility.tables.beyond_model import is_beyond_model, is_complete
from skewbridge.fragility.tables.key_columns import variant_values
from skewbridge.fragility.tables.limit_states import LimitState
from skewbridge.fragility.tables.outcomes import check_demands

MIN_RUNS: Final = 8
_POINTS: Final = 41


def system_curves(
    demands: pd.DataFrame,
    limit_states: Sequence[LimitState],
    im_column: str,
    *,
    exclude: Sequence[str] = ("column_shear",),
) -> pd.DataFrame:
    """Return the system curve of every variant and degree of damage.

    A component takes part where it has a state of that name and its cloud is usable; ``left_out``
    names the others. The cloud of the completed runs is used (``n_runs``): where runs collapsed
    or went beyond the model the curve is a lower bound of the fragility; ``n_not_ok`` says how many
    are left out, ``n_beyond_model`` how many of these for a failed column.

    Limit states of one ``name`` form a system. ``exclude`` names the components left out, by
    default the demand-capacity ratios, which have names of their own.

    Returns:
        One row per (variant, limit_state): components, left_out, status, theta, beta (lognormal
        through x16, x50, x84), max_dp (its largest distance to the curve), theta_weakest and
        weakest (component with the largest contribution at theta), its share_without, n_runs,
        n_not_ok, n_beyond_model.

    Raises:
        InputError: A column is missing or a value unusable.
    """
    states = [state for state in limit_states if state.component not in exclude]
    check_demands(demands, im_column, list(dict.fromkeys(state.demand for state in states)))
    names = list(dict.fromkeys(state.name for state in states))
    rows: list[dict[str, Any]] = []
    for _, part in demands.groupby("variant", sort=True):
        variant = variant_values(part)
        for name in names:
            members = [state for state in states if state.name == name]
            rows.append(variant | {"limit_state": name} | _system(part, members, im_column))
    return pd.DataFrame(rows)


def _system(part: pd.DataFrame, members: Sequence[LimitState], im_column: str) -> dict[str, Any]:
    done = part[is_complete(part)]
    row: dict[str, Any] = {
        "n_runs": len(done),
        "n_not_ok": len(part) - len(done),
        "n_beyond_model": int(np.sum(is_beyond_model(part))),
    }
    usable = [state for state in members if _usable(done, state)]
    row["components"] = ";".join(state.component for state in usable)
    row["left_out"] = ";".join(state.component for state in members if state not in usable)
    blank = {"theta": np.nan, "beta": np.nan, "max_dp": np.nan}
    if len(done) < MIN_RUNS or not usable:
        return row | blank | {"status": "too_few_runs" if usable else "no_component"}
    im = done[im_column].to_numpy(dtype=np.float64)
    try:
        joint = joint_demand(
            im,
            done[[state.demand for state in usable]].to_numpy(dtype=np.float64),
            np.array([state.threshold for state in usable]),
            np.array([state.dispersion for state in usable]),
        )
    except InputError:
        return row | blank | {"status": "non_increasing"}
    lowest = float(np.min(joint.theta))
    # Without a run beyond the weakest component the system curve would be an extrapolation.
    exceeded = any((done[state.demand] > state.threshold).any() for state in usable)
    if lowest > im.max() and not exceeded:
        return row | blank | {"status": "no_exceedance"}
    reach = float(np.exp(4.0 * np.max(joint.beta)))
    grid = np.geomspace(lowest / reach, lowest * reach, _POINTS)
    theta, beta, distance = lognormal_of_system(grid, series_system(grid, joint))
    share = contributions(np.array([theta]), joint)[0]
    weakest = int(np.argmax(share))
    return row | {
        "status": FITTED,
        "theta": theta,
        "beta": beta,
        "max_dp": distance,
        "weakest": usable[weakest].component,
        "theta_weakest": float(joint.theta[weakest]),
        "share_without": float(share[weakest]),
    }


def _usable(done: pd.DataFrame, state: LimitState) -> bool:
    values = done[state.demand].to_numpy(dtype=np.float64)
    return bool(values.size and np.all(np.isfinite(values) & (values > 0.0)))
