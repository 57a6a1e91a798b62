"""All columns of the demands table, the key of its rows, and lookups of columns by name."""

from collections.abc import Iterable
from typing import Any, Final

from skewbridge.demands.completeness import BEYOND_MODEL, COMPLETE
from skewbridge.demands.demand_columns import DEMAND_COLUMNS, INTENSITY_COLUMNS, Column, Role
from skewbridge.demands.suspect import SEPARATOR, SUSPECT
from skewbridge.statuses import STATUSES
from skewbridge.units import split_unit
from skewbridge.variant.axes import AXES, Axis, axes_of
from skewbridge.variant.random_properties import DRAW_PREFIX
from skewbridge.variant.variant import Variant

SUITE: Final = "suite"
KEY: Final = ("variant", "motion_id", "scale", "incidence_deg")


def axis_column(axis: Axis) -> Column:
    """Return the column of an axis of the grid."""
    return Column(
        axis.name,
        kind="integer" if axis.is_whole else "number",
        unit=axis.unit,
        label=axis.label,
        description=axis.description,
    )


COLUMNS: Final = (
    Column("variant", kind="text", description="bridge variant"),
    Column("bridge", kind="text", description="bridge"),
    Column("abutment", kind="text", description="abutment model"),
    *(axis_column(axis) for axis in AXES),
    Column("motion_id", kind="text", description="ground motion"),
    Column(SUITE, kind="text", description="suite of the ground motion"),
    Column("scale", description="factor on both components"),
    Column("incidence_deg", unit="deg", description="angle from bridge x to component 1"),
    *INTENSITY_COLUMNS,
    *DEMAND_COLUMNS,
    Column("status", kind="text", description=f"one of {', '.join(STATUSES)}"),
    Column(
        COMPLETE,
        kind="boolean",
        description="whether demands are peaks of the whole motion: status ok, no column failed",
    ),
    Column(
        "collapse_criterion",
        kind="text",
        description="limit that the collapse exceeded, or reason of the failure",
    ),
    Column(
        BEYOND_MODEL,
        kind="text",
        description="failure of a column: shear (demand/capacity 1), flexure (drift over "
        "capacity 1) or empty; demands are the peaks up to it",
    ),
    Column(
        "beyond_model_s", unit="s", description="time of the column failure; histories continue"
    ),
    Column("time_reached_s", unit="s", description="time that the analysis reached"),
    Column("duration_s", unit="s", description="time of the end of the motion"),
    Column(
        "recovery_rung",
        kind="integer",
        description="highest recovery step with which a step converged",
    ),
    Column(
        "steps_by_rung",
        kind="text",
        description="(sub-)steps that converged with each recovery step, from 0",
    ),
    Column("loosened_ratio", description="share of these steps that met only a looser test"),
    Column("houbolt_failures", kind="integer", description="failed attempts under Houbolt"),
    Column("substeps", kind="integer", description="sub-steps besides the regular steps"),
    Column(
        SUSPECT,
        kind="text",
        description="reasons to doubt the row (section suspect of the configuration), joined by "
        f"'{SEPARATOR}'; empty without any",
    ),
    Column("wall_s", unit="s", description="wall time of the analysis"),
    Column("cpu_s", unit="s", description="processor time of the analysis"),
    Column("run_key", kind="text", description="digest of everything that the row depends on"),
)
_BY_NAME: Final = {column.name: column for column in COLUMNS}


def columns_with(present: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns of a study whose rows have these, with axes and random properties."""
    names = list(present)
    extra = tuple(axis_column(axis) for axis in axes_of(names) if axis.name not in _BY_NAME)
    after = 1 + next(i for i, column in enumerate(COLUMNS) if column.name == AXES[-1].name)
    draws = [_draw_column(name) for name in names if name.startswith(DRAW_PREFIX)]
    return (*COLUMNS[:after], *extra, *COLUMNS[after:-1], *draws, COLUMNS[-1])


def _draw_column(name: str) -> Column:
    what = name.removeprefix(DRAW_PREFIX)
    unit = split_unit(what)[1]
    return Column(name, unit=unit, description=f"random property of the motion: {what}")


def key_values(
    variant: Variant, motion_id: str, scale: float, incidence_deg: float
) -> dict[str, Any]:
    """Return the key columns of one analysis."""
    return {
        "variant": variant.slug,
        "bridge": variant.bridge_name,
        "abutment": variant.abutment,
        **variant.values(),
        "motion_id": motion_id,
        "scale": scale,
        "incidence_deg": incidence_deg,
    }


def demands_for(role: Role, present: Iterable[str] | None = None) -> tuple[str, ...]:
    """Return the demand columns with a role, in the order of the table, of those present."""
    names = [column.name for column in DEMAND_COLUMNS if role in column.roles]
    known = set(names if present is None else present)
    return tuple(name for name in names if name in known)


def column_of(name: str) -> Column | None:
    """Return the column or axis of the grid with a name, None for a foreign column."""
    axes = axes_of([name])
    return _BY_NAME.get(name) or (axis_column(axes[0]) if axes else None)


def label_of(name: str) -> str:
    """Return the label of a column with its unit; for a foreign column, its name in words."""
    known = column_of(name)
    return known.label_with_unit if known else name.replace("_", " ")


def unit_of(name: str) -> str:
    """Return the unit of a column; empty for a ratio and for a foreign column."""
    column = column_of(name)
    return "" if column is None or column.unit == "-" else column.unit
