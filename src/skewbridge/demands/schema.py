"""The demands table: its columns, units and meaning, and the rows made from an analysis."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import pandas as pd
import pyarrow as pa

from skewbridge.variant.variant import Variant

type Kind = Literal["text", "integer", "number"]

STATUSES: Final = ("ok", "collapse", "numerical_failure", "timeout", "crash", "invalid_input")
KEY: Final = ("variant", "motion_id", "scale", "incidence_deg")
#: Columns that may differ between two runs of the same analysis.
TIMING: Final = ("wall_s", "cpu_s")


@dataclass(frozen=True, slots=True)
class Column:
    """One column of the table.

    Attributes:
        name: Name, with the unit unless it is SI and obvious.
        kind: Type of the values.
        unit: Unit, ``-`` for ratios and texts.
        description: What the number is, with its sign.
    """

    name: str
    kind: Kind
    unit: str
    description: str


_KEY_COLUMNS: Final = (
    Column("variant", "text", "-", "name of the bridge variant"),
    Column("bridge", "text", "-", "catalogue name of the bridge"),
    Column("abutment", "text", "-", "abutment model"),
    Column("skew_deg", "integer", "deg", "skew of the abutment line from the transverse axis"),
    Column("gap_mm", "integer", "mm", "initial longitudinal joint gap"),
    Column("friction", "number", "-", "Coulomb coefficient at the contacts"),
    Column("motion_id", "text", "-", "ground motion"),
    Column("scale", "number", "-", "factor on both components"),
    Column("incidence_deg", "number", "deg", "angle from bridge x to component 1"),
)

INTENSITY_COLUMNS: Final = (
    Column("im_pga_rotd50_g", "number", "g", "peak ground acceleration, RotD50"),
    Column("im_pgv_rotd50_mps", "number", "m/s", "peak ground velocity, RotD50"),
    Column("im_sa_t1_rotd50_g", "number", "g", "5 % PSA at the bridge's conditioning T1, RotD50"),
    Column("im_sa_1p000_rotd50_g", "number", "g", "5 % PSA at 1.0 s, RotD50"),
    Column(
        "im_saavg_rotd50_g",
        "number",
        "g",
        "geometric mean of PSA RotD50 at 20 log-spaced periods from 0.2 T1 to 3 T1",
    ),
    Column("im_arias_mps", "number", "m/s", "Arias intensity"),
    Column("im_cav_mps", "number", "m/s", "cumulative absolute velocity"),
    Column("im_d5_75_s", "number", "s", "significant duration, 5 to 75 % of Arias intensity"),
    Column("im_d5_95_s", "number", "s", "significant duration, 5 to 95 % of Arias intensity"),
)

DEMAND_COLUMNS: Final = (
    Column("column_shear_x_kn", "number", "kN", "peak longitudinal shear at a column base"),
    Column("column_shear_y_kn", "number", "kN", "peak transverse shear at a column base"),
    Column(
        "column_shear_kn", "number", "kN", "peak resultant shear at a column base, worst column"
    ),
    Column("column_shear_dcr", "number", "-", "peak of shear over ductility-dependent capacity"),
    Column("column_drift_ratio", "number", "-", "peak resultant drift over clear height"),
    Column("column_curvature_ductility", "number", "-", "peak curvature over yield curvature"),
    Column("column_residual_drift_ratio", "number", "-", "resultant drift at the end of the run"),
    Column("deck_disp_x_m", "number", "m", "peak longitudinal displacement at the mass centre"),
    Column("deck_disp_y_m", "number", "m", "peak transverse displacement at the mass centre"),
    Column("deck_disp_m", "number", "m", "peak resultant displacement at the mass centre"),
    Column("deck_rotation_rad", "number", "rad", "peak rotation of the deck about the vertical"),
    Column("deck_accel_mps2", "number", "m/s2", "peak resultant total acceleration of the deck"),
    Column("abutment_passive_m", "number", "m", "peak push of the backwall into the fill, no gap"),
    Column("abutment_active_m", "number", "m", "peak movement of the backwall away from the fill"),
    Column("abutment_transverse_m", "number", "m", "peak transverse movement of the abutment"),
    Column("bearing_disp_m", "number", "m", "peak resultant shear deformation of a bearing"),
    Column(
        "unseating_m", "number", "m", "peak outward move off the seat, normal to it, any corner"
    ),
    Column("acute_corner_unseating_m", "number", "m", "the same at the acute corners of the deck"),
    Column("shear_key_force_kn", "number", "kN", "peak force of a shear key that the deck touches"),
    Column(
        "backwall_force_kn", "number", "kN", "peak force that the deck passes through one backwall"
    ),
    Column("friction_force_kn", "number", "kN", "peak friction force on one backwall or key"),
    Column("contact_closures", "number", "-", "closures of all contact units"),
    Column("contact_time_s", "number", "s", "time that some contact unit was closed, summed"),
    Column("contact_max_penetration_m", "number", "m", "peak penetration of a contact unit"),
    Column("slip_work_kj", "number", "kJ", "work of friction, dissipated"),
    Column("cone_violation_ratio", "number", "-", "worst excess over the friction cone"),
    Column("energy_residual_ratio", "number", "-", "energy not accounted for, over the input"),
)

_RUN_COLUMNS: Final = (
    Column("status", "text", "-", f"one of {', '.join(STATUSES)}"),
    Column(
        "collapse_criterion", "text", "-", "limit whose passing is the collapse, or why it failed"
    ),
    Column("time_reached_s", "number", "s", "time that the analysis reached"),
    Column("duration_s", "number", "s", "time that it was to reach"),
    Column("recovery_rung", "integer", "-", "highest rung of the recovery ladder in use, 0 none"),
    Column("substeps", "integer", "-", "sub-steps taken beyond the regular steps"),
    Column("wall_s", "number", "s", "wall time of the analysis"),
    Column("cpu_s", "number", "s", "processor time of the analysis"),
    Column("run_key", "text", "-", "digest of everything that the row depends on"),
)

COLUMNS: Final = _KEY_COLUMNS + INTENSITY_COLUMNS + DEMAND_COLUMNS + _RUN_COLUMNS

_TYPES: Final = {"text": pa.string(), "integer": pa.int64(), "number": pa.float64()}


def demands_schema(provenance: Mapping[str, str] | None = None) -> pa.Schema:
    """Return the Arrow schema: unit and description per field, provenance for the file."""
    fields = [
        pa.field(
            column.name,
            _TYPES[column.kind],
            metadata={"unit": column.unit, "description": column.description},
        )
        for column in COLUMNS
    ]
    metadata: dict[bytes | str, bytes | str] = dict((provenance or {}).items())
    return pa.schema(fields, metadata=metadata)


def key_values(
    variant: Variant, motion_id: str, scale: float, incidence_deg: float
) -> dict[str, Any]:
    """Return the key columns of one analysis."""
    return {
        "variant": variant.slug,
        "bridge": variant.bridge,
        "abutment": variant.abutment,
        "skew_deg": variant.skew_deg,
        "gap_mm": variant.gap_mm,
        "friction": variant.friction,
        "motion_id": motion_id,
        "scale": scale,
        "incidence_deg": incidence_deg,
    }


def to_table(rows: Iterable[Mapping[str, Any]], provenance: Mapping[str, str]) -> pa.Table:
    """Return the rows as a sorted Arrow table.

    Args:
        rows: Rows with every column of the schema; a demand that was never reached is None.
        provenance: Texts for the file metadata.

    Raises:
        ValueError: A row lacks a column, has one too many, an unknown status, or its key twice.
    """
    names = [column.name for column in COLUMNS]
    ordered = sorted(rows, key=lambda row: tuple(row[name] for name in KEY))
    keys = [tuple(row[name] for name in KEY) for row in ordered]
    if len(set(keys)) != len(keys):
        raise ValueError(
            f"an analysis is there twice: {next(k for k in keys if keys.count(k) > 1)}"
        )
    for row, key in zip(ordered, keys, strict=True):
        if set(row) != set(names):
            raise ValueError(f"row {key}: wrong columns {sorted(set(row) ^ set(names))}")
        if row["status"] not in STATUSES:
            raise ValueError(f"row {key}: unknown status {row['status']!r}")
    schema = demands_schema(provenance)
    return pa.table({name: [row[name] for row in ordered] for name in names}, schema=schema)


def data_dictionary() -> pd.DataFrame:
    """Return the columns as a table: name, unit, description."""
    return pd.DataFrame(
        [(column.name, column.unit, column.description) for column in COLUMNS],
        columns=["column", "unit", "description"],
    )
