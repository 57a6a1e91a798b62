"""Medians, dispersions and probabilities at a place inside the box of a study."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.old_joint.model import JointModel, exceedance
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.provenance.tables import read_frame
from skewbridge.reading.tables import records_of

_USUAL_ABUTMENT: Final = "contact_friction"
#: Where the table lies in the folder of a study, and in one that `skewbridge statistics` wrote.
_PLACES: Final = ("fragility/joint.parquet", "joint.parquet")


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """What is asked for.

    Attributes:
        bridge: Bridge; None for the only one.
        abutment: Abutment model; None for the only one, or contact-friction.
        values: Value by axis.
        component: Component; None for all.
        state: Limit state; None for all.
        at: Intensity of the probabilities; None for none.
    """

    bridge: str | None
    abutment: str | None
    values: Mapping[str, float]
    component: str | None = None
    state: str | None = None
    at: float | None = None


def predict_states(results: Path, place: Place) -> list[dict[str, Any]]:
    """Return a row per limit state that has a joint model.

    Rows have component, state, theta, beta, beta_total, ci_theta, p and p_total (probabilities at
    ``at`` by either dispersion), loo_error, source, im.

    Raises:
        InputError: There is no such table, bridge, abutment model or state, or the place is outside
            the box of the study.
    """
    table = _joint_table(results)
    if place.at is not None and not 0.0 < place.at < np.inf:
        raise InputError(f"at must be > 0 and finite, got {place.at:g}", column="at")
    table = _chosen(table, "bridge", place.bridge)
    table = _chosen(table, "abutment", place.abutment, usual=_USUAL_ABUTMENT)
    for column, name in (("component", place.component), ("limit_state", place.state)):
        table = table if name is None else _chosen(table, column, name)
    usable = table[table["preferred"].to_numpy(dtype=bool) & (table["status"] == FITTED)]
    if usable.empty:
        why = ", ".join(sorted(set(table["status"])))
        raise InputError(f"no joint model of these limit states has an estimate: {why}")
    return [_row(each, place) for each in records_of(usable)]


def _joint_table(results: Path) -> pd.DataFrame:
    for name in _PLACES:
        if (results / name).is_file():
            return read_frame(results / name)
    raise InputError(
        f"{results} has neither {' nor '.join(_PLACES)}: run the study, or skewbridge statistics, "
        "or name another folder (--results)",
        file=str(results),
    )


def _chosen(
    table: pd.DataFrame, column: str, name: str | None, usual: str | None = None
) -> pd.DataFrame:
    known = sorted(set(table[column].astype(str)))
    if name is None:
        name = known[0] if len(known) == 1 else usual if usual in known else None
    else:
        name = name.replace("-", "_") if column == "abutment" else name
    if name not in known:
        said = "is missing" if name is None else f"got {name!r}"
        raise InputError(f"{column} must be one of {', '.join(known)}; {said}", column=column)
    return table[table[column] == name]


def _row(row: Mapping[str, Any], place: Place) -> dict[str, Any]:
    model = JointModel.of_row(row)
    model.box.check(place.values)
    theta, low, high = model.median(place.values)
    p = {
        name: None if place.at is None else exceedance(place.at, theta, beta)
        for name, beta in (("p", model.beta), ("p_total", model.beta_total))
    }
    return {
        "component": row["component"],
        "state": row["limit_state"],
        "theta": theta,
        "beta": model.beta,
        "beta_total": model.beta_total,
        "ci_theta": [low, high],
        **p,
        "loo_error": row["loo_error"],
        "source": row["source"],
        "im": row["im"],
    }
