"""Runs of variants that differ in one axis only, paired under the same motion."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from skewbridge.errors import InputError
from skewbridge.fragility.old_likelihood.links import FloatArray
from skewbridge.fragility.tables.beyond_model import BEYOND_MODEL, is_beyond_model, is_complete
from skewbridge.fragility.tables.key_columns import (
    BRIDGE_COLUMNS,
    LOADING_COLUMNS,
    axis_names,
    models_of,
    motion_codes,
    varying_axes,
)
from skewbridge.statuses import COLLAPSE

type Scope = Literal["variant", "pooled"]


def pair_groups(
    demands: pd.DataFrame, columns: Sequence[str], *, scope: Scope = "variant"
) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield the pairs of runs along each axis, of each bridge and abutment model by itself.

    An axis in which the variants of a model do not differ has no pairs: an abutment model that
    lacks it does not enter.

    Args:
        demands: Table of demands.
        columns: Those whose values are paired.
        scope: Whether the pairs of each pair of variants stand together, or those of all.

    Yields:
        Axis, scope, bridge, abutment, from_value, to_value and, for a pair of variants, the other
        axes; and the pairs of `run_pairs`.
    """
    for model, own in models_of(demands):
        for axis in varying_axes(own):
            pairs = run_pairs(own, axis, columns)
            keys = ["from_value", "to_value"]
            if scope == "variant":
                keys += other_axes(own, axis)
            for key, part in pairs.groupby(keys, sort=True, dropna=False):
                told = {"axis": axis, "scope": scope} | dict(zip(keys, key, strict=True))
                yield model | told, part


def other_axes(table: pd.DataFrame, axis: str) -> list[str]:
    """Return the axis columns of a table but one."""
    return [name for name in axis_names(table) if name != axis]


def run_pairs(demands: pd.DataFrame, axis: str, columns: Sequence[str]) -> pd.DataFrame:
    """Pair the runs of variants that differ in ``axis`` only.

    Returns:
        One row per pair: bridge, abutment, the other axes, motion_id, from_value, to_value,
        status, beyond_model and complete (truth values) and the demands with ``_from`` and
        ``_to``.

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
    others_rows = table[table[axis] > lowest].rename(columns={axis: "to_value"})
    return others_rows.merge(reference, on=key, suffixes=("_to", "_from"), validate="many_to_one")


def ends_of(part: pd.DataFrame, name: str) -> tuple[FloatArray, FloatArray]:
    """Return a demand at to_value and at from_value."""
    top, bottom = (part[f"{name}_{end}"].to_numpy(dtype=np.float64) for end in ("to", "from"))
    return top, bottom


@dataclass(frozen=True, slots=True, kw_only=True)
class PairFacts:
    """What became of the two runs of each pair, whatever the demand; arrays of shape (n,).

    Attributes:
        motions: Number of the motion.
        side: What the two runs tell of the change of a demand: 0 the change itself, 1 a change at
            least as large as that of the peaks, -1 at most so large, 2 nothing, because neither
            run is complete. A run that collapsed, failed or went beyond the model went through at
            least the peaks up to then.
        apart: One side alone collapsed, failed or went beyond the model.
        status_to: Status at to_value.
        status_from: Status at from_value.
        beyond_to: Whether a column failed beyond the model at to_value.
        beyond_from: The same at from_value.
    """

    motions: NDArray[np.intp]
    side: NDArray[np.int_]
    apart: NDArray[np.bool_]
    status_to: NDArray[np.str_]
    status_from: NDArray[np.str_]
    beyond_to: NDArray[np.bool_]
    beyond_from: NDArray[np.bool_]

    @classmethod
    def of(cls, part: pd.DataFrame) -> Self:
        """Return the facts of the pairs of `run_pairs`."""
        top, bottom = (part[f"complete_{end}"].to_numpy(dtype=np.bool_) for end in ("to", "from"))
        status_to, status_from = (part[f"status_{e}"].to_numpy(dtype=str) for e in ("to", "from"))
        beyond_to, beyond_from = (
            part[f"{BEYOND_MODEL}_{end}"].to_numpy(dtype=np.bool_) for end in ("to", "from")
        )
        return cls(
            motions=motion_codes(part),
            side=np.select([top & bottom, bottom, top], [0, 1, -1], default=2),
            apart=(status_to != status_from) | (beyond_to != beyond_from),
            status_to=status_to,
            status_from=status_from,
            beyond_to=beyond_to,
            beyond_from=beyond_from,
        )

    def at(self, rows: NDArray[np.intp]) -> Self:
        """Return the facts of some of the pairs."""
        return type(self)(**{each.name: getattr(self, each.name)[rows] for each in fields(self)})

    def counts(self, used: NDArray[np.bool_]) -> dict[str, int]:
        """Return how many pairs there are, are left out, have a failed column; the collapses."""
        return {
            "n_pairs": int(used.size),
            "n_beyond_model": int(np.sum(self.beyond_to | self.beyond_from)),
            "n_left_out": int(np.sum(~used)),
            "n_collapse_from": int(np.sum(self.status_from == COLLAPSE)),
            "n_collapse_to": int(np.sum(self.status_to == COLLAPSE)),
        }
