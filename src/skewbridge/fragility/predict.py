"""Fragility at a point between the variants of a study."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy import special

from skewbridge.errors import InputError
from skewbridge.files.tables import read_frame, records_of
from skewbridge.fragility.existence import FITTED
from skewbridge.fragility.joint import JointModel

_USUAL_ABUTMENT: Final = "contact_friction"
#: Path of the table in the folder of a study, and in one that `skewbridge statistics` wrote.
_PATHS: Final = ("fragility/joint.parquet", "joint.parquet")


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
