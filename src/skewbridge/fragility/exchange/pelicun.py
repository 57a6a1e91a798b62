"""Fragility functions of pelicun: a CSV of parameters and a JSON beside it with their names.

References:
    pelicun 3, fragility database (``LS1-Family``, ``LS1-Theta_0``, ``LS1-Theta_1``; the JSON has
    ``Description`` and ``LimitStates`` by ID).
"""

import json
from pathlib import Path
from typing import Any, Final

import pandas as pd

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.chosen import CURVE_BETA, ChosenCurves
from skewbridge.fragility.exchange.data_files import write_csv
from skewbridge.fragility.exchange.identifiers import identifier
from skewbridge.fragility.exchange.measures import pelicun_demand
from skewbridge.fragility.old_likelihood.fit import FITTED
from skewbridge.provenance.files import write_text

#: pelicun cuts names at every ``-``, and then finds none of the rows of the file.
_ID_SIGNS: Final = "A-Za-z0-9_."
_LONGEST_ID: Final = 200
_PARAMETERS: Final = ("Family", "Theta_0", "Theta_1", "DamageStateWeights")


def write_pelicun(curves: ChosenCurves, out: Path) -> dict[str, Any]:
    """Write a row per variant and component; a limit state has one number in all files.

    The number is its place by threshold among all limit states of its component in the study,
    fitted or not. A state without an estimate is a hole: pelicun passes over empty parameters.

    Returns:
        ``names`` (the JSON beside the CSV) and ``holes`` (rows that lack states, with them).

    Raises:
        InputError: The intensity measure is no demand type of pelicun, or the file asked for is
            the JSON.
        OSError: A file cannot be written.
    """
    names_file = out.with_suffix(".json")
    if names_file == out:
        raise InputError(f"{out.name}: the parameters are CSV, and the names stand beside in JSON")
    rows: list[dict[str, Any]] = []
    names: dict[str, Any] = {}
    holes: list[dict[str, Any]] = []
    for (variant, component), part in curves.fitted.groupby(["variant", "component"], sort=True):
        states = curves.states[str(component)]
        own = {str(row["limit_state"]): row for row in part.to_dict("records")}
        name = identifier(f"{variant}.{component}", _ID_SIGNS, _LONGEST_ID)
        row, told = _row(name, states, own), _names(curves, part, states)
        rows.append(row)
        names[row["ID"]] = told
        if missing := [state for state in states if state not in own]:
            holes.append({"id": row["ID"], "missing": missing})
    write_csv(pd.DataFrame(rows), out)
    write_text(names_file, json.dumps(names, indent=1, allow_nan=False) + "\n")
    return {"names": str(names_file), "holes": holes}


def _row(name: str, states: list[str], own: dict[str, dict[Any, Any]]) -> dict[str, Any]:
    demand, unit = pelicun_demand(str(next(iter(own.values()))["im"]))
    row: dict[str, Any] = {
        "ID": name,
        "Incomplete": 0,
        "Demand-Type": demand,
        "Demand-Unit": unit,
        "Demand-Offset": 0,
        # 0 lets pelicun take the larger direction and multiply it by 1.2; ours is RotD50 already
        "Demand-Directional": 1,
    }
    for number, state in enumerate(states, start=1):
        found = own.get(state)
        values = ("", "", "", "")
        if found is not None:
            values = ("lognormal", found["theta"], found[CURVE_BETA], "")
        row |= {f"LS{number}-{key}": v for key, v in zip(_PARAMETERS, values, strict=True)}
    return row


def _names(curves: ChosenCurves, part: pd.DataFrame, states: list[str]) -> dict[str, Any]:
    """Return what the JSON says of one row: of every state its name, threshold and source."""
    first = part.iloc[0]
    of_variant = curves.rows[
        (curves.rows["variant"] == first["variant"])
        & (curves.rows["component"] == first["component"])
    ]
    told = {str(row["limit_state"]): row for row in of_variant.to_dict("records")}
    limit_states: dict[str, Any] = {}
    missing: list[str] = []
    for number, state in enumerate(states, start=1):
        row = told.get(state)
        if row is None or row["status"] != FITTED:
            missing.append(f"LS{number} {state} ({'no row' if row is None else row['status']})")
            continue
        capacity = f"median {row['threshold']:g}, dispersion {row.get('capacity_dispersion', 0):g}"
        # pelicun numbers damage states by the limit states that have parameters
        limit_states[f"LS{number}"] = {
            f"DS{len(limit_states) + 1}": {
                "Description": f"{state}: {row.get('demand', '')} above {capacity}",
                "Reference": str(row.get("citation", "")),
            }
        }
    comments = "dispersion with that of the capacity where a slope carries it over"
    if missing:
        comments += f"; without an estimate: {', '.join(missing)}"
    return {
        "Description": f"{first['component']} of {first['variant']}, {curves.method} fit",
        "Comments": comments,
        "SuggestedComponentBlockSize": "1 EA",
        "RoundUpToIntegerQuantity": "True",
        "LimitStates": limit_states,
    }
