"""Fragility at a point between the variants of a study, and its comparison with new analyses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.fragility.demand_table import (
    BRIDGE_COLUMNS,
    IDENTITY_COLUMNS,
    LOADING_COLUMNS,
    motion_codes,
)
from skewbridge.fragility.existence import FITTED, NO_EXCEEDANCE, NOT_APPLICABLE
from skewbridge.fragility.fits import fit_cloud
from skewbridge.fragility.joint import JointModel, joint_table
from skewbridge.fragility.limit_states import LimitState
from skewbridge.fragility.outcomes import demand_outcomes, states_by_demand
from skewbridge.fragility.settings import DEFAULTS, FitSettings
from skewbridge.provenance.tables import read_frame
from skewbridge.reading import records_of
from skewbridge.variant.axes import axis

_USUAL_ABUTMENT: Final = "contact_friction"
#: Path of the table in the folder of a study, and in one that `skewbridge statistics` wrote.
_PATHS: Final = ("fragility/joint.parquet", "joint.parquet")
#: Shares of the range of every other axis, for each inner variant; the axes between them have the
#: complement, so that the variants are not all on one diagonal.
_SHARES: Final = (0.5, 0.25, 0.75)

CHECK_COLUMNS: Final[dict[str, str]] = {
    "variant": "variant inside the grid",
    "bridge": "catalogue entry",
    "abutment": "abutment model",
    "component": "component of the limit state",
    "limit_state": "degree of damage",
    "status": "ok, or why there is nothing to compare",
    "theta_predicted": "median from the joint model of the runs of the grid under the same motions",
    "theta_analysed": "median of the cloud of the analyses of this variant",
    "error": "theta_predicted/theta_analysed - 1",
    "se_analysed": "standard error of ln theta_analysed",
    "n_exceed": "runs of this variant known to exceed the state",
    "n_motions": "motions of this variant",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """A point in the range of a study.

    Attributes:
        bridge: Bridge; None if the study has only one.
        abutment: Abutment model; None for the only one, or contact-friction.
        values: Value of each axis.
        component: Component; None for all.
        state: Limit state; None for all.
        at: Intensity at which to give probabilities; None for no probabilities.
    """

    bridge: str | None
    abutment: str | None
    values: Mapping[str, float]
    component: str | None = None
    state: str | None = None
    at: float | None = None


def predict_states(results: Path, point: Point) -> list[dict[str, Any]]:
    """Return a row per limit state that has a joint model.

    Rows have component, state, theta, ci_theta, beta (record-to-record), beta_total (including the
    capacity), p and p_records (probability of exceedance with beta_total and with beta), loo_error
    and im.

    Raises:
        InputError: The table, bridge, abutment model or state does not exist, or the point is
            outside the range of the study.
    """
    path = next((results / name for name in _PATHS if (results / name).is_file()), None)
    if path is None:
        raise InputError(
            f"{results} has neither {' nor '.join(_PATHS)}: run the study or skewbridge "
            "statistics, or name another folder (--study)",
            file=str(results),
        )
    if point.at is not None and not 0.0 < point.at < np.inf:
        raise InputError(f"at must be > 0 and finite, got {point.at:g}", column="at")
    table = _chosen(read_frame(path), "bridge", point.bridge)
    abutment = None if point.abutment is None else point.abutment.replace("-", "_")
    table = _chosen(table, "abutment", abutment, usual=_USUAL_ABUTMENT)
    for column, name in (("component", point.component), ("limit_state", point.state)):
        table = table if name is None else _chosen(table, column, name)
    usable = records_of(table[table["status"] == FITTED])
    if not usable:
        why = ", ".join(sorted(set(table["status"])))
        raise InputError(f"no joint model of these limit states has an estimate: {why}")
    JointModel.of_row(usable[0]).axis_range.check(point.values)
    rows: list[dict[str, Any]] = []
    for row in usable:
        model = JointModel.of_row(row)
        theta, low, high = model.median(point.values)
        p, p_records = (
            None if point.at is None else float(special.ndtr(np.log(point.at / theta) / beta))
            for beta in (model.beta_total, model.beta)
        )
        found = {"component": row["component"], "state": row["limit_state"], "theta": theta}
        found |= {"beta": model.beta, "beta_total": model.beta_total, "ci_theta": [low, high]}
        found |= {"p": p, "p_records": p_records, "loo_error": row["loo_error"], "im": row["im"]}
        rows.append(found)
    return rows


def _chosen(
    table: pd.DataFrame, column: str, name: str | None, usual: str | None = None
) -> pd.DataFrame:
    names = sorted(set(table[column].astype(str)))
    if name is None:
        name = names[0] if len(names) == 1 else usual
    if name not in names:
        problem = "is missing" if name is None else f"got {name!r}"
        raise InputError(f"{column} must be one of {', '.join(names)}; {problem}", column=column)
    return table[table[column] == name]


def inner_variants(grid: Mapping[str, Sequence[float]]) -> list[dict[str, float]]:
    """Return three points inside a grid, none of which is one of its variants.

    They are at 1/2, 1/4 and 3/4 of the range of the first axis and every second one after it, and
    at 1/2, 3/4 and 1/4 of the others. An axis with a single value keeps it.
    """
    points: list[dict[str, float]] = []
    for share in _SHARES:
        point: dict[str, float] = {}
        for place, (name, values) in enumerate(grid.items()):
            low, high = min(values), max(values)
            part = share if place % 2 == 0 else 1.0 - share
            value = round(low + part * (high - low), 6)
            point[name] = float(round(value)) if axis(name).is_whole else value
        if all(value in grid[name] for name, value in point.items()):
            name = next((name for name, values in grid.items() if len(set(values)) > 1), None)
            if name is None:
                raise InputError("the grid has one variant only, and no variants inside")
            levels = sorted(set(grid[name]))
            place = min(levels.index(point[name]), len(levels) - 2)
            point[name] = levels[place] + (levels[place + 1] - levels[place]) / 3.0
        points.append(point)
    return points


def check_predict(
    joint: pd.DataFrame,
    study: pd.DataFrame,
    inner: pd.DataFrame,
    limit_states: Sequence[LimitState],
    settings: FitSettings = DEFAULTS,
) -> pd.DataFrame:
    """Compare predicted medians with those of new analyses of variants inside the grid.

    The new analyses usually have fewer motions than the study. The joint models are therefore
    fitted again to the runs of the grid under the motions of the new analyses: the scatter from
    motion to motion is then the same in both medians and the difference is the error of the terms.

    Returns:
        A row per new variant and limit state with the columns `CHECK_COLUMNS`.

    Raises:
        InputError: The study lacks a motion of the new analyses.
    """
    loading = list(LOADING_COLUMNS)
    same = study.merge(inner[loading].drop_duplicates(), on=loading)
    if lacking := set(inner["motion_id"]) - set(same["motion_id"]):
        raise InputError(f"the study has no runs of {', '.join(sorted(map(str, lacking)))}")
    key = [*BRIDGE_COLUMNS, "component", "limit_state"]
    status = joint.set_index(key)["status"].to_dict()
    models = {
        tuple(row[name] for name in key): row
        for row in records_of(joint_table(same, limit_states, None, settings))
    }
    rows: list[dict[str, Any]] = []
    for identity, part in inner.groupby(list(IDENTITY_COLUMNS), sort=True):
        values = {str(name): part[name].iloc[0] for name in part}
        for states in states_by_demand(limit_states).values():
            outcomes = demand_outcomes(part, states)
            used = outcomes.used
            for state in states:
                exceeding = int(np.sum(outcomes.exceed(state)))
                row: dict[str, Any] = dict(zip(IDENTITY_COLUMNS, identity, strict=True)) | {
                    "component": state.component,
                    "limit_state": state.name,
                    "n_exceed": exceeding,
                    "n_motions": part["motion_id"].nunique(),
                }
                place = tuple(row[name] for name in key)
                stages = [status.get(place), models[place]["status"] if place in models else None]
                row["status"] = next((s or NOT_APPLICABLE for s in stages if s != FITTED), FITTED)
                if exceeding == 0:
                    row["status"] = NO_EXCEEDANCE
                if row["status"] == FITTED:
                    cloud = fit_cloud(
                        part[settings.im].to_numpy(dtype=np.float64)[used],
                        outcomes.lower[used],
                        state.threshold,
                        outcomes.upper[used],
                        settings=settings,
                        motions=motion_codes(part)[used],
                    )
                    predicted = JointModel.of_row(models[place]).median(values)[0]
                    row |= {
                        "status": cloud.status,
                        "theta_predicted": predicted,
                        "theta_analysed": cloud.theta,
                        "error": predicted / cloud.theta - 1.0,
                        "se_analysed": cloud.se_ln_theta,
                    }
                rows.append(row)
    return pd.DataFrame(rows, columns=list(CHECK_COLUMNS))
