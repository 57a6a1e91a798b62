"""Pairs of runs under the same motion, of variants that differ in one axis only."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.demands.completeness import BEYOND_MODEL, is_beyond_model, is_complete
from skewbridge.errors import InputError
from skewbridge.fragility.columns import FloatArray
from skewbridge.fragility.demand_table import (
    BRIDGE_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    models_of,
    motion_codes,
    varying_axes,
)
from skewbridge.statuses import COLLAPSE

#: What a pair shows of the change of a demand: the change, a lower or an upper bound, or nothing.
EXACT: Final = 0
AT_LEAST: Final = 1
AT_MOST: Final = -1
UNKNOWN: Final = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """All pairs of runs from one value of an axis to another, of one bridge and abutment model.

    Attributes:
        place: bridge, abutment, axis, from_value and to_value.
        table: The pairs of `run_pairs`.
        cells: For each pair of variants the values of the other axes, and the numbers of its rows.
        motions: Number of the motion of each pair, (n,).
        count: Motions of the pairs.
        side: `EXACT`, `AT_LEAST`, `AT_MOST` or `UNKNOWN`, (n,). A run that collapsed, failed or
            lost a column has peaks up to then, so its demands are at least so large.
        differ: The two runs have another status, or one of them alone lost a column, (n,).
        counted: Columns that count pairs, by name, each (n,).
    """

    place: Mapping[str, Any]
    table: pd.DataFrame
    cells: Sequence[tuple[Mapping[str, Any], NDArray[np.intp]]]
    motions: NDArray[np.intp]
    count: int
    side: NDArray[np.int_]
    differ: NDArray[np.bool_]
    counted: Mapping[str, NDArray[np.bool_]]

    @classmethod
    def of(cls, place: Mapping[str, Any], table: pd.DataFrame) -> Self:
        """Return the pairs of `run_pairs` with the values of ``place``."""
        names = other_axes(table, str(place["axis"]))
        groups = table.groupby(names, sort=True, dropna=False).indices if names else {}
        cells: list[tuple[Mapping[str, Any], NDArray[np.intp]]] = []
        for key, rows in groups.items():
            values = key if isinstance(key, tuple) else (key,)
            cells.append((dict(zip(names, values, strict=True)), np.asarray(rows, dtype=np.intp)))
        (top, bottom), (status_to, status_from), (failed_to, failed_from) = (
            (table[f"{name}_to"].to_numpy(), table[f"{name}_from"].to_numpy())
            for name in ("complete", "status", BEYOND_MODEL)
        )
        motions = motion_codes(table)
        return cls(
            place=place,
            table=table,
            cells=cells or [({}, np.arange(len(table)))],
            motions=motions,
            count=int(motions.max()) + 1,
            side=np.select(
                [top & bottom, bottom, top], [EXACT, AT_LEAST, AT_MOST], default=UNKNOWN
            ),
            differ=(status_to != status_from) | (failed_to != failed_from),
            counted={
                "n_beyond_model": failed_to | failed_from,
                "n_collapse_from": status_from == COLLAPSE,
                "n_collapse_to": status_to == COLLAPSE,
            },
        )

    def ends(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return a column at to_value and at from_value, each of shape (n,)."""
        to, start = (self.table[f"{name}_{end}"] for end in ("to", "from"))
        return to.to_numpy(dtype=np.float64), start.to_numpy(dtype=np.float64)

    def counts(
        self, rows: NDArray[np.intp], used: NDArray[np.bool_], discordant: NDArray[np.bool_]
    ) -> dict[str, int]:
        """Return the counts of some of the pairs: all columns ``n_`` of an effect but n_cells.

        ``used`` are the pairs that enter the effect, ``discordant`` those with a demand on one side
        only, both of shape (n,).
        """
        own, apart, outcomes = used[rows], discordant[rows], self.counted.items()
        return {
            "n_motions": int(np.unique(self.motions[rows][own]).size),
            "n_pairs": int(rows.size),
            "n_bounds": int(np.count_nonzero(own & (self.side[rows] != EXACT))),
            "n_left_out": int(np.count_nonzero(~own)),
            "n_discordant": int(np.count_nonzero(apart)),
            **{name: int(np.count_nonzero(values[rows])) for name, values in outcomes},
        }


def study_pairs(demands: pd.DataFrame, columns: Sequence[str]) -> Iterator[Pairs]:
    """Yield the pairs of runs along each axis, of each bridge and abutment model.

    An axis in which the variants of a model do not differ has no pairs.

    Raises:
        InputError: A run occurs twice.
    """
    for model, rows in models_of(demands):
        for axis in varying_axes(rows):
            keys = ["from_value", "to_value"]
            for values, part in run_pairs(rows, axis, columns).groupby(keys, sort=True):
                place = model | {"axis": axis} | dict(zip(keys, values, strict=True))
                yield Pairs.of(place, part)


def other_axes(table: pd.DataFrame, axis: str) -> list[str]:
    """Return the axis columns of a table but one."""
    return [name for name in axis_names(table) if name != axis]


def run_pairs(demands: pd.DataFrame, axis: str, columns: Sequence[str]) -> pd.DataFrame:
    """Pair the runs of variants that differ in ``axis`` only, the smallest value as reference.

    Returns:
        One row per pair: bridge, abutment, the other axes, motion_id, scale, incidence_deg,
        from_value, to_value; status, beyond_model and complete (truth values) and the columns with
        ``_from`` and ``_to``.

    Raises:
        InputError: A run occurs twice.
    """
    group = [*BRIDGE_COLUMNS, *other_axes(demands, axis)]
    key = [*group, *LOADING_COLUMNS]
    table = demands[[*key, axis, "status", *columns]].assign(
        **{BEYOND_MODEL: is_beyond_model(demands), "complete": is_complete(demands)}
    )
    once = ~table.duplicated([*key, axis]).to_numpy()
    if not once.all():
        row = demands.index[int(np.argmin(once))]
        raise InputError(f"the run of row {row} occurs twice in the demands table", row=row)
    lowest = table.groupby(group, dropna=False)[axis].transform("min")
    reference = table[table[axis] == lowest].rename(columns={axis: "from_value"})
    others = table[table[axis] > lowest].rename(columns={axis: "to_value"})
    return others.merge(reference, on=key, suffixes=("_to", "_from"), validate="many_to_one")
