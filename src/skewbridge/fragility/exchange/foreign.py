"""Demands tables made elsewhere: columns renamed, units converted, missing keys filled, checked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict, Field

from skewbridge.errors import InputError
from skewbridge.fragility.exchange.data_files import read_table
from skewbridge.fragility.old_likelihood.validate import as_column, require_all
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL
from skewbridge.fragility.tables.key_columns import (
    IDENTITY_COLUMNS,
    LOADING_COLUMNS,
    need_columns,
    variant_columns,
)
from skewbridge.reading import checked, read_yaml
from skewbridge.statuses import OK, STATUSES

_DEFAULTS: Final[dict[str, Any]] = {
    "bridge": "foreign",
    "abutment": "foreign",
    "scale": 1.0,
    "incidence_deg": 0.0,
    "status": OK,
}


class ColumnMap(BaseModel):
    """A file that says what the columns of a foreign table are."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    columns: dict[str, str] = Field(description="our column to theirs")
    factors: dict[str, float] = Field(default={}, description="factor to our unit, by our column")
    constants: dict[str, str | float] = Field(
        default={}, description="values of columns that the file lacks"
    )


def read_mapped(path: Path, column_file: Path) -> pd.DataFrame:
    """Read runs of somebody else's model by a YAML file with columns, factors, constants.

    Raises:
        InputError: As `read_foreign`; or the file of columns is wrong, names the key.
    """
    chosen = checked(ColumnMap, read_yaml(column_file), column_file.name)
    return read_foreign(path, chosen.columns, factors=chosen.factors, constants=chosen.constants)


def read_foreign(
    path: Path,
    columns: Mapping[str, str],
    *,
    factors: Mapping[str, float] | None = None,
    constants: Mapping[str, Any] | None = None,
) -> pd.DataFrame:
    """Read runs of somebody else's model as a demands table.

    Args:
        path: CSV or parquet with one row per run.
        columns: Our column name to the column of the file, for example
            ``{"motion_id": "record", "im_pga_rotd50_g": "PGA", "column_drift_ratio": "drift"}``.
            At least ``motion_id``, one ``im_`` column and one demand.
        factors: Factor to our unit per column of ours, for example ``{"deck_disp_m": 0.0254}``.
        constants: Values of columns that the file lacks; bridge, abutment, scale, incidence_deg
            and status have neutral ones.

    Returns:
        A table for `fit_study`, `paired_effects` and the rest; ``variant`` is made of bridge,
        abutment and axes unless it is given.

    Raises:
        InputError: A column is missing, a number unreadable, an intensity not positive, a status
            unknown; names row and column.
    """
    source = read_table(path)
    need_columns(source, columns.values(), path.name)
    out = pd.DataFrame(index=source.index)
    for ours, theirs in columns.items():
        out[ours] = source[theirs]
    if "motion_id" not in out or not any(str(name).startswith("im_") for name in out):
        raise InputError("the column map needs motion_id and at least one im_ column")
    for name, value in (dict(_DEFAULTS) | dict(constants or {})).items():
        if name not in out:
            out[name] = value
    texts = {*IDENTITY_COLUMNS, "motion_id", "status", "collapse_criterion", BEYOND_MODEL}
    for name in out.columns.difference(sorted(texts)):
        numbers = as_column(out[name].to_numpy(), columns.get(name, name))
        out[name] = numbers * (factors or {}).get(name, 1.0)
    if "variant" not in out:
        parts = [out[name].map(str).tolist() for name in variant_columns(out)[1:]]
        out["variant"] = ["_".join(texts) for texts in zip(*parts, strict=True)]
    for name in texts & set(out.columns):
        values = out[name].fillna("") if name == BEYOND_MODEL else out[name]
        out[name] = values.astype(str)
    known = out["status"].isin(STATUSES).to_numpy()
    wrong = repr(out["status"].iloc[int(np.argmin(known))])
    require_all(known, "status", f"{wrong} is not known")
    for name in [c for c in out if str(c).startswith("im_")]:
        require_all(out[name].to_numpy() > 0.0, str(name), "must be > 0 and finite")
    doubled = out.duplicated(["variant", *LOADING_COLUMNS])
    if doubled.any():
        row = int(np.flatnonzero(doubled.to_numpy())[0])
        raise InputError(
            f"row {row} repeats variant, motion_id, scale and incidence_deg of another row", row=row
        )
    key = [*variant_columns(out), *LOADING_COLUMNS, "status"]
    rest = [name for name in out if name not in key]
    return out[[*key, *rest]].reset_index(drop=True)
