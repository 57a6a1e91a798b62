"""All columns of the demands table, and what is asked of them by name."""

from collections.abc import Iterable
from typing import Final

from skewbridge.demands.column import Column, Role
from skewbridge.demands.demand_columns import DEMAND_COLUMNS
from skewbridge.statuses import STATUSES
from skewbridge.variant.axes import AXES, Axis, axes_of


def axis_column(axis: Axis) -> Column:
    """Return the column of an axis of the grid."""
    return Column(
        axis.name,
        kind="integer" if axis.is_whole else "number",
        unit=axis.unit,
        label=axis.label,
        description=axis.description,
    )


VARIANT_COLUMNS: Final = (
    Column("variant", kind="text", description="name of the bridge variant"),
    Column("bridge", kind="text", description="catalogue name of the bridge"),
    Column("abutment", kind="text", description="abutment model"),
    *(axis_column(axis) for axis in AXES),
)

LOADING_COLUMNS: Final = (
    Column("motion_id", kind="text", description="ground motion"),
    Column("scale", description="factor on both components"),
    Column("incidence_deg", unit="deg", description="angle from bridge x to component 1"),
)

INTENSITY_COLUMNS: Final = (
    Column(
        "im_pga_rotd50_g",
        unit="g",
        label="PGA RotD50",
        description="peak ground acceleration, RotD50",
    ),
    Column(
        "im_pgv_rotd50_mps",
        unit="m/s",
        label="PGV RotD50",
        description="peak ground velocity, RotD50",
    ),
    Column(
        "im_sa_t1_rotd50_g",
        unit="g",
        label="$S_a(T_1)$ RotD50",
        description="5 % PSA at the bridge's conditioning T1, RotD50",
    ),
    Column(
        "im_sa_1p000_rotd50_g",
        unit="g",
        label=r"$S_a(1.0\,\mathrm{s})$ RotD50",
        description="5 % PSA at 1.0 s, RotD50",
    ),
    Column(
        "im_saavg_rotd50_g",
        unit="g",
        label=r"$S_{a,\mathrm{avg}}$ RotD50",
        description="geometric mean of PSA RotD50 at 20 log-spaced periods from 0.2 T1 to 3 T1",
    ),
    Column("im_arias_mps", unit="m/s", label="Arias intensity", description="Arias intensity"),
    Column("im_cav_mps", unit="m/s", label="CAV", description="cumulative absolute velocity"),
    Column(
        "im_d5_75_s",
        unit="s",
        label="$D_{5-75}$",
        description="significant duration, 5 to 75 % of Arias intensity",
    ),
    Column(
        "im_d5_95_s",
        unit="s",
        label="$D_{5-95}$",
        description="significant duration, 5 to 95 % of Arias intensity",
    ),
)

RUN_COLUMNS: Final = (
    Column("status", kind="text", description=f"one of {', '.join(STATUSES)}"),
    Column(
        "collapse_criterion",
        kind="text",
        description="limit whose passing is the collapse, or why it failed",
    ),
    Column("time_reached_s", unit="s", description="time that the analysis reached"),
    Column("duration_s", unit="s", description="time that it was to reach"),
    Column(
        "recovery_rung",
        kind="integer",
        description="highest rung of the recovery ladder in use, 0 none",
    ),
    Column("substeps", kind="integer", description="sub-steps taken beyond the regular steps"),
    Column("wall_s", unit="s", description="wall time of the analysis"),
    Column("cpu_s", unit="s", description="processor time of the analysis"),
    Column("run_key", kind="text", description="digest of everything that the row depends on"),
)

COLUMNS: Final = (
    *VARIANT_COLUMNS,
    *LOADING_COLUMNS,
    *INTENSITY_COLUMNS,
    *DEMAND_COLUMNS,
    *RUN_COLUMNS,
)
_BY_NAME: Final = {column.name: column for column in COLUMNS}


def demands_for(role: Role, present: Iterable[str] | None = None) -> tuple[str, ...]:
    """Return the demand columns with a role, in the order of the table.

    Args:
        role: What the study does with them.
        present: Only those among these names; None for all.
    """
    names = tuple(column.name for column in DEMAND_COLUMNS if role in column.roles)
    if present is None:
        return names
    known = set(present)
    return tuple(name for name in names if name in known)


def column_of(name: str) -> Column | None:
    """Return what is known of a column or of an axis of the grid, None of a foreign column."""
    axes = axes_of([name])
    return _BY_NAME.get(name) or (axis_column(axes[0]) if axes else None)


def label_of(name: str) -> str:
    """Return the label of a column with its unit; a foreign column is named in plain words."""
    known = column_of(name)
    return known.label_with_unit if known else name.replace("_", " ")


def unit_of(name: str) -> str:
    """Return the unit of a column; empty for a ratio and for a foreign column."""
    column = column_of(name)
    return "" if column is None or column.unit == "-" else column.unit
